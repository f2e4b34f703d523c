"""What the search says it could have named, against logs in which that much is hidden, and against hold-outs that show little of it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.loading.load import LoadedRig, rig_from_text
from gap.data.measured import load
from gap.fitting.compare import paired_t
from gap.fitting.model import Model
from gap.fitting.nuisance import nuisances
from gap.search.hold_out_sizes import on_hold_out
from gap.search.opening import experiments_of, started
from gap.search.search_state import GateSearch
from gap.search.select import least_t
from gap.search.settings import Settings
from gap.signatures.candidates import candidates
from gap.signatures.screen import Screening, screen_sizes
from gap.signatures.visible import checked
from tests.support.gap import axis_logs
from tests.support.gap.finished_search import quiet

TEXT = axis_logs.axis_text()
HIDDEN = "asymmetric_friction"


def opened(folder: Path, truth: str, share: float) -> GateSearch:
    """The rig file refitted to two logs of `truth`; `share`: of the full command in the second, which is held out."""
    loaded, rig = LoadedRig(axis_logs.axis_rig(), TEXT, "axis.yaml"), rig_from_text(truth)
    columns = [axis_logs.simulated(rig, seed, 8.0, amplitude=part) for seed, part in ((1, 1.0), (2, share))]
    logs = [load(axis_logs.write(folder / f"{k}.csv", one), loaded.rig) for k, one in enumerate(columns)]
    names, few, held = experiments_of(loaded, logs[:1], logs[1:], Settings(propose=False))
    free = nuisances(loaded, frozenset(names))
    model = Model(loaded.rig, free, np.array([item.start for item in free]))
    return started(model, few, held, frozenset(names), quiet)[0]


def sizes(state: GateSearch) -> tuple[Screening, Screening]:
    """As the fit log sees them, and as the hold-out does too."""
    found = candidates(state.current.model.rig, state.channels)
    first = screen_sizes(state.current, state.costs, found, state.seen_at, quiet, None)
    fitted = checked(first, state.current, state.costs, state.seen_at)
    return fitted, on_hold_out(fitted, state.current, state.seen, state.costs, len(found))


def of(screening: Screening, effect: str) -> float:
    return next(s.smallest_visible for s in screening.signatures if s.candidate.effect == effect)


@pytest.fixture(scope="module")
def lively(tmp_path_factory: pytest.TempPathFactory) -> GateSearch:
    return opened(tmp_path_factory.mktemp("lively"), TEXT, 1.0)


def test_the_hold_out_never_makes_an_effect_easier_to_see(lively: GateSearch) -> None:
    fitted, held = sizes(lively)
    assert fitted.signatures
    for before, after in zip(fitted.signatures, held.signatures, strict=True):
        assert after.smallest_visible >= before.smallest_visible


@pytest.mark.slow
def test_a_hold_out_that_hardly_moves_asks_for_more(lively: GateSearch, tmp_path: Path) -> None:
    _, held = sizes(lively)
    still = opened(tmp_path, TEXT, 0.02)
    fitted, waiting = sizes(still)
    assert of(fitted, HIDDEN) == pytest.approx(of(sizes(lively)[0], HIDDEN), rel=0.3)
    assert of(waiting, HIDDEN) > 2.0 * of(held, HIDDEN)


@pytest.mark.slow
def test_what_is_hidden_in_that_size_shows_on_the_hold_out(lively: GateSearch, tmp_path: Path) -> None:
    """Constants refitted to it all the same: what they leave is what the claim said, and enough for a name."""
    held = sizes(lively)[1]
    size = of(held, HIDDEN)
    last = TEXT.rindex("{effect:")
    line = f"{{effect: {HIDDEN}, where: axis, friction_difference: {size:.6g} N}}\n"
    indent = TEXT[TEXT.rindex("\n", 0, last) + 1 : last]
    end = TEXT.index("\n", last) + 1
    hidden = opened(tmp_path, TEXT[:end] + indent + line + TEXT[end:], 1.0)
    t = paired_t(hidden.seen, lively.seen)
    least = least_t(len(held.signatures))
    assert 0.8 * least < t < 2.0 * least
