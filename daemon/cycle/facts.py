"""Every number the loop knows in one cycle, as one flat list of floats with names: the log row first, then what only checks need.

The same list is checked by the interlocks, published to the supervisor and shown by `longreach why`, so none of them can disagree.
"""

from __future__ import annotations

from collections.abc import Mapping

from config.options.canopen_rig import canopen_devices
from config.schema.rig import Rig
from drivers.canopen.counts import BUS_COUNTS, DEVICE_COUNTS
from drivers.contract import Quality
from recording.format.layout import CycleLayout

SLOW_COUNTS = ("polls", "failed_polls")  # of a device that the I/O process reads

# What only checks and status need; the log row does not hold it.
_LOOP_FACTS = (
    "estop_latched",  # 1 until a reset
    "loop.late_s",  # how long after the next deadline the last cycle ended
    "loop.overruns_in_window",
    "recorder.age_s",  # since the recorder last reported
    "recorder.failed",  # 1 when it has ended or cannot write
    "recorder.drops",  # records lost since this recording began
    "disk.free_bytes",
    "host.rate_Hz",  # the highest that `longreach host` has seen this computer keep; 0: nothing measured
    "supervisor.age_s",  # since the supervisor last reported
    "commands",  # requests carried out since the start
    "run.number",  # last run asked for; 0 for none
    "run.countdown_s",
    "run.elapsed_s",
    "run.duration_s",
    "run.verdict",  # see daemon.modes.run_watch.Verdict
)


def link_facts(rig: Rig) -> dict[str, tuple[str, ...]]:
    """Link → its facts: LINK.COUNT, and DEVICE.COUNT of the devices on it."""
    facts: dict[str, tuple[str, ...]] = {}
    for name, options in canopen_devices(rig).items():
        channel = options.bus.channel
        of_bus = facts.get(channel) or tuple(f"{channel}.{count}" for count in BUS_COUNTS)
        facts[channel] = (*of_bus, *(f"{name}.{count}" for count in DEVICE_COUNTS))
    slow = (name for name, device in rig.devices.items() if device.slow)
    return facts | {name: tuple(f"{name}.{count}" for count in SLOW_COUNTS) for name in slow}


class Facts:
    """Names and indices of the numbers of one rig. `values` in the loop is a list made by blank()."""

    def __init__(self, rig: Rig, layout: CycleLayout, declared: Mapping[str, float]) -> None:
        """`declared`: facts that only checks need, each with its value before anything was measured."""
        row = [field.name for field in layout.fields]
        quality = {f"{signal}.quality": float(Quality.BAD) for signal in rig.signals}
        following = {f"{joint}.following_error": 0.0 for joint in rig.joints}
        counts = {fact: 0.0 for facts in link_facts(rig).values() for fact in facts}
        beside_row = quality | following | dict.fromkeys(_LOOP_FACTS, 0.0) | dict(declared) | counts
        self.row_length = len(row)
        self.names = (*row, *beside_row)
        self._blank = [*layout.blank(), *beside_row.values()]
        self.indices = {name: number for number, name in enumerate(self.names)}

    def index(self, name: str) -> int:
        """KeyError for no fact of this rig."""
        return self.indices[name]

    def has(self, name: str) -> bool:
        return name in self.indices

    def blank(self) -> list[float]:
        """Nothing measured yet: log row as layout.blank(), qualities BAD, declared facts as declared, the rest 0."""
        return list(self._blank)
