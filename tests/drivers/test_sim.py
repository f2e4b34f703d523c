from __future__ import annotations

import time
from pathlib import Path

import pytest

from config.errors import ConfigError, DriverError
from config.loading.load import load_rig
from config.schema.rig import Device
from drivers.contract import Driver
from drivers.driver_contract import OutputContract, Outputs
from drivers.output_register import OutputRegister
from drivers.sim import SimDriver, create

RIG = load_rig("ornl_testbed").rig
MS = 1_000_000


class TestSimOnTheWallClock(OutputContract):
    """The register file is read as another process would read it."""

    safe_outputs = (0.0, 0.0)

    @pytest.fixture(autouse=True)
    def _runtime_directory(self, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
        monkeypatch.setenv("RUNTIME_DIRECTORY", str(tmp_path))
        self.path = tmp_path / "plant.outputs"

    def make(self) -> Driver:
        return create("plant", RIG.devices["plant"], RIG, lockstep=False)

    def actual_outputs(self, driver: Driver) -> Outputs:
        register = OutputRegister.attach(self.path)
        values = register.effective(time.monotonic_ns())
        register.close()
        return values

    def test_silence_makes_the_valves_safe_by_the_devices_own_clock(self) -> None:
        driver = self.active()
        now = time.monotonic_ns()
        driver.write([1.0, -1.0], now)
        register = OutputRegister.attach(self.path)
        timeout_ns = round(1e9 * RIG.devices["plant"].timeout_s)
        assert register.timeout_s == pytest.approx(1e-9 * timeout_ns)
        assert register.effective(now + timeout_ns - MS) == (1.0, -1.0)
        assert register.effective(now + timeout_ns + MS) == (0.0, 0.0)
        register.close()
        driver.close()


class TestSimInLockstep(OutputContract):
    """Its register in a file as well, which shows the outputs after close() too."""

    safe_outputs = (0.0, 0.0)
    now_ns = 0

    @pytest.fixture(autouse=True)
    def _register_file(self, tmp_path: Path) -> None:
        self.path = tmp_path / "plant.outputs"

    def make(self) -> Driver:
        return SimDriver("plant", RIG.devices["plant"], RIG, lockstep=True, register_path=self.path)

    def fresh_time(self) -> int:
        self.now_ns += MS
        return self.now_ns

    def actual_outputs(self, driver: Driver) -> Outputs:
        register = OutputRegister.attach(self.path)
        values = register.effective(self.now_ns)
        register.close()
        return values


def driver(lockstep: bool, timeout_s: float = 0.1) -> SimDriver:
    made = SimDriver("plant", Device(driver="sim", timeout=timeout_s), RIG, lockstep)
    made.open()
    made.activate()
    return made


def rotary_counts(sim: SimDriver, now_ns: int) -> float:
    return sim.read(now_ns)[sim.inputs.index("rotary.position")].raw


def test_lockstep_moves_one_period_a_read_whatever_the_time_says() -> None:
    a, b = driver(lockstep=True), driver(lockstep=True)
    for cycle in range(200):
        now = cycle * MS
        counts = rotary_counts(a, now), rotary_counts(b, now)
        assert counts[0] == counts[1]
        a.write([1.0, 0.0], now)
        b.write([1.0, 0.0], now)
    assert counts[0] != 0.0


def test_wall_clock_catches_up_with_missed_periods() -> None:
    """The plant is as far after one late read as after as many reads in time (no noise in the position transducer's count)."""
    often, seldom = driver(lockstep=False, timeout_s=5.0), driver(lockstep=False, timeout_s=5.0)
    for sim in (often, seldom):
        sim.read(0)
        sim.write([1.0, 0.0], 0)
    for cycle in range(1, 301):
        counts = rotary_counts(often, cycle * MS)
    assert rotary_counts(seldom, 300 * MS) == pytest.approx(counts, abs=5)


def test_jitter_of_a_few_microseconds_changes_nothing() -> None:
    exact, jittery = driver(lockstep=False), driver(lockstep=False)
    for cycle in range(300):
        now, late = cycle * MS, (cycle * 7919) % 300_000
        assert rotary_counts(exact, now) == rotary_counts(jittery, now + late)
        exact.write([1.0, 0.0], now)
        jittery.write([1.0, 0.0], now + late)


def test_plant_obeys_the_time_out_and_not_the_last_command() -> None:
    """A valve held open for 20 ms and then timed out moves the joint much less than one held open."""
    short, long = driver(lockstep=False, timeout_s=0.02), driver(lockstep=False, timeout_s=5.0)
    moved = []
    for sim in (short, long):
        start = rotary_counts(sim, 0)
        sim.write([2.0, 0.0], 0)
        moved.append(abs(rotary_counts(sim, 900 * MS) - start))
    assert moved[0] < 0.2 * moved[1]


def test_a_stopped_process_finds_the_plant_a_second_later(monkeypatch: pytest.MonkeyPatch) -> None:
    """Not an hour of periods: its next cycle would come as much later."""
    sim = driver(lockstep=False)
    sim.read(0)
    steps: list[float] = []
    advance = sim._plant.advance
    monkeypatch.setattr(sim._plant, "advance", lambda volts, period_s: (steps.append(period_s), advance(volts, period_s)))
    sim.read(3600 * 1000 * MS)
    assert sum(steps) == pytest.approx(1.0)
    sim.read((3600 * 1000 + 1) * MS)
    assert len(steps) == 1001, "and goes on from there, period by period"


def test_unknown_options_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"devices.plant.options.*sead is not a key here: nearest is 'seed'"):
        SimDriver("plant", Device(driver="sim", options={"sead": 1}), RIG, lockstep=True)


def test_opening_twice_is_refused() -> None:
    sim = driver(lockstep=True)
    with pytest.raises(DriverError, match="open already"):
        sim.open()
