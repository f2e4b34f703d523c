"""The driver contract. A plug-in implements these verbs; it need not import longreach (typing.Protocol).

Life of a driver:  open → configure → activate → (read, write)* → safe → close.
After `open` and before `activate` it may be read but must not move anything. `safe` puts every output into its safe state and
may be called at any time, also twice; after it a write needs a new `activate`, and `configure` may come again (KeepsSetup).
`close` calls it. Any verb raises an exception (DriverError or its own) on failure.

A driver is made by `factory(name, device, rig, lockstep) -> Driver`. Where the factories are: `config.options.driver_options` for the
shipped ones, the entry-point group `longreach.drivers` for those of plug-ins.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from enum import IntEnum
from typing import Protocol, runtime_checkable


class Quality(IntEnum):
    """How far a sample can be believed."""

    GOOD = 0
    UNCERTAIN = 1  # e.g. a device warning bit
    BAD = 2  # drop-out, alarm bit, out of the device's range


class Sample:
    """The latest value of one channel: raw device counts, when it was taken (monotonic clock, ns), and its quality."""

    __slots__ = ("quality", "raw", "stamp_ns")

    def __init__(self, raw: float = float("nan"), stamp_ns: int = 0, quality: int = Quality.BAD) -> None:
        self.raw = raw
        self.stamp_ns = stamp_ns
        self.quality = quality


@runtime_checkable
class Counts(Protocol):
    """A driver that counts what its device and the link to it do, besides the verbs below. Names stay the same for its life."""

    def counts(self) -> Mapping[str, float]:
        """Numbers of the device, since it was opened."""

    def link_counts(self) -> tuple[str, Mapping[str, float]]:
        """Name of the link, which other devices may share, and its numbers since it was opened."""


@runtime_checkable
class KeepsSetup(Protocol):
    """A driver that notices when its device loses its settings, besides the verbs below. Then `read` raises until `configure` is called."""

    @property
    def setup_lost(self) -> str:
        """Why what was set and proven of the device no longer counts, as what it did; empty while it counts."""

    @property
    def needs_setup(self) -> bool:
        """It cannot be activated as it is; a reset calls `configure` again."""


class Driver(Protocol):
    """One device. `inputs` and `outputs` name its channels; read and write use that order."""

    name: str
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]

    def open(self) -> None:
        """Connect; nothing moves."""

    def configure(self) -> None:
        """Write the device's settings, read them back, and raise on a difference."""

    def activate(self) -> None:
        """Outputs act from the next write on. The first state after activate is the safe state."""

    def read(self, now_ns: int) -> Sequence[Sample]:
        """The latest sample of every input channel; never waits longer than the cycle allows. The list is reused."""

    def write(self, values: Sequence[float], now_ns: int) -> None:
        """Set every output (volts × the output's scale). Also feeds the device's own time-out."""

    def safe(self) -> None:
        """Put every output into its safe state, now."""

    def close(self) -> None:
        """safe(), then give the device back."""
