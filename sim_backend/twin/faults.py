"""What can be made wrong with one simulated CANopen device, by name, so that a fault can be injected from another process."""

from __future__ import annotations

import random
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field

from config.errors import PlantError

Effect = Callable[["NodeFaults", float], None]


@dataclass(slots=True)
class NodeFaults:
    """The faults a device has at present. The numbers are in the device's counts."""

    silent: bool = False  # the cable is cut: it neither sends nor hears
    no_heartbeat: bool = False
    stuck: bool = False  # measured values stay what they are
    jump_counts: float = 0.0
    noise_counts: float = 0.0
    late_ns: int = 0  # process data leave this much later
    alarm_bits: int = 0
    stuck_state: bool = False  # device control no longer answers
    generator: random.Random = field(default_factory=lambda: random.Random(1))

    def measured(self, count: float) -> float:
        """The count with jump and noise."""
        if self.noise_counts:
            count += self.generator.gauss(0.0, self.noise_counts)
        return count + self.jump_counts

    def set(self, name: str, amount: float) -> None:
        """Start the fault `name`. PlantError when there is none of this name."""
        effect = EFFECTS.get(name)
        if effect is None:
            raise PlantError("this device has no such fault", value=name, limit=", ".join(EFFECTS))
        effect(self, amount)


def _silent(faults: NodeFaults, amount: float) -> None:
    faults.silent = True


def _no_heartbeat(faults: NodeFaults, amount: float) -> None:
    faults.no_heartbeat = True


def _stuck(faults: NodeFaults, amount: float) -> None:
    faults.stuck = True


def _jump(faults: NodeFaults, amount: float) -> None:
    faults.jump_counts = amount


def _noisy(faults: NodeFaults, amount: float) -> None:
    faults.noise_counts = amount


def _late(faults: NodeFaults, amount: float) -> None:
    faults.late_ns = round(1e6 * amount)


def _alarm(faults: NodeFaults, amount: float) -> None:
    faults.alarm_bits = int(amount) or 1


# name → what it does; the amount is: counts (jump), counts rms (noisy), ms (late), bits (alarm)
EFFECTS: Mapping[str, Effect] = {
    "silent": _silent,
    "no_heartbeat": _no_heartbeat,
    "stuck": _stuck,
    "jump": _jump,
    "noisy": _noisy,
    "late": _late,
    "alarm": _alarm,
}
