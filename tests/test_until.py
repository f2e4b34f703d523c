"""`--until` of tests/conftest.py: what is not begun in time is skipped, and a failure stays one."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest_plugins = "pytester"

IN_2100_S = "4102444800"


@pytest.fixture
def failing(pytester: pytest.Pytester) -> pytest.Pytester:
    pytester.makeconftest(Path(__file__).with_name("conftest.py").read_text())
    pytester.makepyfile("def test_it():\n    assert False")
    return pytester


def test_a_test_is_begun_in_time_or_skipped(failing: pytest.Pytester) -> None:
    failing.runpytest("--until", IN_2100_S).assert_outcomes(failed=1)
    skipped = failing.runpytest("--until", "1", "-rs")
    skipped.assert_outcomes(skipped=1)
    skipped.stdout.fnmatch_lines(["SKIPPED*not begun*"])


def test_a_second_try_of_what_failed_is_begun_whatever_the_time(failing: pytest.Pytester) -> None:
    failing.runpytest("--until", IN_2100_S).assert_outcomes(failed=1)
    failing.runpytest("--until", "1", "--last-failed").assert_outcomes(failed=1)
