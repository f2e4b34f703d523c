"""Which suspects are followed first does not hang on how large the discrepancy has grown, and lines are taken where they lead."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gap.evidence.lines import followed
from gap.evidence.promises import _along_lines, _promised, _ranked, in_its_place, widened
from gap.evidence.refinement import hypothesis_of, opened
from gap.evidence.score.hypothesis import Hypothesis, Seen, hypothesis_at
from gap.evidence.screening import Screen, signatures_of
from gap.evidence.search_state import EvidenceSearch
from gap.evidence.stages import _decided
from gap.suspects.candidates import candidates
from tests.support.gap import axis_logs
from tests.support.gap.constants_fitted import constants_fitted

SUSPECT, OVERLAP = "valve_deadband at axis", 0.004

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def search(tmp_path_factory: pytest.TempPathFactory) -> EvidenceSearch:
    """The constants alone, fitted to a machine with a dead band that just shows."""
    text, line = axis_logs.axis_text(), f"    - {{effect: valve_deadband, where: axis, overlap: {OVERLAP}}}"
    true = text.replace("  effects:\n", f"  effects:\n{line}\n", 1)
    return constants_fitted(tmp_path_factory.mktemp("logs"), text, true, 72)


def hidden_by(seen: Seen, start: Hypothesis) -> Hypothesis:
    """The same fit with a discrepancy of twenty times the size that lasts as long as a window."""
    there = start.at.discrepancy
    grown = replace(there, sd=20.0 * np.maximum(there.sd, seen.scales), time_s=np.full_like(there.time_s, 0.4))
    return hypothesis_at(seen, start.suspects, replace(start.at, discrepancy=grown))


def test_a_discrepancy_that_hides_everything_leaves_the_order(search: EvidenceSearch) -> None:
    suspects = search.suspects_beside(search.null)
    hidden = hidden_by(search.seen, search.null)
    plain, grown = (_ranked(search, start, suspects) for start in (search.null, hidden))
    assert [p.suspect.label for p in grown] == [p.suspect.label for p in plain]
    gains = [max(p.log_z for p in ranked) - start.log_z for ranked, start in ((plain, search.null), (grown, hidden))]
    assert gains[1] < 0.5 * gains[0]  # what is promised beside it is less all the same


def test_a_line_that_was_taken_far_off_is_taken_again_where_it_leads(search: EvidenceSearch) -> None:
    suspects = [s for s in candidates(search.rig, search.channels) if s.label == SUSPECT]
    signature = next(s for s in signatures_of(search.seen, search.null, suspects) if s.values[0] > 2.0 * OVERLAP)
    far = Screen(search.seen, search.null, [signature]).missing(signature)
    nearer, line = _along_lines(search, search.null, far)
    assert nearer.signature is not None
    assert line is not None
    assert line.log_z > followed(search.seen, search.null, far).log_z + 1.0
    assert abs(nearer.signature.values[0] - OVERLAP) < abs(signature.values[0] - OVERLAP)


def test_what_waits_beside_a_fit_is_not_promised_there_again(search: EvidenceSearch) -> None:
    """The best set less one may stand where its rest is fitted: the same sets would be promised, and fitted, twice."""
    wide = widened(search, search.null)
    assert in_its_place(wide, search.null, search.null).waiting == wide.waiting


def test_where_a_descent_led_nowhere_lines_tell_what_is_reached_without_a_suspect(search: EvidenceSearch) -> None:
    """Case 0057 of the second study: from constants without a name that was gone no step gained; lines of any suspect led
    80 higher, to where the constants alone are as well, and six suspects were fitted for that."""
    model = search.null.model
    away = model.with_theta(model.theta + 0.5 * np.array([free.scale for free in model.free]))
    start = hypothesis_of(search.seen, (), opened(search.seen, away, search.null.at.discrepancy))
    reached, waiting = _promised(search, start, search.suspects_beside(search.null), start)  # as if none had gained
    assert reached.log_z > start.log_z + 5.0
    assert {w.level for w in waiting} == {reached.log_z}


def test_a_start_at_its_floor_is_not_fitted_again(search: EvidenceSearch) -> None:
    reached, _ = _promised(
        search, search.null, search.suspects_beside(search.null)[:1], replace(search.null, log_z=search.null.log_z + 1.0)
    )
    assert reached.log_z == search.null.log_z + 1.0


@pytest.mark.parametrize("times", [1.0, 1e-3])
def test_sets_that_can_hold_no_share_are_fitted_only_where_the_best_one_leaves_too_much(search: EvidenceSearch, times: float) -> None:
    """Beside a set that is ahead of all promises. `times`: part of what honest models leave; a thousandth is too little for any model."""
    strict = replace(search, seen=replace(search.seen, scales=times * search.seen.scales))
    wide, said = widened(strict, strict.null), list[str]()
    waiting = max(wide.waiting, key=lambda w: w.gain)
    best = replace(strict.null, suspects=(waiting.promise.suspect,), log_z=strict.null.log_z + 1e4)
    _decided(replace(wide, fitted=(strict.null, best)), strict.null, said.append, 2)
    assert bool(said) == (times < 1.0)
