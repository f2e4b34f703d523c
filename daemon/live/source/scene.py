"""What a view shows of a rig, made once from the rig file: units as it states them, the arm's shape, which plots belong together."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from config.loading.load import rig_from_text
from config.loading.stated_units import stated_units
from config.stated_sentences import Conversion
from recording.format.shown_units import field_conversions

# Title of a plot → what the names of its signals end with. Each joint has its own of the first, the rest hold all joints.
_OF_A_JOINT = {"position": (".target", ".reference", ".position"), "rate": (".reference_rate", ".velocity")}
_OF_THE_RIG = {
    "tip acceleration": ("tip.acceleration_mps2",),
    "tip deflection": ("tip.deflection_m",),
    "command": (".command_V",),
    "following error": (".following_error",),
    "pressures": ("_pressure_Pa", ".pressure_a_Pa", ".pressure_b_Pa"),
    "temperatures": ("_temperature_C",),
    "timing": ("late_us", "read_us", "compute_us", "write_us"),
}


def scene(answer: Mapping[str, Any]) -> dict[str, Any]:
    """From the daemon's answer to `rig`: name, text, `played` (the log, if it is one), joints, arm, `plots`, `at_t_s`, `signals`: name, SI
    unit, unit, factor, offset."""
    rig = rig_from_text(answer["text"], f"{answer['name']}.yaml")
    signals = _signals(answer["text"], answer["signals"])
    names = [signal["name"] for signal in signals]
    return {
        "name": rig.name,
        "description": rig.description,
        "text": answer["text"],
        "played": answer.get("played", ""),
        "rate_Hz": rig.loop.rate_Hz,
        "arm": {"kind": rig.arm.kind, "hub_offset_m": rig.arm.hub_offset_m},
        "joints": {name: {"motion": joint.motion, "travel": list(joint.travel)} for name, joint in rig.joints.items()},
        "signals": signals,
        "plots": _plots(tuple(rig.joints), signals),
        "at_t_s": names.index("t_s"),
    }


def _signals(text: str, signals: Iterable[tuple[str, str]]) -> list[dict[str, Any]]:
    """Every number of a sample with its unit in the rig file."""
    units = dict(signals)
    shown = field_conversions(units, stated_units(text))
    return [{"name": name, "si_unit": unit, **_shown(shown.get(name, (unit, 1.0, 0.0)))} for name, unit in units.items()]


def _shown(conversion: Conversion) -> dict[str, Any]:
    """shown = factor × SI + offset"""
    return dict(zip(("unit", "factor", "offset"), conversion, strict=True))


def _plots(joints: Sequence[str], signals: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Title and signals of every plot that has any."""
    plots: list[dict[str, Any]] = []
    for title, endings in _OF_A_JOINT.items():
        plots += [{"title": f"{joint} {title}", "signals": [f"{joint}{ending}" for ending in endings]} for joint in joints]
    for title, endings in _OF_THE_RIG.items():
        names = [signal["name"] for signal in signals if str(signal["name"]).endswith(endings)]
        plots += [{"title": title, "signals": names}] if names else []
    return plots
