"""What the report says of the blind test is what was counted there, or that nothing was."""

from __future__ import annotations

from pathlib import Path

from gap.report.naming_record import Tally, how_often_right, named_of, tallies

RECORD = (
    "cases:\n  - {effect: coulomb_friction, multiple: 3, right: 5, cases: 6}\n  - {effect: backlash, multiple: 3, right: 1, cases: 2}\n"
)


def test_the_nearest_size_in_factors_is_told(tmp_path: Path) -> None:
    path = tmp_path / "record.yaml"
    path.write_text(RECORD + "  - {effect: coulomb_friction, multiple: 10, right: 6, cases: 6}\n")
    record = tallies(path)
    assert record[0] == Tally("coulomb_friction", 3.0, 5, 6)
    said = how_often_right("coulomb_friction", 5.0, record)
    assert "at 3 times" in said
    assert "5 of 6 cases (all effects of that size: 6 of 8)" in said
    assert "at 10 times" in how_often_right("coulomb_friction", 6.0, record)
    assert [named_of(3.0, record=record), named_of(3.0, "backlash", record), named_of(10.0, "backlash", record)] == ["6 of 8", "1 of 2", ""]


def test_nothing_is_made_up(tmp_path: Path) -> None:
    assert tallies(tmp_path / "none.yaml") == ()
    assert "no blind-test record" in how_often_right("backlash", 3.0, ())
    assert "no sizes" in how_often_right("backlash", None, (Tally("backlash", 3.0, 1, 2),))
    assert "Not among the blind cases" in how_often_right("gravity", 3.0, (Tally("backlash", 3.0, 1, 2),))
