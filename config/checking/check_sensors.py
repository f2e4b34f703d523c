"""Simulated transducers against what judges and uses their signals: plausibility limits, ranges, travel, supply."""

from __future__ import annotations

import math
from collections.abc import Iterator

from config.checking.finding import Finding, warning_at
from config.parsing.yaml_tree import YamlTree
from config.schema.plant import Plant
from config.schema.plant_sensor import Sensor
from config.schema.rig import Rig
from config.schema.signals import Signal

PEAK = 5.0  # standard deviations that noise exceeds about once in two million samples


def check_sensors(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    """Findings about `plant.sensors`."""
    plant = rig.plant
    if plant is None:
        return
    for name, joint in rig.joints.items():
        sensor = plant.sensors.get(f"{name}.position")
        if sensor is not None and not plant.joints[name].is_imposed:
            yield from _noise(rig, tree, name, sensor)
            yield from _steps(rig, tree, name, sensor)
            yield from _range(tree, f"{name}.position", sensor, joint.travel, joint.position_unit, f"joints.{name}.travel")
    yield from _pressures(rig, plant, tree)


def second_difference(noise: float, bandwidth_Hz: float, rate_Hz: float) -> float:
    """Mean |x(k) - 2 x(k-1) + x(k-2)| of noise behind a first-order lag, which is what `plausibility.noise` looks at.

    Its variance is noise² (6 - 8 a + 2 a²) with a = exp(-2 pi bandwidth / rate), and the mean of a normal |x| is sqrt(2/pi) sd.
    """
    kept = math.exp(-2 * math.pi * bandwidth_Hz / rate_Hz) if bandwidth_Hz else 0.0
    return math.sqrt(2 / math.pi * (6 - 8 * kept + 2 * kept**2)) * noise


def _noise(rig: Rig, tree: YamlTree, name: str, sensor: Sensor) -> Iterator[Finding]:
    joint, limits, rate_Hz = rig.joints[name], rig.interlocks.plausibility, rig.loop.rate_Hz
    path, unit = ("plant", "sensors", f"{name}.position", "noise"), joint.position_unit
    deviation = second_difference(sensor.noise, sensor.bandwidth_Hz, rate_Hz)
    rms = f"plant.sensors.{name}.position: noise of {sensor.noise:.3g} {unit} rms"
    if limits.noise is not None and deviation > limits.noise * joint.following_error_limit:
        limit = f"interlocks.plausibility.noise stops the arm at {limits.noise * joint.following_error_limit:.3g} {unit}"
        yield warning_at(tree, path, f"{rms} looks like {deviation:.3g} {unit} from sample to sample; {limit}")
    kept = math.exp(-2 * math.pi * sensor.bandwidth_Hz / rate_Hz) if sensor.bandwidth_Hz else 0.0
    jump = PEAK * sensor.noise * math.sqrt(2 * (1 - kept)) * rate_Hz
    if limits.rate is not None and jump > limits.rate * joint.rate_limit:
        limit = f"interlocks.plausibility.rate stops the arm at {limits.rate * joint.rate_limit:.3g} {unit}/s"
        yield warning_at(tree, path, f"{rms} jumps by {jump:.3g} {unit}/s at times; {limit}")


def _steps(rig: Rig, tree: YamlTree, name: str, sensor: Sensor) -> Iterator[Finding]:
    """A moving count steps by whole counts, which looks like a jump, like noise or like a stuck sensor when counts are coarse."""
    joint, limits = rig.joints[name], rig.interlocks.plausibility
    path, unit = ("plant", "sensors", f"{name}.position", "resolution"), joint.position_unit
    judged = (
        ("noise", limits.noise, joint.following_error_limit, unit, sensor.resolution),
        ("stuck", limits.stuck, joint.following_error_limit, unit, sensor.resolution),
        ("rate", limits.rate, joint.rate_limit, f"{unit}/s", sensor.resolution * rig.loop.rate_Hz),
    )
    for rule, share, per, of, step in judged:
        if share is not None and step >= share * per:
            text = f"plant.sensors.{name}.position: one count is {step:.3g} {of}; interlocks.plausibility.{rule} stops the arm at"
            yield warning_at(tree, path, f"{text} {share * per:.3g} {of}")


def _range(tree: YamlTree, name: str, sensor: Sensor, needed: tuple[float, float], unit: str, what: str) -> Iterator[Finding]:
    slack = 1e-6 * max(map(abs, needed))
    if sensor.low > needed[0] + slack or sensor.high < needed[1] - slack:
        ends, all_of_it = (f"{low:.6g} to {high:.6g} {unit}" for low, high in ((sensor.low, sensor.high), needed))
        text = f"plant.sensors.{name} reads {ends} only; {what} is {all_of_it}"
        yield warning_at(tree, ("plant", "sensors", name), text)


def _pressures(rig: Rig, plant: Plant, tree: YamlTree) -> Iterator[Finding]:
    """What the transducers will read at rest, against their range and against the signal's `low` and `high`."""
    if plant.supply is None:
        return
    at_rest = {"supply_pressure": plant.supply.pressure_Pa, "return_pressure": plant.supply.return_pressure_Pa}
    for name, sensor in plant.sensors.items():
        true_Pa = at_rest.get(name.rpartition(".")[2])
        if true_Pa is None:
            continue
        yield from _range(tree, name, sensor, (true_Pa, true_Pa), "Pa", "the pressure there")
        if name in rig.signals:
            yield from _believed(tree, name, rig.signals[name], sensor, true_Pa)


def _believed(tree: YamlTree, name: str, signal: Signal, sensor: Sensor, true_Pa: float) -> Iterator[Finding]:
    peak_Pa = PEAK * sensor.noise + abs(sensor.bias)
    least, most = max(true_Pa - peak_Pa, sensor.low), min(true_Pa + peak_Pa, sensor.high)
    for key, end, reached, side in (("low", signal.low, least, -1), ("high", signal.high, most, 1)):
        if end is not None and side * (reached - end) > 0:
            text = f"signals.{name}.{key} is {end:.4g} Pa; with noise of {sensor.noise:.3g} Pa rms about {true_Pa:.4g} Pa"
            yield warning_at(tree, ("signals", name, key), f"{text} the reading reaches {reached:.4g} Pa and is refused as implausible")
