"""What C⁻¹ makes of the rows that are integrated out, [A B], kept for every δ and T that was asked for.

While constants are fitted these rows stay the same; only the residuals change. So of the inner products

    G = [A B x]ᵀ C⁻¹ [A B x]

the part of [A B] is taken once for every channel, window, δ and T (all on the rungs of a ladder, ornstein_uhlenbeck), and a try of another
discrepancy costs one filter of x, forwards and back. What is kept is a memory of a pure function: the result is the same without it.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from threading import Lock

import numpy as np
from numpy.typing import NDArray

from gap.data.measured import Array
from gap.data.windows import Experiment
from gap.evidence.noise.ornstein_uhlenbeck import Filter, at_rung, filter_of, gains, rung, sample_period_s, solved, whitened
from gap.evidence.noise.unknowns import Unknowns

Numbers = NDArray[np.int64]
Blocks = Sequence[Array]  # of rows, each numbers × windows × samples × channels; together they may be larger than a copy has room for
_LOWEST, _HIGHEST = (int(rung(value)) for value in (1e-3, 1e8))  # of δ in a window
_ONE_AT_A_TIME = Lock()  # of the threads of a search, while they look at what is kept or add to it
_AT_ONCE = 130  # rows of windows that are whitened before their products are taken: they fit a processor's own memory
_KEPT_BYTES = 8_000_000  # of one log and channel; then it is begun anew, which costs no more time than looking through more


@dataclass(frozen=True, slots=True)
class Part:
    """What one channel adds in one log: inner products of [A B] in every window, `numbers` into `grams`; `cross`, what x and each of
    [A B x] have; log|C| of every window."""

    grams: Array
    numbers: Numbers
    cross: Array
    log_det: Array

    @property
    def squares(self) -> Array:
        """xᵀ C⁻¹ x of every window."""
        return self.cross[:, -1]

    @property
    def whole(self) -> Array:
        """Inner products of [A B x], one matrix a window."""
        return joined(self.grams[self.numbers], self.cross[:, None, :-1], self.cross[:, -1:, None])


@dataclass(slots=True)
class _Kept:
    """Of one channel and T: inner products of [A B] in a window with a δ; `where`: windows × rungs, −1 for none."""

    where: Numbers
    grams: Array
    log_det: Array
    count: int = 0

    def add(self, windows: Numbers, rungs: Numbers, grams: Array, log_det: Array) -> Numbers:
        """Keep these; where they stand from now on. What was handed out before stays as it was."""
        made = np.arange(self.count, self.count + len(windows))
        if made[-1] >= len(self.grams):
            size = max(2 * len(self.grams), made[-1] + 1)
            grown, log_dets = np.empty((size, *self.grams.shape[1:])), np.empty(size)
            grown[: self.count], log_dets[: self.count] = self.grams[: self.count], self.log_det[: self.count]
            self.grams, self.log_det = grown, log_dets
        self.grams[made], self.log_det[made], self.where[windows, rungs] = grams, log_det, made
        self.count += len(windows)
        return made


@dataclass(frozen=True)
class Whitening:
    """One log with what its readings hang on."""

    experiment: Experiment
    unknowns: Unknowns
    _kept: dict[tuple[int, int], _Kept] = field(default_factory=dict, compare=False, repr=False)

    @property
    def states(self) -> int:
        """Unknowns of a window's own: the first rows."""
        return len(self.unknowns.states)

    @property
    def forms(self) -> int:
        """Those that all windows share: the rows that follow."""
        return len(self.unknowns.forms)

    def widths(self, share: float, contact: float) -> Array:
        """Standard deviations of the shares of these: `share` η, and of contacts that do not creep."""
        widths = np.full(self.forms, share)
        widths[self.forms - self.unknowns.contacts :] = contact
        return widths

    @cached_property
    def there(self) -> NDArray[np.bool_]:
        """What was measured, windows × samples × channels."""
        return np.isfinite(self.experiment.measured)

    @cached_property
    def _samples_there(self) -> list[NDArray[np.bool_]]:
        """The same of every channel, samples × windows."""
        return [np.ascontiguousarray(self.there[:, :, c].T) for c in range(self.there.shape[2])]

    @cached_property
    def period_s(self) -> float:
        return sample_period_s(self.experiment)

    @cached_property
    def _by_channel(self) -> list[Array]:
        """[A B] of every channel, windows × samples × numbers."""
        rows = np.concatenate([self.unknowns.states, self.unknowns.forms])
        return [np.ascontiguousarray(np.moveaxis(rows[..., c], 0, -1)) for c in range(rows.shape[-1])]

    @cached_property
    def reached(self) -> list[bool]:
        """Whether [A B] changes a channel at all: a pump that holds its pressure leaves nothing of a valve's start in it."""
        return [bool(rows.any()) for rows in self._by_channel]

    @cached_property
    def _by_window(self) -> Array:
        """[A B] of every window, windows × values × numbers."""
        rows = np.concatenate([self.unknowns.states, self.unknowns.forms])
        numbers, windows, samples, channels = rows.shape
        return np.ascontiguousarray(np.moveaxis(rows, 0, -1)).reshape(windows, samples * channels, numbers)

    def part(self, c: int, left: Array, sizes: Numbers, time: int) -> Part:
        """Of one channel with the residuals `left` (samples × windows), δ of every window and T as rungs."""
        sizes, decay = np.clip(sizes, _LOWEST, _HIGHEST), self._decay(time)
        row, squares = solved(left, *gains(self._samples_there[c], at_rung(sizes) ** 2, decay), decay)
        kept, numbers = self._of_unknowns(c, sizes, time)
        products = np.matmul(np.ascontiguousarray(row.T)[:, None], self._by_channel[c])[:, 0]
        cross = np.concatenate([products, squares[:, None]], axis=1)
        return Part(kept.grams, numbers, cross, kept.log_det[numbers])

    def squares(self, c: int, left: Array, sizes: Numbers, time: int) -> Part:
        """The same of a channel that is not reached: x alone."""
        sizes, decay = np.clip(sizes, _LOWEST, _HIGHEST), self._decay(time)
        gain, root = gains(self._samples_there[c], at_rung(sizes) ** 2, decay)
        _, squares = solved(left, gain, root, decay)
        nothing = np.empty((0, self.states + self.forms, self.states + self.forms))
        return Part(nothing, np.empty(0, dtype=np.int64), squares[:, None], _log_det(self._samples_there[c], root))

    def grams(self, rows: Blocks, sd: Array, time_s: Array) -> tuple[Array, Array]:
        """Inner products of [A B x] in every window for rows x, and log|C|, windows × channels. `sd`: windows × channels, or one a
        channel."""
        windows, _, channels = self.there.shape
        sizes = np.broadcast_to(np.clip(rung(sd), _LOWEST, _HIGHEST), (windows, channels))
        times = rung(time_s)
        of_unknowns = np.zeros((windows, self.states + self.forms, self.states + self.forms))
        for c in (c for c in range(channels) if self.reached[c]):
            kept, numbers = self._of_unknowns(c, sizes[:, c], int(times[c]))
            of_unknowns += kept.grams[numbers]
        made = filter_of(self.there, at_rung(sizes), at_rung(times), self.period_s)
        return joined(of_unknowns, *self._side_by_side(made, rows)), made.log_det

    def _side_by_side(self, made: Filter, rows: Blocks) -> tuple[Array, Array]:
        """Inner products of rows x with [A B], and among themselves; some windows on every thread, what is made of them small enough for a
        processor's own memory."""
        workers, unknowns = max(self.experiment.workers, 1), self._by_window

        def of_windows(part: slice) -> tuple[Array, Array]:
            white, solved = made.of_windows(part).applied(np.concatenate([block[:, part] for block in rows]))
            return np.matmul(solved.transpose(0, 2, 1), unknowns[part]), np.matmul(white.transpose(0, 2, 1), white)

        at_once = max(_AT_ONCE // sum(map(len, rows)), 1)
        cuts = list(pairwise([*range(0, len(made.gain), at_once), len(made.gain)]))
        if len(cuts) == 1:
            return of_windows(slice(*cuts[0]))
        with ThreadPoolExecutor(workers) as pool:
            parts = list(pool.map(lambda ends: of_windows(slice(*ends)), cuts))
        return np.concatenate([p[0] for p in parts]), np.concatenate([p[1] for p in parts])

    def _decay(self, time: int) -> float:
        return float(np.exp(-self.period_s / at_rung(time)))

    def _of_unknowns(self, c: int, sizes: Numbers, time: int) -> tuple[_Kept, Numbers]:
        """What is kept of a channel and T, as it is now, and where every window's own stands in it. Several threads may ask."""
        windows = np.arange(len(sizes))
        with _ONE_AT_A_TIME:
            kept = self._kept.get((c, time)) or self._begun(c, time)
            numbers = kept.where[windows, sizes - _LOWEST]
            new = np.flatnonzero(numbers < 0)
            if not len(new):
                return replace(kept), numbers
        there, decay = np.ascontiguousarray(self._samples_there[c][:, new]), self._decay(time)
        gain, root = gains(there, at_rung(sizes[new]) ** 2, decay)
        log_det = _log_det(there, root)
        white = whitened(self._by_channel[c][new], gain, root, decay)
        grams = np.matmul(white.transpose(0, 2, 1), white)
        with _ONE_AT_A_TIME:
            numbers[new] = kept.add(new, sizes[new] - _LOWEST, grams, log_det)
            return replace(kept), numbers

    def _begun(self, c: int, time: int) -> _Kept:
        """Nothing kept yet of a channel and T; if the channel holds too much already, all of it is let go."""
        own = [key for key in self._kept if key[0] == c]
        if sum(self._kept[key].grams.nbytes for key in own) > _KEPT_BYTES:
            for key in own:
                del self._kept[key]
        numbers = self.states + self.forms
        where, room = np.full((len(self.there), _HIGHEST - _LOWEST + 1), -1), len(self.there)
        return self._kept.setdefault((c, time), _Kept(where, np.empty((room, numbers, numbers)), np.empty(room)))


def _log_det(there: NDArray[np.bool_], root: Array) -> Array:
    """log|C| of every window of a channel, from samples × windows."""
    return np.asarray(-2.0 * np.sum(np.log(np.where(there, root, 1.0)), axis=0))


def joined(of_unknowns: Array, cross: Array, own: Array) -> Array:
    """One matrix a window of the inner products of [A B], of x with these, and of x."""
    numbers = of_unknowns.shape[1]
    whole = np.empty((len(own), numbers + own.shape[1], numbers + own.shape[1]))
    whole[:, :numbers, :numbers], whole[:, numbers:, numbers:] = of_unknowns, own
    whole[:, numbers:, :numbers], whole[:, :numbers, numbers:] = cross, cross.transpose(0, 2, 1)
    return whole
