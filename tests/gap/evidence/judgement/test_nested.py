"""What a set says of itself with a suspect less is what the set without it says when it is fitted, where nothing is rough."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.loading.load import rig_from_text
from gap.evidence.judgement.nested import nested
from gap.evidence.promises import widened
from gap.evidence.refinement import finished
from gap.evidence.search_state import EvidenceSearch
from gap.evidence.set_fits import refined
from gap.evidence.stages import refitted
from tests.gap.evidence.test_effect_free import opened, rig_file
from tests.support.gap import axis_logs

CHANGED = "coulomb_friction at axis changed (friction)"


def searched(folder: Path, truth: str) -> EvidenceSearch:
    """The constants alone fitted to a log of `truth`, every suspect beside them waiting."""
    rig = rig_from_text(truth)
    search, _ = opened(folder, rig_file(), [axis_logs.simulated(rig, 31 + k, 6.0) for k in (0, 1)])
    search = refitted(search, lambda line: None)
    return widened(search, search.null)


@pytest.mark.parametrize(
    ("label", "entry"),
    [
        ("gravity at axis", "{effect: gravity, where: axis, tilt: 0.065 deg}"),
        ("transport_delay at axis", "{effect: transport_delay, where: axis, delay: 0.12 ms}"),
        ("stiction at axis", ""),
    ],
)
def test_it_is_the_evidence_of_the_set_without_it(tmp_path: Path, label: str, entry: str) -> None:
    text = axis_logs.axis_text()
    search = searched(tmp_path, f"{text}    - {entry}\n" if entry else text)
    whole = refined(search, next(w for w in search.waiting if w.labels == {label}))
    whole = finished(search.seen, whole.suspects, whole.at)
    (part,) = nested(search.seen, whole, search.nominal.model)
    assert part.labels == frozenset()
    assert part.log_z == pytest.approx(search.null.log_z, abs=1.0), (whole.log_z, search.null.log_z)
    assert np.sum(part.windows - search.null.windows) == pytest.approx(0.0, abs=2.0)


def test_a_number_that_had_changed_has_its_own_prior_again(tmp_path: Path) -> None:
    search = searched(tmp_path, axis_logs.axis_text().replace("friction: 20.39", "friction: 21.5"))
    whole = refined(search, next(w for w in search.waiting if w.labels == {CHANGED}))
    whole = finished(search.seen, whole.suspects, whole.at)
    (part,) = nested(search.seen, whole, search.nominal.model)
    assert [f.prior for f in part.model.free] == [f.prior for f in search.nominal.model.free]
    assert part.log_z == pytest.approx(search.null.log_z, abs=1.0), (whole.log_z, search.null.log_z)
