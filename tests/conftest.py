"""Tests marked `clock` have the machine for themselves: a daemon or twin on the wall clock whose cycles or time-outs they judge.

Everything else waits on conditions with limits of seconds, also where it starts processes, and runs beside other tests.
"""

from __future__ import annotations

import signal
import time
from collections.abc import Iterator

import pytest
from hypothesis import settings

from tests.support.machine.pauses import Pauses

settings.register_profile("any machine", deadline=None)  # how long an example takes says more of the machine than of the code
settings.load_profile("any machine")


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption(
        "--until",
        type=float,
        metavar="SECONDS_SINCE_1970",
        help="no test is begun later; what was left is skipped and named (not with --last-failed)",
    )


def pytest_configure(config: pytest.Config) -> None:
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:  # as in a shell's background: every program started here would ignore Ctrl-C
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if not hasattr(config, "workerinput"):
        config.pluginmanager.register(Pauses())


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    for item in items:
        if item.get_closest_marker("device_clock"):  # acts within milliseconds, or the driver calls it silent
            item.add_marker("clock")


@pytest.fixture
def terminal_can_end() -> Iterator[None]:
    """Under nohup, what a test starts would ignore the end of its terminal."""
    before = signal.signal(signal.SIGHUP, signal.SIG_DFL)
    yield
    signal.signal(signal.SIGHUP, before)


@pytest.hookimpl(tryfirst=True)
def pytest_runtest_setup(item: pytest.Item) -> None:
    until_s = item.config.getoption("--until")
    if until_s is not None and time.time() > until_s and not item.config.getoption("lf"):
        pytest.skip("not begun: the time that these tests have is over")
