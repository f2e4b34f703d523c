"""Two whole cases on the machine of other code, with the search's own friction law and exact constants: what must hold in any study."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from tests.blind.baselines import METHODS
from tests.blind.cases import Case
from tests.blind.one_case import Work, run_case
from tests.blind.scoring.score import Score, right, score
from tests.blind.truth.friction import BRISTLE
from tests.blind.truth.session import Hidden, Setting

FIT, HOLDOUT = ("strokes+multisine", 10.0), ("stairs", 7.0)


def judged(tmp_path: Path, hidden: tuple[Hidden, ...]) -> Score:
    removed = tuple((h.effect, h.where) for h in hidden)
    setting = Setting(900_777, hidden, False, BRISTLE)
    case = Case("case-0000", "single" if hidden else "null", setting, removed, 10.0 if hidden else 0.0, FIT, HOLDOUT)
    run_case(Work(case.as_json(), str(tmp_path / "case-0000.json"), threads=2))
    result = json.loads((tmp_path / "case-0000.json").read_text())
    assert set(result["baselines"]) == set(METHODS)
    assert [path.name for path in tmp_path.iterdir()] == ["case-0000.json"]
    return score(case, result)


@pytest.mark.slow
@pytest.mark.long  # as tests/gap/test_find_arm.py, on the hidden machine
@pytest.mark.timeout(900)
def test_a_link_that_bends_is_named(tmp_path: Path) -> None:
    seen = judged(tmp_path, (Hidden("link_flexibility", "link", 3556.75),))
    assert right(seen)
    assert seen.parameter_error is not None
    assert seen.parameter_error < 0.1


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_nothing_is_confirmed_where_nothing_is_hidden(tmp_path: Path) -> None:
    seen = judged(tmp_path, ())
    assert not seen.refused
    assert seen.wrong_confirmed == ()
