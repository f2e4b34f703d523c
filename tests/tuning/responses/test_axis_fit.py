"""The response of a single hydraulic axis: both of its pairs come back, whichever is the faster, and the waves stay within its limits."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
import yaml

from config.errors import ConfigError, LogError
from config.loading.load import load_rig
from tuning.experiments.excited_run import ResponseConditions
from tuning.experiments.experiments import experiments
from tuning.experiments.usual_campaign import usual_campaign
from tuning.responses.axis_fit import fit_axis
from tuning.responses.frequency_response import FrequencyResponse

CONDITIONS = ResponseConditions("axis", "command", 1.0, np.nan, 40.0, np.nan, 0.1)


def measured(load_Hz: float, damping: float, valve_Hz: float, noise: float = 0.0, lines: int = 40) -> FrequencyResponse:
    """0.05 m/s per V behind load on oil and a valve damped by 0.8."""
    f = np.geomspace(0.6, 90.0, lines)

    def pair(frequency_Hz: float, ratio: float) -> np.ndarray:
        return 1.0 / (1.0 + 2j * ratio * f / frequency_Hz - (f / frequency_Hz) ** 2)

    random = np.random.default_rng(3)
    scatter = 1.0 + noise * (random.standard_normal(lines) + 1j * random.standard_normal(lines))
    response = 0.05 / (2j * pi * f) * pair(load_Hz, damping) * pair(valve_Hz, 0.8) * scatter
    return FrequencyResponse("multisine", CONDITIONS, f, response, np.full(lines, max(noise, 1e-4)), np.ones(lines), np.ones(lines))


@pytest.mark.parametrize(
    ("load_Hz", "damping", "valve_Hz"), [(53.0, 0.03, 42.0), (53.0, 0.15, 42.0), (25.0, 0.1, 60.0), (12.0, 0.3, 150.0)]
)
def test_both_pairs_come_back(load_Hz: float, damping: float, valve_Hz: float) -> None:
    fit = fit_axis(measured(load_Hz, damping, valve_Hz, noise=0.01))
    assert fit.velocity_gain == pytest.approx(0.05, rel=0.01)
    assert fit.natural_Hz == pytest.approx(load_Hz, rel=0.02)
    assert fit.damping_ratio == pytest.approx(damping, rel=0.1)
    assert fit.values["valve_Hz"] == pytest.approx(valve_Hz, rel=0.1)
    assert fit.worst_dB < 0.5


def test_the_fit_is_its_own_response() -> None:
    response = measured(53.0, 0.1, 42.0)
    assert fit_axis(response)(response.frequencies_Hz) == pytest.approx(response.response, rel=1e-3)


def test_too_few_lines_are_refused() -> None:
    with pytest.raises(LogError, match="too few lines"):
        fit_axis(measured(53.0, 0.1, 42.0, lines=3))


def test_the_waves_of_an_axis_keep_half_of_its_limits() -> None:
    rig = load_rig("analogue_axis").rig
    joint, servo = rig.joints["axis"], rig.servo["axis"]
    campaign = usual_campaign(rig, "multisine")
    largest = max(campaign.amplitudes_V)
    assert largest == pytest.approx(0.5 * joint.rate_limit * servo.velocity_feedforward, rel=0.01)
    assert largest <= 0.5 * joint.following_error_limit * servo.gain
    low, high = campaign.band_Hz
    assert low < 1.0
    assert high > 52.6, "beyond mass on oil"
    for run in experiments(rig, campaign):
        text = yaml.safe_load(run.maneuver)
        place = float(text["start"]["axis"].split()[0])
        assert joint.travel[0] < place < joint.travel[1]
        assert float(text["period"].split()[0]) * rig.loop.rate_Hz == pytest.approx(
            round(float(text["period"].split()[0]) * rig.loop.rate_Hz)
        )


@pytest.mark.parametrize(("name", "what"), [("force_axis", "multisine"), ("analogue_axis", "map")])
def test_what_cannot_be_made_says_what_can(name: str, what: str) -> None:
    with pytest.raises(ConfigError) as refused:
        usual_campaign(load_rig(name).rig, what)  # type: ignore[arg-type]
    assert "--" in str(refused.value), "what to type instead"
