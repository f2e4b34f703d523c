"""The first motions: each joint a little to and fro for the valve's polarity, gain and null; then a stop while it moves."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from config.errors import LongreachError
from config.schema.rig import AnyJoint
from daemon.cli.commission.bench import Ran
from daemon.cli.commission.context import Context
from daemon.cli.commission.late import tells_of_lateness
from daemon.cli.commission.record import Outcome, Value
from recording.files.reader import read_log
from recording.files.recordings import asked
from servo_control.signals import Mode

SHARE_OF_TRAVEL, SHARE_OF_RATE, TINY_S = 0.01, 0.05, 0.5  # of a tiny move; the servo of a fast joint must have time to settle in it
STOPPED_SHARE, STOPPED_RATE, STOP_AFTER_S = 0.05, 0.1, 0.5  # of the move that is stopped, at a third of it at the latest
FASTER = 2.0  # times as far and as fast, the second time
MOST_NULL = 0.05  # of the command limit
GAIN_RANGE = (0.5, 2.0)  # rate per volt beside 1 / velocity_feedforward
FULL_RATE = 0.95
LONGEST_REST_S = 2.0


class FullRate(NamedTuple):
    """Of the part at full rate: mean rate (SI/s) and mean command (V)."""

    rate: float
    command_V: float


def polarity(context: Context) -> Outcome:
    """Each joint a little to one side and back, then twice as far and as fast. A positive command must make the position grow."""
    values: list[Value] = []
    logs: list[str] = []
    for name, joint in context.rig.joints.items():
        step, speed, unit = _move(joint, SHARE_OF_TRAVEL, SHARE_OF_RATE, TINY_S)
        context.allow(f"{name} moves by {context.shown(step, unit, name)} to and fro, then by twice as much; be ready to stop it")
        moves = []
        for times in (1.0, -1.0, FASTER, -FASTER):
            ran = context.run(_jog(name, times * step, abs(times) * speed, unit))
            logs.append(str(ran.log))
            if not ran.valid:
                turned = (
                    ""
                    if tells_of_lateness(f"{ran.reason} {context.bench.fault}")
                    else f" If it ran away, turn the sign of outputs.{name}.scale."
                )
                advice = f"{ran.reason}{turned}"
                return Outcome(False, f"{name} did not follow: {advice}", [*values, Value(name, "not valid", "valid", False)], logs)
            moves.append(steady_of(ran, name))
        values += _judged(context, name, unit, moves)
        if not context.bench.simulated:
            seen = context.ask(f"Did {name} move to its positive side first (rotary: anticlockwise, linear: out)?")
            values.append(Value(f"{name} as seen at the arm", "right" if seen else "wrong way", "right", seen))
    return Outcome(all(value.ok for value in values), "tiny moves of every joint", values, logs)


def stop_in_motion(context: Context) -> Outcome:
    """A longer move of the first joint is stopped half way: it comes to rest and holds."""
    name, joint = next(iter(context.rig.joints.items()))
    step, speed, unit = _move(joint, STOPPED_SHARE, STOPPED_RATE, 3.0 * STOP_AFTER_S)
    context.allow(f"{name} moves by at most {context.shown(step, unit, name)} and is stopped")
    ran = context.run(_jog(name, step, speed, unit), stop_after_s=STOP_AFTER_S)
    rest_s = _rest_s(ran)
    values = [
        Value("mode after the stop", ran.mode, "holding", ran.mode == "holding"),
        Value("from the stop to rest", f"{rest_s:.2f} s" if np.isfinite(rest_s) else "was not stopped", f"≤ {LONGEST_REST_S:g} s",
              rest_s <= LONGEST_REST_S),
        Value("why the run ended", ran.reason, "stop was asked for", "stop was asked for" in ran.reason),
    ]  # fmt: skip
    return Outcome(all(value.ok for value in values), f"controlled stop of {name} in motion", values, [str(ran.log)])


def steady_of(ran: Ran, joint: str) -> FullRate:
    """Mean rate and command while the joint's target moves at its full rate, without the first third, in which the servo settles."""
    log = read_log(ran.log)
    running = (log.columns["maneuver"] == ran.run) & (log.columns["mode"] == Mode.RUNNING)
    rate = np.abs(np.nan_to_num(log.columns[f"{joint}.target_rate"]))
    rows = np.flatnonzero(running & (rate >= FULL_RATE * np.max(rate[running])))
    if not len(rows):
        raise LongreachError("the joint was not moved", value=joint, where=str(ran.log), next_step=f"See {asked('plot', ran.log)}.")
    rows = rows[len(rows) // 3 :]
    t, position = log.columns["t_s"][rows], log.columns[f"{joint}.position"][rows]
    return FullRate(float(np.polyfit(t - t[0], position, 1)[0]), float(np.mean(log.columns[f"{joint}.command_V"][rows])))


def _judged(context: Context, name: str, unit: str, moves: Sequence[FullRate]) -> list[Value]:
    """From slow out, slow back, fast out, fast back. command = null ± friction + rate / per_volt: the change from slow to fast gives the
    rate a volt without the friction, the sum of out and back the null, half their difference what is left the friction."""
    out, back, faster_out, faster_back = moves
    joint = context.rig.joints[name]
    per_volt = (faster_out.rate - out.rate - faster_back.rate + back.rate) / (
        faster_out.command_V - out.command_V - faster_back.command_V + back.command_V
    )
    null_V = 0.5 * (out.command_V + back.command_V)
    friction_V = 0.5 * (out.command_V - back.command_V - (out.rate - back.rate) / per_volt)
    most_V = MOST_NULL * joint.command_limit_V
    feedforward = context.rig.servo[name].velocity_feedforward
    values = [
        Value(f"{name} polarity", "positive" if per_volt > 0.0 else "negative", "positive", per_volt > 0.0),
        Value(f"{name} null of the valve", f"{1e3 * null_V:z.1f} mV", f"within ±{1e3 * most_V:.0f} mV", abs(null_V) <= most_V),
        Value(f"{name} friction", f"±{1e3 * friction_V:.1f} mV"),
    ]
    if feedforward > 0.0:
        ratio = per_volt * feedforward
        low, high = GAIN_RANGE
        shown = f"{context.shown_difference(per_volt, f'{unit}/s', name)} a volt, {ratio:.2f} of 1 / velocity_feedforward"
        values.append(Value(f"{name} rate", shown, f"{low:g} to {high:g}", low <= ratio <= high))
    return values


def _move(joint: AnyJoint, share: float, rate: float, least_s: float) -> tuple[float, float, str]:
    """Distance, speed and unit of a move over a share of the travel that takes `least_s` or longer."""
    low, high = joint.travel
    way = share * (high - low)
    return way, min(rate * joint.rate_limit, way / least_s), joint.position_unit


def _jog(joint: str, by: float, speed: float, unit: str) -> dict[str, object]:
    text = f"longreach: maneuver/1\nname: jog\nkind: jog\njoint: {joint}\nby: {by:.8g} {unit}\nspeed: {speed:.8g} {unit}/s\n"
    return {"maneuver": {"text": text, "name": "jog"}}


def _rest_s(ran: Ran) -> float:
    """How long the mode was stopping; infinite where it never was."""
    log = read_log(ran.log)
    rows = np.flatnonzero(log.columns["mode"] == Mode.STOPPING)
    return float(log.columns["t_s"][rows[-1]] - log.columns["t_s"][rows[0]]) if len(rows) else float("inf")
