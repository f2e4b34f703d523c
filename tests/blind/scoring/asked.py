"""What is asked of a search, the limit, and what a study has seen."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from statistics import median
from typing import Any

from gap.outcome.findings import explanations
from tests.blind.scoring.score import NEW_VALUE_WITHIN, QUIET, Score, right
from tests.blind.scoring.tables import of_group, share

SAID = 0.5  # probability from which a name on a healthy machine counts as false
MUCH = 3.0  # times a number has changed

Results = Mapping[str, Mapping[str, Any]]
Demand = tuple[str, str, str]


def demands(scores: Sequence[Score], found: Results) -> list[Demand]:
    """What is asked of a search, the limit, and what was seen."""
    null, single, pair, strange = (of_group(scores, g) for g in ("null", "single", "pair", "out_of_library"))
    large, small = [s for s in single if s.case.multiple >= MUCH], [s for s in single if s.case.multiple == 1]
    changed = [s for s in of_group(scores, "changed") if max(s.case.multiple, 1.0 / s.case.multiple) >= MUCH]
    errors = [s.parameter_error for s in large if s.parameter_error is not None]
    held = [inside for s in large if (inside := holds_truth(s, found[s.case.name])) is not None]

    def says_one(s: Score) -> bool:
        return any((f.get("probability") or 1.0) >= SAID for f in found[s.case.name].get("findings", []))

    def stands(s: Score) -> bool:
        return s.in_set and s.verdict in ("named", "ambiguous")

    rows: list[tuple[str, str, Sequence[Score], Callable[[Score], bool]]] = [
        ("nothing missing: `no_gap` or `parameter_mismatch`", "≥ 90 %", null, lambda s: s.verdict in QUIET),
        ("… a confirmed name", "0", null, lambda s: bool(s.wrong_confirmed)),
        ("… a name of 0.5 and more", "≤ 3 %", null, says_one),
        ("one effect, 3× and 10×: right name first or in its set", "≥ 95 %", large, lambda s: s.in_set),
        ("… and the verdict `named` or `ambiguous`", "≥ 93 %", large, stands),
        ("… at 1×: right name first or in its set", "≥ 60 %", small, lambda s: s.in_set),
        ("two effects: both named", "≥ 88 %", pair, lambda s: s.all_named),
        ("out of the library: flagged", "≥ 95 %", strange, right),
        (f"a number changed {MUCH:g} times and more: named, within {NEW_VALUE_WITHIN:.0%}", "≥ 90 %", changed, right),
        ("any case: a wrong confirmed name", "≤ 1 %", scores, lambda s: bool(s.wrong_confirmed)),
    ]
    counted = [(text, limit, share(some, hit).text()) for text, limit, some, hit in rows]
    of_sizes = ("one effect, 3× and 10×: median error of its size", "≤ 3 %", f"{median(errors):.1%} of {len(errors)}" if errors else "–")
    of_intervals = ("… 95 % intervals that hold the truth", "88 to 99 %", f"{sum(held)} of {len(held)}" if held else "–")
    return [*counted, of_sizes, of_intervals]


def holds_truth(judged: Score, result: Mapping[str, Any]) -> bool | None:
    """Whether the interval of the hidden effect's first parameter holds its value; None where it was not named."""
    hidden = judged.case.setting.hidden[0]
    for item in explanations(result):
        intervals = [p["ci95"] for p in item["parameters"].values() if p.get("ci95")]
        if (item["effect"], item["where"]) == (hidden.effect, hidden.where) and intervals:
            low, high = intervals[0]
            return bool(low <= hidden.value <= high)
    return None
