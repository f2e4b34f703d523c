"""Predicted against measured, for every shaped move of a log: vibration left, and how much later than planned the arm arrives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, nan

import numpy as np

from config.errors import LogError, LongreachError
from config.schema.rig import Rig
from recording.evaluation.spectrum import without_gaps
from recording.evaluation.vibration import HoldVibration, hold_vibration
from recording.files.reader import Log, open_rig
from servo_control.planning.planning import plan_run
from servo_control.planning.run_plan import RunPlan
from servo_control.planning.run_request import RunRequest
from servo_control.signals import Mode
from tuning.shaper_choice.coupled_prediction import can_be_coupled, predicted_coupled
from tuning.shaper_choice.shape_prediction import lateness, predicted

ERRORS = (-0.10, -0.05, 0.0, 0.05, 0.10)


@dataclass(frozen=True, slots=True)
class ShapedMove:
    """One move. Vibration (m/s²) 1.0 s after its planned end: measured by the tip accelerometer; predicted on the whole simulated rig
    (NaN: the rig file has no plant for it); on ideal joints with the believed frequency, and the worst within ±10 % of it. Lateness (s):
    of the measured joints, and of the planned references."""

    run: int
    shaper: str
    move: str
    measured_mps2: float
    coupled_mps2: float
    ideal_mps2: float
    ideal_worst_mps2: float
    measured_late_s: float
    predicted_late_s: float

    def text(self) -> str:
        coupled = f"{self.coupled_mps2:.3f} predicted on the whole rig, " if isfinite(self.coupled_mps2) else ""
        return (
            f"run {self.run}, {self.move}, {self.shaper}: vibration {self.measured_mps2:.3f} m/s² measured, {coupled}{self.ideal_mps2:.3f} "
            f"on ideal joints (up to {self.ideal_worst_mps2:.3f} within ±10 % of the frequency); {self.measured_late_s:.2f} s later than "
            f"planned measured, {self.predicted_late_s:.2f} s predicted"
        )


def shaped_moves(log: Log, runs: Sequence[int] | None = None) -> list[ShapedMove]:
    """Of every run with a command filter (or of `runs` alone). Empty where nothing was shaped or the tip was not measured."""
    try:
        rig, holds = open_rig(log), hold_vibration(log)
    except LogError:
        return []
    wanted = [number for number in dict.fromkeys(hold.run for hold in holds) if runs is None or number in runs]
    return [move for number in wanted for move in _of_run(log, rig, number, [hold for hold in holds if hold.run == number])]


def _of_run(log: Log, rig: Rig, number: int, holds: Sequence[HoldVibration]) -> list[ShapedMove]:
    request = RunRequest.from_json(log.attachments[f"run-{number}.json"])
    if request.shaper.get("kind", "none") == "none":
        return []
    try:
        plan = plan_run(rig, request)
        expected = predicted(rig, plan, ERRORS)
        coupled = np.full((len(expected.moves), 1), nan)
        if can_be_coupled(rig):
            coupled = predicted_coupled(rig, plan, (0.0,), _oil_C(log, number)).residual_mps2
    except LongreachError:  # the rig file of a what-if, or a run without a move that can be judged
        return []
    place = {move: n for n, move in enumerate(expected.moves)}
    nominal = ERRORS.index(0.0)
    return [
        ShapedMove(
            number, plan.shaper.kind, hold.move, hold.amplitude_mps2, float(coupled[place[hold.move], 0]),
            float(expected.residual_mps2[place[hold.move], nominal]), float(np.max(expected.residual_mps2[place[hold.move]])),
            _late(log, rig, plan, number, hold.move), float(expected.late_s[place[hold.move]]),
        )
        for hold in holds if hold.move in place
    ]  # fmt: skip


def _late(log: Log, rig: Rig, plan: RunPlan, number: int, move: str) -> float:
    rows = (log.columns["maneuver"] == number) & (log.columns["mode"] == Mode.RUNNING)
    names = list(rig.joints)
    position = np.column_stack([without_gaps(np.asarray(log.columns[f"{joint}.position"][rows], dtype=np.float64)) for joint in names])
    end_s = next(segment.end_s for segment in plan.segments if segment.name == move)
    return lateness(position, end_s, 1.0 / rig.loop.rate_Hz, names)


def _oil_C(log: Log, number: int) -> float | None:
    """Of the run, as the rotary valve's return port had it; None where it was not measured."""
    values = log.columns.get("rotary.return_temperature_C")
    measured = values[(log.columns["maneuver"] == number) & (log.columns["mode"] == Mode.RUNNING)] if values is not None else np.array([])
    return float(np.nanmean(measured)) if np.any(np.isfinite(measured)) else None
