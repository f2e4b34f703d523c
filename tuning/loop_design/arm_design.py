"""The design problem of a rig: its joint over gain, extension, payload and temperature, its link modes everywhere in its workspace."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from math import degrees, inf

from config.errors import ManeuverError
from config.schema.end_point import EndPoint
from config.schema.rig import LinkMode, Rig
from servo_control.link.end_point import lead_shares, scheduled_gain
from servo_control.link.link_mode import LinkFrequency
from tuning.limit_cycles.describing_function import FrictionCompliance
from tuning.limit_cycles.exact_cycle import Cycle, ExactLoop
from tuning.linear.closed_loop import Servo, least_damping, sampled_loop
from tuning.linear.family import GAINS
from tuning.linear.linear_arm import LinearArm, linear_arm
from tuning.loop_design.amplitude_members import amplitude_members
from tuning.loop_design.axis_design import axis_joint, axis_problem, position_response
from tuning.loop_design.lag_lead_design import Demands, Design, DesignProblem, PlantResponse, at_pace, search
from tuning.loop_design.measured_plant import MeasuredPlant
from tuning.loop_design.rotary_joint import DesignedJoint, designed_joint
from tuning.loop_design.workspace import OVERLOAD, UNLOADED, Place, extension_m, places_in
from tuning.transfer import lag_lead
from tuning.variants import ROTARY

PAYLOAD_SHARES = (0.0, 1 / 3, 1.0, OVERLOAD)  # of the believed payload, at one extension
DAMPING_WITH_TIP = 0.015
STIFF_HZ = 15.0  # a link above this does not disturb the paper's joint loop, as long as it keeps
DAMPING_KEPT = 0.4  # of its own damping ratio
DELAY_CYCLES = 1.5  # half a hold and one sample
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
    """The lag-lead found and the best pure gain under the same demands; `chosen` is the stiffer one, `hunting` its cycles with
    friction."""

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
    joint = _joint(rig)
    plants = (*_rigid_plants(rig, [place[0] for place in places_in(rig, UNLOADED)]), *_amplitudes(rig, joint.pace))
    roll_off_Hz = (rig.end_point or EndPoint()).roll_off_Hz
    least = DAMPING_WITH_TIP if tip_gain > 0.0 else kept_damping(rig.link_mode)
    damping = _damping(rig, rig.link_mode, places_in(rig), joint.pace)
    return DesignProblem(plants, demands or at_pace(joint.pace), tip_gain, roll_off_Hz, damping, least, joint.pace)


def _joint(rig: Rig) -> DesignedJoint:
    return designed_joint(rig, linear_arm(rig, extension_m(rig, 0.5), 0.0, rigid=True))


def _amplitudes(rig: Rig, pace: float) -> tuple[PlantResponse, ...]:
    return amplitude_members(rig, DELAY_CYCLES / rig.loop.rate_Hz, extension_m(rig, 0.5), pace)


def kept_damping(link: LinkMode) -> float:
    """Damping ratio of a link that no servo may go below."""
    return DAMPING_KEPT * link.damping_ratio


def problem_at(problem: DesignProblem, rig: Rig, extension: float) -> DesignProblem:
    """The same problem at one extension (m): its inertia and its link modes, every amplitude."""
    assert rig.link_mode is not None
    measured: list[PlantResponse] = [plant for plant in problem.plants if isinstance(plant, MeasuredPlant)]
    plants = (*_rigid_plants(rig, [extension]), *measured)
    here = list(dict.fromkeys((extension, share * rig.link_mode.payload_kg) for share in PAYLOAD_SHARES))
    return replace(problem, plants=plants, damping=_damping(rig, rig.link_mode, here, problem.pace))


def _rigid_plants(rig: Rig, extensions_m: Sequence[float]) -> list[PlantResponse]:
    """The empty arm with a link that does not bend, over the family's gains."""
    arms = [linear_arm(rig, extension, 0.0, rigid=True) for extension in extensions_m]
    return [partial(position_response, arm, gain, DELAY_CYCLES / rig.loop.rate_Hz) for arm, gain in product(arms, GAINS)]


def _damping(rig: Rig, link: LinkMode, where: Sequence[Place], pace: float) -> Callable[[Servo], float]:
    return partial(worst_damping, operating_points(rig, link, where, pace), 1.0 / rig.loop.rate_Hz, kept_damping(link))


def operating_points(rig: Rig, link: LinkMode, where: Sequence[Place], pace: float) -> list[OperatingPoint]:
    """The arm at every place; a link is stiff beside a joint of this pace or not."""
    return [_operating_point(rig, link, extension, payload_kg, pace) for extension, payload_kg in where]


def _operating_point(rig: Rig, link: LinkMode, extension: float, payload_kg: float, pace: float) -> OperatingPoint:
    frequency = LinkFrequency(link.model_copy(update={"payload_kg": payload_kg, "frequency_map": ()})).frequency_Hz(extension)
    settings = (rig.end_point or EndPoint()).model_copy(update={"gain": 1.0})
    believed_Hz = LinkFrequency(link).frequency_Hz(extension)
    share, lead = scheduled_gain(settings, believed_Hz), lead_shares(settings, believed_Hz)
    light = frequency > STIFF_HZ * pace or payload_kg == 0.0
    return OperatingPoint(linear_arm(rig, extension, payload_kg), share, light, lead)


def worst_damping(places: Sequence[OperatingPoint], period_s: float, kept: float, servo: Servo) -> float:
    """Smallest damping ratio of any mode at any place and any gain of the family; light places only count when less than `kept`
    is left of their own damping; infinite when none counts."""
    found = []
    for place, gain in product(places, GAINS):
        scheduled = replace(servo, gain=servo.gain * gain, tip_gain=servo.tip_gain * place.tip_share, tip_lead=place.tip_lead)
        damping = least_damping(sampled_loop(place.arm, scheduled, period_s), period_s)
        if not (place.light and damping > kept):
            found.append(damping)
    return min(found, default=inf)


def design(
    rig: Rig,
    tip_gain: float,
    demands: Demands | None = None,
    effort: int = EFFORT,
    largest_cycle: float = inf,
    measured: Sequence[MeasuredPlant] = (),
) -> ArmDesign:
    """Search lag-lead and pure gain for the arm's rotary joint or a single axis; gains are in V/rad (or V/m).

    `measured`: responses of that joint on the rig, on which the margins are kept too. `largest_cycle`: load amplitude of the hunting that
    is allowed, in H_c. Lag makes the loop hunt, so while the cycle is too large the search goes on with less of it.
    """
    single = rig.arm.kind == "single_axis"
    problem = with_measured(axis_problem(rig, demands) if single else arm_problem(rig, tip_gain, demands), measured)
    joint = axis_joint(rig) if single else _joint(rig)
    pure = search(problem, with_sections=False, effort=effort)
    found = search(problem, effort=effort)
    while _hunts_more(joint, found.servo, largest_cycle) and problem.demands.lag_ratio > 1.01:
        problem = replace(problem, demands=replace(problem.demands, lag_ratio=max(1.0, problem.demands.lag_ratio / LESS_LAG)))
        found = search(problem, effort=effort)
    allowed = not _hunts_more(joint, found.servo, largest_cycle)
    chosen = found if allowed and found.stiffness_gain_dB > pure.stiffness_gain_dB else pure
    return ArmDesign(problem, found, pure, chosen, hunting(joint, chosen.servo))


def with_measured(problem: DesignProblem, measured: Sequence[MeasuredPlant]) -> DesignProblem:
    """The problem whose family has these members too."""
    return replace(problem, plants=(*problem.plants, *measured))


def _hunts_more(joint: DesignedJoint, servo: Servo, largest_cycle: float) -> bool:
    """Whether any cycle's load amplitude is above this, in H_c. The cycles of a joint unlike the paper's take seconds to find."""
    if largest_cycle == inf:
        return False
    return any(cycle is not None and cycle.load_amplitude > largest_cycle for cycle in hunting(joint, servo))


def hunting(joint: DesignedJoint, servo: Servo) -> tuple[Cycle | None, ...]:
    """Exact cycles with the friction-compliance element, one for each H_s/H_c; amplitudes in H_c. None: comes to rest."""
    loop = lag_lead(servo.gain, servo.sections) * joint.system
    return tuple(ExactLoop(loop, FrictionCompliance.of_ratio(ratio)).march(1.0) for ratio in HUNTING_RATIOS)


def designed_name(rig: Rig) -> str:
    """The joint that a design is made for."""
    return ROTARY if rig.arm.kind == "rotary_prismatic" else next(iter(rig.joints))


def shown_gain(rig: Rig, gain: float) -> str:
    """A servo gain of that joint, as rig files state it: V/deg or V/m."""
    linear = rig.joints[designed_name(rig)].motion == "linear"
    return f"{gain:.6g} V/m" if linear else f"{gain / degrees(1.0):.6g} V/deg"


def as_overrides(rig: Rig, servo: Servo, schedule: Sequence[tuple[float, float]] = ()) -> list[str]:
    """What `config.loading.overrides.apply_overrides` needs to put the servo into a rig file; `schedule`: (extension in m, factor)."""
    joint = designed_name(rig)
    sections = ", ".join(f"{{zero: {zero:.6g} rad/s, pole: {pole:.6g} rad/s}}" for zero, pole in servo.sections)
    points = ", ".join(f"{{extension: {extension:.5g} m, factor: {factor:.4g}}}" for extension, factor in schedule)
    lines = [f"servo.{joint}.gain={shown_gain(rig, servo.gain)}", f"servo.{joint}.sections=[{sections}]"]
    return lines if rig.arm.kind == "single_axis" else [*lines, f"servo.{joint}.gain_schedule=[{points}]"]
