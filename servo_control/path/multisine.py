"""Odd random-phase multisine, tabulated once so that a cycle of the loop costs one interpolation whatever the number of lines.

Only odd harmonics of the inverse period are excited: what appears at the even harmonics and at the odd ones left out is
nonlinearity or noise (R. Pintelon and J. Schoukens, System Identification: A Frequency Domain Approach, 2012, chapter 4).
Phases are drawn from a seeded generator until the crest factor is low enough.
"""

from __future__ import annotations

from array import array
from collections.abc import Sequence
from math import ceil, cos, pi, sin, sqrt
from random import Random

from config.errors import ManeuverError
from servo_control.path.waves import Fade

POINTS_PER_FASTEST_PERIOD = 40  # cubic Hermite interpolation is then right to 2e-6 of the fastest line
DRAWS = 60
FOUND_SHARE = 0.95  # of the crest factor's limit: draws are compared by a few points, and the peak lies between them


class Multisine:
    """`periods` full periods between a fade in and a fade out; the peak of one period is `amplitude`."""

    __slots__ = ("_fade", "_fade_s", "_period_s", "_rates", "_step_s", "_values", "duration_s", "harmonics")

    def __init__(
        self, amplitude: float, harmonics: Sequence[int], period_s: float, periods: int, fade_s: float, seed: int, crest_limit: float
    ) -> None:
        self.harmonics = tuple(harmonics)
        points = POINTS_PER_FASTEST_PERIOD * max(harmonics)
        phases = _phases_with_low_crest(self.harmonics, points, seed, crest_limit)
        values, rates = _tabulate(self.harmonics, phases, points, period_s)
        scale = amplitude / max(abs(v) for v in values)
        self._values = array("d", [scale * v for v in values])
        self._rates = array("d", [scale * r for r in rates])
        self._step_s = period_s / points
        self._period_s, self._fade_s = period_s, fade_s
        self.duration_s = 2.0 * fade_s + periods * period_s
        self._fade = Fade(fade_s, self.duration_s)

    def at(self, t: float) -> tuple[float, float, float]:
        place = ((t - self._fade_s) % self._period_s) / self._step_s
        index = int(place)
        return self._fade.times(t, *self._hermite(index % len(self._values), place - index))

    def _hermite(self, i: int, u: float) -> tuple[float, float, float]:
        k = (i + 1) % len(self._values)
        h = self._step_s
        y0, y1, d0, d1 = self._values[i], self._values[k], h * self._rates[i], h * self._rates[k]
        a, b = 2.0 * (y0 - y1) + d0 + d1, 3.0 * (y1 - y0) - 2.0 * d0 - d1
        return y0 + u * (d0 + u * (b + u * a)), (d0 + u * (2.0 * b + 3.0 * u * a)) / h, (2.0 * b + 6.0 * u * a) / (h * h)


def odd_harmonics(from_Hz: float, to_Hz: float, period_s: float, lines: int) -> tuple[int, ...]:
    """At most `lines` odd multiples of 1/period within [from, to], spread evenly over log frequency. Raises ManeuverError for none."""
    lowest, highest = from_Hz * period_s, to_Hz * period_s
    odd = [k for k in range(1, int(highest + 1e-9) + 1, 2) if k >= lowest - 1e-9]
    if not odd:
        raise ManeuverError(
            "the multisine has no line: no odd multiple of the inverse period lies between its frequencies",
            value=f"{from_Hz:g} to {to_Hz:g}",
            unit="Hz",
            limit=f"multiples of {1.0 / period_s:g}",
            next_step="Choose a longer period or a wider band.",
        )
    ratio = (odd[-1] / odd[0]) ** (1.0 / max(1, lines - 1))
    wanted = [odd[0] * ratio**i for i in range(lines)]
    return tuple(sorted({min(odd, key=lambda k: abs(k - w)) for w in wanted}))


def _phases_with_low_crest(harmonics: Sequence[int], points: int, seed: int, crest_limit: float) -> list[float]:
    best: tuple[float, list[float]] | None = None
    random = Random(seed)
    coarse = max(1, points // (8 * max(harmonics)))  # eight points a period are enough to compare draws
    for _ in range(DRAWS):
        phases = [2.0 * pi * random.random() for _ in harmonics]
        crest = _crest(harmonics, phases, points // coarse)
        if best is None or crest < best[0]:
            best = crest, phases
        if crest <= FOUND_SHARE * crest_limit:
            return phases
    assert best is not None
    enough = ceil(100.0 * best[0] / FOUND_SHARE) / 100.0
    raise ManeuverError(
        f"no phases with a low enough crest factor in {DRAWS} draws",
        value=f"{best[0]:.3f}",
        limit=f"{FOUND_SHARE * crest_limit:.3f}, {FOUND_SHARE:g} of crest_limit",
        next_step=f"Raise crest_limit to {enough:g}, use fewer lines or another seed.",
        mend={"crest_limit": f"{enough:g}"},
    )


def _crest(harmonics: Sequence[int], phases: Sequence[float], points: int) -> float:
    step = 2.0 * pi / points
    lines = list(zip(harmonics, phases, strict=True))
    peak = max(abs(sum([cos(k * step * n + p) for k, p in lines])) for n in range(points))
    return peak / sqrt(0.5 * len(lines))


def _tabulate(harmonics: Sequence[int], phases: Sequence[float], points: int, period_s: float) -> tuple[list[float], list[float]]:
    omega = 2.0 * pi / period_s
    lines = list(zip(harmonics, phases, strict=True))
    times = [n * period_s / points for n in range(points)]
    values = [sum([cos(k * omega * t + p) for k, p in lines]) for t in times]
    rates = [sum([-k * omega * sin(k * omega * t + p) for k, p in lines]) for t in times]
    return values, rates
