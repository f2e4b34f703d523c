"""Findings against the answer: pure bookkeeping, the same for the search and for every baseline."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from tests.blind.cases import Case

Name = tuple[str, str]
QUIET = ("no_gap", "parameter_mismatch")
CLOSED = 1.2  # noise floors
NEW_VALUE_WITHIN = 0.1  # of a changed number, relative


@dataclass(frozen=True, slots=True)
class Score:
    """One case judged."""

    case: Case
    verdict: str
    first: bool  # a right name is the first one, alone
    in_set: bool  # the first name or one of its look-alikes is right
    all_named: bool  # every hidden effect is a name or in a set
    wrong: tuple[Name, ...]  # names whose set does not hold any right one
    wrong_confirmed: tuple[Name, ...]
    flagged: bool  # says that something is there which it cannot confirm
    parameter_error: float | None  # relative, of the first hidden effect's first parameter, where it was named
    closed: bool
    refused: bool


def score(case: Case, result: Mapping[str, Any]) -> Score:
    """Judge `result` (findings.json, or {"verdict": "refused"})."""
    found: Sequence[Mapping[str, Any]] = [*result.get("findings", []), *result.get("leads", [])]  # `unknown` names none: what it tried
    sets = [names_of(item) for item in found]
    truth = set(case.truth)
    wrong = tuple(s[0] for s in sets if not truth & set(s))
    confirmed = tuple(s[0] for s, item in zip(sets, found, strict=True) if not truth & set(s) and item.get("confirmed"))
    verdict = str(result["verdict"])
    after = (result.get("gap") or {}).get("holdout_after")
    return Score(
        case=case,
        verdict=verdict,
        first=bool(sets) and sets[0][0] in truth,
        in_set=bool(sets) and bool(truth & set(sets[0])),
        all_named=bool(truth) and truth <= {name for s in sets for name in s},
        wrong=wrong,
        wrong_confirmed=confirmed,
        flagged=verdict == "unknown" or (bool(found) and not any(item.get("confirmed") for item in found)),
        parameter_error=_parameter_error(case, found),
        closed=after is not None and after <= CLOSED,
        refused=verdict in ("refused", "crashed", "data_problem"),
    )


def names_of(item: Mapping[str, Any]) -> list[Name]:
    """A finding and its look-alikes."""
    return [(item["effect"], item["where"]), *((a["effect"], a["where"]) for a in item.get("look_alikes", []))]


def _parameter_error(case: Case, found: Sequence[Mapping[str, Any]]) -> float | None:
    hidden = case.setting.hidden
    if not hidden or case.group == "out_of_library":
        return None
    for item in found:
        values = [p["value"] for p in item["parameters"].values() if p.get("value") is not None]
        if (item["effect"], item["where"]) == (hidden[0].effect, hidden[0].where) and values and hidden[0].value:
            return abs(values[0] - hidden[0].value) / abs(hidden[0].value)
    return None


def right(score: Score) -> bool:
    """Whether a case of its group came out as it should."""
    if score.case.group == "null":
        return not score.wrong and not score.refused
    if score.case.group == "out_of_library":
        return score.flagged and not score.wrong_confirmed
    if score.case.group == "changed":
        return score.in_set and score.parameter_error is not None and score.parameter_error <= NEW_VALUE_WITHIN
    return score.all_named if score.case.group == "pair" else score.in_set
