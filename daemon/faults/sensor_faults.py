"""Faults of sensors and of what they measure, for each joint where it differs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import nan

from daemon.faults.benches.lockstep_bench import Inject, LockstepTarget, loaded_rig, lockstep_trial
from daemon.faults.fault import INFERRED_MS, SEEN_MS, Expected, Fault, Until
from daemon.faults.injections.faulty_device import Tamper
from drivers.contract import Quality, Sample

STOP_MS = 5000.0  # the daemon's longest controlled stop; a longer one is a fault


@dataclass(frozen=True, slots=True)
class _Disturbance:
    """Sizes of an odd encoder in counts, small against what the joint does in a maneuver."""

    jump: float
    noise: float


_DISTURBANCES = {
    "rotary": _Disturbance(jump=200.0, noise=12.0),
    "prismatic": _Disturbance(jump=200.0, noise=12.0),
}  # 1 deg, 0.06 deg rms; 5 mm, 0.3 mm rms


def sensor_faults() -> Iterator[Fault]:
    """Encoders of every joint, then pressures, temperature and tip."""
    for joint in loaded_rig().rig.joints:
        yield from _encoder_faults(joint)
    yield from _pressure_faults()
    yield from _oil_and_tip_faults()


def _encoder_faults(joint: str) -> Iterator[Fault]:
    channel, disturbance = f"{joint}.position", _DISTURBANCES[joint]

    def fault(name: str, expected: str, inject: Inject, limit_ms: float = SEEN_MS) -> Fault:
        run = lockstep_trial(inject, Until.SAFE, joint)
        return Fault(f"{joint} {name}", "encoder", Expected(f"fault: {joint}{expected}", Until.SAFE, limit_ms), run)

    yield fault("encoder off", ".position quality", lambda target: _tamper(target, channel, _off))
    yield fault("encoder alarm bit", ".position quality", lambda target: _tamper(target, channel, _alarm))
    yield fault("encoder stuck", " position stuck", lambda target: _tamper(target, channel, _stuck()))
    yield fault("encoder jump", " position rate", lambda target: _tamper(target, channel, _jump(disturbance.jump)))
    yield fault("encoder noisy", " position", lambda target: _tamper(target, channel, _noisy(target, disturbance.noise)))
    yield fault("encoder late", ".position age", lambda target: _tamper(target, channel, _late()))
    yield fault("encoder out of range", ".position range", lambda target: _tamper(target, channel, _is(1e6)))
    yield fault("valve cable off", " unexplained motion", lambda target: target.device.disconnected.add(f"{joint}.command"), INFERRED_MS)


def _pressure_faults() -> Iterator[Fault]:
    psi = 1.0 / 0.7  # counts a psi
    yield _limit_fault("supply pressure low", "rotary.supply_pressure", 1400 * psi)
    yield _limit_fault("supply pressure high", "prismatic.supply_pressure", 2500 * psi)
    yield _limit_fault("return pressure high", "rotary.return_pressure", 200 * psi)
    yield _sensor_fault("pressure transducer gives no number", "prismatic.supply_pressure", "quality", lambda: _off)
    yield _sensor_fault("pressure transducer's wire broken", "rotary.supply_pressure", "range", lambda: _is(-500 * psi))
    yield _sensor_fault("pressure transducer late", "prismatic.return_pressure", "age", _late)
    lost = lockstep_trial(lambda target: target.device.lose_supply(), Until.SAFE, "rotary")
    yield Fault("supply pressure lost", "oil and tip", Expected("fault: rotary.supply_pressure lost", Until.SAFE, SEEN_MS), lost)


def _oil_and_tip_faults() -> Iterator[Fault]:
    yield _limit_fault("oil too hot", "reservoir_temperature", 700.0)
    yield _limit_fault("oil too cold", "reservoir_temperature", 50.0)
    yield _sensor_fault("thermometer's wire broken", "reservoir_temperature", "range", lambda: _is(3000.0))
    old_ms = loaded_rig().rig.signals["reservoir_temperature"].max_age_s * 1e3
    yield _sensor_fault("thermometer late", "reservoir_temperature", "age", _late, old_ms + SEEN_MS)
    yield _limit_fault("tip acceleration too large", "tip.acceleration", 2200.0)
    yield _sensor_fault("accelerometer off", "tip.acceleration", "quality", lambda: _off)


def _limit_fault(name: str, channel: str, counts: float) -> Fault:
    """A value beyond its limit, which is a controlled stop."""
    run = lockstep_trial(lambda target: _tamper(target, channel, _is(counts)), Until.REST, "rotary")
    return Fault(name, "oil and tip", Expected(f"controlled stop: {channel} limit", Until.REST, STOP_MS), run, began_limit_ms=SEEN_MS)


def _sensor_fault(name: str, channel: str, check: str, change: Callable[[], Tamper], limit_ms: float = SEEN_MS) -> Fault:
    """A sensor that cannot be believed, which is a fault."""
    run = lockstep_trial(lambda target: _tamper(target, channel, change()), Until.SAFE, "rotary")
    return Fault(name, "oil and tip", Expected(f"fault: {channel} {check}", Until.SAFE, limit_ms), run)


def _tamper(target: LockstepTarget, channel: str, change: Tamper) -> None:
    target.device.tamper[channel] = change


def _off(sample: Sample, now_ns: int) -> None:
    sample.raw, sample.quality = nan, Quality.BAD


def _alarm(sample: Sample, now_ns: int) -> None:
    sample.quality = Quality.BAD


def _is(counts: float) -> Tamper:
    def change(sample: Sample, now_ns: int) -> None:
        sample.raw = counts

    return change


def _jump(counts: float) -> Tamper:
    def change(sample: Sample, now_ns: int) -> None:
        sample.raw += counts

    return change


def _noisy(target: LockstepTarget, counts_rms: float) -> Tamper:
    def change(sample: Sample, now_ns: int) -> None:
        sample.raw = round(sample.raw + target.rng.gauss(0.0, counts_rms))

    return change


def _stuck() -> Tamper:
    """The first value it sees, for ever, and always fresh."""
    held: list[float] = []

    def change(sample: Sample, now_ns: int) -> None:
        held.append(sample.raw) if not held else None
        sample.raw = held[0]

    return change


def _late() -> Tamper:
    """No new sample comes: value and time stay."""
    held: list[tuple[float, int]] = []

    def change(sample: Sample, now_ns: int) -> None:
        held.append((sample.raw, sample.stamp_ns)) if not held else None
        sample.raw, sample.stamp_ns = held[0]

    return change
