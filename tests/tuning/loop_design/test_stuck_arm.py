"""An arm on a joint that friction holds: the linear arm against the plant, and the limit of the friction gain against releases."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm

from config.schema.rig import Rig
from servo_control.link.end_point import lead_shares
from servo_control.link.link_mode import LinkFrequency
from sim_backend.memory.layout import J
from sim_backend.plant import SimulatedRig
from tuning.experiments.release import ReleaseConditions, release, servo_of
from tuning.linear.closed_loop import modes, sampled_loop
from tuning.linear.linear_arm import linear_arm
from tuning.loop_design.stuck_arm import largest_friction_gain, stuck_damping, stuck_places

INCH, POUND = 0.0254, 0.45359237


def test_a_held_joint_moves_as_the_plant_does(rig: Rig) -> None:
    """A step of 2 mV, a tenth of what breaks it loose, hysteresis off: hub over 0.3 s against the kernel's own bristles."""
    plant = SimulatedRig(rig)
    plant.parameters.values[plant.parameters.offset(J.HYSTERESIS, "rotary")] = 0.0
    plant.reset([0.0, 0.9])
    ran = plant.run(np.tile([0.002, 0.0], (300, 1)), 0.001)
    arm = linear_arm(rig, 0.9, stuck=True)
    n = len(arm.b)
    block = np.zeros((n + 1, n + 1))
    block[:n, :n], block[:n, n] = arm.a, arm.b
    one, state, theta = expm(block * 0.001), np.append(np.zeros(n), 0.002), []
    for _ in range(300):
        theta.append(arm.position @ state[:n])
        state = one @ state
    assert np.abs(ran["rotary.position"] - theta).max() < 0.15 * np.abs(theta).max()  # bristles soften as they bend


def test_the_link_of_a_held_joint_has_nearly_its_clamped_frequency(rig: Rig) -> None:
    """36 in, nothing at the tip: 25.0 Hz clamped (Euler and Bernoulli); on bristles and oil, whose stiffness adds, a little less."""
    found = modes(linear_arm(rig, 36 * INCH, 0.0, stuck=True).a)
    nearest = np.argmin(np.abs(found.frequency_Hz - 25.016))
    assert 0.97 * 25.016 < found.frequency_Hz[nearest] < 1.01 * 25.016
    assert found.damping_ratio[nearest] > 0.0


def test_shipped_friction_gain_has_room_and_twice_as_much_has_not(rig: Rig) -> None:
    """The family's gain of 1.2 is in it."""
    assert rig.end_point is not None
    servo, shipped = servo_of(rig), rig.end_point.friction_gain
    places = stuck_places(rig)
    assert stuck_damping(places, 0.001, servo, shipped) > 0.0
    assert stuck_damping(places, 0.001, servo, 2.0 * shipped) < 0.0


def test_lead_damps_a_fast_link_that_the_feedback_did_not(rig: Rig) -> None:
    """10 lb at 30 in, 11 Hz, joint stuck, payload known: with the lead its mode has six times the damping and more."""
    assert rig.end_point is not None
    assert rig.link_mode is not None
    link, servo = LinkFrequency(rig.link_mode.model_copy(update={"payload_kg": 10 * POUND})), servo_of(rig)
    frequency_Hz = link.frequency_Hz(30 * INCH)
    push = rig.end_point.friction_gain * 2 * np.pi * frequency_Hz * 0.0228
    arm = linear_arm(rig, 30 * INCH, 10 * POUND, stuck=True)

    def damping(lead: tuple[float, float]) -> float:
        loop = sampled_loop(arm, replace(servo, push=push, tip_lead=lead), 0.001)
        found = modes(loop, 0.001)
        near = (found.frequency_Hz > 0.7 * frequency_Hz) & (found.frequency_Hz < 1.4 * frequency_Hz)
        return float(found.damping_ratio[near].min())

    with_lead = damping(lead_shares(rig.end_point, frequency_Hz))
    assert with_lead > 0.05
    assert with_lead > 6 * damping((1.0, 0.0))


@pytest.mark.slow
def test_the_limit_is_where_a_release_begins_to_hum(rig: Rig) -> None:
    """36 in to 48 in, empty: quiet with the shipped gain, humming above the empty link's 12 Hz with five times the limit."""
    assert rig.end_point is not None
    limit = largest_friction_gain(rig, servo_of(rig))
    assert rig.end_point.friction_gain <= limit
    bold = rig.model_copy(update={"end_point": rig.end_point.model_copy(update={"friction_gain": 5.0 * limit})})
    place = ReleaseConditions(48 * INCH, 0.0)
    assert release(rig, place, servo_of(rig), 15.0).tip_amplitude_m < 2e-4
    humming = release(bold, place, servo_of(bold), 15.0)
    assert humming.tip_amplitude_m > 3e-4
    assert 12.0 < _tip_Hz(humming.deflection_m[-5000:]) < 16.0


def _tip_Hz(deflection: np.ndarray) -> float:
    spectrum = np.abs(np.fft.rfft(deflection - deflection.mean()))
    return float(np.argmax(spectrum)) / (len(deflection) * 0.001)
