"""What a number does over the weeks: it stays, drifts along a straight line, steps, or does both.

The logs are cut into pieces one break at a time (binary segmentation: A. J. Scott and M. Knott, Biometrics 30, 1974). A break is the best
of all places between two logs; its likelihood ratio has the scatter estimated with it, and Bonferroni's bound on the maximum over places
(K. J. Worsley, "On the likelihood ratio test for a shift in location of normal populations", JASA 74, 1979). This is done twice, with a
level in each piece and with a straight line in each; of the two the one with the smaller BIC is told, a break's place counted as a number.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.stats import f

from gap.data.measured import Array
from gap.watch.regression import Regression, regression

LEAST_P = 0.01  # of all numbers of a rig together, for any break or drift to be told


@dataclass(frozen=True, slots=True)
class Pieces:
    """Logs in pieces: `firsts` are the numbers of the first log of each but the first. `numbers` of each piece: 1, its level, or 2, its
    level in the middle and its slope a day."""

    days: Array
    firsts: tuple[int, ...]
    numbers: int

    def row(self, piece: int, day: float) -> Array:
        """Of the design: a moment as this piece has it."""
        row = np.zeros(self.numbers * (len(self.firsts) + 1))
        inside = self.days[slice(*self.ends(piece))]
        row[self.numbers * piece : self.numbers * (piece + 1)] = [1.0, day - inside.mean()][: self.numbers]
        return row

    def ends(self, piece: int) -> tuple[int, int]:
        """First log of a piece, and of the next."""
        edges = (0, *self.firsts, len(self.days))
        return edges[piece], edges[piece + 1]

    @property
    def design(self) -> Array:
        whole = np.zeros((len(self.days), self.numbers * (len(self.firsts) + 1)))
        for piece in range(len(self.firsts) + 1):
            inside = slice(*self.ends(piece))
            days = self.days[inside]
            whole[inside, self.numbers * piece] = 1.0
            if self.numbers == 2:
                whole[inside, 2 * piece + 1] = days - days.mean()
        return whole

    def further(self) -> list[Pieces]:
        """Every further break that leaves each side more logs than numbers, not all of one moment."""
        edges = (0, *self.firsts, len(self.days))
        places = [k for k in range(1, len(self.days)) if min(abs(k - edge) for edge in edges) > self.numbers]
        cut = [Pieces(self.days, tuple(sorted((*self.firsts, k))), self.numbers) for k in places if self.days[k] > self.days[k - 1]]
        return [pieces for pieces in cut if pieces.told]

    @property
    def told(self) -> bool:
        """Whether every piece has as many moments as numbers."""
        ends = [self.ends(piece) for piece in range(len(self.firsts) + 1)]
        return all(len(set(self.days[first:last])) >= self.numbers for first, last in ends)


@dataclass(frozen=True, slots=True)
class Course:
    """What is told (`pieces`, `fit`), and the slope of the last piece, told or not: a day, with its 95 % half width."""

    pieces: Pieces
    fit: Regression
    slope: tuple[float, float]
    drifts: bool

    @property
    def steps(self) -> tuple[int, ...]:
        """Numbers of the first log after each."""
        return self.pieces.firsts

    def step(self, number: int) -> tuple[float, float]:
        """By how much it is another there than the piece before would be, and the 95 % half width."""
        day = float(self.pieces.days[self.steps[number]])
        height, sd = self.fit.at(self.pieces.row(number + 1, day) - self.pieces.row(number, day))
        return height, self.fit.times_sd() * sd

    @property
    def now(self) -> tuple[float, float]:
        """At the last log, and its standard deviation."""
        return self.fit.at(self.pieces.row(len(self.steps), float(self.pieces.days[-1])))


def course(days: Array, values: Array, sds: Array, least_p: float = LEAST_P) -> Course:
    """Logs in the order of time, of two moments at least. `sds`: what each would scatter by if it were run again; `least_p`: chance of
    telling a break or drift that is not there."""
    levels, lines = (_broken(Pieces(days, (), numbers), values, sds, least_p) for numbers in (1, 2))
    chances = [lines[1].p_of(column) for column in range(1, lines[1].design.shape[1], 2)]
    sloping = min(chances) * len(chances) < least_p
    pieces, fit = lines if sloping and _bic(*lines) < _bic(*levels) else levels
    return Course(pieces, fit, _slope(pieces, fit), chances[-1] < least_p and pieces.numbers == 2)


def _slope(pieces: Pieces, fit: Regression) -> tuple[float, float]:
    """Of the last piece; with levels, the line that would fit there beside the others' levels."""
    if pieces.numbers == 1:
        first, last = pieces.ends(len(pieces.firsts))
        days = pieces.days[first:last]
        if len(set(days)) < 2 or fit.freedom < 2:
            return 0.0, np.inf
        tilt = np.where(np.arange(len(pieces.days)) >= first, pieces.days - days.mean(), 0.0)
        fit = regression(np.column_stack([fit.design, tilt]), fit.values, fit.sds)
    return float(fit.beta[-1]), fit.times_sd() * float(np.sqrt(fit.covariance[-1, -1]))


def _bic(pieces: Pieces, found: Regression) -> float:
    return found.bic + len(pieces.firsts) * float(np.log(len(found.values)))


def _broken(pieces: Pieces, values: Array, sds: Array, least_p: float) -> tuple[Pieces, Regression]:
    """The pieces with every break that is clear beside those before it."""
    found = regression(pieces.design, values, sds)
    while (more := _clearest(pieces, found)) is not None and more[1] < least_p:
        pieces = more[0]
        found = regression(pieces.design, values, sds)
    return pieces, found


def _clearest(pieces: Pieces, found: Regression) -> tuple[Pieces, float] | None:
    """The likeliest further break, and the chance of one as clear where there is none; None where none is possible."""
    free, cuts = found.freedom - pieces.numbers, pieces.further()
    if free < 1 or not cuts:
        return None
    root = np.sqrt(found.weights)
    left = [_left(cut.design * root[:, None], found.values * root) for cut in cuts]
    best = int(np.argmin(left))
    # Logs that scatter less than their intervals say do not make these narrower.
    before = _left(found.design * root[:, None], found.values * root)
    gain = before - left[best]
    rest = max(before, float(found.freedom)) - gain
    chance = f.sf(gain / pieces.numbers * free / max(rest, 1e-12), pieces.numbers, free)
    return cuts[best], min(1.0, len(cuts) * float(chance))


def _left(design: Array, values: Array) -> float:
    """Squares that the best coefficients leave."""
    return float(np.sum((values - design @ np.linalg.lstsq(design, values, rcond=None)[0]) ** 2))
