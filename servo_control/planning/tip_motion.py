"""How fast a program moves the tip: its speed, and its acceleration across the link, which `interlocks.tip_acceleration_max` limits.

    |v| = √(ṙ² + (r θ̇)²),   a = r θ̈ + 2 ṙ θ̇,   r = hub offset + extension: of a rigid arm on the program

A command filter behind the program delays and averages; what the link adds by vibrating is not in it.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import hypot
from typing import NamedTuple

from config.errors import ManeuverError
from config.schema.rig import Rig
from servo_control.path.pieces import Piece
from servo_control.planning.plan_checks import SLACK, samples
from servo_control.planning.run_plan import TipMotion


class TipPeaks(NamedTuple):
    """Largest speed (m/s) and acceleration across the link (m/s²)."""

    speed_mps: float
    acceleration_mps2: float


def tip_peaks(rig: Rig, pieces: Sequence[Piece], period_s: float) -> TipPeaks | None:
    """None on an arm without tip: one that is not rotary and prismatic."""
    names = list(rig.joints)
    if "rotary" not in names or "prismatic" not in names:
        return None
    rotary, prismatic = names.index("rotary"), names.index("prismatic")
    speed = across = 0.0
    for _, (positions, rates, accelerations, _volts) in samples(pieces, period_s):
        r, turning, sliding = rig.arm.hub_offset_m + positions[prismatic], rates[rotary], rates[prismatic]
        speed = max(speed, hypot(sliding, r * turning))
        across = max(across, abs(r * accelerations[rotary] + 2.0 * sliding * turning))
    return TipPeaks(speed, across)


def checked_tip(rig: Rig, planned: TipPeaks | None, run: TipPeaks | None, rates: Sequence[float], where: str) -> TipMotion | None:
    """What the operator is told. `rates`: peaks of the joints, rad/s or m/s. Raises ManeuverError for a tip that would be too fast for
    the interlock, which would end the run."""
    if planned is None or run is None:
        return None
    limit = rig.interlocks.tip_acceleration_max_m_per_s2
    if limit is not None and run.acceleration_mps2 > limit * SLACK:
        raise ManeuverError(
            "the tip's acceleration across the link is above interlocks.tip_acceleration_max",
            value=f"{run.acceleration_mps2:.4g}",
            limit=f"{limit:.4g}",
            unit="m/s^2",
            where=where,
            next_step="Choose a lower speed or acceleration.",
        )
    shares = {name: rate / joint.rate_limit for (name, joint), rate in zip(rig.joints.items(), rates, strict=True)}
    fastest = max(shares, key=lambda name: shares[name])
    return TipMotion(planned.speed_mps, run.speed_mps, planned.acceleration_mps2, run.acceleration_mps2, limit, fastest, shares[fastest])
