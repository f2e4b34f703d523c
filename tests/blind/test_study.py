"""A study goes on where it stopped, and the page counts what its files say."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from blind.__main__ import results, waiting
from blind.cases import PLACES, Case, Size, cases, sizes
from blind.one_case import finder_digest, rig_text
from blind.page import write_page
from blind.seal import published, seal, unseal
from config.load import rig_from_text

SIZES = {place: Size(0.01, 0.0, 1.0) for place in PLACES}


def result(case: Case, finder: str) -> dict[str, Any]:
    """As if every hidden effect of the library were found; null cases quiet, the others unknown."""
    found = [
        {"effect": e, "where": w, "confirmed": True, "parameters": {"p": {"value": h.value}}, "look_alikes": []}
        for (e, w), h in zip(case.truth, case.setting.hidden, strict=False)
    ]
    verdict = "named" if found else "no_gap" if case.group == "null" else "unknown"
    return {
        "name": case.name, "verdict": verdict, "findings": found, "gap": {"holdout_after": 1.0}, "finder": finder, "commit": "abc",
        "date": "2026-01-01 00:00", "seconds": 1.0, "resolved": None, "baselines": {"refit": [], "stlsq": [], "bic": []},
    }  # fmt: skip


@pytest.fixture
def study(tmp_path: Path) -> Path:
    drawn = cases(5, SIZES)
    seal(tmp_path, drawn, 5)
    (tmp_path / "results").mkdir()
    for number, case in enumerate(drawn[:40]):
        finder = finder_digest() if number % 2 else "older"
        (tmp_path / "results" / f"{case.name}.json").write_text(json.dumps(result(case, finder)))
    return tmp_path


def test_cases_with_a_result_are_not_run_again(study: Path) -> None:
    every = unseal(study)
    assert waiting(study, every, again=False) == every[40:]
    assert waiting(study, every, again=True) == [*every[0:40:2], *every[40:]]


def test_page_shows_hash_counts_and_pictures(study: Path, tmp_path: Path) -> None:
    docs = tmp_path / "docs"
    docs.mkdir()
    write_page(study, unseal(study), results(study), docs)
    text = (docs / "blind.md").read_text()
    assert published(study)[0] in text
    assert "**40 of 670 cases run**" in text
    assert "None among the cases run" in text
    assert (docs / "pictures" / "blind_power.png").stat().st_size > 1000
    assert (docs / "pictures" / "blind_confusion.png").stat().st_size > 1000


def test_the_finder_gets_a_rig_without_the_hidden_effect() -> None:
    for case in cases(5, sizes()):
        if case.group == "single" and case.truth[0][0] == "coulomb_friction":
            text = rig_text(case)
            rig = rig_from_text(text)
            assert rig.plant is not None
            assert ("coulomb_friction", "rotary") not in {(e.effect, e.where) for e in rig.plant.effects}
            assert ("rotary.pressure_a" in rig.plant.sensors) is case.setting.chambers
            assert case.name not in text


def test_sizes_cover_every_place_that_is_scaled() -> None:
    known = sizes()
    assert all(size.visible and abs(size.visible) <= size.limit for size in known.values())
    assert len({case.truth[0] for case in cases(5, known) if case.group == "single"}) == len(PLACES)
