"""The paired table on studies made by hand."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest
from scipy.stats import binomtest

from tests.blind.cases import FIT, HOLDOUT, Case
from tests.blind.result_file import ALL
from tests.blind.scoring.paired import pairs, table, worse
from tests.blind.seal import seal
from tests.blind.truth.session import Setting

NOTHING: dict[str, Any] = {"findings": [], "gap": {"holdout_after": 1.0}}
WRONG = {"effect": "gravity", "where": "rotary", "confirmed": True, "parameters": {}, "look_alikes": []}


def study(folder: Path, seed: int, verdicts: list[str]) -> Path:
    """Effect-free cases; a search that says `named` has a wrong confirmed name."""
    cases = [Case(f"case-{k:04d}", "null", Setting(seed + k), (), 0.0, FIT, HOLDOUT) for k in range(len(verdicts))]
    seal(folder, cases, seed)
    lines = [
        NOTHING | {"name": case.name, "verdict": word, "processor_s": 7.0, "findings": [WRONG] if word == "named" else []}
        for case, word in zip(cases, verdicts, strict=True)
    ]
    (folder / ALL).write_text("".join(json.dumps(line) + "\n" for line in lines))
    return folder


def test_counts_of_two_studies_of_the_same_cases(tmp_path: Path) -> None:
    a = study(tmp_path / "a", 7, ["unknown", "unknown", "named", "no_gap"])
    b = study(tmp_path / "b", 7, ["no_gap", "named", "parameter_mismatch", "no_gap"])
    rows = list(table(pairs(a, b)))
    assert rows[2] == "| null | 4 | 3 | 3 | 1 | 1 | 0.750 | 1 | 3 | 1 | 1 | 7.0 | 7.0 |"
    assert rows[3].startswith("| all | 4 |")


def test_only_cases_that_both_have_and_that_are_the_same(tmp_path: Path) -> None:
    a, b = study(tmp_path / "a", 7, ["no_gap", "no_gap"]), study(tmp_path / "b", 7, ["no_gap"])
    assert len(pairs(a, b)) == 1
    with pytest.raises(ValueError, match="--seed"):
        pairs(a, study(tmp_path / "c", 8, ["no_gap"]))


@pytest.mark.parametrize(("only_a", "only_b"), [(0, 0), (1, 0), (5, 1), (2, 9)])
def test_p_against_scipy_s_test(only_a: int, only_b: int) -> None:
    expected = binomtest(only_a, only_a + only_b, 0.5, "greater").pvalue if only_a + only_b else 1.0
    assert worse(only_a, only_b) == pytest.approx(expected)
