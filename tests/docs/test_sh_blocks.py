"""Every command of a block marked `sh` runs as shown, each in a folder of its own that holds what the page calls by example names.

The lines above a command in its block that are not of longreach (`cp`, `sed` …) run before it.
"""

from __future__ import annotations

import re
import signal
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import pytest

from daemon.server.protocol import Client
from tests.docs.page_world import World, environment
from tests.docs.pages import PAGES, Block, blocks
from tests.support.daemon.running_daemon import RunningDaemon, until
from tests.support.live.gentle_daemon import gentle_daemon
from tests.support.live.terminal import Terminal

LIMIT_S = 280
CTRL_C = (0, 130)

# First word, or words anywhere in the line, of what cannot run in a test: why.
NOT_HERE = {
    "sudo": "asks for root and changes this computer",
    "systemctl": "needs a running service",
    "make": "sets up the environment that the tests run in",
    "ip": "a CAN interface or network namespace; the root blocks of connect-canopen.md have one",
    "candump": "needs a CAN interface",
    "ping": "a real device",
    "ssh": "a second computer",
    "pip": "changes the environment that the tests run in; tests/drivers/test_new_driver.py imports such a package",
    "pytest": "the tests of a package that is made there; tests/drivers/test_new_driver.py runs them",
    "my_gauge": "a package that pip would have installed; tests/drivers/test_new_driver.py",
    "device calibrate": "a twin on a bus; tests/daemon/cli/devices/test_calibrate.py",
    "--kind arm": "asks fifteen questions; tests/tuning/new_rig/test_new_arm.py",
    "/dev/ttyUSB0": "a serial adapter",
    "longreach twin": "a bus; the root blocks of connect-canopen.md start one",
    "benchmarks.live": "takes minutes on an idle machine",
}
# What takes minutes, or was not yet tried here on an idle machine, and the test that runs the verb.
ELSEWHERE = {
    "gap demo": "docs/guide/model/find-the-gap.md, a console block",
    "gap next": "tests/gap/maneuvers/test_next_maneuver.py",
    "--holdout sine.mcap": "tests/gap/test_cylinder_bench.py",
    "commission trial.yaml": "tests/daemon/cli/commission/test_commission.py",
    "commission my_rig.yaml": "tests/daemon/processes/test_commission_on_daemon.py",
    "--on-rig": "tests/daemon/processes/test_identify_on_rig.py",
    "/tmp/run.sock why": "the log that the line above plays; tests/daemon/live/test_play.py",
    "demo --lockstep": "console blocks of first-run.md and rig-file.md",
}
TALKS = re.compile(r"longreach (why(?! LOG)|events|reset|prove|arm|disarm|jog|start|stop|status|ui|top|live)\b")
ARMED = re.compile(r"longreach (start|stop|jog)\b")
STAYS = re.compile(r"longreach (ui|live|play)\b|longreachd|--watch")
IN_HALF_A_MINUTE = re.compile(r"longreach (shape my_rig|gap find --rig frictionless|design my_rig.yaml --tip-gain)")
IN_SECONDS = re.compile(r"longreach (check|new-rig|import day)")
# Other than 0, as the pages say: two runs that differ; something stands in the way; the simulated rig has pressure; no rate is kept.
STATUS = {"log diff": (1,), "longreach why": (0, 1), "longreach prove": (1,), "longreach host": (0, 1)}


class Case(NamedTuple):
    block: Block
    before: str
    command: str

    def __str__(self) -> str:
        return f"{self.block.page.name} {self.command}"


def lines_of(block: Block) -> list[str]:
    return [line for line in re.sub(r"\\\n\s*", "", "\n".join(block.lines)).splitlines() if line.strip()]


def why_not(line: str) -> str:
    """The reason why a line is not run; nothing if it is."""
    said = (reason for words, reason in (NOT_HERE | ELSEWHERE).items() if re.search(rf"(?<![\w-]){re.escape(words)}(?![\w-])", line))
    return next(said, "")


def cases() -> Iterator[Case]:
    for page in PAGES:
        for block in blocks(page):
            if block.words[:1] != ("sh",):
                continue
            before = ""
            for line in lines_of(block):
                shown = re.sub(r"\s+#.*", "", line)
                if not re.search(r"\blongreachd?\b", shown.split()[0]):
                    before += "" if why_not(shown) else f"{shown}\n"
                elif not why_not(shown):
                    yield Case(block, before, shown)


CASES = list(cases())
WITH_DAEMON = [case for case in CASES if TALKS.search(case.command)]
STAYING = [case for case in CASES if STAYS.search(case.command) and case not in WITH_DAEMON]
ALONE = [case for case in CASES if case not in WITH_DAEMON and case not in STAYING]
QUICK = [case for case in ALONE if IN_SECONDS.match(case.command)]
LONGER = [
    pytest.param(case, marks=pytest.mark.long) if IN_HALF_A_MINUTE.match(case.command) else case for case in ALONE if case not in QUICK
]


@pytest.fixture(scope="module")
def world(tmp_path_factory: pytest.TempPathFactory) -> World:
    return World(tmp_path_factory.mktemp("world"))


@pytest.fixture(scope="module")
def daemon(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningDaemon]:
    with gentle_daemon(tmp_path_factory.mktemp("daemon")) as running:
        yield running


@pytest.mark.parametrize("case", QUICK, ids=str)
def test_commands_that_take_seconds(case: Case, world: World, tmp_path: Path) -> None:
    said = ends(case, prepared(case, world, tmp_path))
    assert not NEVER_SAID.search(said), f"{case.block}: {case.command}\n{said}"


@pytest.mark.slow
@pytest.mark.parametrize("case", LONGER, ids=str)
def test_commands_that_take_longer(case: Case, world: World, tmp_path: Path) -> None:
    ends(case, prepared(case, world, tmp_path))


@pytest.mark.slow
@pytest.mark.clock
@pytest.mark.parametrize("case", WITH_DAEMON, ids=str)
def test_commands_that_talk_to_the_daemon(case: Case, world: World, daemon: RunningDaemon, tmp_path: Path) -> None:
    brought_to_its_state(case, daemon)
    directory, variables = prepared(case, world, tmp_path), {"LONGREACH_SOCKET": str(daemon.socket)}
    if " jog" in case.command:
        jogs(case, directory, variables)
    elif STAYS.search(case.command):
        stays(case, directory, variables)
    else:
        ends(case, directory, **variables)


@pytest.mark.slow
@pytest.mark.parametrize("case", STAYING, ids=str)
def test_commands_that_stay_until_ctrl_c(case: Case, world: World, tmp_path: Path) -> None:
    stays(case, prepared(case, world, tmp_path), {"RUNTIME_DIRECTORY": str(tmp_path / "run")})


def test_nothing_is_excused_that_no_page_shows() -> None:
    shown = [line for page in PAGES for block in blocks(page) if block.words[:1] == ("sh",) for line in lines_of(block)]
    reasons = {why_not(line) for line in shown}
    assert [words for words, reason in (NOT_HERE | ELSEWHERE).items() if reason not in reasons] == []


def prepared(case: Case, world: World, directory: Path) -> Path:
    world.lay_out(directory, case.block.page.name, case.before + re.sub(r"(-o|--out|>) \S+", "", case.command))
    if case.before:
        subprocess.run(["bash", "-ec", case.before], cwd=directory, env=environment(), check=True, timeout=LIMIT_S)
    return directory


# What no command may say, whatever its exit status: an error nobody wrote a sentence for, a number nobody looked at.
NEVER_SAID = re.compile(r"Traceback|\bnan\b|Warning:")


def ends(case: Case, directory: Path, **variables: str) -> str:
    """With the exit status that the page promises; what it says."""
    done = subprocess.run(
        ["bash", "-c", case.command],
        cwd=directory,
        env=environment(**variables),
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        timeout=LIMIT_S,
    )
    allowed = next((status for words, status in STATUS.items() if words in case.command), (0,))
    assert done.returncode in allowed, f"{case.block}: {case.command}\n{done.stdout}"
    return done.stdout


def stays(case: Case, directory: Path, variables: dict[str, str]) -> None:
    """It says something or opens its socket, goes on, and Ctrl-C ends it."""
    said = directory / "said.txt"
    # exec: the signal reaches the command, not a shell around it
    command = ["bash", "-c", f"exec {case.command.rstrip('& ')}"]
    with said.open("wb") as output:
        process = subprocess.Popen(
            command, cwd=directory, env=environment(PYTHONUNBUFFERED="1", **variables), stdout=output, stderr=subprocess.STDOUT
        )
    try:
        until(lambda: process.poll() is not None or said.stat().st_size > 0 or list(directory.glob("run/*.sock")), LIMIT_S)
        assert process.poll() is None, f"{case.block}: {case.command}\n{said.read_text()}"
        process.send_signal(signal.SIGINT)
        assert process.wait(60) in CTRL_C, said.read_text()
    finally:
        process.kill()
        process.wait(10)


def jogs(case: Case, directory: Path, variables: dict[str, str]) -> None:
    """In a terminal; `q` comes to rest and ends it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(directory)
        for key, value in environment(**variables).items():
            patch.setenv(key, value)
        terminal = Terminal(["bash", "-c", case.command], 100, 30)
        try:
            terminal.shows(lambda text: "%" in text)
            terminal.press(b"q")
            until(lambda: terminal.lines() and terminal.process.poll() is not None, 60.0)
            assert terminal.process.returncode == 0, "\n".join(terminal.lines())
        finally:
            terminal.close()


def brought_to_its_state(case: Case, daemon: RunningDaemon) -> None:
    """Disarmed without e-stop, or armed; moving if it is to stop."""
    with Client(daemon.socket) as client:
        client.call("disarm")
        client.call("reset")
        if ARMED.search(case.command):
            client.call("arm")
        if " stop" in case.command:
            client.call("start", maneuver={"name": "slow_triangle"}, approach=True, countdown_s=0.0)
