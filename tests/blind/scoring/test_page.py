"""The page of a study made by hand whose counts are known, with an earlier search on the same cases."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from matplotlib.image import imread

from tests.blind.cases import FIT, HOLDOUT, Case
from tests.blind.result_file import ALL
from tests.blind.scoring.asked import demands
from tests.blind.scoring.page import EARLIER, SECOND, write_page
from tests.blind.scoring.score import score
from tests.blind.seal import seal
from tests.blind.truth.session import Hidden, Setting

FRICTION = Hidden("coulomb_friction", "rotary", 20.0)
WRONG = "gravity"
GROUPS = [
    ("null", (), 0.0), ("null", (), 0.0), ("single", (FRICTION,), 3.0), ("single", (FRICTION,), 10.0), ("single", (FRICTION,), 1.0),
    ("changed", (FRICTION,), 0.25), ("changed", (FRICTION,), 2.0),
]  # fmt: skip
CASES = [Case(f"case-{k:04d}", group, Setting(k, hidden), (), multiple, FIT, HOLDOUT) for k, (group, hidden, multiple) in enumerate(GROUPS)]


def result(case: Case, verdict: str, *names: tuple[str, float, float]) -> dict[str, Any]:
    """`names`: effect, value, probability; the interval is ±1."""
    found = [
        {"effect": effect, "where": "rotary", "confirmed": p > 0.99, "probability": p, "look_alikes": [],
         "parameters": {"friction": {"value": value, "unit": "N*m", "ci95": [value - 1.0, value + 1.0]}}}
        for effect, value, p in names
    ]  # fmt: skip
    rest = {
        "resolved": None,
        "commit": "abc1234",
        "finder": "f00d",
        "date": "2026-11-25 20:00",
        "processor_s": 60.0,
        "gap": {"holdout_after": 1.0},
    }
    return rest | {"name": case.name, "verdict": verdict, "findings": found}


GOOD = [
    result(CASES[0], "no_gap"),
    result(CASES[1], "named", (WRONG, 1.0, 0.7)),
    result(CASES[2], "named", (FRICTION.effect, 20.5, 1.0)),
    result(CASES[3], "named", (FRICTION.effect, 22.0, 1.0)),
    result(CASES[4], "parameter_mismatch"),
    result(CASES[5], "named", (FRICTION.effect, 21.0, 1.0)),
    result(CASES[6], "named", (FRICTION.effect, 40.0, 1.0)),
]


def test_what_is_asked_is_counted_group_by_group() -> None:
    found = {r["name"]: r for r in GOOD}
    seen = {text: value for text, _, value in demands([score(c, found[c.name]) for c in CASES], found)}
    starts = [value.split(",")[0] for value in seen.values()]
    assert starts == [
        "1 of 2", "0 of 2", "1 of 2",  # healthy: one is quiet, the other has a tentative name of 0.7
        "2 of 2", "2 of 2", "0 of 1",  # single effects
        "–", "–",  # no pair, none out of the library
        "1 of 1", "0 of 7",  # one number has changed four times, the other twice
        "6.2% of 2", "1 of 2",  # 2.5 and 10 % off; the second interval ends at 21
    ]  # fmt: skip


def test_the_page_has_both_searches_and_the_picture(tmp_path: Path) -> None:
    study = tmp_path / "study"
    seal(study, CASES, 7)
    for search, lines in zip((EARLIER, "evidence"), ([result(c, "unknown") for c in CASES[:6]], GOOD), strict=True):
        (study / search).mkdir()
        (study / search / ALL).write_text("".join(json.dumps(line) + "\n" for line in lines))
    write_page(study / "evidence", tmp_path)
    text = (tmp_path / "results" / "blind.md").read_text()
    assert "(abc1234) ran 6 of these cases" in text
    assert "| null | 2 | 2 | 1 |" in text  # an `unknown` without a name is right, but not quiet
    assert "| nothing missing: `no_gap` or `parameter_mismatch` | ≥ 90 % | 0 of 2, 0% (0 to 66) | 1 of 2, 50% (9 to 91) |" in text
    assert "| case-0001 | null | nothing (0×) | named | gravity at rotary |" in text
    assert imread(tmp_path / "pictures" / "blind_reliability.png").std() > 0.01


def test_a_second_study_stands_beside_the_first(tmp_path: Path) -> None:
    study, second = tmp_path / "study", tmp_path / SECOND
    for folder, lines in ((study, GOOD), (second, [result(c, "unknown") for c in CASES[:2]])):
        seal(folder, CASES, 7)
        (folder / ALL).write_text("".join(json.dumps(line) + "\n" for line in lines))
    (study / "evidence").mkdir()
    (study / ALL).rename(study / "evidence" / ALL)
    write_page(study / "evidence", tmp_path)
    part = (tmp_path / "results" / "blind.md").read_text().split("## The second study")[1]
    assert "**2 of 7 cases run** (2 null, 0 single, 0 changed)" in part
    assert "| nothing missing: `no_gap` or `parameter_mismatch` | ≥ 90 % | 1 of 2, 50% (9 to 91) | 0 of 2, 0% (0 to 66) |" in part
