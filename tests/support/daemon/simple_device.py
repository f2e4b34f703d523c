"""A device for tests of the loop: every sensor and valve of a rig, joints that integrate their command, and faults on request."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from config.schema.rig import Device, Rig
from drivers.contract import Driver, Quality, Sample


class SimpleDevice:
    """`log` keeps the verbs; `written` the last outputs (None: safe); `override` replaces values, `handed` what a sample says
    (raw, stamp_ns, quality); `on_read` may raise or delay."""

    def __init__(self, name: str, device: Device, rig: Rig, lockstep: bool) -> None:
        self.name = name
        self.rig = rig
        self.inputs = tuple(signal.channel for signal in rig.signals.values() if signal.device == name)
        self.joints = tuple(joint for joint, output in rig.outputs.items() if output.device == name)
        self.outputs = tuple(rig.outputs[joint].channel for joint in self.joints)
        self.signal_of = {signal.channel: key for key, signal in rig.signals.items() if signal.device == name}
        self.positions = {joint: 0.5 * (limits.travel[0] + limits.travel[1]) for joint, limits in rig.joints.items()}
        self.override: dict[str, float] = {}
        self.age_ns: dict[str, int] = {}
        self.handed: dict[str, dict[str, Any]] = {}
        self.written: list[float] | None = None
        self.verbs: list[str] = []
        self.on_read: Callable[[], None] = lambda: None
        self.on_write: Callable[[], None] = lambda: None
        self.on_activate: Callable[[], None] = lambda: None
        self.on_safe: Callable[[], None] = lambda: None
        self._samples = [Sample() for _ in self.inputs]

    def open(self) -> None:
        self.verbs.append("open")

    def configure(self) -> None:
        self.verbs.append("configure")

    def activate(self) -> None:
        self.verbs.append("activate")
        self.on_activate()

    def read(self, now_ns: int) -> Sequence[Sample]:
        self.on_read()
        self._move()
        for sample, channel in zip(self._samples, self.inputs, strict=True):
            key = self.signal_of[channel]
            calibration = self.rig.signals[key].calibration
            value = self.override.get(key, self._value(key))
            sample.raw = (value - calibration.offset) / calibration.scale
            sample.stamp_ns = now_ns - self.age_ns.get(key, 0)
            sample.quality = Quality.GOOD if value == value else Quality.BAD
            for word, said in self.handed.get(key, {}).items():
                setattr(sample, word, said)
        return self._samples

    def write(self, values: Sequence[float], now_ns: int) -> None:
        self.on_write()
        self.written = list(values)

    def safe(self) -> None:
        self.on_safe()
        self.verbs.append("safe")
        self.written = None

    def close(self) -> None:
        self.safe()
        self.verbs.append("close")

    def _move(self) -> None:
        """Rate = command / feed-forward gain: the joint the servo was designed for."""
        for joint, volts in zip(self.joints, self.written or [0.0] * len(self.joints), strict=True):
            gain = 1.0 / self.rig.servo[joint].velocity_feedforward if self.rig.servo[joint].velocity_feedforward else 1.0
            self.positions[joint] += volts * gain / self.rig.loop.rate_Hz

    def _value(self, key: str) -> float:
        part, _, what = key.rpartition(".")
        if what == "position":
            return self.positions[part]
        limits = self.rig.interlocks
        typical = {"supply_pressure": limits.supply_pressure_min_Pa or 1e7, "reservoir_temperature": limits.oil_temperature_min_C or 30.0}
        return 1.2 * typical[what] if what in typical else 0.0


def factory(made: list[SimpleDevice]) -> Callable[[str, Device, Rig, bool], Driver]:
    """A driver factory that remembers what it made."""

    def create(name: str, device: Device, rig: Rig, lockstep: bool) -> Driver:
        made.append(SimpleDevice(name, device, rig, lockstep))
        return made[-1]

    return create
