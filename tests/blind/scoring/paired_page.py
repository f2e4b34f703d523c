"""`python -m tests.blind.scoring.paired_page STUDY`: the page of two searches, from STUDY/gates and STUDY/evidence: results of one
sealed study.

Everything on the page is counted from files of the study. To write it opens the seal: what decides, and at how many cases, was declared
before (STUDY/README.md).
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from statistics import median
from typing import Any

from gap.outcome.findings import explanations
from tests.blind.result_file import results
from tests.blind.scoring import paired, reliability
from tests.blind.scoring.page import DOCS
from tests.blind.scoring.score import NEW_VALUE_WITHIN, QUIET, Score, right, score
from tests.blind.scoring.tables import failures, of_group, share, table
from tests.blind.seal import published, unseal

SEARCHES = ("gates", "evidence")
PICTURE = "paired_reliability.png"
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


def page(study: Path, docs: Path = DOCS) -> str:
    """The page's text; draws the reliability diagram into `docs`."""
    parts = [study / name for name in SEARCHES]
    cases = {case.name: case for case in unseal(parts[0])}
    found = [results(part) for part in parts]
    scores = [[score(case, own[name]) for name, case in cases.items() if name in own] for own in found]
    common = set(found[0]) & set(found[1])
    asked = [demands([s for s in some if s.case.name in common], own) for some, own in zip(scores, found, strict=True)]
    both = [(text, limit, seen, other) for (text, limit, seen), (_, _, other) in zip(*asked, strict=True)]
    made = reliability.bins(reliability.said_names(cases, found[1]))
    reliability.diagram(made, docs / "pictures" / PICTURE)
    sections = [
        _head(study, found, len(common), len(cases)),
        "## Pair by pair\n\nA: gates, B: evidence.\n\n" + "\n".join(paired.table(paired.pairs(*parts))) + "\n",
        "## What is asked for\n\n" + table(("", "asked", *SEARCHES), both),
        f"## Probabilities\n\nOf all {len(found[1])} cases by evidence:\n\n" + "\n".join(reliability.table(made)),
        f"\n![share of right names over the probability said](../pictures/{PICTURE})\n",
        "## What evidence missed\n\n" + table(("case", "group", "hidden", "verdict", "wrong names"), failures(scores[1])),
    ]
    return "\n".join(sections)


def _head(study: Path, found: Sequence[Results], common: int, drawn: int) -> str:
    digest, _ = published(study / SEARCHES[0])
    commits = [", ".join(sorted({str(r["commit"]) for r in own.values()})) for own in found]
    dates = sorted(str(r["date"]) for own in found for r in own.values())
    return f"""# Two searches on the same sealed cases

Written by `python -m tests.blind.scoring.paired_page {study}`; do not edit.

Of {drawn} cases (SHA-256 of the answers
`{digest}`)
{common} were run by both: by gates ({commits[0]}) and by evidence ({commits[1]}), {dates[0]} to {dates[-1]} UTC.
What decides between them was [declared before](../../tests/blind/paired_study/README.md).
How cases are drawn and scored: [protocol](../../tests/blind/scoring/protocol.md).
"""


def main() -> int:
    """Exit 0."""
    parser = argparse.ArgumentParser(prog="python -m tests.blind.scoring.paired_page", description=__doc__)
    parser.add_argument("study", type=Path, help="folder with the two studies")
    study = parser.parse_args().study
    (DOCS / "results" / "paired.md").write_text(page(study))
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
