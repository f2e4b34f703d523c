"""findings.json: the machine-readable answer, in the words of the contract."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field
from importlib.metadata import version
from math import inf
from typing import Any

from config.schema.effect import Equation
from config.schema.effect_library import EFFECTS
from gap.data.coarse_steps import CoarseStep
from gap.data.measured import Array, Measured
from gap.evidence.judgement.votes import Votes
from gap.evidence.score.changed import Changed
from gap.evidence.score.hypothesis import Suspect
from gap.fitting.model import Model
from gap.fitting.nuisance import ALARM
from gap.outcome.localise import Disagreement
from gap.outcome.names import Fitted, LookAlike, Named, numbers_of
from gap.outcome.steadiness import Steadiness
from gap.outcome.verdict import Verdict
from gap.suspects.candidates import Candidate


@dataclass(frozen=True, slots=True)
class LeastSize:
    """The smallest size (SI) of an effect's parameter at which it would have been named; infinite where none would. `stated`: where it is
    a number of the rig file, from which it would have to differ by as much. `assumed`: the effect's other parameters, with units."""

    effect: str
    where: str
    parameter: str
    unit: str
    size: float
    stated: float | None = None
    assumed: Mapping[str, tuple[float, str]] = field(default_factory=dict)


def finding(name: Named, final: Fitted, by_fit: Fitted) -> dict[str, Any]:
    """One name with the numbers of all logs (`final`), those of the fit logs beside them. Of a number of the rig file that has changed also
    what was `stated`, and the `value` now."""
    suspect, explanation = name.suspect, name.explanation
    parameters = _beside(_parameters(suspect, final), _parameters(suspect, by_fit))
    effect = EFFECTS.get(suspect.effect)
    return {
        "effect": suspect.effect,
        "where": suspect.where,
        "confirmed": name.confirmed,
        "probability": _short(name.probability),
        "parameters": parameters,
        "holdout_gain": _short(explanation.gain),
        "t": _short(explanation.t),
        "look_alikes": [_look_alike(other) for other in name.look_alikes],
        "fingerprint": effect.fingerprint if effect else "",
        "equation": name.equation,
        **_stated(suspect, parameters),
        **_voted(name.votes),
    }


def _parameters(suspect: Suspect, fitted: Fitted) -> dict[str, Any]:
    """What a model has of it; the effect's fixed keys where nothing of it is fitted."""
    model, numbers = fitted.model, numbers_of(suspect, fitted.model)
    if not numbers and isinstance(suspect, Candidate):
        given = model.entry_added(suspect.effect, suspect.where).model_dump(by_alias=True)
        return {key: {"value": given.get(key), "unit": "", "ci95": [given.get(key)] * 2} for key in EFFECTS[suspect.effect].neutral}
    free = [model.free[k] for k in numbers]
    return {
        _parameter(model, k): number(float(model.theta[k]), float(fitted.half_width[k]), f.unit, f.low, f.high)
        for k, f in zip(numbers, free, strict=True)
    }


def _parameter(model: Model, number: int) -> str:
    return model.free[number].key.rpartition(".")[2]


def _beside(final: dict[str, Any], by_fit: dict[str, Any]) -> dict[str, Any]:
    return {key: item | by_fit_logs(by_fit[key]) for key, item in final.items()}


def _stated(suspect: Suspect, parameters: dict[str, Any]) -> dict[str, Any]:
    if not isinstance(suspect, Changed):
        return {}
    (changed,) = parameters.values()
    return {"stated": _short(suspect.free.start), "value": changed["value"]}


def _voted(votes: Votes | None) -> dict[str, Any]:
    """What either log says of a name, the other one fitted (ln)."""
    return {"votes": {"holdout": _short(votes.holdout), "fit_logs": _short(votes.fit_logs)}} if votes else {}


def _look_alike(other: LookAlike) -> dict[str, Any]:
    explanation, suspect, model = other.explanation, other.explanation.suspect, other.explanation.fit.model
    fitted = {
        _parameter(model, k): {"value": _short(float(model.theta[k])), "unit": model.free[k].unit} for k in numbers_of(suspect, model)
    }
    return {
        "effect": suspect.effect,
        "where": suspect.where,
        "share": _short(other.share),
        "holdout_gain": _short(explanation.gain),
        "t": _short(explanation.t),
        "parameters": fitted,
        **_stated(suspect, fitted),
        **_voted(other.votes),
    }


def step_finding(item: CoarseStep) -> dict[str, Any]:
    """An effect that the values of the logs show without any simulation."""
    return {
        "effect": "sensor_quantization",
        "where": item.where,
        "confirmed": True,
        "parameters": {"step": number(item.step, 0.0, item.unit)},
        "holdout_gain": _short(item.gain),
        "t": _short(item.t),
        "look_alikes": [],
        "fingerprint": EFFECTS["sensor_quantization"].fingerprint,
        "equation": Equation.SENSOR,
    }


def by_fit_logs(parameter: dict[str, Any]) -> dict[str, Any]:
    """A number as the fit logs alone have it, to stand beside the one of all logs: with it the hold-out was predicted blind."""
    return {"fit_logs": {key: parameter[key] for key in ("value", "ci95")}}


def number(value: float, half_width: float, unit: str, low: float = -inf, high: float = inf) -> dict[str, Any]:
    """With an interval that ends where the number's range does: no friction is negative, however little is known of it."""
    ends = [max(value - half_width, min(low, value)), min(value + half_width, max(high, value))]
    return {"value": _short(value), "unit": unit, "ci95": [_short(end) for end in ends]}


def constants(model: Model, half_width: Array, file: Model, steady: Sequence[Steadiness]) -> dict[str, Any]:
    """Constants of the rig file that the data see or that `file` has changed, at their values in the improved rig file, with how well the
    logs know them. The changed ones also log by log, where `steady` has them. `model`: with every constant free; it gives the alarms."""
    found, by_log = {}, {s.free.key: s.as_dict() for s in steady}
    new = {free.key: float(value) for free, value in zip(file.free, file.theta, strict=True)}
    for free, value, width in zip(model.free, model.theta, half_width, strict=True):
        seen = width < 1.7 * free.scale or abs(value - free.start) > 0.5 * free.scale
        if free.prior and (seen or free.key in new):
            kept = new.get(free.key, free.start)
            alarm = max(abs(value - free.start), abs(kept - free.start)) >= ALARM * free.scale
            prior = {"value": _short(free.start), "sd": _short(free.scale), "tag": free.tag}
            said = {"prior": prior, "alarm": bool(alarm)} | by_log.get(free.key, {})
            found[free.key] = number(kept, float(width), free.unit, free.low, free.high) | said
    return found


def not_seen(sizes: Sequence[LeastSize], named: Set[tuple[str, str]], steps: Mapping[str, float]) -> list[dict[str, Any]]:
    """Every effect that was looked for and not named (effect and place), with the smallest size that would have shown. `steps`: those
    that would have been read off the values, by place."""
    rows = []
    for s in sizes:
        if (s.effect, s.where) not in named:
            by_eye = steps.get(s.where, math.inf) if s.effect == "sensor_quantization" else math.inf
            row = {"effect": s.effect, "where": s.where, "parameter": s.parameter, "smallest_visible": _short(min(s.size, by_eye))}
            assumed = {key: {"value": _short(value), "unit": unit} for key, (value, unit) in s.assumed.items()}
            rows.append(row | {"unit": s.unit, "assumed": assumed} | ({} if s.stated is None else {"stated": _short(s.stated)}))
    return sorted(rows, key=lambda row: (str(row["effect"]), str(row["where"])))


def document(
    verdict: Verdict, places: Sequence[Disagreement], found: Sequence[dict[str, Any]], parts: dict[str, Any], logs: Sequence[Measured]
) -> dict[str, Any]:
    """The whole file; `found`: what the improved rig file has; `parts`: leads, parameters, gap, not_seen, next_maneuver, data, …"""
    return {
        "verdict": verdict.word,
        "why": verdict.why,
        "where": [place.as_dict() for place in places],
        "findings": list(found),
        **parts,
        "software": f"longreach {version('longreach')}",
        "inputs": [{"file": log.path.name, "sha256": log.sha256} for log in logs],
    }


def explanations(content: dict[str, Any]) -> list[dict[str, Any]]:
    """What was found, and under `unknown` what helped but left too much to be named: what a further log could settle."""
    return [*content["findings"], *content.get("leads", [])]


def as_text(content: dict[str, Any]) -> str:
    return json.dumps(content, indent=2, allow_nan=False, default=float) + "\n"


def _short(value: float) -> float | None:
    return float(f"{value:.6g}") if math.isfinite(value) else None
