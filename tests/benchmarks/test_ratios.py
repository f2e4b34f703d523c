"""A ratio fails where a run's median is worse than the baseline by more than half of the baseline's spread, and not before."""

from __future__ import annotations

import random

import pytest

from benchmarks.ratios import PAIRS, judged, pairs_of, spread_of


def run(middle: float, noise: float, seed: int) -> list[float]:
    random.seed(seed)
    return [random.gauss(middle, noise) for _ in range(PAIRS)]


def test_runs_like_those_of_the_baseline_pass_and_a_slower_one_fails() -> None:
    """Noise of 5 % a pair: no run of a thousand fails by chance, and 15 % slower is seen in all."""
    median, spread = spread_of([run(2.0, 0.1, seed) for seed in range(12)])
    kept = {"a": {"median": median, "spread": spread}}
    assert median == pytest.approx(2.0, abs=0.05)
    assert spread == pytest.approx(2 * 1.645 * 0.1, rel=0.2)
    verdicts = [next(judged({"a": run(2.0, 0.1, seed)}, kept))[1] for seed in range(100, 1100)]
    assert not any(verdicts)
    assert all(next(judged({"a": run(2.3, 0.1, seed)}, kept))[1] for seed in range(100, 1100) if seed % 10 == 0)


def test_runs_that_differ_as_a_whole_widen_the_spread() -> None:
    runs = [run(middle, 0.001, seed) for seed, middle in enumerate((1.0, 1.3, 1.1))]
    median, spread = spread_of(runs)
    assert (median, spread) == (pytest.approx(1.1, abs=0.01), pytest.approx(0.3, abs=0.01))


def test_better_is_never_worse_and_without_a_baseline_nothing_is() -> None:
    line, worse = next(judged({"a": [0.5]}, {"a": {"median": 1.0, "spread": 0.1}}))
    assert not worse
    assert line.endswith("baseline 1.000, limit 1.050: ok")
    line, worse = next(judged({"b": [9.0]}, {}))
    assert not worse
    assert line.endswith("no baseline")


def test_a_ratio_is_that_of_the_two_sides_work() -> None:
    def counted(terms: int) -> object:
        return lambda: sum(range(terms))

    found = pairs_of({"twice": (counted(200_000), counted(100_000))}, 9)
    assert sorted(found["twice"])[4] == pytest.approx(2.0, rel=0.3)
