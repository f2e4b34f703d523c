"""Friction of other forms: the stop operator against its closed form, and which joints get which changes."""

from __future__ import annotations

import numpy as np
import pytest

from config.loading.load import load_rig
from gap.evidence.noise.repeated import FORMS, element, other_forms
from sim_backend.kernel.parameters import Parameters
from sim_backend.memory.layout import J_START, J


def test_an_element_draws_over_its_way_and_then_slips() -> None:
    """There over 5 ways, back over half a one, back over 5: Masing's rule, a turn needs twice the way."""
    way = 1e-3
    path = np.concatenate([np.linspace(0, 5, 501), np.linspace(5, 4.5, 51), np.linspace(4.5, 0, 451)]) * way
    held = element(path, way)
    assert held[50] == pytest.approx(0.5)
    assert np.all(held[100:501] == pytest.approx(1.0))
    assert held[551] == pytest.approx(0.5)  # half a way back: from 1 to a half
    assert held[705] == pytest.approx(-1.0)
    assert held[-1] == pytest.approx(-1.0)


@pytest.mark.parametrize("way", [1e-4, 1e-3, 1e-2])
def test_work_of_a_closed_loop_is_that_of_its_area(way: float) -> None:
    """Back and forth over 2 A: 4 (A − way) of work a cycle where A > way, none where it never slips."""
    amplitude = 2e-3
    t = np.linspace(0, 4 * np.pi, 200001)
    position = amplitude * np.sin(t)
    held = element(position, way)
    last = slice(100000, None)  # the second cycle
    work = float(np.sum(0.5 * (held[last][1:] + held[last][:-1]) * np.diff(position[last])))
    assert work == pytest.approx(max(4.0 * (amplitude - way), 0.0), abs=2e-7)


def test_only_hydraulic_joints_with_friction_get_other_bristles() -> None:
    p = Parameters(load_rig("ornl_testbed").rig).values
    found = other_forms(p)
    assert len(found) == 2 * len(FORMS)
    for other, (_, times, elastic) in zip(found, 2 * FORMS, strict=True):
        assert np.count_nonzero(other != p) == (times != 1.0) + (elastic > 0.0)
    smooth = p.copy()
    smooth[[J_START + J.COULOMB, J_START + J.STICTION]] = 0.0
    assert len(other_forms(smooth)) == len(FORMS)
    assert other_forms(Parameters(load_rig("force_axis").rig).values) == []
