"""What the hold-out prefers a set to: beside the sum of its windows, and their spread by drawing blocks with repetition."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from gap.evidence.judgement.preference import preferences
from gap.evidence.score.hypothesis import Hypothesis

NONE, NAME, RIVAL = frozenset[str](), frozenset({"friction at axis"}), frozenset({"gravity at axis"})
FITTED, HELD = 12, 60


def of_windows(windows: np.ndarray, rest: float = 0.0) -> Hypothesis:
    nothing: Any = None
    return Hypothesis((), nothing, float(windows.sum()) + rest, windows)


def drawn(seed: int, gain: float, spread: float) -> tuple[dict[frozenset[str], Hypothesis], dict[frozenset[str], Hypothesis]]:
    """The name gains so much in every window of the hold-out beside none, the rival a little less; nothing in the fit logs."""
    draw = np.random.default_rng(seed)
    base = draw.normal(-40.0, 5.0, FITTED + HELD)
    more = np.concatenate([np.zeros(FITTED), draw.normal(gain, spread, HELD)])
    windows = {NONE: base, NAME: base + more, RIVAL: base + 0.9 * more}
    return {k: of_windows(w[:FITTED]) for k, w in windows.items()}, {k: of_windows(w, 7.0) for k, w in windows.items()}


SHARES = {NONE: 0.1, NAME: 0.7, RIVAL: 0.2}


def test_the_gain_is_what_the_hold_out_adds_and_the_interval_that_of_drawn_blocks() -> None:
    fitted, on_all = drawn(1, 0.5, 1.0)
    to_none, to_rival = preferences(fitted, on_all, NAME, SHARES)
    assert (to_none.over, to_rival.over) == (NONE, RIVAL)
    parts = (on_all[NAME].windows - on_all[NONE].windows)[FITTED:]
    assert to_none.gain == pytest.approx(parts.sum())
    assert to_rival.gain == pytest.approx(0.1 * parts.sum())
    sums = parts.reshape(-1, 3).sum(axis=1)
    draw = np.random.default_rng(5)
    again = [draw.choice(sums, len(sums)).sum() for _ in range(4000)]
    assert to_none.high - to_none.low == pytest.approx(np.subtract(*np.percentile(again, [97.5, 2.5])), rel=0.15)


def test_the_interval_holds_the_expected_gain_in_about_95_of_100() -> None:
    inside = 0
    for seed in range(200):
        (to_none, _) = preferences(*drawn(seed, 0.3, 1.0), NAME, SHARES)
        inside += to_none.low < 0.3 * HELD < to_none.high
    assert 0.88 <= inside / 200 <= 0.99


def test_constants_alone_are_asked_beside_the_best_name() -> None:
    (to_name,) = preferences(*drawn(3, 0.5, 1.0), NONE, SHARES)
    assert to_name.over == NAME
    assert to_name.gain < 0.0
    assert to_name.as_dict() == {"over": ["friction at axis"], "ln": pytest.approx(to_name.gain, rel=1e-5),
                                 "ci95": pytest.approx([to_name.low, to_name.high], rel=1e-5)}  # fmt: skip
