"""A ratio fails where its median is worse than the baseline by more than half of the baseline's spread, in every run, and not before."""

from __future__ import annotations

import random
from collections.abc import Callable

import pytest

from benchmarks.ratios import BETWEEN_PROCESSORS, JUDGED, PAIRS, RUNS, baseline_for, judged, kernel_and_c, pairs_of, spread_of, worse

KERNEL = JUDGED[0]


def run(middle: float, noise: float, seed: int) -> list[float]:
    random.seed(seed)
    return [random.gauss(middle, noise) for _ in range(PAIRS)]


def one(pairs: list[float], kept: dict[str, dict[str, float]]) -> tuple[str, bool]:
    ((_, line, above),) = judged({KERNEL: pairs}, kept)
    return line, above


def test_runs_like_those_of_the_baseline_pass_and_a_slower_one_fails() -> None:
    """Noise of 5 % a pair: no run of a thousand is worse by chance, and 30 % slower is seen in all."""
    middle, spread = spread_of([run(2.0, 0.1, seed) for seed in range(12)])
    kept = {KERNEL: {"median": middle, "spread": spread}}
    assert middle == pytest.approx(2.0, abs=0.05)
    assert spread < 0.1 * 2.0  # medians of fifteen pairs scatter by 1.25 × 5 % / √15
    assert not any(one(run(2.0, 0.1, seed), kept)[1] for seed in range(100, 1100))
    assert all(one(run(2.6, 0.1, seed), kept)[1] for seed in range(100, 1100, 10))


def test_runs_that_differ_as_a_whole_widen_the_spread() -> None:
    runs = [run(middle, 0.001, seed) for seed, middle in enumerate((1.0, 1.3, 1.1))]
    middle, spread = spread_of(runs)
    assert (middle, spread) == (pytest.approx(1.1, abs=0.01), pytest.approx(0.3, abs=0.01))


def test_a_single_pair_does_not_widen_the_spread() -> None:
    calm = [[1.0] * PAIRS for _ in range(11)]
    assert spread_of([*calm, [1.0] * (PAIRS - 1) + [9.0]]) == (1.0, 0.0)


def test_better_is_never_worse_and_without_a_baseline_nothing_is() -> None:
    line, above = one([0.5], {KERNEL: {"median": 1.0, "spread": 0.5}})
    assert not above
    assert line.endswith("baseline 1.000, limit 1.250: ok")
    line, above = one([9.0], {})
    assert not above
    assert line.endswith("no baseline")


def test_a_baseline_of_calm_runs_still_leaves_a_fifth() -> None:
    kept = {KERNEL: {"median": 1.0, "spread": 0.01}}
    assert not one([1.19], kept)[1]
    assert one([1.21], kept)[1]


def test_what_a_busy_machine_alone_makes_worse_is_shown_and_not_judged() -> None:
    kept = {"controller over arithmetic": {"median": 1.0, "spread": 0.1}}
    ((_, line, above),) = judged({"controller over arithmetic": [2.0]}, kept)
    assert not above
    assert line.endswith("above, not judged")


def runs(*middles: float) -> Callable[[], dict[str, list[float]]]:
    left = list(middles)
    return lambda: {KERNEL: [left.pop(0)]}


def test_only_what_is_worse_in_every_run_fails(capsys: pytest.CaptureFixture[str]) -> None:
    kept = {KERNEL: {"median": 1.0, "spread": 0.2}}
    assert worse(runs(1.05), kept) == []
    assert "again" not in capsys.readouterr().out
    assert worse(runs(*[1.5] * (RUNS - 1), 1.05), kept) == []
    assert worse(runs(*[1.5] * RUNS), kept) == [KERNEL]
    assert capsys.readouterr().out.count("measured again") == 2 * (RUNS - 1)


def test_another_processor_is_judged_by_the_loosest_limit_and_what_processors_differ_by() -> None:
    one_of = {"host_python": "3.11.7", "ratios": {KERNEL: {"median": 1.0, "spread": 0.1}}}
    kept = {"A": one_of, "B": {"host_python": "3.11.2", "ratios": {KERNEL: {"median": 0.8, "spread": 1.0}}}}
    assert baseline_for(kept, "A", "3.11.9") == (one_of["ratios"], 1.0)
    baseline, allowance = baseline_for(kept, "C", "3.11.9")
    assert (baseline[KERNEL]["median"], allowance) == (0.8, BETWEEN_PROCESSORS)
    limit = 1.3 * BETWEEN_PROCESSORS
    assert worse(lambda: {KERNEL: [limit - 0.01]}, baseline, allowance) == []
    assert worse(lambda: {KERNEL: [limit + 0.01]}, baseline, allowance) == [KERNEL]


def test_a_baseline_of_another_python_judges_nothing() -> None:
    kept = {"A": {"host_python": "3.11.7", "ratios": {KERNEL: {"median": 1.0, "spread": 0.1}}}}
    baseline, allowance = baseline_for(kept, "A", "3.12.1")
    assert worse(lambda: {KERNEL: [9.0]}, baseline, allowance) == []


def test_a_ratio_is_that_of_the_two_sides_work() -> None:
    def counted(terms: int) -> object:
        return lambda: sum(range(terms))

    found = pairs_of({"twice": (counted(200_000), counted(100_000))}, 9)
    assert sorted(found["twice"])[4] == pytest.approx(2.0, rel=0.3)


def test_a_kernel_that_is_called_twice_fails_where_the_kernel_itself_passes() -> None:
    """A slowdown injected on purpose, against a baseline that is made of the kernel beside C right here."""
    try:
        kernel, in_c = kernel_and_c()
    except FileNotFoundError:
        pytest.skip("no C compiler")

    def twice() -> None:
        kernel()
        kernel()

    ways = {"once": (kernel, in_c), "twice": (twice, in_c)}
    pairs_of(ways, 1)  # nothing is measured cold
    found = pairs_of(ways, 5)
    middle, _ = spread_of([found["once"]])
    kept = {KERNEL: {"median": middle, "spread": 0.5 * middle}}  # wider than any seen on a loaded machine
    assert worse(lambda: {KERNEL: found["once"]}, kept) == []
    assert worse(lambda: {KERNEL: found["twice"]}, kept) == [KERNEL]
