"""Which checks a rig has, in the order in which causes come before their consequences (a dead sensor before what it measures)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import inf

from config.canopen_options import proofs
from config.rig import Rig
from daemon.calibration_watch import calibration_checks
from daemon.checks import Check, Reaction
from daemon.facts import Facts
from daemon.plausibility import plausibility_checks
from drivers.contract import Quality
from recording.fields import field_of_signal

RECORDER_AGE_LIMIT_S = 1.0  # ten of its sync periods
SUPPLY_LOST = 0.5  # of the least supply pressure: less is not low pressure but none
SUPERVISOR_AGE_LIMIT_S = 2.0
_UNITS = {"angle": "rad", "length": "m", "pressure": "Pa", "temperature": "degC", "acceleration": "m/s^2"}


def interlocks(rig: Rig, facts: Facts) -> tuple[Check, ...]:
    """Every check of this rig."""
    return (
        *_daemon_checks(rig, facts),
        *_proof_demands(rig, facts),
        *calibration_checks(rig, facts),
        *_signal_checks(rig, facts),
        *plausibility_checks(rig, facts),
        *_oil_checks(rig, facts),
        *_motion_checks(rig, facts),
    )


def _daemon_checks(rig: Rig, facts: Facts) -> Iterator[Check]:
    def check(name: str, fact: str, low: float, high: float, unit: str, source: str, reaction: Reaction, next_step: str) -> Check:
        return Check(name, facts.index(fact), low, high, unit, source, reaction, next_step)

    late, many = rig.loop.overruns.fault_late_s, rig.loop.overruns.stop_after - 1
    advice = "Look for other work on this computer; `longreach status` names the slowest phase. Then reset or lower loop.rate."
    yield check("e-stop", "estop_latched", 0, 0, "", "daemon", Reaction.FAULT, "Make sure the arm may move, then `longreach reset`.")
    yield check("loop stall", "loop.late_s", -inf, late, "s", "loop", Reaction.FAULT, advice)
    yield check("loop timing", "loop.overruns_in_window", 0, many, "overruns", "loop", Reaction.STOP, advice)
    then_fault = Reaction.STOP_THEN_FAULT
    restart = "The log is the evidence of a run: `longreach reset` starts the recorder again."
    yield check("recorder lost", "recorder.failed", 0, 0, "", "recorder", then_fault, restart)
    yield check("recorder silent", "recorder.age_s", -inf, RECORDER_AGE_LIMIT_S, "s", "recorder", then_fault, restart)
    yield check("records dropped", "recorder.drops", 0, 0, "records", "recorder", then_fault, "Use a faster disk or a lower loop.rate.")
    least = rig.interlocks.disk_free_min_bytes
    yield check("disk space", "disk.free_bytes", least, inf, "bytes", "log directory", Reaction.STOP, "Move old logs away.")
    silent = "See `systemctl status longreachd`; restart the daemon."
    yield check("supervisor alive", "supervisor.age_s", -inf, SUPERVISOR_AGE_LIMIT_S, "s", "supervisor", Reaction.STOP, silent)


def proof_checks(rig: Rig, facts: Facts) -> tuple[Check, ...]:
    """What must hold before and during the proof of the safe state: valves open, so no pressure may be there; and it must be logged."""
    conditions = [check for check in _daemon_checks(rig, facts) if check.name in ("e-stop", "recorder lost")]
    most, advice = rig.interlocks.proof_pressure_max_Pa, "Switch the pump off, close the shut-off valve and let the accumulator down."
    for joint in pressure_is_measured(rig):
        name = f"{joint}.supply_pressure"
        signal, age = rig.signals[name], facts.index(f"{name}_age_s")
        source, value = f"{signal.device}.{signal.channel}", facts.index(field_of_signal(name))
        conditions.append(Check(f"{name} off", value, -inf, most, "Pa", source, Reaction.FAULT, advice, age))
        conditions.append(Check(f"{name} age", age, -inf, signal.max_age_s, "s", source, Reaction.FAULT, f"Check {source}.", age))
    return tuple(conditions)


def pressure_is_measured(rig: Rig) -> list[str]:
    """The joints whose supply pressure the rig measures."""
    return [joint for joint in rig.joints if f"{joint}.supply_pressure" in rig.signals]


def _proof_demands(rig: Rig, facts: Facts) -> Iterator[Check]:
    advice = "Take the pressure off and run `longreach prove`; once after every start of the daemon or of the device."
    for device, demanded in proofs(rig).items():
        if demanded:
            index = facts.index(f"{device}.proven_s")
            yield Check(f"{device} safe state proven", index, 0, inf, "s since the start", device, Reaction.REFUSE, advice)


def _signal_checks(rig: Rig, facts: Facts) -> Iterator[Check]:
    """Quality, age and range of every required signal."""
    for name, signal in rig.signals.items():
        if not signal.required:
            continue
        source, age = f"{signal.device}.{signal.channel}", facts.index(f"{name}_age_s")
        quality = facts.index(f"{name}.quality")
        cable = f"Check the cable and supply of {source}."
        yield Check(f"{name} quality", quality, 0, float(Quality.UNCERTAIN), "", source, Reaction.FAULT, cable, age)
        yield Check(f"{name} age", age, -inf, signal.max_age_s, "s", source, Reaction.FAULT, f"{source} has gone silent. {cable}", age)
        low, high = _or(signal.low, -inf), _or(signal.high, inf)
        if (low, high) != (-inf, inf):
            value, advice = facts.index(field_of_signal(name)), f"The value cannot be true: check {source} and its calibration."
            yield Check(f"{name} range", value, low, high, _UNITS[signal.measures], source, Reaction.FAULT, advice, age)


def _oil_checks(rig: Rig, facts: Facts) -> Iterator[Check]:
    """Limits of the `interlocks:` section, for the signals that the rig has."""
    limits = rig.interlocks
    for joint in rig.joints:
        low, high = _or(limits.supply_pressure_min_Pa, -inf), _or(limits.supply_pressure_max_Pa, inf)
        yield from _supply_lost(rig, facts, f"{joint}.supply_pressure", SUPPLY_LOST * low)
        yield from _limit(rig, facts, f"{joint}.supply_pressure", low, high, "Check pump, accumulator and shut-off valve.")
        yield from _limit(rig, facts, f"{joint}.return_pressure", -inf, _or(limits.return_pressure_max_Pa, inf), "Check the return filter.")
    low, high = _or(limits.oil_temperature_min_C, -inf), _or(limits.oil_temperature_max_C, inf)
    yield from _limit(rig, facts, "reservoir_temperature", low, high, "Warm the oil up by circulating it, or check the cooler.")
    most = limits.tip_acceleration_max_m_per_s2
    if most is not None:
        yield from _limit(rig, facts, "tip.acceleration", -most, most, "Use a command filter or a slower maneuver.")


def _limit(rig: Rig, facts: Facts, name: str, low: float, high: float, advice: str) -> Iterator[Check]:
    signal = rig.signals.get(name)
    if signal is None or (low, high) == (-inf, inf):
        return
    source, age = f"{signal.device}.{signal.channel}", facts.index(f"{name}_age_s")
    index = facts.index(field_of_signal(name))
    yield Check(f"{name} limit", index, low, high, _UNITS[signal.measures], source, Reaction.STOP, advice, age)


def _supply_lost(rig: Rig, facts: Facts, name: str, low: float) -> Iterator[Check]:
    """Without pressure the servo cannot stop the arm, and the arm would jump when pressure returned."""
    lost = _limit(rig, facts, name, low, inf, "Check pump and shut-off valve.")
    yield from (replace(check, name=f"{name} lost", reaction=Reaction.FAULT) for check in lost)


def _motion_checks(rig: Rig, facts: Facts) -> Iterator[Check]:
    """Following error; and travel, with the following error as margin so that a joint held at its end does not trip."""
    for name, joint in rig.joints.items():
        unit, source = ("rad" if joint.motion == "rotary" else "m"), f"joint {name}"
        error = facts.index(f"{name}.following_error")
        advice = "Check pressure, valve and polarity; compare command and position in the log."
        yield Check(f"{name} following error", error, -inf, joint.following_error_limit, unit, source, Reaction.FAULT, advice)
        low, high = joint.travel[0] - joint.following_error_limit, joint.travel[1] + joint.following_error_limit
        back = "Bring the joint back by hand, with the pressure off."
        yield Check(f"{name} travel", facts.index(f"{name}.position"), low, high, unit, source, Reaction.STOP, back)


def _or(value: float | None, otherwise: float) -> float:
    return otherwise if value is None else value
