"""On simulated logs of a single axis without a missing effect the log Bayes factors of all suspects are what theory says of wrong ones;
where friction has another form, or a constant is far off, no name is sure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from config.loading.load import LoadedRig, rig_from_text
from gap.data.experiments import experiments_of
from gap.data.measured import load
from gap.data.windows import Experiment
from gap.evidence.noise.repeated import SLOW, WAYS
from gap.evidence.noise.unknowns import UNTOLD, unknowns_of
from gap.evidence.opening import opening
from gap.evidence.score.changed import changeable
from gap.evidence.screening import Screen, signatures_of
from gap.evidence.search_state import EvidenceSearch
from gap.evidence.stages import STAGES, refitted
from gap.fitting.nuisance import nuisances
from gap.settings import Settings
from gap.suspects.candidates import candidates
from sim_backend.kernel.batch import quiet
from sim_backend.kernel.parameters import Parameters
from tests.support.gap import axis_logs
from tests.support.gap.maxwell_axis import maxwell_axis

MOST = 3.0  # ln B of a wrong effect: ½ χ²₁ beyond its Occam factor of 2 to 10 happens in less than 1 of 100


def rig_file() -> LoadedRig:
    text = axis_logs.axis_text()
    return LoadedRig(rig_from_text(text), text, "axis.yaml")


def opened(folder: Path, loaded: LoadedRig, columns: list[axis_logs.Columns]) -> tuple[EvidenceSearch, list[str]]:
    """The search before its first stage, and the channels; the first log is fitted, the second held out."""
    search, names, _ = opened_and_held(folder, loaded, columns)
    return search, names


def opened_and_held(
    folder: Path, loaded: LoadedRig, columns: list[axis_logs.Columns]
) -> tuple[EvidenceSearch, list[str], Sequence[Experiment]]:
    """The same, and the log that is held out."""
    logs = [load(axis_logs.write(folder / f"{k}.csv", own), loaded.rig) for k, own in enumerate(columns)]
    names, few, held = experiments_of(loaded, logs[:1], logs[1:], Settings())
    return opening(loaded.rig, nuisances(loaded, frozenset(names)), few, names), names, held


def searched(search: EvidenceSearch) -> EvidenceSearch:
    for stage in STAGES:
        search = stage(search, lambda line: None)
    return search


@pytest.mark.parametrize("seed", [31, 47])
def test_wrong_effects_gain_nothing_by_chance(tmp_path: Path, seed: int) -> None:
    loaded = rig_file()
    search, names = opened(tmp_path, loaded, [axis_logs.simulated(loaded.rig, seed + k, 6.0) for k in (0, 1)])
    search = refitted(search, lambda line: None)
    base = search.null
    assert np.all(base.at.discrepancy.sd < 0.5)  # nothing but noise is left
    signatures = signatures_of(search.seen, base, candidates(loaded.rig, frozenset(names)))
    screen = Screen(search.seen, base, signatures)
    missing = [screen.missing(s) for s in signatures]
    changed = [screen.changed(c) for c in changeable(loaded.rig, search.nominal.model.free)]
    gains = np.array([p.log_z - base.log_z for p in (*missing, *changed)])
    assert len(gains) > 12
    assert gains.max() < MOST
    assert np.median(gains) < -2.0


@pytest.mark.slow
@pytest.mark.parametrize("seed", [61, 83])
def test_friction_that_yields_in_several_places_is_no_effect(tmp_path: Path, seed: int) -> None:
    """The rig file has a bristle; the machine, of other code, four elements that break away after 20 to 600 um."""
    search, _ = opened(tmp_path, rig_file(), [maxwell_axis(seed + k, 8.0) for k in (0, 1)])
    done = searched(search)
    assert done.seen.logs[0].forms == WAYS - 1 + len(SLOW) + 1  # the last: a contact that does not creep
    assert np.any(done.null.at.discrepancy.of_log(0) > 1.0)  # there is something to be taken in by
    assert done.posterior.none > 0.5


@pytest.mark.slow
@pytest.mark.parametrize("seed", [971_120, 971_260, 971_270])
def test_friction_that_yields_at_once_is_no_stiction(tmp_path: Path, seed: int) -> None:
    """One element that breaks away after 1 um, less than the noise: it springs back where the rig file's bristle creeps. Stiction of 1 N,
    which fades within 0.5 mm/s, imitates that."""
    search, _ = opened(tmp_path, rig_file(), [maxwell_axis(seed + k, 10.0, break_away_m=(1e-6,)) for k in (0, 1)])
    done = searched(search)
    assert done.null.log_z > done.nominal.log_z + 10.0  # the rig file's bristle is too soft
    assert done.posterior.none > 0.5


@pytest.mark.slow
def test_a_mass_far_off_its_prior_makes_no_sensor_wrong(tmp_path: Path) -> None:
    """7.5 % more mass, of which the file is sure to 2 %, and an encoder that reads 7 % too little with 7 % less damping move alike. Both,
    and more inertia, are about as likely: the mass costs 7.0 in ln p, a wide prior 3.5 to 4 and the odds of 1 in 12."""
    loaded = rig_file()
    heavy = rig_from_text(loaded.text.replace("mass: 95.1089 kg", "mass: 102.24 kg"))
    done = searched(opened(tmp_path, loaded, [axis_logs.simulated(heavy, 51 + k) for k in (0, 1)])[0])
    found = done.posterior
    assert found.of("sensor_scale at sensor:axis.position") < 0.6
    assert found.none > 0.1


def test_a_start_is_as_uncertain_as_its_readings(tmp_path: Path) -> None:
    """Whatever the sensor's scale: what an unknown start changes in the readings is the same."""
    loaded = rig_file()
    search, _ = opened(tmp_path, loaded, [axis_logs.simulated(loaded.rig, 31 + k, 4.0) for k in (0, 1)])
    small = loaded.text.replace("  effects:\n", "  effects:\n    - {effect: sensor_scale, where: sensor:axis.position, factor: 0.8}\n", 1)
    vectors = [quiet(Parameters(rig)) for rig in (loaded.rig, rig_from_text(small))]
    starts = [unknowns_of(search.seen.experiments, p)[0].states[:, :, 0] for p in vectors]  # the first sample is the start itself
    true, scaled = (np.einsum("nwc,nwd->wcd", start, start) for start in starts)
    np.testing.assert_allclose(scaled, true, rtol=1e-3, atol=UNTOLD**2)
