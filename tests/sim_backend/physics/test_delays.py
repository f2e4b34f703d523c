"""Delays of command and sensor: exact over the whole range that a rig file may give, at every rate, whatever the integration step."""

from __future__ import annotations

import numpy as np
import pytest

from tests.support.sim_backend.plants import SimulatedRig, variant, with_effects

LONGEST_S = 0.1


def spool(delay_s: float, period_s: float, command: np.ndarray) -> np.ndarray:
    """Opening of the force axis, whose spool follows at once, times its full scale: the command that arrived at the last step."""
    late = with_effects({"effect": "transport_delay", "where": "axis", "delay": f"{delay_s} s"})
    rig = variant("force_axis", late)
    plant = SimulatedRig(rig)
    return np.asarray(plant.run(command[:, None], period_s)["axis.spool"] * 10.0 + 0.0899)


@pytest.mark.parametrize("rate_Hz", [100, 1000, 2000, 10_000])
def test_the_longest_command_delay(rate_Hz: int) -> None:
    rows = round(LONGEST_S * rate_Hz)
    command = np.concatenate([np.zeros(5), np.linspace(-1, 1, 40), np.zeros(rows + 5)])
    arrived = spool(LONGEST_S, 1 / rate_Hz, command)
    assert arrived[rows + 1 : rows + 46] == pytest.approx(command[:45], abs=1e-9)
    assert arrived[: rows + 5] == pytest.approx(0.0, abs=1e-9)


def test_a_delay_of_parts_of_a_step_shares_the_command_out() -> None:
    """Four steps a period: a delay of half a step leaves the last step with one half of the old and one half of the new command."""
    arrived = spool(3.5 * 2.5e-4, 1e-3, np.array([0.0, 1.0, 1.0, 1.0]))
    assert arrived == pytest.approx([0.0, 0.0, 0.5, 1.0], abs=1e-9)


@pytest.mark.parametrize("rate_Hz", [100, 1000, 10_000])
def test_the_longest_sensor_delay(rate_Hz: int) -> None:
    late = with_effects({"effect": "sensor_delay", "where": "sensor:axis.position", "delay": f"{LONGEST_S} s"})
    plant = SimulatedRig(variant("force_axis", late))
    rows = round(LONGEST_S * rate_Hz)
    result = plant.run(np.full((3 * rows, 1), 3.0), 1 / rate_Hz, sense=True)
    reading = result["raw"][:, plant.channels.index("axis.position")] * 1e-6
    assert reading[rows:] == pytest.approx(result["axis.position"][:-rows], abs=0.6e-6)
