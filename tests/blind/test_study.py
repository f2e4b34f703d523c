"""A study goes on where it stopped, and the page counts what its files say."""

from __future__ import annotations

import json
from collections import Counter
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from config.loading.load import load_rig, rig_from_text
from gap.report.reliability import RIGHT_OF
from tests.blind.__main__ import STUDY, waiting
from tests.blind.cases import BY_HAND, FORMS, PLACES, RIG, Case, Size, cases, sizes
from tests.blind.changed_numbers import stated
from tests.blind.one_case import finder_digest, rig_text
from tests.blind.result_file import ALL, ENDED, gather, of_case, results
from tests.blind.scoring.page import DOCS, write_page
from tests.blind.scoring.probabilities.reliability import by_place, said_names
from tests.blind.seal import published, seal, unseal
from tests.blind.truth.session import Setting, numbers_of

SIZES = {(*place, form, chambers): Size(0.01, 0.0, 1.0) for place in PLACES for form in FORMS for chambers in (False, True)}


def result(case: Case, finder: str) -> dict[str, Any]:
    """As if every hidden effect of the library were found; null cases quiet, the others unknown."""
    found = [
        {"effect": e, "where": w, "confirmed": True, "parameters": {"p": {"value": h.value}}, "look_alikes": []}
        for (e, w), h in zip(case.truth, case.setting.hidden, strict=False)
    ]
    verdict = "named" if found else "no_gap" if case.group == "null" else "unknown"
    date = "2026-01-01 00:00" if finder == "older" else "2026-01-02 00:00"
    return {
        "name": case.name, "verdict": verdict, "findings": found, "gap": {"holdout_after": 1.0}, "finder": finder, "date": date,
        "commit": "abc" if finder == "older" else "def", "processor_s": 2.0, "resolved": None,
        "baselines": {"refit": [], "stlsq": [], "bic": []},
    }  # fmt: skip


@pytest.fixture
def study(tmp_path: Path) -> Path:
    drawn, folder = cases(5, SIZES), tmp_path / "study"
    seal(folder, drawn, 5)
    (folder / ENDED).mkdir()
    for number, case in enumerate(drawn[:40]):
        finder = finder_digest() if number % 2 else "older"
        of_case(folder, case.name).write_text(json.dumps(result(case, finder)))
    return folder


def test_cases_with_a_result_are_not_run_again(study: Path) -> None:
    every = unseal(study)
    assert waiting(study, every, again=False) == every[40:]
    assert waiting(study, every, again=True) == [*every[0:40:2], *every[40:]]


def test_results_of_single_cases_become_one_file_that_says_the_same(study: Path) -> None:
    before = results(study)
    gather(study)
    assert results(study) == before
    assert not list((study / ENDED).iterdir())
    assert [json.loads(line)["name"] for line in (study / ALL).read_text().splitlines()] == sorted(before)


def test_a_case_that_is_run_again_takes_the_place_of_its_line(study: Path) -> None:
    gather(study)
    name, older = next(iter(results(study).items()))
    of_case(study, name).write_text(json.dumps({**older, "seconds": 77.0}))
    assert results(study)[name]["seconds"] == 77.0
    gather(study)
    assert results(study)[name]["seconds"] == 77.0
    assert len((study / ALL).read_text().splitlines()) == 40


def test_page_shows_hash_counts_and_pictures(study: Path, tmp_path: Path) -> None:
    docs = tmp_path / "docs"
    docs.mkdir()
    write_page(study, docs)
    text = (docs / "results" / "blind.md").read_text()
    assert published(study)[0] in text
    assert f"**40 of {len(unseal(study))} cases run**" in text
    assert "| question | abc | def |" in text  # in the order in which they ran
    assert "| cases | 20 | 20 |" in text
    assert "None among the cases run" in text
    assert (docs / "pictures" / "blind_power.png").stat().st_size > 1000
    assert (docs / "pictures" / "blind_confusion.png").stat().st_size > 1000


def test_the_committed_page_is_made_from_the_committed_results(tmp_path: Path) -> None:
    write_page(STUDY, tmp_path)
    assert (tmp_path / "results" / "blind.md").read_text() == (DOCS / "results" / "blind.md").read_text()


def test_reports_say_how_often_the_study_found_names_right() -> None:
    assert by_place(said_names({case.name: case for case in unseal(STUDY)}, results(STUDY))) == RIGHT_OF


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
    wanted = {(*place, form, chambers) for place in PLACES if place[0] not in BY_HAND for form in FORMS for chambers in (False, True)}
    assert set(known) == wanted
    assert len({case.truth[0] for case in cases(5, known) if case.group == "single"}) == len(PLACES)


def test_a_study_that_is_stopped_early_has_run_cases_of_every_kind() -> None:
    early = cases(5, SIZES)[:73]
    single = [case for case in early if case.group == "single"]
    expected = {"single": 29, "null": 12, "pair": 8, "changed": 8, "out_of_library": 6, "look_alike": 6, "two_logs": 4}
    assert Counter(case.group for case in early) == expected
    assert {case.truth[0] for case in single} == set(PLACES)
    kinds = Counter((case.multiple, case.setting.chambers) for case in single)
    assert set(kinds) == {(3.0, False), (3.0, True), (10.0, False), (10.0, True)}
    assert min(kinds.values()) >= 7
    assert {case.setting.friction_form for case in single[:4]} == set(FORMS)


def test_every_effect_is_hidden_in_every_size_with_and_without_chamber_pressures() -> None:
    single = [case for case in cases(5, SIZES) if case.group == "single"]
    found = Counter((case.truth[0], case.multiple, case.setting.chambers) for case in single)
    kinds = [(multiple, chambers) for multiple in (3.0, 10.0) for chambers in (False, True)] + [(1.0, True)]
    assert found == {(place, *kind): 1 for place in PLACES for kind in kinds}


def test_a_changed_number_stays_in_the_rig_file_and_is_another_in_the_machine() -> None:
    rig = load_rig(RIG).rig
    plain = numbers_of(rig, Setting(1, jitter=False))
    for case in cases(5, SIZES):
        if case.group == "changed":
            (hidden,) = case.setting.hidden
            assert rig_text(replace(case, setting=replace(case.setting, chambers=False))) == load_rig(RIG).text
            assert case.multiple == pytest.approx(hidden.value / stated(rig, (hidden.effect, hidden.where)))
            assert max(case.multiple, 1.0 / case.multiple) >= 2.0
            there = numbers_of(rig, replace(case.setting, jitter=False))
            (key,) = (key for key in plain if there[key] != plain[key] and key != "friction_form")
            assert key.startswith(hidden.where)
            assert there[key] / plain[key] == pytest.approx(case.multiple)


def test_two_searches_share_the_answers_above_their_folders(tmp_path: Path) -> None:
    drawn = cases(5, SIZES)
    seal(tmp_path, drawn, 5)
    (tmp_path / "evidence").mkdir()
    assert unseal(tmp_path / "evidence") == drawn
    assert published(tmp_path / "evidence") == published(tmp_path)


def test_sizes_are_those_of_the_case_s_own_friction_and_sensors() -> None:
    known = {key: Size(0.001 * (1 + key[2]) * (2 if key[3] else 1), 0.0, 1.0) for key in SIZES}
    for case in cases(5, known):
        if case.group == "single" and case.truth[0][0] not in BY_HAND:
            setting = case.setting
            expected = case.multiple * 0.001 * (1 + setting.friction_form) * (2 if setting.chambers else 1)
            assert abs(setting.hidden[0].value) == pytest.approx(expected)
