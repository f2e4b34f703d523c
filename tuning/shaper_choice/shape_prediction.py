"""What a command filter leaves of the link's vibration on ideal joints, over a range of errors of the believed frequency.

The link is what the controller believes of it (formula or identified map), one shape, with the extension of the run:

    ẅ + 2ζω(L) ẇ + ω(L)² w = −α θ̈ − 2 L̇ θ̇ (M + 3/8 mL)/(M + 33/140 mL)

This is the sliding link of docs/method/plant.md with its static shape alone. All errors are integrated side by side: the joints' motion is
the same for each.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from config.errors import ManeuverError
from config.schema.rig import LinkMode, Rig
from recording.evaluation.vibration import AFTER_MOVE_S
from servo_control.link.link_mode import LinkFrequency
from servo_control.planning.prediction import predict
from servo_control.planning.run_plan import RunPlan
from tuning.arrays import Floats
from tuning.experiments.judged_holds import JudgedHold, judged_holds
from tuning.link_and_payload.free_vibration import LINK_INERTIA, LINK_MASS

ERRORS = (-0.10, -0.075, -0.05, -0.025, 0.0, 0.025, 0.05, 0.075, 0.10)  # true frequency over believed, less one
ARRIVED_RAD, ARRIVED_M = 1e-3, 1e-3  # about a millimetre at the tip


@dataclass(frozen=True, slots=True, eq=False)
class Prediction:
    """`residual_mps2` (holds × errors): amplitude of the tip's vibration 1.0 s after every move's planned end. `late_s`: how much later
    than planned the references arrive, one a move. `too_short`: moves that are left out, because their hold ends before the window in
    which vibration is judged."""

    moves: tuple[str, ...]
    errors: Floats
    residual_mps2: Floats
    late_s: Floats
    too_short: tuple[str, ...] = ()

    @property
    def worst_mps2(self) -> float:
        return float(np.max(self.residual_mps2))

    @property
    def nominal_mps2(self) -> float:
        """Largest hold at the error nearest to 0."""
        return float(np.max(self.residual_mps2[:, np.argmin(np.abs(self.errors))]))


def predicted(rig: Rig, plan: RunPlan, errors: tuple[float, ...] = ERRORS) -> Prediction:
    """Of one planned run. ManeuverError when the arm has no flexible link or the run no move with a hold."""
    if rig.link_mode is None:
        raise ManeuverError("the rig has no link_mode, so nothing vibrates", where=rig.name)
    period_s = 1.0 / rig.loop.rate_Hz
    cycles = [(*cycle.reference, *cycle.reference_rate) for cycle in predict(rig, plan)]
    names = list(rig.joints)
    table = np.array(cycles)
    position, rate = table[:, : len(names)], table[:, len(names) :]
    theta, length = names.index("rotary"), names.index("prismatic")
    after = round(AFTER_MOVE_S / period_s)
    holds, too_short = holds_to_judge(rig.link_mode, plan)
    still = after + 1  # the run may end before the last hold is judged
    motion = _Motion(rate[:, theta], position[:, length], rate[:, length], period_s, still)
    envelope = _envelope(rig.link_mode, motion, np.array(errors))
    residual = np.array([envelope[round(hold.end_s / period_s) + after] for hold in holds])
    late = np.array([lateness(position, hold.end_s, period_s, names) for hold in holds])
    return Prediction(tuple(hold.move for hold in holds), np.array(errors), residual, late, tuple(too_short))


def holds_to_judge(link: LinkMode, plan: RunPlan) -> tuple[list[JudgedHold], list[str]]:
    """As `judged_holds`. ManeuverError when there are none."""
    holds, too_short = judged_holds(plan, LinkFrequency(link))
    if not holds:
        where, advice = (
            str(plan.request.maneuver["name"]),
            f"A move must be followed by a hold of more than {AFTER_MOVE_S} s: --set hold=3s.",
        )
        raise ManeuverError("no move of the run can be judged", value=", ".join(too_short), where=where, next_step=advice)
    return holds, too_short


def lateness(position: Floats, planned_end_s: float, period_s: float, names: list[str]) -> float:
    """How long after the planned end of a move the joints (rows × joints) come to stay near where they are going; 0 when before.

    Where they are going is where they are one second after; a joint that is not there then has not arrived.
    """
    first = round(planned_end_s / period_s)
    last = min(first + round(AFTER_MOVE_S / period_s), len(position) - 1)
    if last <= first:
        return 0.0
    tolerance = np.array([ARRIVED_M if name == "prismatic" else ARRIVED_RAD for name in names])
    away = np.any(np.abs(position[first:last] - position[last]) > tolerance, axis=1)
    return float(np.flatnonzero(away)[-1] + 1) * period_s if away.any() else 0.0


class _Motion:
    """Rates of the joints, with a stretch of rest at the end."""

    def __init__(self, theta_d: Floats, length: Floats, length_d: Floats, period_s: float, still: int) -> None:
        self.theta_d = np.concatenate([theta_d, np.zeros(still)])
        self.theta_dd = np.gradient(self.theta_d, period_s)
        self.length = np.concatenate([length, np.full(still, length[-1])])
        self.length_d = np.concatenate([length_d, np.zeros(still)])
        self.period_s = period_s


def _envelope(link: LinkMode, motion: _Motion, errors: Floats) -> Floats:
    """Amplitude of the tip's vibration, m/s² (cycles × errors): ω √((ωw)² + ẇ²) with the joints at rest.

    Every period the oscillator turns exactly about its equilibrium under the period's mean input.
    """
    own = link.mass_per_length_kg_per_m * motion.length
    modal = link.payload_kg + LINK_MASS * own
    pushed = motion.length * (link.payload_kg + LINK_INERTIA * own) / modal * motion.theta_dd
    pushed = -(pushed + 2.0 * motion.length_d * motion.theta_d * (link.payload_kg + 0.375 * own) / modal)
    believed = LinkFrequency(link)
    omega = np.array([believed.omega_d(x) for x in motion.length])[:, None] * (1.0 + errors)
    damping, step = believed.damping_ratio, motion.period_s
    keep, c, s = np.exp(-damping * omega * step), np.cos(omega * step), np.sin(omega * step)
    still = pushed[:, None] / omega**2
    w, rate = np.zeros(len(errors)), np.zeros(len(errors))
    out = np.empty(omega.shape)
    for k in range(len(omega)):
        out[k] = omega[k] * np.hypot(omega[k] * w, rate)
        away = w - still[k]
        w, rate = still[k] + keep[k] * (c[k] * away + s[k] * rate / omega[k]), keep[k] * (c[k] * rate - s[k] * omega[k] * away)
    return out
