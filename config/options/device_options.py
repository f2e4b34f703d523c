"""What a driver declares about its devices, in one class: options with units and ranges, channels and their limits, address.

`longreach check`, `--set`, the bus budget, the twin, the reference page and the driver itself read this class and nothing else, so a
rig file means the same to all of them. A plug-in derives its class from DeviceOptions and names it in the entry-point group
`longreach.driver_options` under the name of its driver.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, Literal, NamedTuple

from config.schema.section import Section


class RigNames(NamedTuple):
    """What a device may need to know of the rig it is in: names of joints, and of the simulated sensors."""

    joints: tuple[str, ...] = ()
    sensors: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Channel:
    """One input or output of a device: what its number means, in which unit, and how far it goes (None: no limit is known).

    `mapped`: of a CANopen channel the object, as a PDO maps it: index << 16 | sub-index << 8 | bits; 0 elsewhere.
    """

    about: str
    unit: str = "counts"
    low: float | None = None
    high: float | None = None
    mapped: int = 0


@dataclass(frozen=True, slots=True)
class Address:
    """Where a device is reached: the link it is on and its number there.

    `agreed`: what all devices on the link must say alike, option ("bus.bitrate") → value. `taken`: numbers that no device may have,
    and whose they are. `alone`: a second device with the same number can't work.
    """

    link: tuple[str, ...]
    number: int
    option: str  # the option that holds the number
    agreed: Mapping[str, Any] = field(default_factory=dict)
    taken: Mapping[int, str] = field(default_factory=dict)
    alone: bool = True


class DeviceOptions(Section):
    """Base of every driver's options. A field is declared as in any section of a rig file (`quantity`, `Field`)."""

    served_by: ClassVar[Literal["loop", "I/O process", "either"]] = "either"
    proves_safe_state: ClassVar[bool] = False  # the driver has prove_safe_state(), see drivers.proof

    def input_channels(self, rig: RigNames) -> Mapping[str, Channel]:
        """Inputs by name, in the driver's order."""
        return {}

    def output_channels(self, rig: RigNames) -> Mapping[str, Channel]:
        """Outputs by name, in the driver's order."""
        return {}

    def address(self) -> Address | None:
        """None for a device that has none, as a simulated one."""
        return None

    def must_prove(self) -> bool:
        """Whether arming demands the proof of the safe state unless the rig file says otherwise."""
        return self.proves_safe_state and bool(self.output_channels(RigNames()))

    def warnings(self) -> Iterator[tuple[str, str]]:
        """(option, what is odd about it) for values that are allowed and yet seldom meant."""
        yield from ()
