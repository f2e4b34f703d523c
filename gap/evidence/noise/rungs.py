"""A discrepancy on the ladder of its values (ornstein_uhlenbeck): what the search for it moves."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gap.evidence.noise.noise_model import Discrepancy
from gap.evidence.noise.ornstein_uhlenbeck import at_rung
from gap.evidence.noise.whitening import Numbers

Rung = tuple[int, int]  # δ and T of one channel


@dataclass(frozen=True, slots=True)
class Rungs:
    """δ and T of every channel, s of the windows of every log, windows × channels; shares of other friction as they are."""

    sizes: Numbers
    memories: Numbers
    times: tuple[Numbers, ...]
    share: float
    contact: float = 0.0

    def moved(self, c: int, size: int, memory: int) -> Rungs:
        """With another δ and T of one channel."""
        sizes, memories = self.sizes.copy(), self.memories.copy()
        sizes[c], memories[c] = size, memory
        return replace(self, sizes=sizes, memories=memories)

    def rescaled(self, name: str, share: float) -> Rungs:
        """With another scale of the shares, `share` or `contact`."""
        return replace(self, share=share) if name == "share" else replace(self, contact=share)

    def beside(self, c: int, size: int, memory: int) -> Rung:
        """δ and T of a channel, so many rungs away."""
        return int(self.sizes[c]) + size, int(self.memories[c]) + memory

    def of_windows(self, c: int) -> list[Numbers]:
        """δ of a channel in the windows of every log."""
        return [self.sizes[c] + times[:, c] for times in self.times]

    @property
    def values(self) -> Discrepancy:
        times = tuple(at_rung(t) for t in self.times)
        return Discrepancy(at_rung(self.sizes), at_rung(self.memories), self.share, times, self.contact)


def clipped(place: Rung, sizes: Rung, memories: Rung) -> Rung:
    """A place within the lowest and highest rungs of δ and of T."""
    return int(np.clip(place[0], *sizes)), int(np.clip(place[1], *memories))
