"""Signals against what uses them: travel, the loop's period; commands and limits against what is measured."""

from __future__ import annotations

from collections.abc import Iterator

from config.checking.finding import Finding, error_at, warning_at
from config.parsing.yaml_tree import YamlTree, dotted
from config.schema.rig import Rig


def check_signals(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    """Findings about `signals`, and about the joints and interlocks that hang on them."""
    yield from _signal_ranges(rig, tree)
    yield from _ages(rig, tree)
    yield from _blind(rig, tree)
    yield from _commands(rig, tree)
    yield from _interlocks(rig, tree)


def _signal_ranges(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    for name, joint in rig.joints.items():
        signal = rig.signals[f"{name}.position"]
        unit = joint.position_unit
        for bound, limit, inside in (("low", signal.low, min), ("high", signal.high, max)):
            edge = inside(joint.travel)
            if limit is not None and inside(limit, edge) != limit:
                text = f"{name}.position: {bound} = {limit:.6g} {unit} lies inside the travel, which ends at {edge:.6g} {unit}"
                yield error_at(tree, ("signals", f"{name}.position", bound), text)


def _ages(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    period_s = 1 / rig.loop.rate_Hz
    for name, signal in rig.signals.items():
        if signal.max_age_s < period_s:
            text = f"{name}: max_age {signal.max_age_s:g} s is less than one period of the loop, {period_s:g} s: always stale"
            yield error_at(tree, ("signals", name, "max_age"), text)
        if name.endswith(".position") and rig.devices[signal.device].slow:
            text = f"{name} comes from the slow device {signal.device!r}: the servo will act on old positions"
            yield warning_at(tree, ("signals", name, "device"), text)


def _blind(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    """5 s where 5 ms were meant. On an old position, a following error of the way that the joint makes meanwhile would have stopped it;
    led by a device that hears nothing, it reaches a stop from the middle of its travel."""
    for name, joint in rig.joints.items():
        position, driven = f"{name}.position", rig.outputs[name].device
        until, half = "on a position of that age; following_error_limit is", 0.5 * (joint.travel[1] - joint.travel[0])
        age_s, unheard_s = rig.signals[position].max_age_s, rig.devices[driven].timeout_s
        yield from _moved(rig, tree, name, ("signals", position, "max_age"), age_s, until, joint.following_error_limit)
        until = "before the device makes its output safe; half its travel is"
        yield from _moved(rig, tree, name, ("devices", driven, "timeout"), unheard_s, until, half)


def _moved(rig: Rig, tree: YamlTree, name: str, path: tuple[str, ...], time_s: float, until: str, most: float) -> Iterator[Finding]:
    moved, unit = rig.joints[name].rate_limit * time_s, rig.joints[name].position_unit
    if moved > most * (1 + 1e-9):
        yield warning_at(tree, path, f"{dotted(path)} is {time_s:g} s: {name} moves up to {moved:.4g} {unit} {until} {most:.4g} {unit}")


def _commands(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    for name, joint in rig.joints.items():
        needed_V = abs(rig.servo[name].velocity_feedforward) * joint.rate_limit
        if needed_V > joint.command_limit_V:
            text = f"joints.{name}: rate_limit needs {needed_V:.3g} V by the feed-forward, command_limit is {joint.command_limit_V:g} V"
            yield warning_at(tree, ("joints", name, "rate_limit"), f"{text}: the joint cannot reach its rate limit")


def _interlocks(rig: Rig, tree: YamlTree) -> Iterator[Finding]:
    fitted = {name.rsplit(".", 1)[-1] for name in rig.signals}
    pairs = (
        ("supply_pressure", "supply_pressure_min", rig.interlocks.supply_pressure_min_Pa),
        ("return_pressure", "return_pressure_max", rig.interlocks.return_pressure_max_Pa),
        ("reservoir_temperature", "oil_temperature_max", rig.interlocks.oil_temperature_max_C),
    )
    for signal, key, limit in pairs:
        if signal in fitted and limit is None:
            yield warning_at(tree, ("interlocks",), f"{signal} is measured but interlocks.{key} is not set: nothing stops the arm on it")
