"""A search that is done lets go of most of its memory, and says what it said."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gap.evidence.promises import widened
from gap.evidence.search_state import EvidenceSearch
from gap.evidence.set_fits import refined
from gap.evidence.stages import refitted
from tests.gap.evidence.test_effect_free import opened, rig_file
from tests.support.gap import axis_logs


@pytest.fixture(scope="module")
def search(tmp_path_factory: pytest.TempPathFactory) -> EvidenceSearch:
    """Constants alone and one suspect fitted, the others waiting."""
    loaded = rig_file()
    folder = tmp_path_factory.mktemp("axis")
    found, _ = opened(folder, loaded, [axis_logs.simulated(loaded.rig, 31 + k, 4.0) for k in (0, 1)])
    found = refitted(found, lambda line: None)
    found = widened(found, found.null)
    first, *rest = sorted(found.waiting, key=found.log_hope, reverse=True)
    done = refined(found, first)
    return replace(found, fitted=(*found.fitted, done), waiting=tuple(rest))


def held_bytes(search: EvidenceSearch) -> int:
    sets = {id(h): h for h in (search.nominal, *search.fitted, *(w.base for w in search.waiting))}
    return sum(j.nbytes for h in sets.values() for j in h.at.jacobian)


def test_what_it_says_stays(search: EvidenceSearch) -> None:
    done = search.at_its_end([search.null])
    assert done.posterior.of_set == search.posterior.of_set
    assert [done.log_hope(w) for w in done.waiting] == [search.log_hope(w) for w in search.waiting]
    assert done.null is search.null  # needed


def test_only_the_needed_sets_keep_their_sensitivities(search: EvidenceSearch) -> None:
    done = search.at_its_end([search.null])
    assert held_bytes(done) == sum(j.nbytes for j in search.null.at.jacobian)
    assert held_bytes(search) > 2 * held_bytes(done)
    assert all(w.promise.signature is None for w in done.waiting)
    assert all(np.isfinite(h.log_z) for h in done.fitted)
