"""The steps that make the arm move well: design, the first shaped move, what the model lacks."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from pathlib import Path

from config.errors import ManeuverError
from config.loading.load import rig_from_text
from config.loading.overrides import apply_overrides
from config.whole_file import write_whole
from daemon.cli.commission.bench import Ran
from daemon.cli.commission.context import Context
from daemon.cli.commission.identified import measured_joint
from daemon.cli.commission.record import Outcome, Value
from daemon.cli.commission.usual_moves import Request, two_runs
from daemon.reports.run_report import write_reports
from recording.evaluation.vibration import hold_vibration, rms_mps2
from recording.files.reader import read_log
from tuning.loop_design.arm_design import as_overrides, design, designed_name, shown_gain

SHAPED_MOVE = "first shaped move"


def servo_design(context: Context) -> Outcome:
    """The stiffest compensator of the rotary joint, or of a hydraulic axis, that the model bears everywhere, beside the rig file's."""
    own = context.rig.end_point.gain if context.rig.end_point is not None else 0.0
    try:
        measured = measured_joint(context)
        found = design(context.rig, own, effort=context.effort, measured=measured)
    except ManeuverError as refusal:  # an electric drive, or no plant
        return Outcome(None, str(refusal))
    overrides = as_overrides(context.rig, found.chosen.servo)
    out = context.folder / f"{context.rig.name}-designed.yaml"
    text = apply_overrides(context.loaded.text, overrides)
    rig_from_text(text, str(out))
    write_whole(out, text)
    worst, damping, demands = found.chosen.worst, found.chosen.least_damping, found.problem.demands
    values = [
        Value("gain found", shown_gain(context.rig, found.chosen.servo.gain)),
        Value("gain of the rig file", shown_gain(context.rig, context.rig.servo[designed_name(context.rig)].gain)),
        Value("least damping", "unknown" if damping is None else f"{damping:.4f}", "> 0", damping is not None and damping > 0.0),
        Value("worst gain margin", f"{worst.gain_margin_dB:.1f} dB"),
        Value("worst phase margin", f"{worst.phase_margin_deg:.1f} deg"),
        Value("worst sensitivity peak", f"{worst.sensitivity_peak:.2f}"),
    ]
    values += [Value("responses measured before that it keeps these margins on", str(len(measured)))] if measured else []
    values += [Value("demand", f"{key} {value:g}") for key, value in dataclasses.asdict(demands).items() if isinstance(value, float)]
    text = f"--set {' --set '.join(map(repr, overrides))}; the whole file is {out.name}"
    return Outcome(all(value.ok for value in values), text, values, files=[str(out)])


def first_shaped_move(context: Context) -> Outcome:
    """The maneuver unshaped and shaped; both must be valid and the shaped one leave less vibration. The second run gets its report."""
    requests = two_runs(context.rig, context.maneuver, context.shaper)
    context.allow(f"The arm runs {_named(requests)} after a slow approach")
    runs: dict[str, Ran] = {}
    for name, request in requests.items():
        context.say(name)
        runs[name] = context.run(request)
    logs = [str(ran.log) for ran in runs.values()]
    values = [Value(name, "valid" if ran.valid else f"not valid: {ran.reason}", "valid", ran.valid) for name, ran in runs.items()]
    if not all(value.ok for value in values):
        return Outcome(False, "a run is not valid", values, logs)
    if context.rig.link_mode is not None:
        left = {name: rms_mps2([hold for hold in hold_vibration(read_log(ran.log)) if hold.run == ran.run]) for name, ran in runs.items()}
        unshaped, shaped = left["unshaped"], left[context.shaper]
        values.append(Value("vibration left, unshaped", f"{unshaped:.3f} m/s²"))
        values.append(Value(f"vibration left, {context.shaper}", f"{shaped:.3f} m/s²", f"< {unshaped:.3f} m/s²", shaped < unshaped))
    *_, second = runs.values()
    pages = write_reports(second.log, [second.run], say=context.say)
    return Outcome(all(value.ok for value in values), _named(requests), values, logs, [str(page) for page in pages])


def gap(context: Context) -> Outcome:
    """What the model lacks, from the two runs before: the unshaped one is fitted, the shaped one decides."""
    from gap.find import find
    from gap.settings import Settings

    moved = context.records.get(SHAPED_MOVE)
    logs = [Path(log) for log in moved.outcome.logs] if moved is not None else []
    if not logs or not all(log.exists() for log in logs):
        return Outcome(False, f"the logs of the step before are not there: --again '{SHAPED_MOVE}'")
    unshaped, shaped = logs
    out = context.folder / "gap"
    found = find(context.loaded.path, [unshaped], [shaped], out, context.say, Settings(propose=False))
    values = [Value("verdict", found.verdict.word, "not data_problem", found.verdict.word != "data_problem")]
    values += [
        Value(item["effect"], f"at {item['where']}, {'confirmed' if item['confirmed'] else 'tentative'}")
        for item in found.content["findings"]
    ]
    return Outcome(all(value.ok for value in values), found.verdict.why, values, files=[str(out / "report.html"), str(out / "rig.yaml")])


def _named(requests: Mapping[str, Request]) -> str:
    """'paper_line, unshaped and adaptive'"""
    (maneuver,) = {str(request["maneuver"]["name"]) for request in requests.values()}
    return f"{maneuver}, {' and '.join(requests)}"
