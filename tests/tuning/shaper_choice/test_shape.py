"""What a command filter is predicted to leave, against another integrator with two shapes; recommendation; predicted beside measured."""

from __future__ import annotations

from math import pi
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from config.errors import ManeuverError
from config.loading.load import load_maneuver, load_rig
from config.schema.maneuver import maneuver_content
from config.schema.rig import Rig
from daemon.lockstep import run_lockstep
from recording.evaluation.vibration import hold_vibration
from recording.files.reader import read_log
from servo_control.link.link_mode import LinkFrequency
from servo_control.planning.planning import plan_run
from servo_control.planning.run_plan import RunPlan
from servo_control.planning.run_request import RunRequest
from tuning.experiments.line_run import coupled_run, ideal_run, plan_line
from tuning.shaper_choice.coupled_prediction import can_be_coupled, predicted_coupled
from tuning.shaper_choice.shape_prediction import lateness, predicted
from tuning.shaper_choice.shape_recommendation import Residual, ShaperCandidate, _choose, recommend
from tuning.shaper_choice.shaped_moves import shaped_moves
from tuning.variants import without_effect


def _line(name: str = "paper_line_y30") -> dict[str, Any]:
    return maneuver_content(load_maneuver(name).maneuver)


def test_unshaped_as_published_and_as_the_two_shape_model(rig: Rig) -> None:
    """4.09 / 3.00 / 9.35 m/s² at y0 = 30 in."""
    plan = plan_line(rig, "paper_line_y30")
    found = predicted(rig, plan, (0.0,))
    assert found.moves == ("move 1", "move 2", "move 3")
    assert found.residual_mps2[:, 0] == pytest.approx([4.09, 3.00, 9.35], rel=0.05)
    assert found.residual_mps2[:, 0] == pytest.approx(ideal_run(rig, plan).hold_amplitudes, rel=0.02)
    assert found.late_s == pytest.approx([0.0, 0.0, 0.0], abs=0.005)


@pytest.mark.parametrize("kind", ["zvd", *(pytest.param(kind, marks=pytest.mark.slow) for kind in ("two_hump_ei", "robust_notch"))])
def test_shaped_as_the_two_shape_model(rig: Rig, kind: str) -> None:
    plan = plan_line(rig, "paper_line_y30", {"kind": kind})
    found = predicted(rig, plan, (0.0,))
    assert found.residual_mps2[:, 0] == pytest.approx(ideal_run(rig, plan).hold_amplitudes, rel=0.06, abs=0.01)


def _with_stiffness(rig: Rig, factor: float) -> Rig:
    assert rig.plant is not None
    effects = tuple(
        entry.model_copy(update={"bending_stiffness_N_m2": factor * entry.bending_stiffness_N_m2})  # type: ignore[attr-defined]
        if entry.effect == "link_flexibility"
        else entry
        for entry in rig.plant.effects
    )
    return rig.model_copy(update={"plant": rig.plant.model_copy(update={"effects": effects})})


@pytest.mark.parametrize("error", [-0.1, pytest.param(0.1, marks=pytest.mark.slow)])
def test_a_frequency_error_is_another_stiffness_of_the_link(rig: Rig, error: float) -> None:
    """The true link rings at (1 + error) of what the shaper believes: here because it is stiffer or softer."""
    plan = plan_line(rig, "paper_line_y30", {"kind": "adaptive"})
    found = predicted(rig, plan, (error,)).residual_mps2[:, 0]
    other = ideal_run(_with_stiffness(rig, (1.0 + error) ** 2), plan).hold_amplitudes
    assert 20 * np.log10(np.sqrt(np.mean(found**2) / np.mean(other**2))) == pytest.approx(0.0, abs=0.5)


def test_adaptive_in_phase_leaves_less_than_a_hundredth_and_comes_one_period_later(rig: Rig) -> None:
    assert rig.link_mode is not None
    bare, shaped = (predicted(rig, plan_line(rig, "paper_line_y30", {"kind": kind})) for kind in ("none", "adaptive"))
    assert shaped.nominal_mps2 < 0.01 * bare.nominal_mps2
    assert shaped.worst_mps2 < 10 ** (-28 / 20) * bare.worst_mps2
    period = 2 * pi / LinkFrequency(rig.link_mode).omega_d(42.4 * 0.0254)
    assert shaped.late_s[0] == pytest.approx(0.8 * period, rel=0.15)  # its last part moves less than a millimetre


def test_lateness_of_a_ramp() -> None:
    """0.1 rad/s until 0.25 s after the planned end: within 1 mrad 0.24 s after it."""
    t = 0.001 * np.arange(3000)
    position = np.column_stack([np.minimum(0.1 * t, 0.125), np.full(3000, 1.0)])
    assert lateness(position, 1.0, 0.001, ["rotary", "prismatic"]) == pytest.approx(0.24, abs=0.002)
    assert lateness(position, 1.5, 0.001, ["rotary", "prismatic"]) == 0.0


def _held(rig: Rig, kind: str, hold_s: float) -> RunPlan:
    return plan_run(rig, RunRequest(1, {**_line("paper_line_y30"), "hold": hold_s}, {"kind": kind}))


@pytest.mark.parametrize("kind", ["zvd", "none"])
def test_the_next_move_does_not_show_in_a_short_hold(rig: Rig, kind: str) -> None:
    """What the first move leaves is the same with a short hold: the next move, which begins inside the window, does not show. A hold of
    1.0 s holds half the window: it is left out and named. The last one goes on for good."""
    first = [ideal_run(rig, _held(rig, kind, hold_s)).hold_amplitudes[0] for hold_s in (3.0, 1.4, 1.25, 1.1)]
    assert first == pytest.approx([first[0]] * 4, rel=1e-3)
    found = predicted(rig, _held(rig, kind, 1.0), (0.0,))
    assert (found.moves, found.too_short) == (("move 3",), ("move 1", "move 2"))
    assert len(ideal_run(rig, _held(rig, kind, 1.0)).hold_amplitudes) == 1


def _candidate(kind: str, worst: float, late: float, refused: str = "") -> ShaperCandidate:
    residual = None if refused else Residual(worst / 2, worst, late, (0.0,), (worst,))
    return ShaperCandidate(kind, residual, refused=refused)


def test_the_whole_rig_judges_where_it_was_simulated() -> None:
    """Ideal joints promise 0.01 m/s²; friction and feedback leave 0.2: the slower filter that really is good enough is recommended."""
    ideal = Residual(0.005, 0.01, 0.0, (0.0,), (0.01,))
    candidates = [
        ShaperCandidate("none", Residual(3.0, 3.0, 0.0, (0.0,), (3.0,)), Residual(0.5, 0.5, 0.0, (0.0,), (0.5,))),
        ShaperCandidate("zv", ideal, Residual(0.2, 0.2, 0.1, (0.0,), (0.2,))),
        ShaperCandidate("adaptive", ideal, Residual(0.04, 0.08, 0.4, (0.0,), (0.08,))),
    ]
    assert _choose(candidates, 0.1)[0] == "adaptive"


@pytest.mark.slow
def test_the_coupled_prediction_is_the_run_on_the_rig(rig: Rig) -> None:
    """The testbed believes what its plant has, so without error the prediction is what a run leaves; a softer link with the same shaper is
    the plant with that stiffness; and ideal joints say nothing of what friction leaves."""
    plan = plan_line(rig, "paper_line_y30", {"kind": "adaptive", "joints": ["rotary", "prismatic"]})
    found = predicted_coupled(rig, plan, (-0.1, 0.0))
    assert found.residual_mps2[:, 1] == pytest.approx(coupled_run(rig, plan).hold_amplitudes, rel=1e-6)
    assert found.residual_mps2[:, 0] == pytest.approx(coupled_run(_with_stiffness(rig, 0.81), plan).hold_amplitudes, rel=1e-6)
    assert found.moves == ("move 1", "move 2", "move 3")
    assert np.all(found.late_s < 0.6)


def test_without_plant_there_is_nothing_to_couple(rig: Rig) -> None:
    assert can_be_coupled(rig)
    assert not can_be_coupled(rig.model_copy(update={"plant": None}))
    assert not can_be_coupled(without_effect(rig, "link_flexibility"))


def test_the_quickest_that_is_good_enough_and_else_the_best() -> None:
    candidates = [_candidate("none", 3.0, 0.0), _candidate("zv", 0.09, 0.1), _candidate("zvd", 0.01, 0.3), _candidate("ei", 0.0, 0.0, "no")]
    assert _choose(candidates, 0.1)[0] == "zv"
    assert _choose(candidates, 0.05)[0] == "zvd"
    chosen, why = _choose(candidates, 0.001)
    assert (chosen, "no filter stays below 0.001 m/s²" in why) == ("zvd", True)


def test_a_generous_limit_needs_no_filter_and_a_rig_without_link_is_refused(rig: Rig) -> None:
    found = recommend(rig, [_line("jog")], {}, 5.0, (-0.1, 0.0, 0.1), coupled=False)
    assert found.chosen == found.best.kind == "none"
    assert found.best.tip is not None
    assert found.best.tip.speed_mps > 0.0
    assert {candidate.kind for candidate in found.candidates} >= {"zv", "zvd", "ei", "two_hump_ei", "notch", "adaptive"}
    with pytest.raises(ManeuverError, match="nothing vibrates"):
        predicted(rig.model_copy(update={"link_mode": None}), plan_line(rig, "paper_line_y30"))


@pytest.mark.slow
def test_predicted_beside_measured_for_a_run_of_the_whole_rig(tmp_path: Path) -> None:
    request = {"maneuver": {"name": "paper_line"}, "shaper": {"kind": "two_hump_ei"}, "approach": True}
    (path,) = run_lockstep(load_rig("ornl_testbed"), [request], tmp_path)
    log = read_log(path)
    moves = shaped_moves(log)
    assert [move.move for move in moves] == ["move 1", "move 2", "move 3"]
    assert [move.measured_mps2 for move in moves] == [hold.amplitude_mps2 for hold in hold_vibration(log)]
    for move in moves:
        assert 0.0 < move.ideal_mps2 <= move.ideal_worst_mps2 < 1.0
        assert move.coupled_mps2 == pytest.approx(move.measured_mps2, rel=0.25, abs=0.01)
        assert move.measured_late_s == pytest.approx(move.predicted_late_s, abs=0.25)
        assert f"{move.measured_mps2:.3f} m/s² measured" in move.text()
    assert shaped_moves(log, [7]) == []
