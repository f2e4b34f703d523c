"""A suspect that is not proportional to its size is tried where it would just show too."""

from __future__ import annotations

import pytest

from config.loading.load import LoadedRig, rig_from_text
from gap.data.measured import load
from gap.evidence.opening import opening
from gap.evidence.promises import widened
from gap.evidence.screening import Screen, signatures_of
from gap.evidence.search_state import EvidenceSearch
from gap.evidence.stages import refitted
from gap.evidence.where_shown import first_lines, sizes_shown, taken_there
from gap.fitting.nuisance import nuisances
from gap.search.opening import experiments_of
from gap.search.settings import Settings
from gap.signatures.candidates import candidates
from tests.support.gap import axis_logs

SUSPECT, NEEDED = "valve_deadband at axis", 2.6
OVERLAP = 0.004


@pytest.fixture(scope="module")
def search(tmp_path_factory: pytest.TempPathFactory) -> EvidenceSearch:
    """The constants alone, fitted to a machine with a dead band that just shows."""
    folder, text = tmp_path_factory.mktemp("logs"), axis_logs.axis_text()
    true = rig_from_text(
        text.replace("  effects:\n", f"  effects:\n    - {{effect: valve_deadband, where: axis, overlap: {OVERLAP}}}\n", 1)
    )
    loaded = LoadedRig(rig_from_text(text), text, "axis.yaml")
    logs = [load(axis_logs.write(folder / f"{k}.csv", axis_logs.simulated(true, 71 + k, 6.0)), loaded.rig) for k in (0, 1)]
    names, few, _ = experiments_of(loaded, logs[:1], logs[1:], Settings())
    return refitted(opening(loaded.rig, nuisances(loaded, frozenset(names)), few, names), lambda line: None)


@pytest.mark.slow
def test_it_is_tried_at_a_size_that_just_shows_and_promises_more_there(search: EvidenceSearch) -> None:
    suspects = [s for s in candidates(search.rig, search.channels) if s.label == SUSPECT]
    typical = signatures_of(search.seen, search.null, suspects)
    one_each = first_lines(typical)
    sizes = sizes_shown(search.seen, search.null, one_each, NEEDED)
    (small,) = taken_there(search.seen, search.null, one_each, sizes)
    assert small.values[0] == pytest.approx(sizes[SUSPECT])
    assert small.values[0] < 0.5 * typical[0].values[0]
    screen = Screen(search.seen, search.null, [*typical, small])
    assert screen.missing(small).log_z > max(screen.missing(one).log_z for one in typical)


@pytest.mark.slow
def test_what_waits_is_promised_by_the_size_that_promises_most(search: EvidenceSearch) -> None:
    (waits,) = (one for one in widened(search, search.null).waiting if one.promise.suspect.label == SUSPECT)
    assert waits.promise.signature is not None
    assert waits.promise.signature.values[0] < OVERLAP  # typical is 0.02
