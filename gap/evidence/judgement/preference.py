"""By how much the hold-out prefers the chosen set to none and to its best rival, and how sure that is.

    D = ln p(hold-out | fit logs, S) − ln p(hold-out | fit logs, S′)          (gap.evidence.judgement.judge)

Every window of the hold-out adds its own part, the rest of D is what all logs together say of the sets' numbers. The interval is that of
the Bayesian bootstrap (Rubin 1981) over blocks of neighbouring windows, which hold one stretch of the motion each.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gap.data.measured import Array
from gap.evidence.score.bootstrap import random_weights
from gap.evidence.score.hypothesis import Hypothesis

_BLOCK = 3  # neighbouring windows drawn together

Sets = Mapping[frozenset[str], Hypothesis]


@dataclass(frozen=True, slots=True)
class Preference:
    """`gain`: D (ln) with its 95 % interval; `over`: the labels of S′."""

    over: frozenset[str]
    gain: float
    low: float
    high: float

    def as_dict(self) -> dict[str, object]:
        return {"over": sorted(self.over), "ln": _short(self.gain), "ci95": [_short(self.low), _short(self.high)]}

    def text(self) -> str:
        return f"ln odds {self.gain:+.1f} (95 % {self.low:+.1f} to {self.high:+.1f})"


def preferences(fitted: Sets, on_all: Sets, chosen: frozenset[str], shares: Mapping[frozenset[str], float]) -> tuple[Preference, ...]:
    """Of the chosen set to none, unless it is that, and to the likeliest other one that the hold-out was asked about. `fitted`: sets on the
    fit logs, `on_all`: on all logs, the hold-out's windows last; `shares`: of the posterior."""
    none = frozenset[str]()
    rivals = sorted((labels for labels in on_all if labels not in (chosen, none)), key=lambda labels: -shares[labels])[:1]
    others = [*([none] if chosen else []), *rivals]
    return tuple(_preference(fitted, on_all, chosen, other) for other in others)


def _preference(fitted: Sets, on_all: Sets, chosen: frozenset[str], other: frozenset[str]) -> Preference:
    gain, windows = 0.0, []
    for labels, sign in ((chosen, 1.0), (other, -1.0)):
        gain += sign * (on_all[labels].log_z - fitted[labels].log_z)
        windows.append(on_all[labels].windows[len(fitted[labels].windows) :])
    low, high = gain + _spread(windows[0] - windows[1])
    return Preference(other, gain, float(low), float(high))


def _spread(parts: Array) -> Array:
    """2.5 and 97.5 % of the sum of what windows add, about that sum, their blocks weighted at random."""
    blocks = np.add.reduceat(parts, np.arange(0, len(parts), _BLOCK))
    return np.percentile((random_weights(len(blocks)) - 1.0) @ blocks, [2.5, 97.5])


def _short(value: float) -> float:
    return float(f"{value:.6g}")
