"""What a pause of the machine excuses, and what it does not: the plug-in of tests/conftest.py on tests of its own."""

from __future__ import annotations

import itertools
import time

import pytest

from tests.support.machine.pauses import TRIES, Pause, Pauses

pytest_plugins = "pytester"

TEST = """
import pytest
from pathlib import Path

@pytest.fixture(scope="module")
def daemon():
    tries = Path("tries")
    tries.write_text(tries.read_text() + "x" if tries.exists() else "x")
    return tries

@pytest.mark.clock
def test_it(daemon):
    assert len(daemon.read_text()) >= {passes_at}, "9 overruns"
"""


class PausesAt(Pauses):
    """The machine stands still in these tries, counted from 1."""

    def __init__(self, *tries: int) -> None:
        super().__init__()
        self.tries, self.count = tries, itertools.count(1)

    def seen(self, start_s: float) -> list[Pause]:
        return [Pause(start_s, start_s + 0.034)] if next(self.count) in self.tries else []


def outcome(pytester: pytest.Pytester, pauses: Pauses, passes_at: int) -> tuple[dict[str, int], str]:
    pytester.makeini("[pytest]\nmarkers = clock")
    pytester.makepyfile(TEST.format(passes_at=passes_at))
    result = pytester.inline_run(plugins=[pauses])
    passed, skipped, failed = result.countoutcomes()
    return {"passed": passed, "skipped": skipped, "failed": failed}, "\n".join(pauses.told)


def test_a_test_that_met_a_pause_is_tried_again_with_new_fixtures(pytester: pytest.Pytester) -> None:
    counts, told = outcome(pytester, PausesAt(1, 2), passes_at=3)
    assert counts == {"passed": 1, "skipped": 0, "failed": 0}
    assert told.count("34 ms") == 2
    assert "9 overruns" in told


def test_one_that_meets_a_pause_in_every_try_is_not_judged(pytester: pytest.Pytester) -> None:
    assert outcome(pytester, PausesAt(*range(1, TRIES + 1)), passes_at=9)[0] == {"passed": 0, "skipped": 1, "failed": 0}


def test_one_that_fails_without_a_pause_fails(pytester: pytest.Pytester) -> None:
    assert outcome(pytester, PausesAt(), passes_at=2)[0] == {"passed": 0, "skipped": 0, "failed": 1}


def test_one_that_fails_again_without_a_pause_fails(pytester: pytest.Pytester) -> None:
    assert outcome(pytester, PausesAt(1), passes_at=9)[0] == {"passed": 0, "skipped": 0, "failed": 1}


def test_what_passes_is_not_asked_for_pauses(pytester: pytest.Pytester) -> None:
    counts, told = outcome(pytester, PausesAt(1), passes_at=1)
    assert counts["passed"] == 1
    assert told == ""


def test_a_pause_counts_from_the_begin_of_the_try() -> None:
    pauses, now = Pauses(), time.monotonic()
    (pauses.directory / "0.txt").write_text(f"{now - 2} {now - 1}\n{now - 0.1} {now + 0.1}\n")
    assert pauses.seen(now) == [Pause(now - 0.1, now + 0.1)]
    pauses.pytest_unconfigure()
