"""`longreach top` in a terminal emulator."""

from __future__ import annotations

import asyncio
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from daemon.live.terminal.screen import within
from daemon.server.protocol import Client
from tests.support.live.lockstep_daemon import lockstep_daemon
from tests.support.live.terminal import longreach_in_terminal

ENTER, LEAVE = b"\x1b[?1049h", b"\x1b[?1049l"  # the alternate screen of xterm


@pytest.fixture
def socket(tmp_path: Path) -> Iterator[str]:
    with lockstep_daemon(tmp_path) as path:
        yield str(path)


@pytest.mark.slow
def test_it_shows_mode_joints_oil_and_checks_and_follows_what_happens(socket: str) -> None:
    with longreach_in_terminal("--socket", socket, "top") as terminal:
        screen = terminal.shows(lambda text: re.search(r"1 of \d+ checks stand in the way", text) is not None)
        assert "ornl_testbed  DISARMED  e-stop latched" in screen
        assert "NO e-stop" in screen
        assert re.search(r"rotary +-?\d+\.\d+ deg", screen)
        assert re.search(r"prismatic +(39\.99|40\.00)\d in", screen)
        assert re.search(r"rotary +\d+\.\d+ psi", screen)
        with Client(socket) as client:
            client.call("reset")
            terminal.shows(lambda text: re.search(r"\d+ checks: nothing stands in the way", text) is not None)
            client.call("arm")
            terminal.shows(lambda text: "HOLDING" in text)
            client.call("estop")
        assert "e-stop was asked for" in terminal.shows(lambda text: "FAULT" in text)


@pytest.mark.parametrize(("columns", "rows"), [(80, 24), (60, 16), (200, 60)])
def test_it_fits_the_terminal(socket: str, columns: int, rows: int) -> None:
    with longreach_in_terminal("--socket", socket, "top", columns=columns, rows=rows) as terminal:
        terminal.shows(lambda text: "stand in the way" in text)
        lines = terminal.lines()
        assert "DISARMED" in lines[0]
        assert any("longreach estop" in line for line in lines)


@pytest.mark.parametrize("key", [b"q", b"\x03"])
def test_the_terminal_is_as_before_when_it_ends(socket: str, key: bytes) -> None:
    with longreach_in_terminal("--socket", socket, "top") as terminal:
        terminal.shows(lambda text: "DISARMED" in text)
        assert terminal.settings() != terminal.settings_before
        terminal.press(key)
        assert terminal.process.wait(20) == (0 if key == b"q" else 130)
        terminal.lines()
        assert terminal.settings() == terminal.settings_before
        assert terminal.seen.count(ENTER) == terminal.seen.count(LEAVE) == 1


def test_ctrl_c_is_heard_when_it_comes_together_with_data() -> None:
    """The screen stayed until Ctrl-C was pressed again."""

    async def watched() -> bool:
        data = asyncio.Event()

        async def watch() -> None:
            while True:
                await within(5.0, data.wait())
                data.clear()

        watching = asyncio.create_task(watch())
        await asyncio.sleep(0.01)
        data.set()
        await asyncio.sleep(0)
        watching.cancel()  # as asyncio.run does at Ctrl-C
        await asyncio.wait({watching}, timeout=2.0)
        return watching.cancelled()

    assert asyncio.run(watched())


def test_without_a_daemon_it_says_so_and_waits(tmp_path: Path) -> None:
    with longreach_in_terminal("--socket", str(tmp_path / "none"), "top") as terminal:
        terminal.shows(lambda text: "NO LIVE DATA" in text and "longreachd" in text)
        with lockstep_daemon(tmp_path) as path:
            path.rename(tmp_path / "none")
            terminal.shows(lambda text: "DISARMED" in text and "NO LIVE DATA" not in text)


def test_without_a_terminal_it_prints_one_picture(socket: str) -> None:
    command = [sys.executable, "-m", "daemon.cli.main", "--socket", socket, "top"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0
    assert "DISARMED" in done.stdout
    assert "\x1b" not in done.stdout


def test_without_a_terminal_and_a_daemon_it_says_so_and_ends(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "daemon.cli.main", "--socket", str(tmp_path / "none"), "top"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 1
    assert "NO LIVE DATA" in done.stdout
