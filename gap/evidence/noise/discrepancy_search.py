"""The search for δ, T, s and η where the log density of the residuals, with their priors, is largest: one channel after the other, up and
down the ladder of their values (ornstein_uhlenbeck).

What a try of one channel costs stands in `channel_sums`; one of η costs no filter. What a try is worth does not hang on the way to it, so
the next ones are made side by side on the threads of the search; which of them counts is decided in their order, whatever the number of
threads.
"""

from __future__ import annotations

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from functools import cache
from itertools import product

import numpy as np

from gap.data.measured import Array
from gap.evidence.deciding_numbers import MEMORY_S, OTHER_FORM, SPREAD
from gap.evidence.noise.channel_sums import ChannelSums, Parts
from gap.evidence.noise.discrepancy import LEAST_SHARE, MOST_SHARE, log_prior_of_sizes, log_prior_of_times
from gap.evidence.noise.noise_model import Discrepancy, Weighed, less_shared
from gap.evidence.noise.ornstein_uhlenbeck import OCTAVE, at_rung, rung
from gap.evidence.noise.rungs import Rung, Rungs, clipped
from gap.evidence.noise.whitening import Numbers, Whitening

_SMALLEST, _LARGEST = 0.02, 1e6  # of δ, in units of the noise: less changes nothing, more is a simulation that ran away
_STEPS = (OCTAVE, 1)  # of δ, T and η, as rungs; doubled as long as that helps
_GAIN = 0.01  # of ln p, below which a step is none
_LEAPS = (0.1, 0.4, 1.6)
_SWEEPS = 4  # over the channels, at each step
_TIMES = OCTAVE * np.arange(-3, 8)  # of δ in a window …
_NEAR = (-OCTAVE, 0, OCTAVE)  # … and from what it had, for a model close by


def fitted_discrepancy(
    logs: Sequence[Whitening], left: Sequence[Array], scales: Array, start: Discrepancy, near: bool = False
) -> Discrepancy:
    """For residuals `left` (windows × samples × channels of every log, in noise). `scales`: of δ's prior, one a channel. `near`: it was
    found for a model close by."""
    search = _Search(logs, left, scales, start)
    return (search.near() if near else search.whole()).found


def on_other_logs(logs: Sequence[Whitening], left: Sequence[Array], scales: Array, start: Discrepancy) -> tuple[Discrepancy, float]:
    """For logs that were not fitted, with η as it is: the likeliest δ, T and times there (what a model leaves depends on the motion), and
    ln p of the logs and of these."""
    search = _Search(logs, left, scales, replace(start, times=()), False).whole()
    return search.found, search.value


@dataclass(frozen=True, slots=True)
class _Tried:
    """One channel with another discrepancy: the density there, what the channel adds to the inner products, and what windows' own states
    leave of all of them."""

    there: Rungs
    value: float
    parts: Parts
    total: Weighed


class _Search:
    """As for fitted_discrepancy; `moves_share`: whether η is looked for too."""

    def __init__(
        self,
        logs: Sequence[Whitening],
        left: Sequence[Array],
        scales: Array,
        start: Discrepancy,
        moves_share: bool = True,
    ) -> None:
        self._logs, self._scales = logs, scales
        self._scaled = tuple(name for name, there in (("share", logs[0].forms), ("contact", logs[0].unknowns.contacts)) if there)
        self._moving_shares = self._scaled if moves_share else ()
        channels = range(len(start.sd))
        self._sizes = _rungs(_SMALLEST, _LARGEST)
        longest_s = max(log.experiment.plan.rows * log.experiment.plan.period_s for log in logs)
        self._memories = _rungs(min(log.period_s for log in logs), longest_s)
        self.moving = [c for c in channels if any(log.there[..., c].any() for log in logs)]
        self.threads = max(logs[0].experiment.workers, 1)
        self.each = _threads(self.threads).map if self.threads > 1 else map
        self._at = self._on_ladder(start)
        self.sums = ChannelSums(logs, left, self._at)
        self.value = self._value(self.sums.total, self._at)

    @property
    def found(self) -> Discrepancy:
        return self._at.values

    def whole(self) -> _Search:
        """From anywhere."""
        for c in self.moving:
            self._leap(c)
        for steps, near in ((_STEPS, False), (_STEPS[-1:], True)):
            self._settle(steps)
            for c in self.moving:
                self._weigh_windows(c, near)
        return self

    def near(self) -> _Search:
        """From what it was for a model close by: once over the channels, since the model moves on."""
        self._settle(_STEPS[-1:], 1)
        for c in self.moving:
            self._weigh_windows(c, True)
        return self

    def _on_ladder(self, start: Discrepancy) -> Rungs:
        sizes = np.clip(rung(np.maximum(start.sd, _SMALLEST)), *self._sizes)
        times = tuple(rung(t) for t in start.times) or tuple(np.zeros((len(log.there), len(sizes)), np.int64) for log in self._logs)
        contact = (start.contact or OTHER_FORM) if "contact" in self._scaled else 0.0
        return Rungs(sizes, np.clip(rung(start.time_s), *self._memories), times, start.share, contact)

    def _leap(self, c: int) -> None:
        """To a typical T and some size: where δ is nearly nothing, or T as long as a window, small steps change nothing."""
        tries = _Tries(self, c)
        places = [self._clipped((int(rung(sd)), int(rung(MEMORY_S)))) for sd in _LEAPS]
        for n in range(len(places)):
            self._try(tries, places[n:])

    def _settle(self, steps: Sequence[int], sweeps: int = _SWEEPS) -> None:
        """δ and T of every channel, and η, until no step gains anything. Channels hardly touch each other: one that gained nothing is not
        asked again."""
        for step in steps:
            asked = self.moving
            for _ in range(sweeps):
                asked = [c for c in asked if self._improve(c, step)]
                if not self._improve_share(step) and not asked:
                    break

    def _improve(self, c: int, step: int) -> bool:
        """Whether a step of this channel's δ or T, or of both, either way, gave a larger density."""
        tries, gained = _Tries(self, c), False
        for size, memory in ((step, 0), (0, step), (step, 2 * step)):  # the last: δ² / T held
            gained = self._followed(tries, size, memory) or self._followed(tries, -size, -memory) or gained
        return gained

    def _followed(self, tries: _Tries, size: int, memory: int) -> bool:
        """Whether a change of δ and T gained anything; it is doubled while it does. Most gain nothing: the way back is tried beside it."""
        gained = False
        while True:
            there, back = self._beside(tries.c, size, memory), self._beside(tries.c, -size, -memory)
            if not self._try(tries, [there] if gained else [there, back]):
                return gained
            gained, size, memory = True, 2 * size, 2 * memory

    def _beside(self, c: int, size: int, memory: int) -> Rung:
        return self._clipped(self._at.beside(c, size, memory))

    def _clipped(self, place: Rung) -> Rung:
        return clipped(place, self._sizes, self._memories)

    def _improve_share(self, step: int) -> bool:
        """The same of η, and of contacts."""
        before = self.value
        for name, side in product(self._moving_shares, (step, -step)):
            while self._try_share(name, side):
                side *= 2
        return self.value > before

    def _try_share(self, name: str, rungs: int) -> bool:
        share = float(np.clip(getattr(self._at, name) * at_rung(rungs), LEAST_SHARE, MOST_SHARE))
        there = self._at.rescaled(name, share)
        value = self._value(self.sums.total, there)
        if not value > self.value + _GAIN:
            return False
        self._at, self.value = there, value
        return True

    def _weigh_windows(self, c: int, near: bool) -> None:
        """Every window's own times of this channel's δ, beside the other channels and the likeliest shares of other friction."""
        now, others = self._at.times, self.sums.others(c)
        options = [tuple(np.clip(t + s, _TIMES[0], _TIMES[-1]) for t in now) for s in _NEAR] if near else _alike(now)
        tries = list(self.each(lambda times: self.sums.of_channel(c, replace(self._at, times=times)), options))
        densities = self.sums.densities(c, others, self._at)
        found = [t.copy() for t in now]
        for n in range(len(self._logs)):
            offered = np.stack([times[n][:, c] for times in options])
            values = np.stack([densities(n, one[n]) for one in tries]) - 0.5 * (np.log(at_rung(offered)) / SPREAD) ** 2
            found[n][:, c] = np.take_along_axis(offered, np.argmax(values, axis=0)[None], axis=0)[0]
        self._accept(c, others, self.tried(c, others, self._about_one(c, found)))

    def _about_one(self, c: int, times: Sequence[Numbers]) -> Rungs:
        """The same sizes with δ at the geometric mean of the windows that measure the channel, where the prior of s wants it."""
        measured = [log.there[..., c].any(axis=1) for log in self._logs]
        mean = np.mean(np.concatenate([t[own, c] for t, own in zip(times, measured, strict=True)]))
        size = int(np.clip(self._at.sizes[c] + np.rint(mean), *self._sizes))
        for t, own in zip(times, measured, strict=True):
            t[own, c] += self._at.sizes[c] - size
        return replace(self._at.moved(c, size, int(self._at.memories[c])), times=tuple(times))

    def _try(self, tries: _Tries, places: Sequence[Rung]) -> bool:
        """Whether the first of these places is better; the others may be asked for next."""
        if places[0] == (self._at.sizes[tries.c], self._at.memories[tries.c]):
            return False
        return self._accept(tries.c, tries.others, tries.of(places))

    def tried(self, c: int, others: Sequence[Array], there: Rungs) -> _Tried:
        """A discrepancy that differs in one channel; changes nothing here."""
        parts = self.sums.of_channel(c, there)
        total = self.sums.with_channel(c, others, parts)
        return _Tried(there, self._value(total, there), parts, total)

    def at(self, c: int, place: Rung) -> Rungs:
        return self._at.moved(c, *place)

    def _accept(self, c: int, others: Sequence[Array], tried: _Tried) -> bool:
        """Whether it gives a larger density; then it is the one found."""
        if not tried.value > self.value + _GAIN:
            return False
        self._at, self.value = tried.there, tried.value
        self.sums.take(c, others, tried.parts, tried.total)
        return True

    def _value(self, total: Weighed, there: Rungs) -> float:
        found, values = less_shared(total, self._logs[0].widths(there.share, there.contact)), there.values
        prior = log_prior_of_sizes(values, self._scales) + float(log_prior_of_times(values).sum())
        return -0.5 * (float(found.inner[0, 0]) + found.log_det) + prior


class _Tries:
    """Tries of one channel while the others stay as they are; each place is asked for once."""

    def __init__(self, search: _Search, c: int) -> None:
        self._search, self.c, self.others = search, c, search.sums.others(c)
        self._known: dict[Rung, _Tried] = {}

    def of(self, places: Sequence[Rung]) -> _Tried:
        """The first of these; others are made beside it where a thread is free for them."""
        if places[0] not in self._known:
            search, new = self._search, [place for place in places if place not in self._known][: self._search.threads]
            done = search.each(lambda place: search.tried(self.c, self.others, search.at(self.c, place)), new)
            self._known.update(zip(new, done, strict=True))
        return self._known[places[0]]


@cache
def _threads(number: int) -> ThreadPoolExecutor:
    """Kept for all searches of a process: a try takes a millisecond or two."""
    return ThreadPoolExecutor(number)


def _rungs(low: float, high: float) -> tuple[int, int]:
    return int(rung(low)), int(rung(high))


def _alike(now: Sequence[Numbers]) -> list[tuple[Numbers, ...]]:
    """All windows with the same times, as often as there are."""
    return [tuple(np.full_like(t, s) for t in now) for s in _TIMES]
