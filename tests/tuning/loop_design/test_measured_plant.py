"""A measured response as a plant: beyond its last line it goes on as the joint it was measured on, so it has that joint's margins."""

from __future__ import annotations

from math import pi, radians

import numpy as np
import pytest

from config.schema.rig import Rig
from tuning.arrays import Complexes, Floats
from tuning.experiments.excited_run import ResponseConditions
from tuning.linear.margins import margins
from tuning.loop_design.measured_plant import MeasuredPlant, measured_plants
from tuning.responses.frequency_response import FrequencyResponse
from tuning.transfer import EQ4

DEAD_TIME_S, GAIN = 0.003, 10.0  # V/rad
HALF_PERIOD_S = 0.0005


def _joint(omega: Floats) -> Complexes:
    return np.asarray(radians(1.0) * EQ4(1j * omega) * np.exp(-1j * omega * DEAD_TIME_S))


def _measured(rig: Rig, up_to_Hz: float, noise: float = 0.0) -> MeasuredPlant:
    f, random = np.geomspace(0.3, up_to_Hz, 24), np.random.default_rng(2)
    scatter = 1.0 + noise * (random.standard_normal(24) + 1j * random.standard_normal(24))
    at = ResponseConditions("rotary", "command", 0.3, 0.9, 40.0, 0.0)
    response = FrequencyResponse("multisine", at, f, _joint(2 * pi * f) * scatter, np.full(24, 0.01), np.ones(24), np.ones(24))
    (plant,) = measured_plants(rig, [response])
    return plant


@pytest.mark.parametrize("up_to_Hz", [6.0, 8.0, 15.0])
@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_the_gain_margin_is_the_joint_s_or_a_little_less(rig: Rig, up_to_Hz: float, noise: float) -> None:
    """Eq 4 with dead time lags by 180 degrees at 10.5 Hz: beyond the last line of the first two."""
    true = margins(lambda w: GAIN * _joint(w) * np.exp(-1j * w * HALF_PERIOD_S))
    plant = _measured(rig, up_to_Hz, noise)
    found = margins(lambda w: GAIN * plant(w))
    assert true.gain_margin_dB - 3.0 < found.gain_margin_dB < true.gain_margin_dB + 0.5
    assert found.phase_margin_deg == pytest.approx(true.phase_margin_deg, abs=2.0)


def test_the_lines_themselves_are_kept(rig: Rig) -> None:
    plant = _measured(rig, 8.0)
    omega = 2 * pi * plant.tested_Hz
    assert plant(omega) == pytest.approx(_joint(omega) * np.exp(-1j * omega * HALF_PERIOD_S), rel=1e-9)
