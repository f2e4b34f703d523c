"""Scores of results made by hand."""

from __future__ import annotations

from typing import Any

import pytest

from tests.blind.cases import FIT, HOLDOUT, Case
from tests.blind.scoring.score import right, score
from tests.blind.scoring.tables import Share, by_effect, share
from tests.blind.truth.session import Hidden, Setting

COULOMB, DEADBAND = ("coulomb_friction", "rotary"), ("valve_deadband", "rotary")


def case(group: str = "single", *hidden: Hidden, multiple: float = 3.0) -> Case:
    return Case("case-0000", group, Setting(1, hidden), tuple((h.effect, h.where) for h in hidden), multiple, FIT, HOLDOUT)


def finding(name: tuple[str, str], *alike: tuple[str, str], value: float = 1.0, confirmed: bool = True) -> dict[str, Any]:
    parameters = {"friction": {"value": value, "unit": "N*m", "ci95": [0, 1]}}
    others = [{"effect": e, "where": w} for e, w in alike]
    return {"effect": name[0], "where": name[1], "confirmed": confirmed, "parameters": parameters, "look_alikes": others}


def result(verdict: str, *found: dict[str, Any], after: float = 1.0) -> dict[str, Any]:
    return {"verdict": verdict, "findings": list(found), "gap": {"holdout_after": after}}


HIDDEN = Hidden(*COULOMB, 20.0)


def test_right_name_alone() -> None:
    s = score(case("single", HIDDEN), result("named", finding(COULOMB, value=22.0)))
    assert (s.first, s.in_set, s.all_named, s.wrong, s.closed) == (True, True, True, (), True)
    assert s.parameter_error == pytest.approx(0.1)
    assert right(s)


def test_right_name_among_look_alikes() -> None:
    s = score(case("single", HIDDEN), result("ambiguous", finding(DEADBAND, COULOMB, confirmed=False), after=1.3))
    assert (s.first, s.in_set, s.wrong, s.closed, s.parameter_error) == (False, True, (), False, None)
    assert right(s)


def test_right_effect_at_the_wrong_joint_is_wrong() -> None:
    s = score(case("single", HIDDEN), result("named", finding(("coulomb_friction", "prismatic"))))
    assert not s.in_set
    assert s.wrong_confirmed == (("coulomb_friction", "prismatic"),)


def test_right_name_second_does_not_count_as_first() -> None:
    s = score(case("single", HIDDEN), result("named", finding(DEADBAND), finding(COULOMB)))
    assert (s.first, s.in_set, s.all_named, s.wrong) == (False, False, True, (DEADBAND,))


def test_null_cases() -> None:
    quiet = score(case("null"), result("no_gap"))
    assert right(quiet)
    assert not quiet.flagged
    loud = score(case("null"), result("named", finding(COULOMB)))
    assert not right(loud)
    assert loud.wrong_confirmed == (COULOMB,)
    doubtful = score(case("null"), result("unknown", finding(COULOMB, confirmed=False)))
    assert doubtful.wrong == (COULOMB,)
    assert doubtful.wrong_confirmed == ()


def test_a_refusal_is_not_right() -> None:
    assert not right(score(case("null"), {"verdict": "refused", "findings": [], "gap": None}))


def test_pairs_need_both() -> None:
    both = case("pair", HIDDEN, Hidden(*DEADBAND, 0.02))
    assert right(score(both, result("named", finding(COULOMB), finding(DEADBAND))))
    assert not right(score(both, result("named", finding(COULOMB))))


def test_out_of_library() -> None:
    strange = case("out_of_library", Hidden("pump_pulsation", "rotary", 1.0))
    assert strange.truth == ()
    assert right(score(strange, result("unknown")))
    assert right(score(strange, result("named", finding(COULOMB, confirmed=False))))
    assert not right(score(strange, result("named", finding(COULOMB))))
    assert not right(score(strange, result("no_gap")))


def test_counting() -> None:
    scores = [score(case("single", HIDDEN), result("named", finding(COULOMB, value=v))) for v in (20.0, 22.0, 30.0)]
    scores += [score(case("single", HIDDEN, multiple=1.0), result("no_gap"))]
    assert share(scores, lambda s: s.in_set) == Share(3, 4)
    assert by_effect(scores)[0][:4] == ["`coulomb_friction` rotary", "0/1", "3/3", "–"]
