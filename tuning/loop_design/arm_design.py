"""The design problem of a rig: its joint over gain, extension, payload and temperature, its link modes everywhere in the workspace."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from math import degrees, inf

import numpy as np

from config.errors import ManeuverError
from config.schema.end_point import EndPoint
from config.schema.rig import LinkMode, Rig
from servo_control.link.end_point import lead_shares, scheduled_gain
from servo_control.link.link_mode import LinkFrequency
from tuning.arrays import Complexes, Floats
from tuning.limit_cycles.describing_function import FrictionCompliance
from tuning.limit_cycles.exact_cycle import Cycle, ExactLoop
from tuning.linear.closed_loop import Servo, least_damping, sampled_loop
from tuning.linear.family import GAINS
from tuning.linear.linear_arm import LinearArm, linear_arm
from tuning.loop_design.amplitude_members import MeasuredPlant, amplitude_members
from tuning.loop_design.lag_lead_design import Demands, Design, DesignProblem, PlantResponse, search
from tuning.transfer import EQ4, lag_lead

POUND_KG, INCH_M = 0.45359237, 0.0254
# Extension (in) and payload (lb): the corners of the workspace and the places between where the link mode is damped least.
UNLOADED = ((12.0, 0.0), (36.0, 0.0), (60.0, 0.0))
LOADED = ((12.0, 45.0), (20.0, 45.0), (30.0, 45.0), (36.0, 45.0), (48.0, 45.0), (60.0, 45.0), (24.0, 75.0), (40.0, 75.0), (60.0, 75.0))
WORKSPACE = UNLOADED + LOADED
_SLACK_M = 1e-3
PAYLOADS_LB = (0.0, 15.0, 45.0, 75.0)
DAMPING_JOINT_ONLY, DAMPING_WITH_TIP = 0.002, 0.015
STIFF_HZ = 15.0  # a link above this does not disturb the joint loop, as long as it keeps
OWN_DAMPING_KEPT = 0.002  # of its 0.005
HUNTING_RATIOS = (1.0, 1.1, 1.2)
EFFORT = 25
LESS_LAG = 1.5


@dataclass(frozen=True, slots=True)
class OperatingPoint:
    """The arm somewhere in its workspace. `tip_share`, `tip_lead`: what the schedules leave of the tip gain there, and its lead, for the
    payload that the rig file believes in. `light`: a stiff link or an empty one, whose own damping must be kept but need not be raised.
    """

    arm: LinearArm
    tip_share: float
    light: bool
    tip_lead: tuple[float, float] = (1.0, 0.0)


@dataclass(frozen=True, slots=True)
class ArmDesign:
    """The lag-lead found and the best pure gain under the same demands; `chosen` is the stiffer one, `hunting` its cycles with friction."""

    problem: DesignProblem
    lag_lead: Design
    pure_gain: Design
    chosen: Design
    hunting: tuple[Cycle | None, ...]

    @property
    def pure_gain_wins(self) -> bool:
        return self.chosen is self.pure_gain


def arm_problem(rig: Rig, tip_gain: float, demands: Demands | None = None) -> DesignProblem:
    """Margins over gain ± 20 %, inertia and amplitude with the link rigid; damping of the sampled coupled loop over the whole workspace."""
    if rig.arm.kind != "rotary_prismatic" or rig.plant is None or rig.link_mode is None:
        advice = "Give a rig file with plant and link_mode."
        raise ManeuverError(
            "the design needs an arm with a flexible link and its plant", value=rig.arm.kind, where=rig.name, next_step=advice
        )
    low, high = rig.plant.joints["prismatic"].travel
    nearest, farthest = (pick(inches for inches, _ in WORKSPACE) * INCH_M for pick in (min, max))
    if low > nearest + _SLACK_M or high < farthest - _SLACK_M:
        advice, limit = "`longreach new-rig` chose the gain of an arm of another size.", f"at least {nearest:.3f} to {farthest:.3f}"
        text = f"{low:.3f} to {high:.3f}"
        raise ManeuverError("the design is made for the paper's workspace", value=text, limit=limit, unit="m", next_step=advice)
    plants = (*_rigid_plants(rig, [inches for inches, _ in UNLOADED]), *amplitude_members(rig, 1.5 / rig.loop.rate_Hz))
    roll_off_Hz = (rig.end_point or EndPoint()).roll_off_Hz
    least = DAMPING_WITH_TIP if tip_gain > 0.0 else DAMPING_JOINT_ONLY
    return DesignProblem(plants, demands or Demands(), tip_gain, roll_off_Hz, _damping(rig, rig.link_mode, WORKSPACE), least)


def problem_at(problem: DesignProblem, rig: Rig, inches: float) -> DesignProblem:
    """The same problem at one extension (in): its inertia and its link modes, every amplitude."""
    assert rig.link_mode is not None
    measured: list[PlantResponse] = [plant for plant in problem.plants if isinstance(plant, MeasuredPlant)]
    plants = (*_rigid_plants(rig, [inches]), *measured)
    return replace(problem, plants=plants, damping=_damping(rig, rig.link_mode, [(inches, pounds) for pounds in PAYLOADS_LB]))


def _rigid_plants(rig: Rig, extensions_in: Sequence[float]) -> list[PlantResponse]:
    """The empty arm with a link that does not bend, over the family's gains."""
    arms = [linear_arm(rig, inches * INCH_M, 0.0, rigid=True) for inches in extensions_in]
    return [partial(_position, arm, gain, 1.5 / rig.loop.rate_Hz) for arm, gain in product(arms, GAINS)]


def _damping(rig: Rig, link: LinkMode, workspace: Sequence[tuple[float, float]]) -> Callable[[Servo], float]:
    return partial(worst_damping, places(rig, link, workspace), 1.0 / rig.loop.rate_Hz)


def places(rig: Rig, link: LinkMode, workspace: Sequence[tuple[float, float]]) -> list[OperatingPoint]:
    """The arm at every extension (in) and payload (lb)."""
    return [_place(rig, link, inches * INCH_M, pounds * POUND_KG) for inches, pounds in workspace]


def _place(rig: Rig, link: LinkMode, extension_m: float, payload_kg: float) -> OperatingPoint:
    frequency = LinkFrequency(link.model_copy(update={"payload_kg": payload_kg, "frequency_map": ()})).frequency_Hz(extension_m)
    settings = (rig.end_point or EndPoint()).model_copy(update={"gain": 1.0})
    believed_Hz = LinkFrequency(link).frequency_Hz(extension_m)
    share, lead = scheduled_gain(settings, believed_Hz), lead_shares(settings, believed_Hz)
    return OperatingPoint(linear_arm(rig, extension_m, payload_kg), share, frequency > STIFF_HZ or payload_kg == 0.0, lead)


def _position(arm: LinearArm, gain: float, delay_s: float, omega: Floats) -> Complexes:
    return np.asarray(gain * arm.response(omega, arm.position) * np.exp(-1j * omega * delay_s))


def worst_damping(places: Sequence[OperatingPoint], period_s: float, servo: Servo) -> float:
    """Smallest damping ratio of any mode at any place and any gain of the family; light places only count when they lose their own
    damping: infinite when none is left."""
    found = []
    for place, gain in product(places, GAINS):
        scheduled = replace(servo, gain=servo.gain * gain, tip_gain=servo.tip_gain * place.tip_share, tip_lead=place.tip_lead)
        damping = least_damping(sampled_loop(place.arm, scheduled, period_s), period_s)
        if not (place.light and damping > OWN_DAMPING_KEPT):
            found.append(damping)
    return min(found, default=inf)


def design(rig: Rig, tip_gain: float, demands: Demands | None = None, effort: int = EFFORT, largest_cycle: float = inf) -> ArmDesign:
    """Search lag-lead and pure gain; gains are in V/rad. `largest_cycle`: load amplitude of hunting that is allowed, in H_c.

    Lag makes the loop hunt, so while the cycle is too large the search goes on with less of it.
    """
    problem = arm_problem(rig, tip_gain, demands)
    pure = search(problem, with_sections=False, effort=effort)
    found = search(problem, effort=effort)
    while _cycle_size(found.servo) > largest_cycle and problem.demands.lag_ratio > 1.01:
        problem = replace(problem, demands=replace(problem.demands, lag_ratio=max(1.0, problem.demands.lag_ratio / LESS_LAG)))
        found = search(problem, effort=effort)
    allowed = _cycle_size(found.servo) <= largest_cycle
    chosen = found if allowed and found.stiffness_gain_dB > pure.stiffness_gain_dB else pure
    return ArmDesign(problem, found, pure, chosen, hunting(chosen.servo))


def _cycle_size(servo: Servo) -> float:
    """Largest load amplitude of any hunting, in H_c; 0 when it always comes to rest."""
    return max((cycle.load_amplitude for cycle in hunting(servo) if cycle is not None), default=0.0)


def hunting(servo: Servo) -> tuple[Cycle | None, ...]:
    """Exact cycles with the friction-compliance element and Eq 4, one for each H_s/H_c; amplitudes in H_c. None: comes to rest."""
    loop = lag_lead(servo.gain / degrees(1.0), servo.sections) * EQ4
    return tuple(ExactLoop(loop, FrictionCompliance.of_ratio(ratio)).march(1.0) for ratio in HUNTING_RATIOS)


def as_overrides(servo: Servo, schedule: Sequence[tuple[float, float]] = ()) -> list[str]:
    """What `config.loading.overrides.apply_overrides` needs to put the servo into a rig file; `schedule`: (extension in inches, factor)."""
    sections = ", ".join(f"{{zero: {zero:.6g} rad/s, pole: {pole:.6g} rad/s}}" for zero, pole in servo.sections)
    points = ", ".join(f"{{extension: {inches:g} in, factor: {factor:.4g}}}" for inches, factor in schedule)
    return [
        f"servo.rotary.gain={servo.gain / degrees(1.0):.6g} V/deg",
        f"servo.rotary.sections=[{sections}]",
        f"servo.rotary.gain_schedule=[{points}]",
    ]
