"""What a planned run leaves of the link's vibration on the whole simulated rig, over a range of errors of the believed frequency.

Controller, sensors, hydraulics, friction and end-point feedback as in the running daemon; the link is what the controller believes of
it, with its stiffness changed by the square of the frequency error. Ideal joints (`shape_prediction`) say what a filter can do;
this says what is left when the joint sticks, yields and is moved by the feedback.
"""

from __future__ import annotations

import numpy as np

from config.schema.rig import LinkMode, Rig
from recording.evaluation.vibration import AFTER_MOVE_S
from servo_control.link.link_mode import LinkFrequency
from servo_control.planning.run_plan import RunPlan
from sim_backend.effects.link_flexibility import LinkFlexibility
from tuning.experiments.judged_holds import judged_holds
from tuning.experiments.line_run import coupled_run
from tuning.shaper_choice.shape_prediction import Prediction, holds_to_judge, lateness
from tuning.variants import plant_of, with_link

ERRORS = (-0.10, 0.0, 0.10)


def can_be_coupled(rig: Rig) -> bool:
    """Whether the rig file's plant has what the simulation of a run needs: both joints and a flexible link."""
    plant = rig.plant
    if plant is None or plant.link is None or tuple(rig.joints) != ("rotary", "prismatic"):
        return False
    return rig.link_mode is not None and any(isinstance(effect, LinkFlexibility) for effect in plant.effects)


def predicted_coupled(rig: Rig, plan: RunPlan, errors: tuple[float, ...] = ERRORS, temperature_C: float | None = None) -> Prediction:
    """Of one planned run; `late_s` are the true joints' at the error nearest to 0. `temperature_C` of the oil; None: the rig file's.

    ManeuverError when no move of the run can be judged; PlantError when the rig has no plant.
    """
    assert rig.link_mode is not None
    holds, too_short = holds_to_judge(rig.link_mode, plan)
    resting_s = max(0.0, holds[-1].end_s + 2.0 * AFTER_MOVE_S - plan.program.duration_s)
    runs = [coupled_run(as_believed(rig, plan, error), plan, temperature_C=temperature_C, resting_s=resting_s) for error in errors]
    nominal = runs[int(np.argmin(np.abs(errors)))]
    late = np.array([lateness(nominal.position, hold.end_s, nominal.period_s, list(rig.joints)) for hold in holds])
    residual = np.array([[run.amplitude(hold) for run in runs] for hold in holds])
    return Prediction(tuple(hold.move for hold in holds), np.array(errors), residual, late, tuple(too_short))


def as_believed(rig: Rig, plan: RunPlan, error: float) -> Rig:
    """The rig whose true link is the believed one, but for `error` of its frequency. An identified map counts by its ratio to the
    formula where the moves end."""
    assert rig.link_mode is not None
    link = rig.link_mode
    stiffness = link.bending_stiffness_N_m2 * (_mapped(link, plan) * (1.0 + error)) ** 2
    changed = with_link(rig, payload_kg=link.payload_kg, mass_per_length_kg_per_m=link.mass_per_length_kg_per_m)
    plant = plant_of(changed)
    effects = tuple(
        effect.model_copy(update={"bending_stiffness_N_m2": stiffness, "damping_ratio": link.damping_ratio})
        if isinstance(effect, LinkFlexibility)
        else effect
        for effect in plant.effects
    )
    return changed.model_copy(update={"plant": plant.model_copy(update={"effects": effects})})


def _mapped(link: LinkMode, plan: RunPlan) -> float:
    """Believed frequency over that of the formula, mean over the ends of the moves."""
    believed, formula = LinkFrequency(link), LinkFrequency(link.model_copy(update={"frequency_map": ()}))
    return float(np.mean([hold.frequency_Hz / formula.frequency_Hz(hold.extension_m) for hold in judged_holds(plan, believed)[0]]))
