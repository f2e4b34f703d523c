"""What all channels add to the inner products of a log's windows, and what becomes of that when one of them has another discrepancy.

Channels meet only in what they hang on together (unknowns): each adds its own inner products, so that a try of one channel costs one filter
of its residuals. A channel that hangs on none of it is by itself: nothing else has to be asked again.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from gap.data.measured import Array
from gap.evidence.noise.noise_model import Weighed, less_states_with, likeliest_shares, window_densities
from gap.evidence.noise.rungs import Rungs
from gap.evidence.noise.whitening import Part, Whitening

Parts = Sequence[Part]  # of one channel, one a log


class ChannelSums:
    """Of residuals `left` (windows × samples × channels of every log, in noise) with a discrepancy. `total`: what the windows' own states
    leave of all inner products."""

    def __init__(self, logs: Sequence[Whitening], left: Sequence[Array], at: Rungs) -> None:
        channels = range(len(at.sizes))
        self._logs = logs
        self._left = [[np.ascontiguousarray(own[..., c].T) for own in left] for c in channels]
        self._reached = [any(log.reached[c] for log in logs) for c in channels]
        self._parts: list[Parts] = [self.of_channel(c, at) for c in channels]
        self._whole = [self._over_channels(n) for n in range(len(logs))]
        self.total = self._of_windows(self._whole)

    def of_channel(self, c: int, there: Rungs) -> Parts:
        """What one channel adds with a discrepancy."""
        ways = [log.part if self._reached[c] else log.squares for log in self._logs]
        each = zip(ways, self._left[c], there.of_windows(c), strict=True)
        return [way(c, own, sizes, int(there.memories[c])) for way, own, sizes in each]

    def others(self, c: int) -> list[Array]:
        """What all channels but one add; a channel by itself adds nothing here."""
        return [whole - part.whole for whole, part in zip(self._whole, self._parts[c], strict=True)] if self._reached[c] else self._whole

    def with_channel(self, c: int, others: Sequence[Array], parts: Parts) -> Weighed:
        """`total`, did one channel add `parts`."""
        if self._reached[c]:
            return self._of_windows(others, c, parts)
        inner, own = self.total.inner.copy(), self._parts[c]
        inner[-1, -1] += _squares(parts) - _squares(own)
        return Weighed(inner, self.total.log_det + _log_det(parts) - _log_det(own))

    def take(self, c: int, others: Sequence[Array], parts: Parts, total: Weighed) -> None:
        """From now on the channel adds these; `total`: as `with_channel` gave it."""
        self._parts[c], self.total = parts, total
        if self._reached[c]:
            self._whole = [other + part.whole for other, part in zip(others, parts, strict=True)]

    def densities(self, c: int, others: Sequence[Array], at: Rungs) -> Callable[[int, Part], Array]:
        """ln p of every window of a log with what one channel adds, up to what every try of it has alike; beside the likeliest shares of
        other friction, with their scales `at`."""
        if not self._reached[c]:
            return lambda n, part: -0.5 * (part.squares + part.log_det)
        states = [log.states for log in self._logs]
        rest = np.append(-likeliest_shares(self._whole, states, self._logs[0].widths(at.share, at.contact)), 1.0)
        return lambda n, part: window_densities(others[n] + part.whole, states[n], rest) - 0.5 * part.log_det

    def _over_channels(self, n: int) -> Array:
        """Inner products of a log's windows, over the channels that are reached."""
        numbers = self._logs[n].states + self._logs[n].forms + 1
        parts = [own[n].whole for own, reached in zip(self._parts, self._reached, strict=True) if reached]
        return sum(parts, np.zeros((len(self._logs[n].there), numbers, numbers)))

    def _of_windows(self, whole: Sequence[Array], c: int = -1, parts: Parts = ()) -> Weighed:
        """What windows' own states leave of all inner products together; `parts`: of channel c, to be added to `whole`."""
        of_logs = [less_states_with(all_of, parts[n] if parts else None, self._logs[n].states) for n, all_of in enumerate(whole)]
        every = [parts if k == c else own for k, own in enumerate(self._parts)]
        total = Weighed(sum((w.inner for w in of_logs), np.zeros(())), sum(w.log_det for w in of_logs))
        total.inner[-1, -1] += sum(_squares(own) for own, reached in zip(every, self._reached, strict=True) if not reached)
        return replace(total, log_det=total.log_det + sum(map(_log_det, every)))


def _squares(parts: Parts) -> float:
    return sum(float(part.squares.sum()) for part in parts)


def _log_det(parts: Parts) -> float:
    return sum(float(part.log_det.sum()) for part in parts)
