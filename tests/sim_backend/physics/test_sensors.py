"""Sensors: noise size and colour, lag, delay, range, resolution, drop-outs, and that the same seed gives the same readings."""

from __future__ import annotations

import math

import numpy as np
import pytest

from config.schema.rig import Rig
from sim_backend.memory.layout import H, S
from sim_backend.physics.noise import gaussian_pair, mixed, sample_key, uniform
from tests.support.sim_backend.plants import SimulatedRig, ornl, with_effects

STILL = np.zeros((20000, 2))
SWEEPING = np.column_stack([np.sin(np.arange(20000) * 0.004), 2 * np.cos(np.arange(20000) * 0.004)])


@pytest.fixture(scope="module")
def rig() -> Rig:
    return ornl()


def entry(sim: SimulatedRig, signal: str, index: S) -> int:
    return sim.parameters.offset(index, f"sensor:{signal}")


def readings(sim: SimulatedRig, signal: str, commands: np.ndarray = STILL, period_s: float = 1e-3) -> np.ndarray:
    """Readings in the signal's unit."""
    raw = sim.run(commands, period_s, sense=True)["raw"][:, sim.channels.index(signal)]
    return raw * sim.parameters.values[entry(sim, signal, S.RESOLUTION)]


def test_random_numbers_are_splitmix64() -> None:
    """The published first outputs for seed 0 (Vigna's splitmix64.c: state 0 gives e220a8397b1dcdaf, then 6e789e6aa1b965f4)."""
    golden = 0x9E3779B97F4A7C15
    assert int(mixed(np.uint64(0))) == 0xE220A8397B1DCDAF
    assert int(mixed(np.uint64(golden))) == 0x6E789E6AA1B965F4


def test_random_numbers_are_normal() -> None:
    drawn = np.array([gaussian_pair(np.uint64(sample_key(1.0, float(i))), 0) for i in range(40000)]).ravel()
    assert drawn.mean() == pytest.approx(0, abs=0.015)
    assert drawn.std() == pytest.approx(1, abs=0.015)
    assert (drawn**4).mean() == pytest.approx(3, abs=0.12)
    even = np.array([uniform(2.0, float(i), 5) for i in range(20000)])
    assert even.min() > 0
    assert even.max() < 1
    assert np.histogram(even, 10)[0] == pytest.approx(2000, rel=0.08)


@pytest.mark.parametrize(
    ("signal", "rms"), [("rotary.position", math.radians(0.002)), ("prismatic.position", 10e-6), ("tip.deflection", 20e-6)]
)
def test_white_noise_has_its_rms(rig: Rig, signal: str, rms: float) -> None:
    """rms of the reading's error = noise and rounding to the resolution together (independent while the signal moves)."""
    sim = SimulatedRig(rig, seed=3)
    result = sim.run(SWEEPING, 1e-3, sense=True)
    resolution = sim.parameters.values[entry(sim, signal, S.RESOLUTION)]
    error = result["raw"][:, sim.channels.index(signal)] * resolution - result[signal]
    assert error.std() == pytest.approx(math.hypot(rms, resolution / math.sqrt(12)), rel=0.05)


def test_coloured_noise_has_its_bandwidth(rig: Rig) -> None:
    """Accelerometer: 2 mg rms behind a first-order corner at 100 Hz: autocorrelation exp(−2π f τ)."""
    sim = SimulatedRig(rig, seed=5)
    sim.parameters.values[entry(sim, "tip.acceleration", S.RESOLUTION)] = 1e-9
    error = readings(sim, "tip.acceleration")
    error = error - error.mean()
    assert error.std() == pytest.approx(0.002 * 9.80665, rel=0.05)
    for lag in (1, 2, 4):
        correlation = np.mean(error[lag:] * error[:-lag]) / error.var()
        assert correlation == pytest.approx(math.exp(-2 * math.pi * 100 * lag * 1e-3), abs=0.03)


def test_bias_resolution_and_range(rig: Rig) -> None:
    sim = SimulatedRig(rig)
    p = sim.parameters.values
    assert np.mean(readings(sim, "tip.acceleration")) == pytest.approx(0.005 * 9.80665, rel=0.1)
    p[entry(sim, "tip.deflection", S.BIAS)] = 1.0
    assert readings(sim, "tip.deflection", STILL[:10]) == pytest.approx(np.full(10, 0.05))
    assert all(float(count).is_integer() for count in sim.sense())


def test_first_order_lag(rig: Rig) -> None:
    """A thermometer with 5 s: after a jump of the oil, 63 % in 5 s."""
    sim = SimulatedRig(rig)
    p = sim.parameters.values
    p[entry(sim, "reservoir_temperature", S.BIAS)] = 0.0
    p[entry(sim, "reservoir_temperature", S.RESOLUTION)] = 1e-6
    start = readings(sim, "reservoir_temperature", STILL[:1])[0]
    sim.state[H.RESERVOIR] += 10.0
    lagged = readings(sim, "reservoir_temperature", STILL[:4975])
    assert lagged[-1] - start == pytest.approx(10 * (1 - math.exp(-1)), rel=5e-3)


def test_drop_outs_come_at_their_rate(rig: Rig) -> None:
    sim = SimulatedRig(rig, seed=9)
    sim.parameters.values[entry(sim, "rotary.position", S.DROPOUT)] = 0.01
    lost = np.isnan(readings(sim, "rotary.position"))
    assert lost.mean() == pytest.approx(0.01, abs=0.003)
    assert not np.isnan(readings(sim, "prismatic.position")).any()


MOVING = np.column_stack([0.5 * np.sin(np.arange(3000) * 0.01), np.zeros(3000)])


@pytest.mark.parametrize(
    ("entry_", "expected"),
    [
        ({"effect": "sensor_delay", "delay": "10 ms"}, lambda x: np.concatenate([np.full(10, x[0]), x[:-10]])),
        ({"effect": "sensor_delay", "delay": "2.5 ms"}, lambda x: np.interp(np.arange(x.size) - 2.5, np.arange(x.size), x)),
        ({"effect": "sensor_scale", "factor": 1.1}, lambda x: 1.1 * x),
        ({"effect": "sensor_offset", "offset": "0.2 deg"}, lambda x: x + math.radians(0.2)),
        ({"effect": "sensor_polarity", "sign": -1}, lambda x: -x),
        ({"effect": "sensor_quantization", "step": "0.1 deg"}, lambda x: math.radians(0.1) * np.rint(x / math.radians(0.1))),
    ],
    ids=["delay", "part of a period", "scale", "offset", "polarity", "quantization"],
)
def test_sensor_effects(entry_: dict[str, object], expected: object) -> None:
    sim = SimulatedRig(ornl(with_effects(entry_ | {"where": "sensor:rotary.position"})))
    p = sim.parameters.values
    p[entry(sim, "rotary.position", S.NOISE)], p[entry(sim, "rotary.position", S.RESOLUTION)] = 0.0, 1e-12
    result = sim.run(MOVING, 1e-3, sense=True)
    reading = result["raw"][:, sim.channels.index("rotary.position")] * 1e-12
    assert reading == pytest.approx(expected(result["rotary.position"]), abs=1e-11)  # type: ignore[operator]


def test_same_seed_same_readings(rig: Rig) -> None:
    first, second, other = (SimulatedRig(rig, seed=seed).run(MOVING, 1e-3, sense=True) for seed in (7, 7, 8))
    assert (first["raw"] == second["raw"]).all()
    assert (first["rotary.position"] == other["rotary.position"]).all(), "noise is only in the sensors"
    assert (first["raw"] != other["raw"]).any()


def test_asking_twice_changes_nothing(rig: Rig) -> None:
    asked, unasked = SimulatedRig(rig, seed=1), SimulatedRig(rig, seed=1)
    for row in MOVING[:200]:
        asked.advance(row, 1e-3)
        assert asked.sense() == asked.sense()
        unasked.advance(row, 1e-3)
    assert asked.sense() == unasked.sense()
    assert (asked.state == unasked.state).all()
