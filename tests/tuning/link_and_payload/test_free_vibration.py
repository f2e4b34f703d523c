"""Clamped frequency and damping out of a hold, on signals made up from the closed form."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from pathlib import Path

import numpy as np
import pytest

from config.schema.rig import LinkMode, Rig
from recording.files.reader import read_log
from tests.support.recording import session
from tuning.link_and_payload.free_vibration import FreeVibration, free_vibration, free_vibrations
from tuning.link_and_payload.tip_record import TipRecord, tip_records

LENGTH_M, SECONDS = 1.2, 1.9


def _link(rig: Rig) -> LinkMode:
    assert rig.link_mode is not None
    return rig.link_mode


def _ringing(link: LinkMode, clamped_Hz: float, damping_ratio: float, give: complex, noise: float = 0.0) -> FreeVibration:
    """Joint angle = give · deflection: the equation of the link is solved for s, then both signals are written down."""
    own = link.mass_per_length_kg_per_m * LENGTH_M
    arm = LENGTH_M * (link.payload_kg + 11 / 40 * own) / (link.payload_kg + 33 / 140 * own)
    omega = 2 * pi * clamped_Hz
    s = min(np.roots([1 + arm * give, 2 * damping_ratio * omega, omega**2]), key=lambda root: -root.imag)
    t = 0.001 * np.arange(round(SECONDS / 0.001))
    deflection = 0.004 * np.exp(s * t)
    random = np.random.default_rng(3)
    acceleration = np.real(s**2 * (deflection + LENGTH_M * give * deflection)) + 0.2 + noise * random.standard_normal(len(t))
    rotary = np.real(give * deflection) + 0.4 + 1e-6 * t + 0.002 * noise * random.standard_normal(len(t))
    record = TipRecord(1, 0.001, acceleration, None, rotary, np.full(len(t), LENGTH_M), ((1, slice(0, len(t))),))
    return free_vibration(record, 1, record.holds[0][1], link)


@pytest.mark.parametrize("give", [0.0, 0.02, 0.02 - 0.01j, 0.4 - 0.3j])
def test_the_joint_may_do_what_it_likes(rig: Rig, give: complex) -> None:
    """Stuck, springy, springy with loss, and moved by an end-point feedback that damps the ringing to 15 %."""
    found = _ringing(_link(rig), 2.7, 0.006, give)
    assert found.clamped_Hz == pytest.approx(2.7, rel=2e-5)
    assert found.damping_ratio == pytest.approx(0.006, abs=2e-5)
    assert found.ring_damping_ratio > 0.1 or abs(give) < 0.1


def test_the_stated_uncertainty_is_that_of_the_noise(rig: Rig) -> None:
    found = _ringing(_link(rig), 2.7, 0.006, 0.02, noise=0.03)
    assert 0.0 < found.clamped_sigma_Hz < 0.01
    assert abs(found.clamped_Hz - 2.7) < 3.0 * found.clamped_sigma_Hz
    assert abs(found.damping_ratio - 0.006) < 3.0 * found.damping_sigma


def test_only_the_hold_in_which_cycles_are_missing_is_left_out(rig: Rig, tmp_path: Path) -> None:
    """60 cycles lost in the first hold: the later ones stay where they were in time and give what they gave."""
    log = read_log(session.recorded_run(tmp_path / "a.mcap", ring_mps2={0: 2.8, 2: 2.7, 4: 3.6}))
    first = np.flatnonzero(log.columns["segment"] == 2)[0]
    kept = np.delete(np.arange(log.cycles), np.arange(first + 700, first + 760))
    lossy = replace(log, columns={name: values[kept] for name, values in log.columns.items()}, time_ns=log.time_ns[kept])
    (whole,), (torn,) = tip_records(log), tip_records(lossy)
    assert torn.torn == (1,)
    assert torn.holds == whole.holds[1:]
    found = [free_vibrations(record, _link(rig)) for record in (whole, torn)]
    assert [hold.frequency_Hz for hold in found[1]] == [hold.frequency_Hz for hold in found[0][1:]]
    assert len(torn.acceleration) == len(whole.acceleration)
