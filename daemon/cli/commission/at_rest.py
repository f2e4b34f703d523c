"""The steps before anything moves: the rig file, every way to stop, the sensors, the proof of the safe state."""

from __future__ import annotations

import datetime

import numpy as np

from config.checking.check import check_rig
from config.errors import DaemonError
from daemon.cli.commission.context import Context
from daemon.cli.commission.record import Outcome, Value
from recording.format.fields import field_of_signal
from recording.format.layout import CycleLayout

MOST_NOISE = 0.01  # of the sensor's range, standard deviation
AT_START = 0.005  # of the range: the simulated arm stands where its plant says


def rig_file(context: Context) -> Outcome:
    """No error in the rig file; warnings are told."""
    findings = check_rig(context.loaded, datetime.date.today())
    bad = [finding for finding in findings if finding.level != "ok"]
    errors = [finding for finding in bad if finding.level == "error"]
    values = [Value(finding.level, finding.text, "", finding.level != "error") for finding in bad]
    return Outcome(not errors, f"{len(findings)} findings, {len(errors)} errors, {len(bad) - len(errors)} warnings", values)


def stops(context: Context) -> Outcome:
    """Every way to stop, tried while nothing moves: the e-stop latches, arming is refused until it is reset, disarm makes safe."""
    bench = context.bench
    values = [_mode("e-stop", bench.act("estop"), "fault")]
    try:
        refused = f"not refused: {bench.act('arm')}"
    except DaemonError:
        refused = "refused"
    values += [
        Value("arming while the e-stop is latched", refused, "refused", refused == "refused"),
        _mode("reset", bench.act("reset"), "disarmed"),
        _mode("disarm", bench.act("disarm"), "disarmed"),
    ]
    return Outcome(all(value.ok for value in values), "e-stop, reset and disarm, at rest", values)


def sensors(context: Context) -> Outcome:
    """Every signal at rest: within its range, quiet, and what the operator sees at the arm."""
    units = {entry.name: entry.unit for entry in CycleLayout.of_rig(context.rig).fields}
    values: list[Value] = []
    for name, samples in context.bench.readings().items():
        signal, unit = context.rig.signals[name], units[field_of_signal(name)]
        good = samples[np.isfinite(samples)]
        if not len(good):
            values.append(Value(name, "no value", "a value", not signal.required))
            continue
        mean, noise = float(np.mean(good)), float(np.std(good)) if np.ptp(good) else 0.0
        low, high = (bound if bound is not None else own for bound, own in ((signal.low, -np.inf), (signal.high, np.inf)))
        limit = f"{context.shown(low, unit, name)} to {context.shown(high, unit, name)}" if np.isfinite([low, high]).all() else ""
        quiet = not np.isfinite(high - low) or noise <= MOST_NOISE * (high - low)
        shown = f"{context.shown(mean, unit, name)}, noise {context.shown_difference(noise, unit, name)}"
        values.append(Value(name, shown, limit, bool(low <= mean <= high) and quiet))
        values += _where_it_stands(context, name, mean, high - low)
    good_all = all(value.ok for value in values)
    return Outcome(good_all, f"{len(context.rig.signals)} signals, some {len(samples)} readings each", values)


def safe_state(context: Context) -> Outcome:
    """Devices with outputs go safe by themselves when they hear nothing; the pressure must be off."""
    if not context.bench.proves:
        return Outcome(None, "no device of this rig is asked for a proof")
    context.allow("Valves MOVE a little for the proof of the safe state; the hydraulic pressure must be off")
    answer = context.prove()
    values = [Value(result["text"], "ok" if result["ok"] else "NO", "ok", bool(result["ok"])) for result in answer["results"]]
    values += [Value(failure, "NO", "", False) for failure in answer["failures"]]
    if answer["good"]:
        context.allow("Switch the hydraulic pressure on: from now on the joints move when you allow it")
    return Outcome(bool(answer["good"]), "the devices' own time-outs", values)


def _mode(what: str, mode: str, wanted: str) -> Value:
    return Value(f"mode after {what}", mode, wanted, mode == wanted)


def _where_it_stands(context: Context, name: str, mean: float, span: float) -> list[Value]:
    """Sign, zero and scale of a joint's position: on the rig the operator compares it with the arm, in the simulation we know."""
    joint, _, quantity = name.partition(".")
    if quantity != "position" or joint not in context.rig.joints:
        return []
    unit = context.rig.joints[joint].position_unit
    reads = context.shown(mean, unit, joint)
    if not context.bench.simulated:
        seen = context.ask(f"{name} reads {reads}. Measured at the arm, is that where it stands?")
        return [Value(f"{name} as seen at the arm", "agrees" if seen else "does not agree", "agrees", seen)]
    assert context.rig.plant is not None
    true = context.rig.plant.joints[joint].initial
    return [Value(f"{name} beside the plant", reads, context.shown(true, unit, joint), abs(mean - true) <= AT_START * span)]
