"""Which first trials are fitted further: a rival of the same signature is never dropped for a first fit that ended far off."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from benchmarks.gap.look_alike_cases import ONE_WAY
from benchmarks.gap.look_alikes import hidden_and_logged
from gap.find import find
from gap.search.search_state import GateSearch
from gap.search.select import search
from gap.search.settings import Settings
from tests.support.gap import axis_logs
from tests.support.gap.small_friction import OWN_N, Log, opened

FURTHER = ", own initial states"


def fitted_on(told: Sequence[str]) -> set[str]:
    """Effects that the first round of a search fits further."""
    first = told[: next(k for k, line in enumerate(told) if line.startswith("accepted"))]
    return {line.split(" at ")[0].strip() for line in first if FURTHER in line}


def searched(state: GateSearch) -> tuple[set[str], list[str]]:
    """What the first round fits further, and the signatures it begins with, the leading ones first."""
    told: list[str] = []
    found = search(state, told.append)
    assert found.first_screening is not None
    return fitted_on(told), [signature.candidate.effect for signature in found.first_screening.kept()]


@pytest.mark.slow
def test_where_one_solves_the_gap_no_other_signature_is_fitted_on(tmp_path: Path) -> None:
    """Not even the second of the order."""
    further, order = searched(opened(tmp_path, Log(0.5, 1), Log(0.5, 2, 3.0)))
    assert order[0] == "coulomb_friction"
    assert further == {"coulomb_friction"}


@pytest.mark.slow
def test_where_none_does_the_first_signatures_are(tmp_path: Path) -> None:
    """Noise that nothing explains keeps the best from solving it; the second is fitted on, whatever its first fit brought."""
    further, order = searched(opened(tmp_path, Log(0.5, 1), Log(0.5, 2, 3.0), Log(0.5, 3, 6.0, noise_um=4.0)))
    assert order[:2] == ["coulomb_friction", "asymmetric_friction"]
    assert len(order) > 4
    assert further == set(order[:2])


@pytest.mark.slow
def test_what_gains_nearly_as_much_is_fitted_on(tmp_path: Path) -> None:
    """Both frictions are missing, and each takes nine tenths of the gap."""
    text = axis_logs.axis_text("coulomb_friction", "viscous_friction")
    further, order = searched(opened(tmp_path, Log(OWN_N, 11), Log(OWN_N, 12), text=text))
    assert further == {"coulomb_friction", "viscous_friction"}
    assert len(order) > 4


@pytest.mark.slow
@pytest.mark.parametrize("time_constant", ["3 ms", "2 ms"])
def test_a_lag_is_not_taken_for_a_delay(tmp_path: Path, time_constant: str) -> None:
    """Two logs that move one way and hardly show it; both seen as a delay alone, confirmed, before. The first fit of the larger ends far
    off; the smaller has no size, since time constant and damping take each other's place."""
    number = next(k for k, case in enumerate(ONE_WAY.cases) if f"time_constant: {time_constant}, damping_ratio: 0.7" in case)
    _, logs, _ = hidden_and_logged(ONE_WAY, ONE_WAY.cases[number], 1000 + 10 * number, tmp_path)
    told: list[str] = []
    found = find(tmp_path / "model.yaml", logs[:1], logs[1:], tmp_path / "out", told.append, Settings(propose=False))
    (named,) = found.content["findings"]
    assert not named["confirmed"]
    assert {named["effect"], *(rival["effect"] for rival in named["look_alikes"])} == {"valve_lag", "transport_delay"}
    assert all(rival["holdout_gain"] > 0.5 for rival in named["look_alikes"])
    assert fitted_on(told) == {"valve_lag", "transport_delay"}
