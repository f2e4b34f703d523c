"""Frequency responses out of sweeps and multisines, on a linear joint that is known exactly, and against SciPy's own estimate."""

from __future__ import annotations

from dataclasses import replace
from math import pi, radians
from typing import Any

import numpy as np
import pytest
from scipy.signal import cont2discrete, csd, dlsim, tf2ss

from config.errors import LogError
from config.schema.rig import Rig
from servo_control.path.multisine import Multisine, odd_harmonics
from servo_control.path.waves import Sweep
from tuning.experiments.excited_run import ExcitedRun, ResponseConditions
from tuning.responses.frequency_response import FrequencyResponse, combined, sweep_response
from tuning.responses.multisine_response import multisine_response
from tuning.responses.realisations import realisations
from tuning.responses.response_bounds import bounds
from tuning.responses.response_fit import fit_joint
from tuning.transfer import EQ4

PERIOD_S, GAIN = 0.001, 20.0  # V/rad
CONDITIONS = ResponseConditions("rotary", "command", 0.3, 0.9, 40.0, 0.0)
SWEEP = {"kind": "sine_sweep", "from": 0.2, "to": 10.0}
MULTISINE = {"kind": "multisine", "from": 0.2, "to": 10.0, "period": 10.0, "periods": 4, "lines": 24, "fade": 1.0}
JOINT = cont2discrete(([radians(240810.0)], [1.0, 140.0, 6150.0, 0.0]), PERIOD_S)  # Eq 4 behind a hold


def _closed_loop(excitation: np.ndarray, noise: float = 0.0, cubic: float = 0.0, square: float = 0.0) -> tuple[np.ndarray, np.ndarray]:
    """Eq 4 under a proportional servo at 1 kHz, cycle by cycle: command and measured position."""
    top, bottom = np.ravel(JOINT[0]), np.ravel(JOINT[1])
    random = np.random.default_rng(5)
    u, y = np.zeros(len(excitation)), np.zeros(len(excitation))
    entered = np.zeros(len(excitation))
    for k in range(len(excitation)):
        past = range(1, min(k, 3) + 1)
        true = sum(top[i] * entered[k - i] for i in past) - sum(bottom[i] * y[k - i] for i in past)
        y[k] = true
        u[k] = excitation[k] - GAIN * (true + noise * random.standard_normal())
        entered[k] = u[k] + cubic * u[k] ** 3 + square * u[k] ** 2
    return u, y


def _run(maneuver: dict[str, object], wave: Sweep | Multisine, **disturbed: float) -> ExcitedRun:
    excitation = np.array([wave.at(PERIOD_S * k)[0] for k in range(round(wave.duration_s / PERIOD_S))])
    return ExcitedRun(1, CONDITIONS, maneuver, PERIOD_S, excitation, *_closed_loop(excitation, **disturbed))


def _sweep(**disturbed: float) -> ExcitedRun:
    return _run(SWEEP, Sweep(0.3, 0.2, 10.0, 40.0, 1.0, logarithmic=True), **disturbed)


def _multisine(seed: int = 1, **disturbed: float) -> ExcitedRun:
    harmonics = odd_harmonics(0.2, 10.0, 10.0, 24)
    return _run(MULTISINE, Multisine(0.3, harmonics, 10.0, 4, 1.0, seed, 3.0), **disturbed)


def _error(response: FrequencyResponse) -> tuple[float, float]:
    """Largest distance from Eq 4 in dB and degrees."""
    ratio = response.response / (radians(1.0) * EQ4(2j * pi * response.frequencies_Hz))
    return float(np.max(np.abs(20 * np.log10(np.abs(ratio))))), float(np.max(np.abs(np.degrees(np.angle(ratio)))))


def test_a_multisine_gives_eq_4_back() -> None:
    response = multisine_response(_multisine())
    assert _error(response) == (pytest.approx(0.0, abs=0.01), pytest.approx(0.0, abs=0.05))
    assert response.odd is not None
    assert response.even is not None
    assert max(np.max(response.odd.level_dB), np.max(response.even.level_dB)) < -80.0


def test_a_sweep_gives_eq_4_back() -> None:
    response = sweep_response(_sweep())
    assert _error(response) == (pytest.approx(0.0, abs=0.1), pytest.approx(0.0, abs=1.0))
    assert np.min(response.coherence) > 0.98


def test_a_sweep_agrees_with_scipy() -> None:
    """Instrumental estimate of Welch spectra, csd(r, y)/csd(r, u), where the sweep spends whole segments."""
    run = _sweep(noise=2e-5)
    response = sweep_response(run)
    f, to_position = csd(run.excitation, run.position, 1.0 / PERIOD_S, nperseg=8192)
    _, to_command = csd(run.excitation, run.command, 1.0 / PERIOD_S, nperseg=8192)
    welch = to_position / to_command
    for line in (16, 32, 48):  # 2, 4, 6 Hz
        ours = np.interp(f[line], response.frequencies_Hz, np.abs(response.response))
        assert abs(welch[line]) == pytest.approx(ours, rel=0.06)


def test_noise_on_the_sensor_does_not_bias_and_is_told() -> None:
    response = multisine_response(_multisine(noise=2e-4))
    ratio = np.abs(response.response / (radians(1.0) * EQ4(2j * pi * response.frequencies_Hz)) - 1.0)
    assert np.median(ratio / response.sigma) < 2.0
    assert np.median(response.sigma) > 1e-4


@pytest.mark.parametrize(("disturbed", "loud", "quiet"), [({"cubic": 2.0}, "odd", "even"), ({"square": 0.5}, "even", "odd")])
def test_odd_and_even_nonlinearity_show_at_their_own_lines(disturbed: dict[str, float], loud: str, quiet: str) -> None:
    response = multisine_response(_multisine(**disturbed))
    levels = {name: np.median(getattr(response, name).level_dB) for name in (loud, quiet)}
    assert levels[loud] > levels[quiet] + 15.0
    assert levels[loud] > np.median(getattr(response, loud).noise_dB) + 20.0


def test_the_fit_finds_the_three_numbers_of_eq_4() -> None:
    """240810 (°), 140, 6150, and says how sure it is."""
    fit = fit_joint(multisine_response(_multisine(noise=1e-4)))
    assert np.degrees(fit.values["gain"]) == pytest.approx(240810, rel=0.02)
    assert fit.values["damping"] == pytest.approx(140, rel=0.02)
    assert fit.values["stiffness"] == pytest.approx(6150, rel=0.02)
    assert np.degrees(fit.velocity_gain) == pytest.approx(39.156, rel=0.005)
    assert all(0.0 < sure < 0.1 for sure in fit.uncertainty.values())
    assert fit.worst_dB < 0.5


@pytest.mark.parametrize("natural_Hz", [1.5, 12.5, 60.0])
@pytest.mark.parametrize("damping", [0.1, 0.9])
@pytest.mark.parametrize("velocity_gain", [0.01, 5.0])
def test_a_joint_of_any_pace_is_found(natural_Hz: float, damping: float, velocity_gain: float) -> None:
    """Eq 4's form a tenth and five times as fast as the paper's, measured to twice its natural frequency."""
    f, omega = np.geomspace(0.02 * natural_Hz, 2.0 * natural_Hz, 40), 2 * pi * natural_Hz
    s = 2j * pi * f
    measured = velocity_gain * omega**2 / (s * (s**2 + 2 * damping * omega * s + omega**2))
    fit = fit_joint(FrequencyResponse("multisine", CONDITIONS, f, measured, np.full(40, 0.01), np.ones(40), np.ones(40)))
    assert (fit.natural_Hz, fit.damping_ratio) == (pytest.approx(natural_Hz, rel=1e-3), pytest.approx(damping, rel=1e-3))
    assert fit.velocity_gain == pytest.approx(velocity_gain, rel=1e-3)
    assert fit.at_limit == ()


def test_what_the_band_does_not_show_is_said_to_end_at_its_limit() -> None:
    """Far below its resonance a joint is an integrator: that it is no slower than a limit is all that the lines say."""
    f = np.geomspace(0.1, 2.0, 40)
    s = 2j * pi * f
    fit = fit_joint(FrequencyResponse("multisine", CONDITIONS, f, 0.7 / s, np.full(40, 0.001), np.ones(40), np.ones(40)))
    assert fit.velocity_gain == pytest.approx(0.7, rel=1e-2)
    assert "stiffness" in fit.at_limit or "damping" in fit.at_limit


def test_the_stated_uncertainties_are_what_the_fits_scatter_by() -> None:
    """Two standard deviations over 200 responses whose lines scatter by 2 %, as complex numbers: by 1.4 % in either part."""
    f, random, sigma, found = np.geomspace(0.3, 30.0, 40), np.random.default_rng(6), 0.02, []
    for _ in range(200):
        scatter = 1.0 + sigma / np.sqrt(2.0) * (random.standard_normal(40) + 1j * random.standard_normal(40))
        measured = radians(1) * EQ4(2j * pi * f) * scatter
        found.append(fit_joint(FrequencyResponse("sweep", CONDITIONS, f, measured, np.full(40, sigma), np.ones(40), np.ones(40))))
    for name in ("gain", "damping", "stiffness"):
        scattered = 2.0 * np.std(np.log([fit.values[name] for fit in found]))
        assert np.mean([fit.uncertainty[name] for fit in found]) == pytest.approx(scattered, rel=0.15)
    scattered = 2.0 * np.std(np.log([fit.velocity_gain for fit in found]))
    assert np.mean([fit.uncertainty["velocity_gain"] for fit in found]) == pytest.approx(scattered, rel=0.15)


def test_the_fit_with_a_link_finds_antiresonance_and_resonance() -> None:
    f = np.geomspace(0.3, 12.0, 60)
    s = 2j * pi * f
    zero, pole = 2 * pi * 4.1, 2 * pi * 6.3
    link = (s**2 + 0.02 * zero * s + zero**2) / (s**2 + 0.1 * pole * s + pole**2) * (pole / zero) ** 2
    response = FrequencyResponse("sweep", CONDITIONS, f, radians(1) * EQ4(s) * link, np.full(60, 0.01), np.ones(60), np.ones(60))
    fit = fit_joint(response, 4.0)
    assert fit.values["antiresonance_Hz"] == pytest.approx(4.1, rel=1e-3)
    assert fit.values["antiresonance_Hz"] * fit.values["resonance_ratio"] == pytest.approx(6.3, rel=1e-3)
    assert fit.values["damping"] == pytest.approx(140, rel=0.01)


def test_realisations_are_averaged_and_their_scatter_is_the_uncertainty() -> None:
    responses = [multisine_response(_multisine(seed, cubic=2.0)) for seed in (1, 2, 3)]
    mean = combined(responses)
    assert mean.response == pytest.approx(np.mean([each.response for each in responses], axis=0))
    assert np.median(mean.sigma) > 5.0 * np.median(responses[0].sigma)  # the nonlinear part changes with the phases, not with time


def test_only_the_same_lines_under_the_same_conditions_are_averaged(rig: Rig) -> None:
    """Two bands with as many lines, and oil either side of 25 °C: each band's response is Eq 4 at its own frequencies."""
    wide = _multisine()
    harmonics = odd_harmonics(0.3, 8.0, 10.0, 24)
    narrow = _run({**MULTISINE, "from": 0.3, "to": 8.0}, Multisine(0.3, harmonics, 10.0, 4, 1.0, 1, 3.0))
    runs = [replace(run, conditions=replace(CONDITIONS, oil_C=C), maneuver={**run.maneuver, "amplitude": 0.3}) for run, C in (
        (wide, 24.99), (narrow, 24.99), (wide, 25.01), (narrow, 31.0))]  # fmt: skip
    groups = realisations(runs, rig)
    assert [len(group) for group in groups] == [2, 1, 1]
    assert len({len(group[0].frequencies_Hz) for group in groups}) == 1
    for group in groups:
        assert _error(combined(group)) == (pytest.approx(0.0, abs=0.01), pytest.approx(0.0, abs=0.05))
    with pytest.raises(AssertionError):
        combined([groups[0][0], groups[1][0]])


def _scaled(share: float, **changes: Any) -> FrequencyResponse:
    f = np.geomspace(0.5, 8.0, 30)
    at = replace(CONDITIONS, **changes)
    return FrequencyResponse("sweep", at, f, share * EQ4(2j * pi * f), np.full(30, 0.01), np.ones(30), np.ones(30))


def test_bounds_hold_every_response_that_differs_in_one_condition() -> None:
    found = {each.varied: each for each in bounds([_scaled(1.0), _scaled(0.8, amplitude=0.1), _scaled(1.2, oil_C=20.0)])}
    assert set(found) == {"amplitude", "oil_C", "all"}
    assert found["amplitude"].spread == (pytest.approx(20 * np.log10(1 / 0.8)), pytest.approx(0.0, abs=1e-9))
    assert found["all"].spread[0] == pytest.approx(20 * np.log10(1.2 / 0.8))


def test_bounds_are_of_one_joint_excited_one_way_and_of_what_really_varied() -> None:
    """rad/V beside m/V is no spread; two responses at the same amplitude say nothing of the amplitude."""
    responses = [_scaled(1.0), _scaled(0.9), _scaled(0.5, oil_C=20.0), _scaled(0.07, joint="prismatic"), _scaled(3.0, on="reference")]
    found = {(each.joint, each.on, each.varied): each for each in bounds(responses)}
    assert set(found) == {("rotary", "command", "oil_C"), ("rotary", "command", "all")}
    assert found["rotary", "command", "all"].spread[0] == pytest.approx(20 * np.log10(2.0))
    assert found["rotary", "command", "oil_C"].count == 3


def test_a_multisine_that_is_no_whole_number_of_cycles_is_refused() -> None:
    run = _multisine()
    odd = ExcitedRun(1, CONDITIONS, {**MULTISINE, "period": 10.00037}, PERIOD_S, run.excitation, run.command, run.position)
    with pytest.raises(LogError, match="whole periods"):
        multisine_response(odd)


def test_the_loop_of_this_file_is_eq_4() -> None:
    """Against SciPy's own simulation of the discrete joint, in state space."""
    u, y = _closed_loop(np.sin(0.01 * np.arange(500)))
    discrete = cont2discrete(tf2ss([radians(240810.0)], [1.0, 140.0, 6150.0, 0.0]), PERIOD_S)
    assert np.ravel(dlsim(discrete, u)[1]) == pytest.approx(y, abs=1e-9)
