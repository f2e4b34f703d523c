"""The reliability of names: honest probabilities pass, boastful ones do not, and only the name itself counts."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from matplotlib.image import imread

from gap.report.reliability import FURTHER, LEAD, SUREST
from tests.blind.cases import cases, sizes
from tests.blind.scoring.probabilities.reliability import SaidName, bins, by_place, diagram, said_names, table, table_by_place


def drawn(seed: int, boast: float) -> list[SaidName]:
    """A thousand names; said with a probability whose odds are `boast` times those with which they are right."""
    draw = np.random.default_rng(seed)
    true = draw.uniform(0.4, 1.0, 1000)
    odds = boast * true / (1.0 - true)
    return [SaidName(float(o / (1.0 + o)), bool(draw.random() < p)) for o, p in zip(odds, true, strict=True)]


def test_honest_probabilities_are_kept_in_95_of_100_bins() -> None:
    made = [b for seed in range(50) for b in bins(drawn(seed, 1.0))]
    assert len(made) == 200
    assert 0.92 <= np.mean([b.kept for b in made]) <= 1.0


def test_boastful_probabilities_are_seen() -> None:
    assert not all(b.kept for b in bins(drawn(1, 5.0)))


def test_every_name_is_in_one_bin_also_the_certain_one() -> None:
    made = bins([SaidName(p, True) for p in (0.3, 0.5, 0.79, 0.8, 0.95, 0.99, 1.0)])
    assert [(b.low, b.names) for b in made] == [(0.5, 2), (0.8, 1), (0.95, 1), (0.99, 2)]  # below a half no name is said
    assert [b.right for b in made] == [2, 1, 1, 2]
    assert bins([]) == []


def test_a_lead_is_no_name() -> None:
    names = [SaidName(0.99, True), SaidName(0.99, False, LEAD), SaidName(0.6, False, LEAD)]
    assert [(b.low, b.names, b.right) for b in bins(names)] == [(0.99, 1, 1)]
    assert by_place(names)[LEAD] == {0.99: (0, 1), 0.5: (0, 1)}


def test_a_right_look_alike_makes_no_name_right() -> None:
    case = next(c for c in cases(1, sizes()) if c.group == "single")
    (effect, where), *_ = case.truth
    alike = [{"effect": effect, "where": where}]
    wrong = {"effect": "none_such", "where": where, "probability": 0.9, "look_alikes": alike}
    right = {"effect": effect, "where": where, "probability": 0.6, "look_alikes": []}
    by_eye = {"effect": effect, "where": where, "look_alikes": []}
    found = {"verdict": "named", "findings": [by_eye, right], "leads": [wrong]}
    assert said_names({case.name: case}, {case.name: found}) == [SaidName(0.6, True, FURTHER), SaidName(0.9, False, SUREST)]
    under_unknown = said_names({case.name: case}, {case.name: found | {"verdict": "unknown"}})
    assert [name.place for name in under_unknown] == [LEAD, LEAD]


def test_names_are_counted_by_where_they_stand() -> None:
    names = [SaidName(1.0, True), SaidName(0.99, False), SaidName(0.7, True), SaidName(0.4, True), SaidName(0.98, False, FURTHER)]
    counted = by_place(names)
    assert counted[SUREST] == {0.99: (1, 2), 0.5: (1, 1)}
    assert counted[FURTHER] == {0.99: (0, 0), 0.5: (0, 1)}
    assert table_by_place(names)[2] == f"| {SUREST} | 1 of 1 | 1 of 2 |"


def test_table_and_picture(tmp_path: Path) -> None:
    made = bins(drawn(2, 1.0))
    rows = list(table(made))
    assert [row.count("|") for row in rows] == [7] * (2 + len(made))
    assert rows[2].startswith("| 0.5 to 0.8 |")
    diagram(made, tmp_path / "diagram.png")
    assert imread(tmp_path / "diagram.png").std() > 0.01
