"""How far a maneuver separates two explanations, against dense linear algebra."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from config.errors import ManeuverError
from config.loading.load import LoadedRig, load_rig
from gap.data.noise import noise_floors
from gap.data.window_length import window_length_s
from gap.data.windows import prepare
from gap.fitting.sensitivity import projected, sensitivities
from gap.fitting.simulate import simulate
from gap.maneuvers.closed_loop import measured_on
from gap.maneuvers.designs import ManeuverDesign, designs
from gap.maneuvers.extra_sensor import ExtraSensor, with_sensors
from gap.maneuvers.rivals import no_effect, rival_of
from gap.maneuvers.separation import Comparison, observed
from tests.support.gap import axis_logs
from tests.support.gap.compared import compare

START = {"start": {"axis": "0.125 m"}, "joint": "axis"}
TRIANGLE = ManeuverDesign("slow_triangle", {**START, "amplitude": "0.04 m", "rate": "0.08 m/s", "cycles": 2})


def axis(*without: str) -> LoadedRig:
    return LoadedRig(axis_logs.axis_rig(*without), axis_logs.axis_text(*without), "axis.yaml")


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    loaded = axis("coulomb_friction")
    return compare(loaded, rival_of(loaded, "coulomb_friction", "axis", {"friction": 2.0}), no_effect(loaded), TRIANGLE.content)


def test_the_constants_take_their_share_as_in_the_gaussian_integral(comparison: Comparison) -> None:
    """With only priors free, T = eᵀ (I + J Jᵀ)⁻¹ e less what the truth leaves; the side without an effect has nothing but priors."""
    rival, seen = comparison.rival, comparison.seen
    numbers = range(len(rival.model.free))
    columns = projected(seen, sensitivities(rival.model, [seen.experiment], numbers, [seen.readings])[0])
    J, e = columns.reshape(len(numbers), -1).T, seen.left.ravel()
    direct = float(e @ np.linalg.solve(np.eye(e.size) + J @ J.T, e)) - float(np.sum(comparison.run.own.left**2))
    assert pytest.approx(direct, rel=1e-6) == comparison.exact().T


def test_refitting_only_takes_away(comparison: Comparison) -> None:
    exact, bound = comparison.exact(), comparison.bound()
    assert 0.0 < exact.T <= bound.T * (1 + 1e-9)


def test_an_explanation_is_not_separated_from_itself() -> None:
    loaded = axis("coulomb_friction")
    same = rival_of(loaded, "coulomb_friction", "axis", {"friction": 20.0})
    found = compare(loaded, same, same, TRIANGLE.content).exact()
    assert pytest.approx(0.0, abs=1e-6) == found.T
    assert found.t == 0.0


def test_a_late_command_is_not_separated_from_a_late_encoder_by_what_starts_of_windows_leave() -> None:
    """Exactly the same on the position, but each starts its windows in another phase of the motion; near standstill start states taken
    out about one of the two alone left T > 100 on this wave."""
    loaded = axis()
    command = rival_of(loaded, "transport_delay", "axis", {"delay": 0.004})
    encoder = rival_of(loaded, "sensor_delay", "sensor:axis.position", {"delay": 0.004})
    wave = next(d for d in designs(loaded.rig, ["axis"], thorough=False) if d.parameters.get("amplitude") == "2 V" and "2 Hz" in d.label)
    found = [compare(loaded, *pair, wave.content).exact() for pair in ((command, encoder), (encoder, command))]
    assert min(side.T for side in found) < 9.0
    assert min(side.t for side in found) < 0.5


def test_a_rival_takes_over_the_constants_but_not_the_effect() -> None:
    loaded = axis()
    truth = rival_of(loaded, "transport_delay", "axis", {"delay": 0.004})
    moved = rival_of(loaded, "sensor_delay", "sensor:axis.position", {"delay": 0.003})
    moved = replace(moved, model=moved.model.with_theta(1.1 * moved.model.theta))
    found = moved.with_constants_of(truth)
    np.testing.assert_array_equal(found.model.theta[:-1], truth.model.theta[:-1])
    assert found.model.theta[-1] == pytest.approx(0.0033)


def test_a_sensor_not_looked_at_changes_no_reading() -> None:
    """To the last bit."""
    loaded, channels = axis(), ["axis.position"]
    plain = rival_of(loaded, "transport_delay", "axis", {"delay": 0.004})
    rival = replace(plain, model=with_sensors(plain.model, [ExtraSensor(("axis.second_position",))]))
    log = measured_on(rival.model.fitted_rig(), TRIANGLE.content)
    sigma = noise_floors([log], rival.model.rig)
    whole = prepare(log, rival.model.rig, sigma, window_length_s(loaded.rig, [log], sigma), channels)
    readings = simulate(whole, [rival.model.vector()])[0]
    np.testing.assert_array_equal(observed(loaded, rival, log, channels).own.readings, readings)


def test_what_would_near_an_interlock_is_not_run() -> None:
    """The largest wave that the following error allows shakes the tip beyond what the testbed's interlock leaves."""
    rig = load_rig("ornl_testbed").rig
    wave = next(d for d in designs(rig, ["rotary"], thorough=False) if d.parameters.get("amplitude") == "1.4 V")
    with pytest.raises(ManeuverError, match=r"tip\.acceleration would come too near its limit"):
        measured_on(rig, wave.content)
