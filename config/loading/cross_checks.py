"""What one section of a rig file demands of another: every joint has a servo, every signal a device, every name is known.

These run on the plain content, so that they are reported together with the schema's problems, and pass over what is not there.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from config.loading.cross_checks_plant import cross_check_plant
from config.parsing.nearest import nearest_text
from config.parsing.problems import Problem
from config.parsing.yaml_tree import YamlTree, dotted
from config.signal_names import SECOND_POSITION, signal_measures


def cross_check(tree: YamlTree) -> list[Problem]:
    """Every contradiction between the sections of a rig file."""
    checks = (
        _arm_joints,
        _one_entry_per_joint,
        _inferred_keys,
        _signal_names,
        _positions,
        _devices,
        _interlock_signals,
        _end_point,
        _extension,
        _oil,
        _identified,
    )
    return [*(problem for check in checks for problem in check(tree)), *cross_check_plant(tree)]


def _arm_joints(tree: YamlTree) -> Iterator[Problem]:
    joints = _mapping(tree, "joints")
    kind = tree.value(("arm", "kind"))
    if kind == "single_axis" and len(joints) > 1:
        yield tree.problem(("joints",), "a single_axis arm has one joint", of_key=True, value=", ".join(joints))
    if kind != "rotary_prismatic" or not joints:
        return
    for name, motion in (("rotary", "rotary"), ("prismatic", "linear")):
        if name not in joints:
            yield tree.problem(
                ("joints",), f"a rotary_prismatic arm needs a joint named {name!r}", of_key=True, next_step=f"Add joints.{name}."
            )
        elif tree.value(("joints", name, "motion")) not in (motion, None):
            yield tree.problem(("joints", name, "motion"), f"the joint {name!r} of a rotary_prismatic arm must have motion: {motion}")
    for name in joints:
        if name not in ("rotary", "prismatic"):
            yield tree.problem(("joints", name), f"a rotary_prismatic arm has the joints rotary and prismatic, not {name!r}", of_key=True)
    if tree.value(("link_mode",)) is None:
        yield tree.problem(
            (), "a rotary_prismatic arm needs the section 'link_mode'", next_step="It gives the shapers the link's frequency."
        )


def _one_entry_per_joint(tree: YamlTree) -> Iterator[Problem]:
    joints = _mapping(tree, "joints")
    for section in ("servo", "outputs"):
        entries = _mapping(tree, section)
        if not joints or not isinstance(tree.value((section,)), dict):
            continue  # the schema reports a missing section
        for name in joints:
            if name not in entries:
                yield tree.problem(
                    (section, name), f"{section} has no entry for the joint {name!r}", of_key=True, next_step=f"Add {section}.{name}."
                )
        for name in entries:
            if name not in joints:
                what = f"{section}.{name} belongs to no joint{nearest_text(name, joints)}"
                yield tree.problem((section, name), what, of_key=True, next_step=f"Joints: {', '.join(joints)}.")


def _inferred_keys(tree: YamlTree) -> Iterator[Problem]:
    for section, key, source in (("servo", "motion", "joints.{}.motion"), ("signals", "measures", "the name of the signal")):
        for name, entry in _mapping(tree, section).items():
            if isinstance(entry, dict) and key in entry:
                what = f"{section}.{name}.{key} is not a key here"
                yield tree.problem((section, name, key), what, of_key=True, next_step=f"Remove it: it follows from {source.format(name)}.")


def _signal_names(tree: YamlTree) -> Iterator[Problem]:
    known = signal_measures(_motions(tree))
    for name in _mapping(tree, "signals"):
        if name not in known:
            hint = nearest_text(name, known)
            listed = "" if hint else f"Signals of this rig: {', '.join(known)}."
            yield tree.problem(("signals", name), f"{name!r} is not a signal of this rig{hint}", of_key=True, next_step=listed)


def _positions(tree: YamlTree) -> Iterator[Problem]:
    signals = tree.value(("signals",))
    for joint in _mapping(tree, "joints") if isinstance(signals, dict) else ():
        name = f"{joint}.position"
        if name not in signals:
            yield tree.problem(("signals",), f"the joint {joint!r} has no position signal", of_key=True, next_step=f"Add signals.{name}.")
        elif tree.value(("signals", name, "required")) is False:
            yield tree.problem(
                ("signals", name, "required"), f"{name} closes the loop and cannot be optional", next_step="Remove required: false."
            )


def _devices(tree: YamlTree) -> Iterator[Problem]:
    devices = _mapping(tree, "devices")
    if not devices:
        return
    for section in ("signals", "outputs"):
        for name, entry in _mapping(tree, section).items():
            device = entry.get("device") if isinstance(entry, dict) else None
            if isinstance(device, str) and device not in devices:
                what = f"{section}.{name}: there is no device {device!r}{nearest_text(device, devices)}"
                yield tree.problem((section, name, "device"), what, next_step=f"Devices: {', '.join(devices)}.")
    for name, entry in _mapping(tree, "outputs").items():
        device = entry.get("device") if isinstance(entry, dict) else None
        if isinstance(device, str) and tree.value(("devices", device, "slow")) is True:
            what = f"outputs.{name} goes to the slow device {device!r}"
            yield tree.problem(
                ("outputs", name, "device"), what, next_step="A joint's command must be written inside the loop: slow: false."
            )


_SIGNAL_OF_INTERLOCK = {
    "supply_pressure_min": ".supply_pressure",
    "supply_pressure_max": ".supply_pressure",
    "return_pressure_max": ".return_pressure",
    "oil_temperature_min": "reservoir_temperature",
    "oil_temperature_max": "reservoir_temperature",
    "tip_acceleration_max": "tip.acceleration",
    "plausibility.apart": f".{SECOND_POSITION}",
}


def _interlock_signals(tree: YamlTree) -> Iterator[Problem]:
    """A limit on something that is not measured would protect nobody."""
    signals = tree.value(("signals",))
    for limit, signal in _SIGNAL_OF_INTERLOCK.items() if isinstance(signals, dict) else ():
        path = ("interlocks", *limit.split("."))
        if tree.value(path) is not None and not any(name.endswith(signal) for name in signals):
            what = f"interlocks.{limit} needs a signal {'JOINT' if signal[0] == '.' else ''}{signal}, which is not in signals"
            yield tree.problem(path, what, of_key=True, next_step="Add the signal, or remove the limit.")


def _end_point(tree: YamlTree) -> Iterator[Problem]:
    """End-point feedback needs an arm with a link, and the signal it feeds back."""
    if tree.value(("end_point",)) is None:
        return
    if tree.value(("arm", "kind")) == "single_axis":
        yield tree.problem(("end_point",), "a single_axis arm has no end point to feed back", of_key=True, next_step="Remove it.")
    signal = f"tip.{tree.value(('end_point', 'source')) or 'deflection'}"
    if isinstance(tree.value(("signals",)), dict) and signal not in _mapping(tree, "signals"):
        yield tree.problem(
            ("end_point",), f"end_point needs the signal {signal}, which is not in signals", of_key=True, next_step="Add the signal."
        )
    gain = ("end_point", "friction_gain")
    if tree.value(gain) is not None and tree.value(("servo", "rotary", "oil_compensation")) is None:
        what = "end_point.friction_gain acts on the friction in servo.rotary.oil_compensation, which is not there"
        yield tree.problem(gain, what, next_step="Add servo.rotary.oil_compensation, or remove friction_gain.")


def _extension(tree: YamlTree) -> Iterator[Problem]:
    """A gain or a notch that follows the extension needs a joint that extends the link."""
    for joint in _mapping(tree, "servo") if "prismatic" not in _mapping(tree, "joints") else ():
        for key in ("gain_schedule", "link_notch"):
            path = ("servo", joint, key)
            if tree.value(path):
                what = f"{dotted(path)} needs a joint named 'prismatic', whose position is the extension"
                yield tree.problem(path, what, of_key=True, next_step="Remove it.")


def _oil(tree: YamlTree) -> Iterator[Problem]:
    """Oil compensation needs a temperature that is measured."""
    fitted = [name for name in _mapping(tree, "signals") if name.endswith("temperature")]
    for joint in _mapping(tree, "servo") if isinstance(tree.value(("signals",)), dict) else ():
        path = ("servo", joint, "oil_compensation", "source")
        source = tree.value(path)
        if isinstance(source, str) and source not in fitted:
            what = f"{dotted(path)}: there is no temperature signal {source!r}{nearest_text(source, fitted)}"
            yield tree.problem(path, what, next_step=f"Temperature signals: {', '.join(fitted) or 'none'}.")


def _identified(tree: YamlTree) -> Iterator[Problem]:
    """Identified numbers of the link need a link."""
    if tree.value(("identified",)) is not None and tree.value(("link_mode",)) is None:
        yield tree.problem(("identified",), "identified needs the section 'link_mode', whose numbers it replaces", of_key=True)


def _motions(tree: YamlTree) -> dict[str, str]:
    return {name: str(tree.value(("joints", name, "motion"))) for name in _mapping(tree, "joints")}


def _mapping(tree: YamlTree, key: str) -> dict[str, Any]:
    value = tree.value((key,))
    return value if isinstance(value, dict) else {}
