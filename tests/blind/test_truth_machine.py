"""The hidden machine's hydraulics and friction against closed forms of docs/method/plant.md; the log it writes against the contract."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.loading.load import load_rig
from gap.data.measured import load
from tests.blind.truth.effects import EFFECTS, STRANGE
from tests.blind.truth.friction import BRISTLE, ELEMENTS, RIGID, SLIP, bristle_force, bristle_rate, element_force, level, slip
from tests.blind.truth.machine import Machine
from tests.blind.truth.nominal import jittered, machine, nominal
from tests.blind.truth.plant import PRESSURE, Q, W, advance, at_rest
from tests.blind.truth.session import Hidden, Setting, numbers_of, record

pytestmark = pytest.mark.slow  # numba compiles the whole machine
RIG = load_rig("ornl_testbed").rig
NUMBERS = nominal(RIG)
SMOOTH = {f"{j}.{k}": 0.0 for j in ("rotary", "prismatic") for k in ("coulomb", "stiction", "null", "hysteresis")}
TIGHT = {"prismatic.viscous": 0.0, "prismatic.cross": 0.0, "prismatic.rounding": 1e-4}


def driven(m: Machine, volts: tuple[float, float], seconds: float, start: tuple[float, float] = (0.0, 0.9)) -> np.ndarray:
    """State after constant commands."""
    cycles = round(seconds / 1e-3)
    commands = np.tile(np.array(volts), (cycles, 1))
    y, play = at_rest(m, start), np.zeros(2)
    for k in range(cycles):
        advance(y, play, commands, k, 1e-3 * k, 1e-3, 40.0, m)
    return y


def test_cylinder_extends_faster_than_it_retracts() -> None:
    """Symmetric valve on areas of ratio r: v_ext / v_ret = 1/√r, pressures of (P10)."""
    m = machine(NUMBERS | SMOOTH | TIGHT)
    out, back = driven(m, (0.0, 2.0), 0.8), driven(m, (0.0, -2.0), 0.8)
    earlier = driven(m, (0.0, 2.0), 0.4), driven(m, (0.0, -2.0), 0.4)  # speeds over 0.4 s: the piston rings on its oil
    assert (out - earlier[0])[Q + 1] / -(back - earlier[1])[Q + 1] == pytest.approx(1.1547, rel=0.005)
    supply = NUMBERS["supply"]
    assert out[PRESSURE + 2 : PRESSURE + 4] / supply == pytest.approx([0.297, 0.396], rel=0.01)
    assert back[PRESSURE + 2 : PRESSURE + 4] / supply == pytest.approx([0.527, 0.703], rel=0.01)


def test_small_signal_gain_of_the_rotary_joint() -> None:
    """43.09 deg/s per volt without dry friction (set R of docs/method/plant.md)."""
    y = driven(machine(NUMBERS | SMOOTH | {"rotary.viscous_share": 0.0}), (0.1, 0.0), 2.0)
    assert np.degrees(y[W]) == pytest.approx(4.309, rel=0.01)


def test_friction_holds_against_what_it_can() -> None:
    """A dead valve and chambers at rest: with the supply cut the arm stays where it is under a tilt that friction can carry."""
    for form in (SLIP, RIGID, BRISTLE):
        m = machine(NUMBERS | {"friction_form": form, "gravity": 0.2, "rotary.null": 0.0})
        y = driven(m, (0.0, 0.0), 0.5, (0.5, 0.9))
        assert abs(y[Q] - 0.5) < 2e-3


def test_elements_and_bristles_slide_at_the_same_level() -> None:
    """Steady sliding gives g(v) in every form; the elements' first stiffness is the bristles'."""
    j = machine(NUMBERS).rotary
    for v in (0.003, 0.05, -0.3):
        g = level(v, 0.0, 0.0, 40.0, j)
        z, one = np.zeros(ELEMENTS), 0.0
        for _ in range(200_000):
            z += 1e-6 * np.sign(v)
            slip(z, g, j)
            one += 1e-6 / abs(v) * bristle_rate(one, v, g, j)
        assert element_force(z, v, g, j) == pytest.approx(np.sign(v) * g, rel=1e-3)
        assert bristle_force(one, v, g, j) == pytest.approx(np.sign(v) * g, rel=1e-2)
    small = np.full(ELEMENTS, 1e-7)
    assert element_force(small, 0.0, g, j) == pytest.approx(j.bristle * 1e-7, rel=1e-6)


def test_constants_stay_within_their_errors() -> None:
    off = [jittered(NUMBERS, seed) for seed in range(200)]
    relative = {k: np.array([n[k] / v - 1 for n in off]) for k, v in NUMBERS.items() if v}
    assert np.abs(relative["supply"]).max() <= 0.02
    assert 0.15 < np.abs(relative["rotary.bristle"]).max() <= 0.20
    assert 0.08 < np.abs(relative["rotary.coulomb"]).max() <= 0.10
    assert np.all(relative["prismatic.high"] == 0)


def test_every_effect_of_the_contract_can_be_hidden() -> None:
    """Each changes some number of the machine or some channel of the log."""
    plain = numbers_of(RIG, Setting(3))

    places = {"supply_droop": "supply", "return_back_pressure": "supply", "line_loss": "supply"}
    places |= dict.fromkeys(("link_flexibility", "payload_error", "link_damping_error"), "link")
    for effect in (*EFFECTS, *STRANGE):
        if effect.startswith("sensor_"):
            continue
        hidden = Hidden(effect, places.get(effect, "prismatic"), 0.37)
        assert numbers_of(RIG, Setting(3, (hidden,))) != plain, effect


def test_a_log_is_one_the_search_can_read(tmp_path: Path) -> None:
    polarity, offset = Hidden("sensor_polarity", "sensor:tip.deflection", -1.0), Hidden("sensor_offset", "sensor:tip.deflection", 1e-3)
    logs = []
    for k, hidden in enumerate(((), (polarity,), (offset,))):
        record(RIG, Setting(4, hidden, chambers=True), "strokes", 3.0, 0, tmp_path / f"{k}.csv")
        logs.append(load(tmp_path / f"{k}.csv", RIG))
    assert logs[0].rows == pytest.approx(3000, abs=2)
    assert set(logs[0].channels) >= {"rotary.position", "tip.acceleration", "prismatic.supply_pressure"}
    tips = [log.channels["tip.deflection"].values for log in logs]
    assert np.corrcoef(tips[0], tips[1])[0, 1] < -0.99
    assert np.mean(tips[2] - tips[0]) == pytest.approx(1e-3, abs=2e-6)  # the servo does not look at the tip
