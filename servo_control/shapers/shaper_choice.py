"""The shaper part of a run request, checked.

    {"kind": "adaptive", "joints": ["rotary"], "focal": "mid" or "frequency": 4.2, ...}

`focal` is a moment of the maneuver: initial (its start), final (the end of its first move) or mid (geometric mean of both).
"""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from math import isfinite
from typing import Any

from config.errors import ManeuverError

_FIXED = ("focal", "frequency_Hz", "frequency_scale")
OPTIONS: dict[str, tuple[str, ...]] = {  # of every kind, besides `joints`
    "none": (),
    "zv": (*_FIXED, "damping_ratio"),
    "zvd": (*_FIXED, "damping_ratio"),
    "ei": (*_FIXED, "vibration"),
    "two_hump_ei": (*_FIXED, "vibration"),
    "three_term": (*_FIXED, "damping_ratio", "delay_s"),
    "notch": (*_FIXED, "damping_ratio"),
    "robust_notch": (*_FIXED, "damping_ratio"),
    "adaptive": ("frequency_scale",),
    "adaptive_zv": ("frequency_scale",),
    "adaptive_coefficients": ("frequency_scale", "delay_s"),
    "adaptive_delay": ("frequency_scale",),
    "zero_delay": ("frequency_scale", "frequency_range"),
}
KINDS = tuple(OPTIONS)
ADAPTIVE = ("adaptive", "adaptive_zv", "adaptive_coefficients", "adaptive_delay")
FASTER_MOVES = ("adaptive_zv", "zero_delay")  # make room for smooth ramps, or a correction, by a higher speed
FOCAL = ("initial", "final", "mid")
WHERE = "shaper"
_WORDS = {"focal": "--focal", "frequency_Hz": "--focal", "delay_s": "--delay"}  # as the command line calls them


@dataclass(frozen=True, slots=True)
class ShaperChoice:
    """`joints` empty: the rotary joint (or the only one). `delay_s` is T of the kinds with free T.

    `frequency_range`: `zero_delay` leaves no vibration for frequencies within 1 ± this share.
    """

    kind: str = "none"
    joints: tuple[str, ...] = ()
    focal: str = "mid"
    frequency_Hz: float | None = None
    damping_ratio: float | None = None
    delay_s: float | None = None
    vibration: float = 0.05
    frequency_scale: float = 1.0
    frequency_range: float = 0.15

    @staticmethod
    def from_content(content: dict[str, Any]) -> ShaperChoice:
        """Raises ManeuverError naming the key, its value and what is allowed."""
        known = [item.name for item in fields(ShaperChoice)]
        for key in content:
            if key not in known:
                raise ManeuverError("unknown key of the shaper", value=key, limit=", ".join(known), where=WHERE)
        values = {key: value for key, value in content.items() if value is not None}
        joints = values.get("joints", ())
        values["joints"] = (joints,) if isinstance(joints, str) else tuple(joints)
        choice = ShaperChoice(**values)
        _one_of("kind", choice.kind, KINDS)
        _one_of("focal", choice.focal, FOCAL)
        _within("frequency_Hz", choice.frequency_Hz, 0.01, 500.0, "Hz")
        _within("damping_ratio", choice.damping_ratio, 0.0, 0.9, "")
        _within("delay_s", choice.delay_s, 0.002, 10.0, "s")
        _within("vibration", choice.vibration, 0.001, 0.2, "")
        _within("frequency_scale", choice.frequency_scale, 0.5, 2.0, "")
        _within("frequency_range", choice.frequency_range, 0.0, 0.2, "")
        return choice


def refuse_idle_options(content: dict[str, Any]) -> None:
    """ManeuverError for options that say something and that the kind does not have: asked of new requests only, because runs that were
    logged with such options are planned again as they were."""
    usual, kind = asdict(ShaperChoice()), str(content.get("kind", "none"))
    has = ("kind", "joints", *OPTIONS.get(kind, usual))
    idle = [key for key, value in content.items() if key in usual and key not in has and value not in (None, usual[key])]
    if idle:
        raise ManeuverError(
            f"the command filter {kind} does not use {' and '.join(idle)}",
            value=", ".join(str(content[key]) for key in idle),
            limit=", ".join(has[1:]),
            where=WHERE,
            next_step="Leave it out, or choose a filter that has it.",
            mend={_WORDS[key]: None for key in idle if key in _WORDS},
        )


def with_kind(content: dict[str, Any], kind: str) -> dict[str, Any]:
    """The same request for another kind, with what that one has of the options."""
    kept = ("joints", *OPTIONS.get(kind, content))
    return {key: value for key, value in content.items() if key in kept} | {"kind": kind}


def _one_of(key: str, value: object, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise ManeuverError(f"unknown {key} of the shaper", value=value, limit=", ".join(allowed), where=WHERE)


def _within(key: str, value: object, low: float, high: float, unit: str) -> None:
    if value is None:
        return
    if not isinstance(value, (int, float)) or isinstance(value, bool) or not isfinite(value) or not low <= value <= high:
        mend = {_WORDS[key]: None} if key in _WORDS else {}  # without it the filter fits the link, which it does at no bound
        raise ManeuverError(f"{key} is out of range", value=value, limit=f"{low:g} to {high:g}", unit=unit, where=WHERE, mend=mend)
