"""docs/results/blind.md from the results: everything on it is counted from files of the study, nothing is written by hand.

The numbers are those of all cases, and of every version of the search on its own. Beside them stand, where there are results of them:
the second study, of later versions, in `second` beside the study's folder; and the search by gates and the version that was compared with
it, on the cases that both have, in `gates` beside the study's results.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from textwrap import fill
from typing import Any

from tests.blind.baselines import METHODS
from tests.blind.cases import Case
from tests.blind.result_file import results
from tests.blind.scoring import paired
from tests.blind.scoring.asked import Demand, demands
from tests.blind.scoring.pictures import confusion, power
from tests.blind.scoring.probabilities import reliability
from tests.blind.scoring.score import score
from tests.blind.scoring.scored import Scored, scored
from tests.blind.scoring.tables import Share, by_effect, by_form, by_sensors, failures, of_group, share, table

DOCS = Path(__file__).parents[3] / "docs"
TITLE = "How the search fares with a machine it does not know"
PROTOCOL = Path(__file__).with_name("protocol.md")
EARLIER, SECOND = "gates", "second"  # folders beside the study's results, and beside the study


def write_page(study: Path, docs: Path = DOCS) -> None:
    """Score and write. To do that opens the seal."""
    first, earlier, second = scored(study), study.with_name(EARLIER), study.parents[1] / SECOND
    for draw, name in ((confusion, "confusion"), (power, "power")):
        draw(first.scores, docs / "pictures" / f"blind_{name}.png")
    drawn = docs / "pictures" / "blind_reliability.png"
    parts = [_head(first), PROTOCOL.read_text(), _numbers(first), "## Probabilities\n", _probabilities(first, drawn)]
    if results(second):
        parts.append(_second(first, scored(second), docs / "pictures" / "blind_second_reliability.png"))
    if results(earlier):
        parts.append(_beside(study, earlier, first.cases))
    page = docs / "results" / "blind.md"
    page.parent.mkdir(exist_ok=True)
    page.write_text("\n".join([*parts, "## Failures\n", _failures(first)]))


def _head(first: Scored) -> str:
    head = f"""# {TITLE}

You will have: what the search for missing physics gets right and wrong on hidden effects, with how many cases each number rests on.
Written by `make blind`; do not edit.

{first.run_words}
"""
    return _wrapped(head)


def _wrapped(text: str) -> str:
    return "\n".join(fill(line, 110, break_long_words=False, break_on_hyphens=False) for line in text.split("\n"))


def _numbers(study: Scored) -> str:
    scores = study.scores
    parts = [
        "## What came out\n\nIn brackets: Wilson's 95 % interval in percent.\n",
        table(("question", "asked", "seen"), _asked(study)),
        _version_by_version(study, "Version by version", "study"),
        "![Share named over the size](../pictures/blind_power.png)\n",
        "![Hidden effect against first name](../pictures/blind_confusion.png)\n",
        "### By effect\n\nNamed (first or in its set) of cases run, at 1, 3 and 10 smallest visible sizes; where half are named;\n"
        "median error of the parameter at 3× and 10×; what was wrongly named instead.\n",
        table(("hidden", "1×", "3×", "10×", "half at", "error", "wrong names"), by_effect(scores)),
        "### By the hidden machine's friction\n",
        table(("friction", "named at 3× and 10×", "… and closed to 1.2", "null: nothing missing", "null: false name"), by_form(scores)),
        "### By sensors\n",
        table(("chamber pressures", "named at 3× and 10×"), by_sensors(scores)),
        "### Baselines on the same cases\n\n" + _baselines(study),
    ]
    return "\n".join(parts)


def _asked(study: Scored) -> list[Demand]:
    """What is asked, and what was seen on the cases scored."""
    resolved = _resolved(study).text()
    return [*demands(study.scores, study.found), ("look-alikes: resolved by the proposed maneuver", "≥ 90 %", resolved)]


def _version_by_version(study: Scored, heading: str, folder: str) -> str:
    """The same of every version, where there are several. `folder`: of the study, where its versions are declared."""
    versions = study.by_version
    if len(versions) < 2:
        return ""
    columns = [_asked(own) for own in versions.values()]
    rows = [[question, *(column[n][2].split(",")[0] for column in columns)] for n, (question, _, _) in enumerate(columns[0])]
    text = f"""### {heading}

The search was changed on the way. Each version ran cases that nobody had seen, in their order; what was
[declared](../../tests/blind/{folder}/README.md) says why it was changed.
"""
    return "\n".join([text, table(("question", *versions), [["cases", *(str(len(own.found)) for own in versions.values())], *rows])])


def _probabilities(study: Scored, picture: Path) -> str:
    """Of the names said with a probability, how many were right."""
    names = reliability.said_names({case.name: case for case in study.cases}, study.found)
    made = reliability.bins(names)
    reliability.diagram(made, picture)
    drawn = f"![share of right names over the probability said](../pictures/{picture.name})"
    return "\n".join([*reliability.table(made), "", *reliability.table_by_place(names), "", drawn, ""])


def _second(first: Scored, second: Scored, drawn: Path) -> str:
    """What later versions get right and wrong on cases of their own, beside the first study."""
    head = f"""## The second study

Each version is [declared](../../tests/blind/second/README.md) before its cases are run; asymmetric friction is one that seals can have.

{second.run_words}
"""
    asked = table(("question", "asked", "first study", "second study"), _side_by_side(_asked(first), _asked(second)))
    versions = _version_by_version(second, "Its versions", SECOND)
    return "\n".join([_wrapped(head), asked, versions, _probabilities(second, drawn), _failures(second)])


def _side_by_side(one: Sequence[Demand], other: Sequence[Demand]) -> list[tuple[str, str, str, str]]:
    return [(question, limit, seen, beside) for (question, limit, seen), (_, _, beside) in zip(one, other, strict=True)]


def _beside(study: Path, earlier: Path, cases: Sequence[Case]) -> str:
    """What is asked, of both searches on the cases that both have, and these pair by pair."""
    found = [results(part) for part in (earlier, study)]
    common = [case for case in cases if all(case.name in own for own in found)]
    asked = [demands([score(case, own[case.name]) for case in common], own) for own in found]
    gates, evidence = (", ".join(sorted({str(own[case.name]["commit"]) for case in common})) for own in found)
    said = f"""## Beside the search before

A search by gates of the hold-out ({gates}) and one by evidence ({evidence}) ran {len(common)} of these cases. What
would decide between the two was [declared before](../../tests/blind/study/README.md) either was scored; the
search by gates is gone since. A: gates, B: evidence.
"""
    return "\n".join(
        [said, *paired.table(paired.pairs(earlier, study)), "", table(("", "asked", "gates", "evidence"), _side_by_side(*asked))]
    )


def _resolved(study: Scored) -> Share:
    """Of the sets with a proposed maneuver that was then run: how many ended with the right name alone."""
    rounds = [(s.case, again) for s in study.scores if (again := study.found[s.case.name].get("resolved"))]
    good = [bool(again["findings"]) and not again["findings"][0]["look_alikes"] and score(case, again).in_set for case, again in rounds]
    return Share(sum(good), len(good))


def _baselines(study: Scored) -> str:
    rows = []
    for method, title in {"search": "this search", **METHODS}.items():
        judged = [score(s.case, _as_findings(study.found[s.case.name], method)) for s in study.scores]
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


def _failures(study: Scored) -> str:
    rows = failures(study.scores)
    if not rows:
        return "None among the cases run.\n"
    text = f"All {len(rows)} cases at 3× and more that did not come out as they should.\n\n"
    return text + table(("case", "group", "hidden", "verdict", "wrong names"), rows)
