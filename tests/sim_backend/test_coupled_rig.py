"""The coupled rig against the reference's simulations: limit cycle with the flexible link, amplitude sensitivity of the cylinder."""

from __future__ import annotations

import numpy as np
import pytest

from sim_backend.memory.layout import C, J
from tests.support.sim_backend.plants import INCH_M, Content, SimulatedRig, centred_null, isothermal, joint_response, ornl, slot, without


def release(gain_V_per_deg: float, extension_in: float, payload_lb: float) -> tuple[float, float, float]:
    """Proportional control at 1 kHz after a 2 degree release, extension fixed: frequency Hz, joint amplitude deg, tip amplitude mm."""

    def arm(content: Content) -> None:
        retracted = 1.8 - extension_in * INCH_M
        content["plant"]["link"] |= {"payload": f"{payload_lb} lb", "hub_inertia": 12.3 - 2.545698 / 3 * retracted**3}

    sim = SimulatedRig(ornl(arm, isothermal))
    sim.parameters.values[slot(1, J.EXTRA_MASS)] = 1e9
    sim.reset(positions=[np.radians(2.0), extension_in * INCH_M])
    angle, deflection = [], []
    for _ in range(12_000):
        angle.append(np.degrees(sim.true_position[0]))
        deflection.append(1e3 * sim.true_signal("tip.deflection"))
        sim.advance([-gain_V_per_deg * angle[-1], 0.0], 1e-3)
    late = np.array(angle[-4000:])
    spectrum = np.abs(np.fft.rfft((late - late.mean()) * np.hanning(late.size), 1 << 16))
    return 1e3 * float(np.argmax(spectrum)) / (1 << 16), float(np.ptp(late)) / 2, float(np.ptp(deflection[-4000:])) / 2


@pytest.mark.parametrize(
    ("extension_in", "payload_lb", "frequency_Hz", "joint_deg", "tip_mm"),
    [(30, 45, 4.99, 0.91, 72), (28, 45, 5.48, 0.83, 53), (36, 45, 3.87, 0.93, 135)],
)
def test_five_hertz_limit_cycle(extension_in: float, payload_lb: float, frequency_Hz: float, joint_deg: float, tip_mm: float) -> None:
    """Row 8: set R with the flexible link at 1 V/deg."""
    frequency, joint, tip = release(1.0, extension_in, payload_lb)
    assert frequency == pytest.approx(frequency_Hz, abs=0.2)
    assert joint == pytest.approx(joint_deg, rel=0.15)
    assert tip == pytest.approx(tip_mm, rel=0.15)


def test_no_limit_cycle_at_lower_gain() -> None:
    """Row 8: it vanishes at 0.7 V/deg and below."""
    assert release(0.7, 30, 45)[1] < 0.01


@pytest.mark.parametrize(
    ("frequency_Hz", "spread_dB", "spread_deg"), [(1, 2.7, 5), (3, 3.9, 13), (5, 4.7, 17), (8, 5.5, 22), (12, 7.2, 22)]
)
def test_amplitude_sensitivity_of_the_cylinder(frequency_Hz: float, spread_dB: float, spread_deg: float) -> None:
    """Row 12: spread over 0.1, 0.2, 0.5 and 1 V at mid stroke; set R has a valve without null adjustment, so the cylinder creeps at 0 V."""
    sim = SimulatedRig(ornl(isothermal, centred_null, without("link_flexibility")))
    gains = np.array([joint_response_from_mid_stroke(sim, amplitude, frequency_Hz) for amplitude in (0.1, 0.2, 0.5, 1.0)])
    assert np.ptp(20 * np.log10(np.abs(gains))) == pytest.approx(spread_dB, abs=1.5)
    assert np.ptp(np.degrees(np.unwrap(np.angle(gains)))) == pytest.approx(spread_deg, abs=8)


def joint_response_from_mid_stroke(sim: SimulatedRig, amplitude_V: float, frequency_Hz: float) -> complex:
    return joint_response(sim, "prismatic", amplitude_V, frequency_Hz, positions=[0.0, 36 * INCH_M])


@pytest.mark.parametrize("damping_ratio", [0.1, 0.4])
def test_a_strongly_damped_link_is_integrated_as_with_tiny_steps(damping_ratio: float) -> None:
    """Its second shape creeps, up to a hundred times as fast as it would vibrate: steps for the frequency alone ran away."""

    def tip_mm(step_s: float) -> np.ndarray:
        sim = SimulatedRig(ornl(isothermal))
        sim.parameters.values[C.LINK_DAMPING], sim.parameters.values[C.STEP] = damping_ratio, step_s
        sim.reset(positions=[0.0, 15 * INCH_M])
        found = []
        for k in range(500):
            sim.advance([3.0 if k < 250 else -3.0, 2.0], 1e-3)
            found.append(1e3 * sim.true_signal("tip.deflection"))
        return np.array(found)

    coarse, fine = tip_mm(1e-3), tip_mm(1e-5)
    assert np.abs(fine).max() > 1.0
    np.testing.assert_allclose(coarse, fine, atol=1e-3 * np.ptp(fine))
