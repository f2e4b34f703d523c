"""All devices of a rig as the loop sees them: one read that fills the facts, one write, and safe outputs on every way out."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from math import isfinite, nan
from typing import NamedTuple

from config.errors import DriverError, LongreachError
from config.schema.rig import Device, Rig
from daemon.cycle.facts import SLOW_COUNTS, Facts
from daemon.ipc.mailbox import Mailbox
from daemon.ipc.slow_samples import fetch_samples, slow_channels
from drivers import registry
from drivers.contract import Driver, KeepsSetup, Quality, Sample
from drivers.proof import ProvesSafeState
from recording.format.fields import field_of_signal

CreateDriver = Callable[[str, Device, Rig, bool], Driver]


class _Input(NamedTuple):
    """From a device's channel to the indices of one signal's facts."""

    channel: int
    value: int
    raw: int
    age: int
    quality: int
    scale: float
    offset: float
    max_age_s: float


class DeviceBank:
    """Drivers of the fast devices, and the mailboxes in which the I/O process leaves the samples of the slow ones.

    Everything is looked up here once. Raises DriverError for a channel that a device does not have, and for a proof it cannot give.
    """

    def __init__(
        self, rig: Rig, facts: Facts, lockstep: bool, slow: Mapping[str, Mailbox] | None = None, create: CreateDriver = registry.create
    ) -> None:
        self._slow = dict(slow or {})
        self.drivers = {name: create(name, device, rig, lockstep) for name, device in rig.devices.items() if not device.slow}
        _refuse_unprovable(rig, self.drivers)
        self._reads = [(name, driver, _inputs(rig, facts, name, driver.inputs)) for name, driver in self.drivers.items()]
        self._set_up = {name: driver for name, driver in self.drivers.items() if isinstance(driver, KeepsSetup)}
        self._slow_reads = [
            (
                box,
                [Sample() for _ in slow_channels(rig, name)],
                _inputs(rig, facts, name, slow_channels(rig, name)),
                [facts.index(f"{name}.{count}") for count in SLOW_COUNTS],
            )
            for name, box in self._slow.items()
        ]
        self._writes = [(name, driver, _outputs(rig, name, driver)) for name, driver in self.drivers.items() if driver.outputs]

    def open(self) -> None:
        """Open and configure every device. DriverError when one refuses, after those already open were closed."""
        for name, driver in self.drivers.items():
            try:
                driver.open()
                driver.configure()
            except (Exception, SystemExit) as error:  # a foreign driver raises what it likes
                with suppress(Exception):  # the first refusal is the one to report
                    self.close()
                if isinstance(error, LongreachError):
                    raise
                value, advice = f"{type(error).__name__}: {error}", "Check its power, its cable and its options."
                raise DriverError("the device did not open", value=value, where=f"devices.{name}", next_step=advice) from error

    @property
    def needs_setup(self) -> bool:
        """A device has lost its settings, or is not ready to act."""
        return any(driver.needs_setup for driver in self._set_up.values())

    def set_up_again(self, between: Callable[[], None]) -> None:
        """Configure all devices that can lose it, not only those that did: setting up one takes so long that the others miss us.

        The outputs must be safe. `between` is called after each. Raises what a driver raises.
        """
        for name in self._set_up:
            with _of(name):
                self.drivers[name].configure()
            between()

    def activate(self) -> None:
        for name, driver in self.drivers.items():
            with _of(name):
                driver.activate()

    def read(self, now_ns: int, values: list[float]) -> None:
        """Every signal's value, raw count, age and quality into the facts. A sample that is BAD or too old has the value NaN.

        When a driver raises, its inputs are unknown and all others are read; the first error is raised at the end.
        """
        first: Exception | None = None
        for name, driver, inputs in self._reads:
            try:
                _store(inputs, driver.read(now_ns), now_ns, values)
            except (Exception, SystemExit) as error:  # whatever a driver raises
                first = first or _of_device(name, error)
                _forget(inputs, values)
        for box, samples, inputs, counts in self._slow_reads:
            for index, count in zip(counts, fetch_samples(box, samples), strict=True):
                values[index] = count
            _store(inputs, samples, now_ns, values)
        if first is not None:
            raise first

    def write(self, volts: Sequence[float], now_ns: int) -> None:
        """`volts` in the order of rig.joints."""
        for name, driver, outputs in self._writes:
            try:
                driver.write([volts[joint] * scale if joint >= 0 else 0.0 for joint, scale in outputs], now_ns)
            except LongreachError:
                raise
            except (Exception, SystemExit) as error:  # whatever a driver raises
                raise _of_device(name, error) from error

    def safe(self) -> None:
        """Safe outputs on every device, also when one of them raises; the first error is raised at the end."""
        self._all(lambda driver: driver.safe())

    def close(self) -> None:
        self._all(lambda driver: driver.close())

    def _all(self, verb: Callable[[Driver], None]) -> None:
        first: Exception | None = None
        for name, driver in self.drivers.items():
            try:
                verb(driver)
            except (Exception, SystemExit) as error:  # the other devices must become safe too
                first = first or _of_device(name, error)
        if first is not None:
            raise first


@contextmanager
def _of(name: str) -> Iterator[None]:
    """Whatever this device's driver raises inside, an attempt to end the process too, is an Exception that names the device."""
    try:
        yield
    except LongreachError:
        raise
    except (Exception, SystemExit) as error:
        raise _of_device(name, error) from error


def _of_device(name: str, error: Exception | SystemExit) -> Exception:
    """An error of a foreign driver with the device that it is of; ours say it themselves."""
    return error if isinstance(error, LongreachError) else DriverError(f"{type(error).__name__}: {error}", where=f"devices.{name}")


def _store(inputs: list[_Input], samples: Sequence[Sample], now_ns: int, values: list[float]) -> None:
    """TypeError for what is no number, before it is anywhere: it could neither be logged nor compared. An infinite value is none."""
    for channel, value, raw, age, quality, scale, offset, max_age_s in inputs:
        sample = samples[channel]
        count, kind = sample.raw + 0.0, sample.quality + 0
        age_s = (now_ns - sample.stamp_ns) * 1e-9 if sample.stamp_ns else nan  # one that never came has no age
        measured = offset + scale * count if kind != Quality.BAD and -max_age_s <= age_s <= max_age_s else nan
        values[raw], values[age], values[quality] = count, age_s, kind
        values[value] = measured if isfinite(measured) else nan


def _refuse_unprovable(rig: Rig, drivers: Mapping[str, Driver]) -> None:
    for name, device in rig.devices.items():
        if device.demand_proof and not isinstance(drivers.get(name), ProvesSafeState):
            what, where = "the driver cannot prove that the device goes safe by itself", f"devices.{name}.demand_proof"
            advice = "Remove demand_proof, or use a driver that has prove_safe_state() and is not slow."
            raise DriverError(what, value=device.driver, where=where, next_step=advice)


def _forget(inputs: list[_Input], values: list[float]) -> None:
    for each in inputs:
        values[each.value] = values[each.raw] = nan
        values[each.quality] = Quality.BAD


def _inputs(rig: Rig, facts: Facts, device: str, channels: Sequence[str]) -> list[_Input]:
    found = []
    for name, signal in rig.signals.items():
        if signal.device != device:
            continue
        if signal.channel not in channels:
            raise _no_channel(f"signals.{name}.channel", device, signal.channel, channels)
        names = (field_of_signal(name), f"{name}_raw", f"{name}_age_s", f"{name}.quality")
        value, raw, age, quality = (facts.index(fact) for fact in names)
        calibration = signal.calibration
        channel = channels.index(signal.channel)
        found.append(_Input(channel, value, raw, age, quality, calibration.scale, calibration.offset, signal.max_age_s))
    return found


def _outputs(rig: Rig, device: str, driver: Driver) -> list[tuple[int, float]]:
    """For every output channel of the driver: (joint number, scale), or (-1, 0) for a channel nobody uses."""
    plan = [(-1, 0.0) for _ in driver.outputs]
    for joint, name in enumerate(rig.joints):
        output = rig.outputs[name]
        if output.device != device:
            continue
        if output.channel not in driver.outputs:
            raise _no_channel(f"outputs.{name}.channel", device, output.channel, driver.outputs)
        plan[driver.outputs.index(output.channel)] = (joint, output.scale)
    return plan


def _no_channel(where: str, device: str, channel: str, channels: Sequence[str]) -> DriverError:
    return DriverError(f"the device {device!r} has no such channel", value=channel, limit=", ".join(channels), where=where)
