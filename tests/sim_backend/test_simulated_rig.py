"""The rig as a whole: determinism, step size, start, the way commands and counts go in and out, refusals, warming up."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

from config.errors import PlantError
from config.schema.rig import Rig
from sim_backend.kernel.warm_up import warm_up
from sim_backend.memory import compile_cache
from sim_backend.memory.layout import PARAMETERS, C, S
from tests.support.sim_backend.plants import Content, SimulatedRig, ideal, isothermal, ornl, quiet, variant, without

GPM = 6.30902e-5


@pytest.fixture(scope="module")
def rig() -> Rig:
    return ornl()


def excursion(seconds: float, period_s: float = 1e-3) -> np.ndarray:
    t = np.arange(round(seconds / period_s)) * period_s
    return np.column_stack([1.5 * np.sin(2 * np.pi * 1.3 * t), 4.0 * np.sin(2 * np.pi * 0.9 * t + 0.3)])


def test_many_periods_are_single_periods(rig: Rig) -> None:
    """run() and advance() are the same simulation, bit for bit; sense() is the row run() writes."""
    commands = excursion(0.3)
    bulk, single = SimulatedRig(rig, seed=4), SimulatedRig(rig, seed=4)
    result = bulk.run(commands, 1e-3, sense=True)
    for k, row in enumerate(commands):
        assert result["raw"][k].tolist() == single.sense()
        assert result["rotary.position"][k] == single.true_position[0]
        single.advance(row.tolist(), 1e-3)
    assert (bulk.state == single.state).all()


@pytest.mark.slow
def test_same_in_another_process(rig: Rig) -> None:
    code = (
        "from config.loading.load import load_rig; from sim_backend.plant import SimulatedRig; import numpy as np, hashlib;"
        "s = SimulatedRig(load_rig('ornl_testbed').rig, seed=11); s.run(np.full((500, 2), 0.7), 1e-3);"
        "print(hashlib.sha256(s.state.tobytes()).hexdigest())"
    )
    runs = {subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout for _ in range(2)}
    assert len(runs) == 1


def test_reset_starts_over(rig: Rig) -> None:
    sim = SimulatedRig(rig, seed=1)
    first = sim.run(excursion(0.2), 1e-3, sense=True)
    sim.reset()
    again = sim.run(excursion(0.2), 1e-3, sense=True)
    assert all(np.array_equal(first[key], again[key]) for key in first)
    sim.reset(positions=[0.3, 0.7], temperature_C=25.0)
    assert sim.true_position == [0.3, 0.7]
    assert sim.true_signal("reservoir_temperature") == 25.0


def test_start_is_at_rest(rig: Rig) -> None:
    """Nothing jumps at the start: with command 0 pressures and positions stay within 0.1 % and 1 mm for a second."""
    result = SimulatedRig(rig).run(np.zeros((1000, 2)), 1e-3)
    for side in ("rotary.pressure_a", "prismatic.pressure_a", "prismatic.pressure_b"):
        assert np.ptp(result[side]) < 2e-3 * result[side].mean()
    assert np.ptp(result["prismatic.position"]) < 1e-3
    assert np.ptp(result["rotary.position"]) < 1e-5
    assert np.abs(result["tip.acceleration"]).max() < 0.02


def test_step_size_is_converged(rig: Rig) -> None:
    """Fast moves of both joints: the shipped step against one eight times finer, relative to each signal's swing."""
    runs = []
    for step_s in (SimulatedRig(rig).parameters.values[C.STEP], 1e-3 / 24):
        sim = SimulatedRig(rig)
        sim.parameters.values[C.STEP] = step_s
        sim.reset()
        runs.append(sim.run(excursion(3.0), 1e-3))
    shipped, fine = runs
    for signal in ("rotary.position", "prismatic.position", "rotary.pressure_a", "prismatic.pressure_b", "tip.deflection"):
        error = np.sqrt(np.mean((shipped[signal] - fine[signal]) ** 2)) / np.ptp(fine[signal])
        assert error < 1e-5, (signal, error)


def test_step_is_shortened_as_the_link_retracts() -> None:
    """Unloaded, from 40 in onto the inner stop at full flow: there the second shape is at 1411 Hz, which steps of 1 ms would blow up."""

    def light(content: Content) -> None:
        content["plant"]["link"]["payload"] = 0

    commands = np.column_stack([excursion(2.0)[:, 0], np.full(2000, -10.0)])
    runs = []
    for step_s in (1e-3, 1e-3 / 24):
        sim = SimulatedRig(ornl(light))
        sim.parameters.values[C.STEP] = step_s
        runs.append(sim.run(commands, 1e-3))
    shipped, fine = runs
    assert shipped["prismatic.position"][-1] < 12.5 * 0.0254  # it reached the stop
    for signal in ("tip.deflection", "rotary.position", "prismatic.position"):
        assert np.sqrt(np.mean((shipped[signal] - fine[signal]) ** 2)) < 0.01 * np.ptp(fine[signal]), signal


def test_control_periods_of_other_lengths(rig: Rig) -> None:
    """Two periods of half the length with the same command and steps give the same motion; heat is told twice as often."""
    runs = []
    for commands, period_s in ((excursion(0.5), 1e-3), (np.repeat(excursion(0.5), 2, axis=0), 5e-4)):
        sim = SimulatedRig(rig)
        sim.parameters.values[C.STEP] = 5e-4
        runs.append(sim.run(commands, period_s))
    whole, halves = runs
    assert halves["rotary.position"][::2] == pytest.approx(whole["rotary.position"], abs=1e-7)


def test_vectors_have_names(rig: Rig) -> None:
    sim = SimulatedRig(rig)
    assert len(sim.parameters.names) == PARAMETERS == sim.parameters.values.size
    assert len(set(sim.parameters.names)) == PARAMETERS
    assert sim.parameters.values[sim.parameters.names.index("slot0.coulomb")] == 105.0
    assert sim.channels == tuple(rig.plant.sensors)  # type: ignore[union-attr]


def test_calibrations_of_the_shipped_rigs_equal_the_sensors() -> None:
    """raw × scale + offset of the rig file is the plant's own value."""
    for name in ("ornl_testbed", "force_axis"):
        rig = variant(name, quiet)
        sim = SimulatedRig(rig)
        for channel, raw in zip(sim.channels, sim.sense(), strict=True):
            calibration = rig.signals[channel].calibration
            resolution = sim.parameters.values[sim.parameters.offset(S.RESOLUTION, f"sensor:{channel}")]
            assert calibration.scale == pytest.approx(resolution, rel=1e-9)
            assert calibration.offset + calibration.scale * raw == pytest.approx(sim.true_signal(channel), abs=0.51 * resolution)


def test_wrong_rigs_are_refused(rig: Rig) -> None:
    with pytest.raises(PlantError, match="no section 'plant'"):
        SimulatedRig(rig.model_copy(update={"plant": None}))

    def no_oil(content: Content) -> None:
        del content["plant"]["oil"]

    with pytest.raises(PlantError, match="hydraulic"):
        SimulatedRig(ornl(no_oil))
    with pytest.raises(PlantError, match="one column a joint"):
        SimulatedRig(rig).run(np.zeros((5, 3)), 1e-3)
    with pytest.raises(ValueError, match="argument"):
        SimulatedRig(rig).advance([0.0], 1e-3)


def test_compilation_is_announced_only_when_needed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    said: list[str] = []
    compile_cache.announce(said.append)
    assert said == [], "the kernel has been compiled by now"
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    compile_cache.announce(said.append)
    assert len(said) == 1
    assert "compiling the simulation kernel" in said[0]


def test_cache_directory_is_of_these_sources_and_writable(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    monkeypatch.setenv("CACHE_DIRECTORY", str(tmp_path))
    compile_cache.prepare()
    assert str(compile_cache.directory()) == numba.config.CACHE_DIR
    assert tmp_path in compile_cache.directory().parents
    blocked = tmp_path / "file"
    blocked.touch()
    monkeypatch.setenv("CACHE_DIRECTORY", str(blocked))
    compile_cache.prepare()
    assert Path(numba.config.CACHE_DIR).is_dir(), "a directory of its own where the wanted one cannot be made"
    Path(numba.config.CACHE_DIR).rmdir()


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", ["shipped", "ideal", "stiff oil"])
def test_any_command_stays_physical(name: str, seed: int) -> None:
    """Full-scale jumps into both ends of both joints: finite, pressures above vapour, positions within the stops' give."""
    changes = {"shipped": (), "ideal": (ideal,), "stiff oil": (without("hose_compliance", "entrained_air"),)}[name]
    random = np.random.default_rng(seed)
    commands = np.repeat(random.uniform(-10, 10, (40, 2)), 250, axis=0)
    result = SimulatedRig(ornl(isothermal, *changes)).run(commands, 1e-3)
    assert all(np.isfinite(values).all() for values in result.values())
    for signal in ("rotary.pressure_a", "rotary.pressure_b", "prismatic.pressure_a", "prismatic.pressure_b"):
        assert result[signal].min() >= 1e4 - 101325
    assert np.abs(result["rotary.position"]).max() < np.pi / 2 + 0.02
    assert result["prismatic.position"].min() > 0.3048 - 3e-3
    assert result["prismatic.position"].max() < 1.524 + 3e-3


def test_warming_up_over_five_hours(rig: Rig) -> None:
    """Row 10: 20 min idle, then cycles of 12 min at 5 gpm, 8 min at 1.2 gpm, 5 min pause (0.6 gpm)."""
    minutes = [0.6] * 20 + ([5.0] * 12 + [1.2] * 8 + [0.6] * 5) * 12
    flow = np.repeat(minutes, 60)[: 5 * 3600] * GPM
    result = warm_up(rig, flow, 1.0, 22.0)
    reservoir, supply, hours = result["reservoir_temperature"], result["supply_temperature"], result["t_s"] / 3600
    assert 50 < reservoir[-1] < 60
    assert (np.diff(reservoir[::1500]) > -0.5).all()
    reached = hours[np.argmax(reservoir - 22 > 0.63 * (reservoir[-1] - 22))]
    assert 1.0 < reached < 1.5
    last = hours > 4
    ripple = np.ptp(supply[last])
    assert 4 < ripple < 9
    assert ripple > 3 * np.ptp(reservoir[last])
    assert supply[1199] < reservoir[1199]
    assert (supply > reservoir + 1).any()
