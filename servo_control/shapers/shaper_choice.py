"""The shaper part of a run request, checked.

    {"kind": "adaptive", "joints": ["rotary"], "focal": "mid" or "frequency": 4.2, ...}

`focal` is a moment of the maneuver: initial (its start), final (the end of its first move) or mid (geometric mean of both).
"""

from __future__ import annotations

from dataclasses import dataclass, fields
from math import isfinite
from typing import Any

from config.errors import ManeuverError

KINDS = (
    "none", "zv", "zvd", "ei", "two_hump_ei", "three_term", "notch", "robust_notch",
    "adaptive", "adaptive_zv", "adaptive_coefficients", "adaptive_delay", "zero_delay",
)  # fmt: skip
ADAPTIVE = ("adaptive", "adaptive_zv", "adaptive_coefficients", "adaptive_delay")
FASTER_MOVES = ("adaptive_zv", "zero_delay")  # make room for smooth ramps, or a correction, by a higher speed
FOCAL = ("initial", "final", "mid")
WHERE = "shaper"
_OPTIONS = {"frequency_Hz": "--focal", "delay_s": "--delay"}  # as the command line calls them


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


def _one_of(key: str, value: object, allowed: tuple[str, ...]) -> None:
    if value not in allowed:
        raise ManeuverError(f"unknown {key} of the shaper", value=value, limit=", ".join(allowed), where=WHERE)


def _within(key: str, value: object, low: float, high: float, unit: str) -> None:
    if value is None:
        return
    if not isinstance(value, (int, float)) or isinstance(value, bool) or not isfinite(value) or not low <= value <= high:
        bound = low if isinstance(value, (int, float)) and value < low else high
        mend = {_OPTIONS[key]: f"{bound:g} {unit}"} if key in _OPTIONS else {}
        raise ManeuverError(f"{key} is out of range", value=value, limit=f"{low:g} to {high:g}", unit=unit, where=WHERE, mend=mend)
