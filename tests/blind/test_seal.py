"""Sealed answers open unchanged or not at all."""

from __future__ import annotations

import hashlib
from collections import Counter
from pathlib import Path

import pytest

from tests.blind.cases import CONSTANTS, FORMS, PLACES, Case, Size, cases
from tests.blind.seal import ANSWERS, HASH, BrokenSealError, published, seal, unseal
from tests.blind.truth.effects import STRANGE

SIZES = {(*place, form, chambers): Size(0.01, 0.0, 1.0) for place in PLACES for form in FORMS for chambers in (False, True)}


def drawn(seed: int = 5) -> list[Case]:
    return cases(seed, SIZES)


def test_what_was_sealed_comes_out(tmp_path: Path) -> None:
    before = drawn()
    digest = seal(tmp_path, before, 5)
    assert unseal(tmp_path) == before
    assert published(tmp_path)[0] == digest == hashlib.sha256((tmp_path / ANSWERS).read_bytes()).hexdigest()


def test_a_changed_answer_is_refused(tmp_path: Path) -> None:
    seal(tmp_path, drawn(), 5)
    answers = tmp_path / ANSWERS
    answers.write_text(answers.read_text().replace("coulomb_friction", "viscous_friction", 1))
    with pytest.raises(BrokenSealError, match="published"):
        unseal(tmp_path)


def test_a_seal_is_not_overwritten(tmp_path: Path) -> None:
    first = seal(tmp_path, drawn(), 5)
    with pytest.raises(FileExistsError):
        seal(tmp_path, drawn(6), 6)
    assert (tmp_path / HASH).read_text().startswith(first)


def test_the_same_cases_have_another_hash_each_time(tmp_path: Path) -> None:
    assert seal(tmp_path / "a", drawn(), 5) != seal(tmp_path / "b", drawn(), 5)


def test_a_study_has_what_the_protocol_asks_for() -> None:
    every = drawn()
    assert drawn() == every
    assert drawn(6) != every
    singles = [c for c in every if c.group == "single"]
    assert len({c.truth[0][0] for c in singles}) >= 20
    null = [c for c in every if c.group == "null"]
    assert sum(c.setting.jitter for c in null) == len(null) // 2
    strange = [c for c in every if c.group == "out_of_library"]
    count = Counter(c.group for c in every)
    least = {"single": 120, "null": 60, "pair": 40, "out_of_library": 30, "look_alike": 30, "changed": 40, "two_logs": 20}
    assert all(count[group] >= wanted for group, wanted in least.items())
    assert all((c.second_fit is not None) == (c.group == "two_logs") for c in every)
    assert {c.setting.hidden[0].effect for c in strange} == set(STRANGE) - set(CONSTANTS)


def test_the_first_cases_have_a_share_of_every_group() -> None:
    first = {c.group for c in drawn()[:20]}
    assert first == {"single", "null", "pair", "out_of_library", "look_alike", "changed", "two_logs"}


def test_names_of_cases_tell_nothing() -> None:
    assert all(set(c.name) <= set("case-0123456789") for c in drawn())
