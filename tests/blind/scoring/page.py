"""docs/results/blind.md from the results: everything on it is counted from files of the study, nothing is written by hand."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from textwrap import fill
from typing import Any

from tests.blind.baselines import METHODS
from tests.blind.cases import Case
from tests.blind.scoring.naming_record import write_record
from tests.blind.scoring.pictures import confusion, power
from tests.blind.scoring.score import Score, score
from tests.blind.scoring.tables import Share, by_effect, by_form, by_sensors, by_version, failures, of_group, share, table, targets
from tests.blind.seal import published

DOCS = Path(__file__).parents[3] / "docs"
TITLE = "How the search fares with a machine it does not know"
PROTOCOL = Path(__file__).with_name("protocol.md")


def write_page(study: Path, cases: Sequence[Case], results: Mapping[str, Mapping[str, Any]], docs: Path = DOCS) -> None:
    """Score and write."""
    scores = [score(case, results[case.name]) for case in cases if case.name in results]
    if docs == DOCS:
        write_record(scores, published(study)[0])
    confusion(scores, docs / "pictures" / "blind_confusion.png")
    power(scores, docs / "pictures" / "blind_power.png")
    parts = [_head(study, cases, results, scores), PROTOCOL.read_text(), _numbers(cases, results, scores), _failures(scores)]
    page = docs / "results" / "blind.md"
    page.parent.mkdir(exist_ok=True)
    page.write_text("\n".join(parts))


def _head(study: Path, cases: Sequence[Case], results: Mapping[str, Mapping[str, Any]], scores: Sequence[Score]) -> str:
    digest, sealed = published(study)
    if not results:
        return f"# {TITLE}\n\nNo case has been run yet. Answers {sealed}, SHA-256 `{digest}`.\n"
    counts = Counter(s.case.group for s in scores)
    versions = {(r["finder"], r["commit"]) for r in results.values()}
    dates = sorted(str(r["date"]) for r in results.values())
    seconds = [float(r["seconds"]) for r in results.values()]
    run = ", ".join(f"{counts[g]} {g.replace('_', ' ')}" for g in ("single", "null", "pair", "out_of_library", "look_alike"))
    builds = "one version" if len(versions) == 1 else f"{len(versions)} versions"
    head = f"""# {TITLE}

You will have: what the search for missing physics gets right and wrong on hidden effects, with how many cases each number rests on.
Written by `make blind`; do not edit.

**{len(scores)} of {len(cases)} cases run** ({run}), {dates[0]} to {dates[-1]} UTC, with {builds} of the search (table below).
Answers {sealed}, SHA-256 `{digest}`, before the run.
No setting of the search was tuned on these answers but where the protocol says so; development used seeds of its own.
A search took {median(seconds):.0f} s (median, on a busy machine; longest {max(seconds):.0f} s).
"""
    return "\n".join(fill(line, 110, break_long_words=False, break_on_hyphens=False) for line in head.split("\n"))


def _numbers(cases: Sequence[Case], results: Mapping[str, Mapping[str, Any]], scores: Sequence[Score]) -> str:
    resolved = _resolved(cases, results)
    parts = [
        "## What came out\n\nIn brackets: Wilson's 95 % interval in percent.\n",
        table(("question", "wanted", "seen"), targets(scores, resolved)),
        "![Share named over the size](../pictures/blind_power.png)\n",
        "![Hidden effect against first name](../pictures/blind_confusion.png)\n",
        "### By version of the search\n",
        table(
            (
                "commit",
                "last case (UTC)",
                "cases",
                "one effect, 3× and 10×: named",
                "no effect: false name",
                "both of two",
                "wrong confirmed",
            ),
            by_version(scores, results),
        ),
        "### By effect\n\nNamed (first or in its set) of cases run, at 1, 3 and 10 smallest visible sizes; where half are named;\n"
        "median error of the parameter at 3× and 10×; what was wrongly named instead.\n",
        table(("hidden", "1×", "3×", "10×", "half at", "error", "wrong names"), by_effect(scores)),
        "### By the hidden machine's friction\n",
        table(("friction", "named at 3× and 10×", "… and closed to 1.2", "null: nothing missing", "null: false name"), by_form(scores)),
        "### By sensors\n",
        table(("chamber pressures", "named at 3× and 10×"), by_sensors(scores)),
        "### Baselines on the same cases\n\n" + _baselines(cases, results),
    ]
    return "\n".join(parts)


def _resolved(cases: Sequence[Case], results: Mapping[str, Mapping[str, Any]]) -> Share:
    """Of the sets with a proposed maneuver that was then run: how many ended with the right name alone."""
    rounds = [(c, results[c.name]["resolved"]) for c in cases if c.name in results and results[c.name].get("resolved")]
    good = [bool(again["findings"]) and not again["findings"][0]["look_alikes"] and score(case, again).in_set for case, again in rounds]
    return Share(sum(good), len(good))


def _baselines(cases: Sequence[Case], results: Mapping[str, Mapping[str, Any]]) -> str:
    rows = []
    for method, title in {"search": "this search", **METHODS}.items():
        judged = [score(c, _as_findings(results[c.name], method)) for c in cases if c.name in results]
        large = [s for s in of_group(judged, "single") if s.case.multiple >= 3]
        null, strange, pair = (of_group(judged, g) for g in ("null", "out_of_library", "pair"))
        rows.append([title, share(large, lambda s: s.in_set).text(), share(null, lambda s: bool(s.wrong)).text(),
                     share(pair, lambda s: s.all_named).text(), share(strange, lambda s: bool(s.wrong)).text()])  # fmt: skip
    head = ("method", "one effect, 3× and 10×: named", "no effect: false name", "both of two", "out of library: false name")
    return table(head, rows)


def _as_findings(result: Mapping[str, Any], method: str) -> Mapping[str, Any]:
    if method == "search":
        return result
    names = result.get("baselines", {}).get(method, [])
    found = [{"effect": e, "where": w, "confirmed": True, "parameters": {}, "look_alikes": []} for e, w in names]
    return {"verdict": "named" if found else "no_gap", "findings": found}


def _failures(scores: Sequence[Score]) -> str:
    rows = failures(scores)
    if not rows:
        return "## Failures\n\nNone among the cases run.\n"
    text = f"## Failures\n\nAll {len(rows)} cases at 3× and more that did not come out as they should.\n\n"
    return text + table(("case", "group", "hidden", "verdict", "wrong names"), rows)
