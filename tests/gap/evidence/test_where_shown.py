"""A suspect that is not proportional to its size is tried where it would just show too."""

from __future__ import annotations

import pytest

from gap.evidence.promises import widened
from gap.evidence.screening import Screen, signatures_of
from gap.evidence.search_state import EvidenceSearch
from gap.evidence.where_shown import first_lines, sizes_shown, taken_there
from gap.suspects.candidates import candidates
from tests.support.gap import axis_logs
from tests.support.gap.constants_fitted import constants_fitted

SUSPECT, NEEDED = "valve_deadband at axis", 2.6
OVERLAP = 0.004


@pytest.fixture(scope="module")
def search(tmp_path_factory: pytest.TempPathFactory) -> EvidenceSearch:
    """The constants alone, fitted to a machine with a dead band that just shows."""
    text, line = axis_logs.axis_text(), f"    - {{effect: valve_deadband, where: axis, overlap: {OVERLAP}}}"
    true = text.replace("  effects:\n", f"  effects:\n{line}\n", 1)
    return constants_fitted(tmp_path_factory.mktemp("logs"), text, true, 72)


@pytest.mark.slow
def test_it_is_tried_at_a_size_that_just_shows_and_promises_more_there(search: EvidenceSearch) -> None:
    suspects = [s for s in candidates(search.rig, search.channels) if s.label == SUSPECT]
    typical = signatures_of(search.seen, search.null, suspects)
    one_each = first_lines(typical)
    sizes = sizes_shown(Screen(search.seen, search.null, typical), one_each, NEEDED)
    (small,) = taken_there(search.seen, search.null, one_each, sizes)
    assert small.values[0] == pytest.approx(sizes[SUSPECT])
    assert small.values[0] < 0.5 * typical[0].values[0]
    screen = Screen(search.seen, search.null, [*typical, small])
    assert screen.missing(small).log_z > max(screen.missing(one).log_z for one in typical)


@pytest.mark.slow
def test_what_waits_is_promised_by_the_size_that_promises_most(search: EvidenceSearch) -> None:
    here, there = (one for one in widened(search, search.null).waiting if one.promise.suspect.label == SUSPECT)
    assert here.base is search.null
    assert there.base is search.nominal
    waits = max(here, there, key=lambda one: one.gain)
    assert waits.promise.signature is not None
    assert waits.promise.signature.values[0] < OVERLAP  # typical is 0.02
