"""From the parameters of a `prove` request to a countdown, and from the events of the proof to its answer."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from config.errors import DaemonError
from config.options.canopen_rig import proofs
from config.schema.rig import Rig
from daemon.checks.declared.safe_state_proof import pressure_is_measured
from daemon.server.protocol import LONGEST_COUNTDOWN_S
from servo_control.signals import Mode

_KEYS = {"countdown_s", "pressure_is_off"}


def proof_countdown_s(rig: Rig, params: Mapping[str, Any]) -> float:
    """Length of the countdown. DaemonError for parameters that are no request, a rig with nothing to prove, and an unmeasured pressure."""
    unknown = sorted(set(params) - _KEYS)
    if unknown:
        raise DaemonError("unknown parameter of prove", value=", ".join(unknown), limit=", ".join(sorted(_KEYS)))
    if not proofs(rig):
        advice = "CANopen valves and output modules prove it, and plug-ins with demand_proof: true. Nothing is needed: `longreach arm`."
        raise DaemonError("no device of this rig can prove its safe state", value=rig.name, next_step=advice)
    _refuse_unknown_pressure(rig, params.get("pressure_is_off", False))
    countdown_s = params.get("countdown_s", rig.loop.countdown_s)
    if isinstance(countdown_s, bool) or not isinstance(countdown_s, (int, float)) or not 0.0 <= countdown_s <= LONGEST_COUNTDOWN_S:
        raise DaemonError("countdown out of range", value=repr(countdown_s), limit=f"0 to {LONGEST_COUNTDOWN_S:g}", unit="s")
    return float(countdown_s)


def proof_answer(events: Sequence[Mapping[str, Any]], mode: Mode) -> dict[str, Any]:
    """Results in their order, which devices are proven now, and what the others failed with."""
    results = [
        {"ok": bool(event["values"]["ok"]), "text": event["text"]}
        | {key: event["values"][key] for key in ("time_to_safe_s", "limit_s") if key in event["values"]}
        for event in events
        if event["name"] == "proof"
    ]
    failures = [event["text"] for event in events if event["name"] in ("not_proven", "fault")]
    proven = sum(event["name"] == "proven" for event in events)
    return {"mode": mode.name.lower(), "good": bool(proven) and not failures, "results": results, "failures": failures}


def _refuse_unknown_pressure(rig: Rig, said_to_be_off: object) -> None:
    unmeasured = [joint for joint in rig.joints if joint not in pressure_is_measured(rig)]
    if unmeasured and said_to_be_off is not True:
        advice = "Take the pressure off, see that it is off, and say so: `longreach prove --pressure-is-off`."
        raise DaemonError("proof refused: nothing measures the supply pressure", value=", ".join(unmeasured), next_step=advice)
