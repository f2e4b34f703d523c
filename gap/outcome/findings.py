"""findings.json: the machine-readable answer, in the words of the contract."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

from config.schema.effect import Equation
from config.schema.effect_library import EFFECTS
from gap.data.coarse_steps import CoarseStep
from gap.data.measured import Array, Measured
from gap.fitting.model import Model
from gap.outcome.localise import Disagreement
from gap.outcome.model_file import width_key
from gap.outcome.steadiness import Steadiness
from gap.search.look_alikes import look_alikes
from gap.search.search_state import GateSearch, Step
from gap.search.trial import Trial
from gap.search.verdict import ALARM, Verdict
from gap.signatures.screen import Screening


@dataclass(frozen=True, slots=True)
class LeastSize:
    """The smallest size (SI) of an effect's parameter at which it would have been named; infinite where none would. `stated`: where it is
    a number of the rig file, from which it would have to differ by as much."""

    effect: str
    where: str
    parameter: str
    unit: str
    size: float
    stated: float | None = None


def finding(state: GateSearch, step: Step, model: Model, widths: Mapping[str, float], verdict: Verdict) -> dict[str, Any]:
    """One accepted effect, with the values of `model`, which is the one in the improved rig file."""
    candidate = step.trial.candidate
    numbers = model.of_effect(step.entry)
    free = [(model.free[k], float(model.theta[k])) for k in numbers]
    parameters = {item.key: number(value, widths[width_key(step, item.key)], item.unit) for item, value in free}
    fixed = {name: step.entry.model_dump(by_alias=True).get(name) for name in (() if numbers else EFFECTS[candidate.effect].neutral)}
    alike = look_alikes(state, step)
    return {
        "effect": candidate.effect,
        "where": candidate.where,
        "confirmed": verdict.confirmed and not alike and not step.weak,
        "parameters": parameters | {key: {"value": value, "unit": "", "ci95": [value, value]} for key, value in fixed.items()},
        "holdout_gain": _short(step.trial.gain),
        "t": _short(step.trial.t),
        "look_alikes": [_look_alike(trial) for trial in alike],
        "fingerprint": EFFECTS[candidate.effect].fingerprint,
        "equation": candidate.equation,
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


def _look_alike(trial: Trial) -> dict[str, Any]:
    model = trial.fit.model
    fitted = {
        model.free[k].key: {"value": _short(float(model.theta[k])), "unit": model.free[k].unit} for k in model.of_effect(model.added[-1])
    }
    place = {"effect": trial.candidate.effect, "where": trial.candidate.where}
    return place | {"holdout_gain": _short(trial.gain), "t": _short(trial.t), "parameters": fitted}


def by_fit_logs(parameter: dict[str, Any]) -> dict[str, Any]:
    """A number as the fit logs alone have it, to stand beside the one of all logs: with it the hold-out was predicted blind."""
    return {"fit_logs": {key: parameter[key] for key in ("value", "ci95")}}


def number(value: float, half_width: float, unit: str) -> dict[str, Any]:
    return {"value": _short(value), "unit": unit, "ci95": [_short(value - half_width), _short(value + half_width)]}


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
            found[free.key] = number(kept, float(width), free.unit) | said
    return found


def not_seen(sizes: Sequence[LeastSize], named: Set[tuple[str, str]], steps: Mapping[str, float]) -> list[dict[str, Any]]:
    """Every effect that was looked for and not named (effect and place), with the smallest size that would have shown. `steps`: those
    that would have been read off the values, by place."""
    rows = []
    for s in sizes:
        if (s.effect, s.where) not in named:
            by_eye = steps.get(s.where, math.inf) if s.effect == "sensor_quantization" else math.inf
            row = {"effect": s.effect, "where": s.where, "parameter": s.parameter, "smallest_visible": _short(min(s.size, by_eye))}
            rows.append(row | {"unit": s.unit} | ({} if s.stated is None else {"stated": _short(s.stated)}))
    return sorted(rows, key=lambda row: (str(row["effect"]), str(row["where"])))


def least_sizes(screening: Screening | None) -> list[LeastSize]:
    """What a search by gates would have named."""
    found = [(s.candidate, s) for s in (screening.signatures if screening else ())]
    return [LeastSize(c.effect, c.where, c.free[0].key if c.free else "", s.unit, s.smallest_visible) for c, s in found]


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
