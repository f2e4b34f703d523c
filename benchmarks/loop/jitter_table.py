"""The turns of `benchmarks.loop.jitter` as a table: medians of runs, then ratios turn by turn, for each load and all together."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from statistics import median
from typing import Any

import numpy as np
from numpy.typing import NDArray

OWN = ("clock", "longreachd", "longreachd-can")
RIVALS = ("cyclictest", "LinuxCNC")
HIGH = 1.5
_FLOOR_US = 0.1  # added to both sides: the clock itself is read no better
_SAMPLES = 2000


def table(turns: Sequence[dict[str, Any]]) -> list[str]:
    """Lines of text."""
    loads = list(dict.fromkeys(turn["load"] for turn in turns))
    lines = [_head(turns)]
    for load in [*loads, *(["all turns"] if len(loads) > 1 else [])]:
        chosen = [turn for turn in turns if load in (turn["load"], "all turns")]
        lines += ["", f"{_title(load)}, {len(chosen)} turns", *_runs(chosen), *_ratios(chosen)]
    return lines


def interval_of_median(values: Sequence[float]) -> tuple[float, float]:
    """95 %, from samples drawn of the values."""
    return _interval(np.median(_drawn(values), axis=1))


def interval_of_sum(values: Sequence[float]) -> tuple[float, float]:
    """The same of a sum: one turn in which the machine stands still may hold most of it."""
    return _interval(np.sum(_drawn(values), axis=1))


def _drawn(values: Sequence[float]) -> NDArray[np.float64]:
    return np.random.default_rng(0).choice(np.asarray(values, dtype=float), (_SAMPLES, len(values)))


def _interval(drawn: NDArray[np.float64]) -> tuple[float, float]:
    low, high = np.quantile(drawn, (0.025, 0.975))
    return float(low), float(high)


def _head(turns: Sequence[dict[str, Any]]) -> str:
    wanted, busy = [turn["wanted_1_min"] for turn in turns], [100 * turn["busy_beside"] for turn in turns]
    return (
        f"{len(turns)} turns from {turns[0]['utc']} to {turns[-1]['utc']} UTC; before a turn {min(wanted):.1f} to {max(wanted):.1f}\n"
        f"processes wanted a processor (median {median(wanted):.1f}); others took {min(busy):.0f} to {max(busy):.0f} % of all (median "
        f"{median(busy):.0f})"
    )


def _title(load: str) -> str:
    return {"idle": "no load of its own", "all": "load on every processor", "all turns": load}.get(load, f"load on processor {load}")


def _runs(turns: Sequence[dict[str, Any]]) -> Iterator[str]:
    yield f"{'period jitter (us), median of turns':36}{'p50':>7}{'p99':>7}{'p99.9':>8}   missed periods, most in a turn"
    for name in (*OWN, *RIVALS):
        runs = [turn["runs"][name] for turn in turns if name in turn["runs"]]
        broken = sum(name in turn["broken"] for turn in turns)
        if not runs:
            continue
        missed, cycles = [run["missed"] for run in runs], sum(run["cycles"] for run in runs)
        shares = sorted(100 * (run["processor"] - run["read"]) for run in runs if "processor" in run)
        yield (
            f"{name:36}{_median(runs, 'p50'):7.1f}{_median(runs, 'p99'):7.1f}{_median(runs, 'p99.9'):8.1f}"
            + f"{sum(missed):7.0f} of {cycles}, {max(missed):3.0f}"
            + (f"; of a processor {median(shares):.0f} % ({shares[0]:.0f} to {shares[-1]:.0f})" if shares else "")
            + (f"; {broken} broke off" if broken else "")
        )


def _median(runs: Sequence[dict[str, float]], key: str) -> float:
    return median(run[key] for run in runs)


def _ratios(turns: Sequence[dict[str, Any]]) -> Iterator[str]:
    above = f"{f'above {HIGH:g}':>11}"
    yield f"{'ratios within a turn: median (95 %)':36}{'p99':>25}{above}{'p99.9':>25}{above}{'missed more':>22}"
    for name in OWN:
        for rival in RIVALS:
            both = [(turn["runs"][name], turn["runs"][rival]) for turn in turns if {name, rival} <= turn["runs"].keys()]
            if both:
                yield f"{f'{name} over {rival}':36}" + "".join(_ratio(both, key) for key in ("p99", "p99.9")) + _missed_more(both)


def _ratio(both: Sequence[tuple[dict[str, float], dict[str, float]]], key: str) -> str:
    ratios = [(own[key] + _FLOOR_US) / (rival[key] + _FLOOR_US) for own, rival in both]
    low, high = interval_of_median(ratios)
    above = sum(ratio > HIGH for ratio in ratios)
    return f"{f'{median(ratios):.3f} ({low:.3f} to {high:.3f})':>25}{f'{above} of {len(ratios)}':>11}"


def _missed_more(both: Sequence[tuple[dict[str, float], dict[str, float]]]) -> str:
    """Periods that the first missed beyond those of the second, of as many cycles, in all turns together."""
    more = [own["missed"] - rival["missed"] * own["cycles"] / rival["cycles"] for own, rival in both]
    low, high = interval_of_sum(more)
    return f"{f'{sum(more):+.0f} ({low:+.0f} to {high:+.0f})':>22}"
