"""Faults of sensors and of what they measure, for each joint where it differs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from math import nan

from daemon.faults.fault import INFERRED_MS, SEEN_MS, Fault, Until
from daemon.faults.faulty_device import Tamper
from daemon.faults.lockstep_bench import Inject, Scene, loaded_rig, lockstep_trial
from drivers.contract import Quality, Sample

STOP_MS = 5000.0  # the daemon's longest controlled stop; a longer one is a fault


@dataclass(frozen=True, slots=True)
class _Odd:
    """Sizes of an odd encoder in counts, small against what the joint does in a maneuver."""

    jump: float
    noise: float


_ODD = {"rotary": _Odd(jump=200.0, noise=12.0), "prismatic": _Odd(jump=200.0, noise=12.0)}  # 1 deg, 0.06 deg rms; 5 mm, 0.3 mm rms


def sensor_faults() -> Iterator[Fault]:
    """Encoders of every joint, then pressures, temperature and tip."""
    for joint in loaded_rig().rig.joints:
        yield from _encoder_faults(joint)
    yield from _gauge_faults()


def _encoder_faults(joint: str) -> Iterator[Fault]:
    channel, odd = f"{joint}.position", _ODD[joint]

    def fault(name: str, expected: str, inject: Inject, limit_ms: float = SEEN_MS) -> Fault:
        run = lockstep_trial(inject, Until.SAFE, joint)
        return Fault(f"{joint} {name}", "encoder", f"fault: {joint}{expected}", Until.SAFE, limit_ms, run)

    yield fault("encoder off", ".position quality", lambda scene: _tamper(scene, channel, _off))
    yield fault("encoder alarm bit", ".position quality", lambda scene: _tamper(scene, channel, _alarm))
    yield fault("encoder stuck", " position stuck", lambda scene: _tamper(scene, channel, _stuck()))
    yield fault("encoder jump", " position rate", lambda scene: _tamper(scene, channel, _jump(odd.jump)))
    yield fault("encoder noisy", " position", lambda scene: _tamper(scene, channel, _noisy(scene, odd.noise)))
    yield fault("encoder late", ".position age", lambda scene: _tamper(scene, channel, _late()))
    yield fault("encoder out of range", ".position range", lambda scene: _tamper(scene, channel, _is(1e6)))
    yield fault("valve cable off", " unexplained motion", lambda scene: scene.device.deaf.add(f"{joint}.command"), INFERRED_MS)


def _gauge_faults() -> Iterator[Fault]:
    psi = 1.0 / 0.7  # counts a psi

    def stop(name: str, channel: str, counts: float) -> Fault:
        run = lockstep_trial(lambda scene: _tamper(scene, channel, _is(counts)), Until.REST, "rotary")
        return Fault(name, "oil and tip", f"controlled stop: {channel} limit", Until.REST, STOP_MS, run, began_limit_ms=SEEN_MS)

    def fault(name: str, channel: str, rule: str, change: Callable[[], Tamper], limit_ms: float = SEEN_MS) -> Fault:
        run = lockstep_trial(lambda scene: _tamper(scene, channel, change()), Until.SAFE, "rotary")
        return Fault(name, "oil and tip", f"fault: {channel} {rule}", Until.SAFE, limit_ms, run)

    yield stop("supply pressure low", "rotary.supply_pressure", 1400 * psi)
    yield stop("supply pressure high", "prismatic.supply_pressure", 2500 * psi)
    yield stop("return pressure high", "rotary.return_pressure", 200 * psi)
    yield fault("pressure transducer gives no number", "prismatic.supply_pressure", "quality", lambda: _off)
    yield fault("pressure transducer's wire broken", "rotary.supply_pressure", "range", lambda: _is(-500 * psi))
    yield fault("pressure transducer late", "prismatic.return_pressure", "age", _late)
    lost = lockstep_trial(lambda scene: scene.device.lose_supply(), Until.SAFE, "rotary")
    yield Fault("supply pressure lost", "oil and tip", "fault: rotary.supply_pressure lost", Until.SAFE, SEEN_MS, lost)
    yield stop("oil too hot", "reservoir_temperature", 700.0)
    yield stop("oil too cold", "reservoir_temperature", 50.0)
    yield fault("thermometer's wire broken", "reservoir_temperature", "range", lambda: _is(3000.0))
    old_ms = loaded_rig().rig.signals["reservoir_temperature"].max_age_s * 1e3
    yield fault("thermometer late", "reservoir_temperature", "age", _late, old_ms + SEEN_MS)
    yield stop("tip acceleration too large", "tip.acceleration", 2200.0)
    yield fault("accelerometer off", "tip.acceleration", "quality", lambda: _off)


def _tamper(scene: Scene, channel: str, change: Tamper) -> None:
    scene.device.tamper[channel] = change


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


def _noisy(scene: Scene, counts_rms: float) -> Tamper:
    def change(sample: Sample, now_ns: int) -> None:
        sample.raw = round(sample.raw + scene.chance.gauss(0.0, counts_rms))

    return change


def _stuck() -> Tamper:
    """The first value it sees, for ever, and always fresh."""
    kept: list[float] = []

    def change(sample: Sample, now_ns: int) -> None:
        kept.append(sample.raw) if not kept else None
        sample.raw = kept[0]

    return change


def _late() -> Tamper:
    """No new sample comes: value and time stay."""
    kept: list[tuple[float, int]] = []

    def change(sample: Sample, now_ns: int) -> None:
        kept.append((sample.raw, sample.stamp_ns)) if not kept else None
        sample.raw, sample.stamp_ns = kept[0]

    return change
