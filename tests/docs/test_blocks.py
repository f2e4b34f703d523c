"""Blocks marked `console` run as shown, in one temporary directory a page, and say what the page says: numbers may differ, `…` is anything.

Words behind `console`: `slow` takes long, `slow long` takes minutes and is left out of CI; `daemon` talks to a daemon, which the test
starts (the wall clock, so slow as well); `root` makes a network namespace `hil` with twin and daemon of its own, so it runs as root only.
"""

from __future__ import annotations

import contextlib
import os
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest

from config.errors import PlantError
from config.options.plug_ins import DRIVERS, installed
from sim_backend.twin.network_namespace import NetworkNamespace
from tests.docs.pages import CHECKOUT, PAGES, Block, blocks, name
from tests.support.daemon.running_daemon import RunningDaemon

LIMIT_S = 800  # a search on a busy machine


@dataclass(frozen=True)
class Step:
    """One command and the lines that the page shows below it."""

    command: str
    shown: tuple[str, ...]


def steps(block: Block) -> Iterator[Step]:
    command, shown = "", []
    for line in block.lines:
        if line.startswith("$ "):
            if command:
                yield Step(command, tuple(shown))
            command, shown = line.removeprefix("$ "), []
        else:
            shown.append(line)
    yield Step(command, tuple(shown))


CONSOLES = {page: [block for block in blocks(page) if block.words[:1] == ("console",)] for page in PAGES}
NEEDS_DAEMON = [page for page, shown in CONSOLES.items() if any("daemon" in block.words for block in shown)]
IN_SECONDS = [page for page, shown in CONSOLES.items() if any(len(block.words) == 1 for block in shown)]
NEEDS_ROOT = [page for page, shown in CONSOLES.items() if any("root" in block.words for block in shown)]
WITH_SLOW = [
    pytest.param(page, marks=pytest.mark.long) if any("long" in block.words for block in shown) else page
    for page, shown in CONSOLES.items()
    if any("slow" in block.words for block in shown)
]


def runs(page: Path, directory: Path, words: set[str], **environment: str) -> None:
    """Run the page's blocks that need no more than `words`, in order."""
    (directory / "config").symlink_to(CHECKOUT / "config")
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    for block in CONSOLES[page]:
        if not set(block.words[1:]) <= words:
            continue
        for step in steps(block):
            written = step.command.partition("new-driver ")[2]
            if written in installed(DRIVERS):
                pytest.skip(f"whoever followed {page.name} has {written} installed: pip uninstall longreach-{written}")
            done = subprocess.run(
                ["bash", "-c", step.command],
                cwd=directory,
                env={**os.environ, "PATH": path, **environment},
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                timeout=LIMIT_S,
            )
            _compare(f"{block}: {step.command}", step.shown, done.stdout)


def _compare(where: str, shown: tuple[str, ...], said: str) -> None:
    """Every line shown is said, in this order."""
    lines = iter(_form(line) for line in said.splitlines())
    for line in shown:
        if line.strip() in ("", "…"):
            continue
        pattern = ".*".join(re.escape(part) for part in _form(line).split("…"))
        assert any(re.fullmatch(pattern, other) for other in lines), f"{where}: the page shows {line!r}, the command said\n{said}"


def _form(line: str) -> str:
    """A line without what may differ: numbers, and how wide a table is drawn."""
    return re.sub(r"[-+−]?\d+(\.\d+)?(e[-+]?\d+)?", "#", re.sub(r"\s+", " ", line)).strip()


@pytest.mark.parametrize("page", IN_SECONDS, ids=name)
def test_blocks_that_take_seconds(page: Path, tmp_path: Path) -> None:
    runs(page, tmp_path, set())


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("page", WITH_SLOW, ids=name)
def test_blocks_that_take_longer(page: Path, tmp_path: Path) -> None:
    try:
        runs(page, tmp_path, {"slow", "long"})
    finally:
        for left in tmp_path.glob("*.pid"):  # what a page puts into the background it names so
            with contextlib.suppress(ProcessLookupError):
                os.kill(int(left.read_text()), signal.SIGKILL)


@pytest.mark.slow
@pytest.mark.parametrize("page", NEEDS_DAEMON, ids=name)
def test_blocks_that_talk_to_a_daemon(page: Path, tmp_path: Path) -> None:
    with RunningDaemon(tmp_path) as daemon:
        daemon.wait_until_ready()
        runs(page, tmp_path, {"daemon"}, LONGREACH_SOCKET=str(daemon.socket))


@pytest.fixture
def namespace() -> Iterator[None]:
    """The page makes it; whatever is left of it goes."""
    try:
        NetworkNamespace(f"blocks-{os.getpid()}").delete()
    except PlantError as reason:
        pytest.skip(str(reason))
    yield
    left = subprocess.run(["ip", "netns", "pids", "hil"], capture_output=True, text=True, check=False).stdout.split()
    for process in left:
        os.kill(int(process), signal.SIGKILL)
    subprocess.run(["ip", "netns", "delete", "hil"], capture_output=True, check=False)


@pytest.mark.slow
@pytest.mark.clock
@pytest.mark.timeout(900)
@pytest.mark.parametrize("page", NEEDS_ROOT, ids=name)
def test_blocks_with_a_twin_in_a_network_namespace(page: Path, tmp_path: Path, namespace: None) -> None:
    runs(page, tmp_path, {"root"}, RUNTIME_DIRECTORY=str(tmp_path / "run"), LONGREACH_SOCKET=str(tmp_path / "run" / "longreach.sock"))
