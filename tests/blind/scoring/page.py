"""docs/results/blind.md from the results: everything on it is counted from files of the study, nothing is written by hand.

The numbers are those of all cases, and of every version of the search on its own. Beside them stand the search by gates and the version
that was compared with it, on the cases that both have, where results lie in `gates` beside those of the study.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from statistics import median
from textwrap import fill
from typing import Any

from tests.blind.baselines import METHODS
from tests.blind.cases import Case
from tests.blind.result_file import results
from tests.blind.scoring import paired
from tests.blind.scoring.asked import Demand, demands
from tests.blind.scoring.pictures import confusion, power
from tests.blind.scoring.probabilities import reliability
from tests.blind.scoring.score import Score, score
from tests.blind.scoring.tables import Share, by_effect, by_form, by_sensors, failures, of_group, share, table
from tests.blind.seal import published, unseal

DOCS = Path(__file__).parents[3] / "docs"
TITLE = "How the search fares with a machine it does not know"
PROTOCOL = Path(__file__).with_name("protocol.md")
EARLIER = "gates"

Results = Mapping[str, Mapping[str, Any]]


def write_page(study: Path, docs: Path = DOCS) -> None:
    """Score and write. To do that opens the seal."""
    cases, found, earlier = unseal(study), results(study), study.with_name(EARLIER)
    scores = [score(case, found[case.name]) for case in cases if case.name in found]
    for draw, name in ((confusion, "confusion"), (power, "power")):
        draw(scores, docs / "pictures" / f"blind_{name}.png")
    parts = [_head(study, cases, found, scores), PROTOCOL.read_text(), _numbers(cases, found, scores), _probabilities(cases, found, docs)]
    if results(earlier):
        parts.append(_beside(study, earlier, cases))
    page = docs / "results" / "blind.md"
    page.parent.mkdir(exist_ok=True)
    page.write_text("\n".join([*parts, _failures(scores)]))


def _head(study: Path, cases: Sequence[Case], found: Results, scores: Sequence[Score]) -> str:
    digest, sealed = published(study)
    if not found:
        return f"# {TITLE}\n\nNo case has been run yet. Answers {sealed}, SHA-256 `{digest}`.\n"
    counts = Counter(s.case.group for s in scores)
    dates = sorted(str(r["date"]) for r in found.values())
    seconds = [float(r["processor_s"]) for r in found.values()]
    run = ", ".join(f"{counts[g]} {g.replace('_', ' ')}" for g in dict.fromkeys(case.group for case in cases))
    commits = ", ".join(_by_version(found))
    head = f"""# {TITLE}

You will have: what the search for missing physics gets right and wrong on hidden effects, with how many cases each number rests on.
Written by `make blind`; do not edit.

**{len(scores)} of {len(cases)} cases run** ({run}), {dates[0]} to {dates[-1]} UTC, by commit {commits}.
Answers {sealed}, SHA-256 `{digest}`, before the run.
A search took {median(seconds):.0f} s of processor time (median; longest {max(seconds):.0f} s).
"""
    return "\n".join(fill(line, 110, break_long_words=False, break_on_hyphens=False) for line in head.split("\n"))


def _numbers(cases: Sequence[Case], found: Results, scores: Sequence[Score]) -> str:
    parts = [
        "## What came out\n\nIn brackets: Wilson's 95 % interval in percent.\n",
        table(("question", "asked", "seen"), _asked(scores, found)),
        _version_by_version(scores, found),
        "![Share named over the size](../pictures/blind_power.png)\n",
        "![Hidden effect against first name](../pictures/blind_confusion.png)\n",
        "### By effect\n\nNamed (first or in its set) of cases run, at 1, 3 and 10 smallest visible sizes; where half are named;\n"
        "median error of the parameter at 3× and 10×; what was wrongly named instead.\n",
        table(("hidden", "1×", "3×", "10×", "half at", "error", "wrong names"), by_effect(scores)),
        "### By the hidden machine's friction\n",
        table(("friction", "named at 3× and 10×", "… and closed to 1.2", "null: nothing missing", "null: false name"), by_form(scores)),
        "### By sensors\n",
        table(("chamber pressures", "named at 3× and 10×"), by_sensors(scores)),
        "### Baselines on the same cases\n\n" + _baselines(cases, found),
    ]
    return "\n".join(parts)


def _asked(scores: Sequence[Score], found: Results) -> list[Demand]:
    """What is asked, and what was seen on the cases scored."""
    resolved = _resolved([s.case for s in scores], found).text()
    return [*demands(scores, found), ("look-alikes: resolved by the proposed maneuver", "≥ 90 %", resolved)]


def _by_version(found: Results) -> dict[str, Results]:
    """Results by the commit that gave them, in the order in which they ran."""
    commits = dict.fromkeys(str(r["commit"]) for r in sorted(found.values(), key=lambda r: str(r["date"])))
    return {commit: {name: r for name, r in found.items() if r["commit"] == commit} for commit in commits}


def _version_by_version(scores: Sequence[Score], found: Results) -> str:
    """The same of every version, where there are several."""
    versions = _by_version(found)
    if len(versions) < 2:
        return ""
    columns = [_asked([s for s in scores if s.case.name in own], own) for own in versions.values()]
    rows = [[question, *(column[n][2].split(",")[0] for column in columns)] for n, (question, _, _) in enumerate(columns[0])]
    text = """### Version by version

The search was changed on the way. Each version ran cases that nobody had seen, in their order; what was
[declared](../../tests/blind/study/README.md) says why it was changed.
"""
    return "\n".join([text, table(("question", *versions), [["cases", *(str(len(own)) for own in versions.values())], *rows])])


def _probabilities(cases: Sequence[Case], found: Results, docs: Path) -> str:
    """Of the names said with a probability, how many were right."""
    names = reliability.said_names({case.name: case for case in cases}, found)
    made = reliability.bins(names)
    reliability.diagram(made, docs / "pictures" / "blind_reliability.png")
    picture = "![share of right names over the probability said](../pictures/blind_reliability.png)"
    return "\n".join(["## Probabilities\n", *reliability.table(made), "", *reliability.table_by_place(names), "", picture, ""])


def _beside(study: Path, earlier: Path, cases: Sequence[Case]) -> str:
    """What is asked, of both searches on the cases that both have, and these pair by pair."""
    found = [results(part) for part in (earlier, study)]
    common = [case for case in cases if all(case.name in own for own in found)]
    asked = [demands([score(case, own[case.name]) for case in common], own) for own in found]
    both = [(text, limit, seen, other) for (text, limit, seen), (_, _, other) in zip(*asked, strict=True)]
    gates, evidence = (", ".join(sorted({str(own[case.name]["commit"]) for case in common})) for own in found)
    said = f"""## Beside the search before

A search by gates of the hold-out ({gates}) and one by evidence ({evidence}) ran {len(common)} of these cases. What
would decide between the two was [declared before](../../tests/blind/study/README.md) either was scored; the
search by gates is gone since. A: gates, B: evidence.
"""
    return "\n".join([said, *paired.table(paired.pairs(earlier, study)), "", table(("", "asked", "gates", "evidence"), both)])


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
