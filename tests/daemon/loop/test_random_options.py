"""Whatever the options of a shipped driver: `check` says what is wrong with its line, or the daemon's driver starts against its twin."""

from __future__ import annotations

import datetime
import itertools
import re
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from config.checking.check import check_rig, refuse_unusable
from config.errors import ConfigError
from config.loading.load import LoadedRig, rig_from_text
from config.options.canopen_options import EncoderOptions, IoOptions, ValveOptions
from config.options.modbus_options import RtuOptions, TcpOptions
from config.schema.rig import Rig
from drivers import registry
from drivers.contract import Driver
from sim_backend.twin.process import Twin
from tests.support.config.bench_rigs import DEVICES, PLANT
from tests.support.config.random_options import options
from tests.support.daemon.running_daemon import until
from tests.support.drivers.modbus_slave import Slave
from tests.support.sim_backend.twin_rig import free_port

TODAY = datetime.date(2026, 1, 1)
CHANNELS = itertools.count()
PLACED = re.compile(r"random.yaml:\d+:\d+: ")
FEW = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
BUS = st.fixed_dictionaries(
    {"interface": st.just("virtual"), "channel": st.just("CHANNEL"), "load_limit": st.just(1)},
    optional={"bitrate": st.sampled_from([1e6, 1e6, 500e3]), "own_node": st.integers(100, 127), "fault_cycles": st.integers(1, 9)},
)
REGISTERS = st.fixed_dictionaries(
    {"address": st.integers(0, 2**16 - 1)},
    optional={
        "table": st.sampled_from(["input", "holding"]),
        "type": st.sampled_from(["int16", "uint16", "int32", "uint32", "float32"]),
        "word_order": st.sampled_from(["big", "little"]),
    },
)
MAP = st.dictionaries(st.sampled_from(["supply", "tank", "oil", "spare"]), REGISTERS, min_size=1, max_size=4)
_BYTES = st.integers(-3, 300)
_REACTIONS = st.dictionaries(st.integers(30, 45), st.integers(0, 3), min_size=1, max_size=3)
SPECIAL: dict[str, st.SearchStrategy[Any]] = {
    "bus": BUS,
    "fault_reactions": st.one_of(*3 * [_REACTIONS], st.dictionaries(_BYTES, _BYTES)),
    "heartbeat": st.floats(0.01, 0.3),  # a node is waited for as long as one takes
    "port": st.sampled_from(["/dev/ttyUSB0", ""]),
    "loopback": st.just({}) | st.dictionaries(st.integers(0, 5), st.integers(0, 5), max_size=2),
    "channels": MAP.map(lambda drawn: {"supply": {"address": 0}, **drawn} if "supply" not in drawn else drawn),
}
MOST_STARTS = 6  # each takes seconds
PATIENT = {"answer_timeout": "2 s"}  # a busy machine


def rig_text(device: str, drawn: dict[str, Any], timeout_s: float | None, channel: str) -> str:
    """The rig of bench_rigs with devices and a plant, the options of one device replaced."""
    rig, plant = yaml.safe_load(DEVICES), yaml.safe_load(PLANT)["plant"]
    plant["sensors"].pop("axis.pressure_a")
    rig["plant"] = plant
    del rig["devices"]["thermometer"], rig["signals"]["reservoir_temperature"], rig["interlocks"]["oil_temperature_max"]
    rig["signals"].pop("axis.return_pressure")
    rig["interlocks"] = {}
    bus = drawn.get("bus") if isinstance(drawn.get("bus"), dict) else {"interface": "virtual", "channel": channel}
    for entry in rig["devices"].values():
        if "bus" in entry["options"]:
            entry["options"]["bus"] = dict(bus)
    rig["devices"]["gauges"]["options"] |= {"port": free_port(), **PATIENT}
    rig["devices"][device]["options"] = drawn
    if timeout_s is not None:
        rig["devices"][device]["timeout"] = timeout_s
    return yaml.safe_dump(rig, sort_keys=False)


def told(text: str) -> list[str]:
    """Errors of `check`, each with its line."""
    try:
        loaded = LoadedRig(rig_from_text(text, "random.yaml"), text, "random.yaml")
        errors = [finding.text for finding in check_rig(loaded, TODAY) if finding.level == "error"]
        if not errors:
            refuse_unusable(loaded)
    except ConfigError as refusal:
        errors = [problem.text() for problem in refusal.problems]
    for error in errors:
        assert PLACED.match(error), error
    return errors


@pytest.fixture(autouse=True)
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """A busy machine is no wrong option."""
    monkeypatch.setattr("canopen.sdo.SdoClient.RESPONSE_TIMEOUT", 10.0)
    monkeypatch.setattr("drivers.canopen.device._START_LIMIT_S", 20.0)


@contextmanager
def twin_of(rig: Rig) -> Iterator[None]:
    twin = Twin(rig)
    thread = threading.Thread(target=twin.run, daemon=True)
    thread.start()
    try:
        until(lambda: twin.bench.clock.caught_up > 0, 60.0)
        yield
    finally:
        twin.stop()
        thread.join(20)


def starts(driver: Driver) -> None:
    """As the daemon does it when it starts."""
    try:
        driver.open()
        driver.configure()
    finally:
        driver.close()


def drawn_options(schema: Any, fixed: dict[str, Any]) -> st.SearchStrategy[dict[str, Any]]:
    return options(schema, fixed, SPECIAL)


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize(
    ("device", "schema"), [("encoder", EncoderOptions), ("valve", ValveOptions), ("module", IoOptions), ("gauges", TcpOptions)]
)
def test_check_tells_or_the_driver_starts(device: str, schema: Any) -> None:
    outcomes = {"told": 0, "started": 0}

    @FEW
    @given(data=st.data())
    def one(data: Any) -> None:
        fixed = {"transport": "tcp", "host": "127.0.0.1", "port": free_port(), **PATIENT} if device == "gauges" else {}
        drawn = data.draw(drawn_options(schema, fixed))
        timeout_s = data.draw(st.none() | st.floats(0.002, 5)) if device != "gauges" else None
        channel = f"random {next(CHANNELS)}"
        if isinstance(drawn.get("bus"), dict):
            drawn["bus"] = drawn["bus"] | {"channel": channel}
        text = rig_text(device, drawn, timeout_s, channel)
        if told(text):
            outcomes["told"] += 1
            return
        if outcomes["started"] >= MOST_STARTS:
            return
        rig = rig_from_text(text, "random.yaml")
        with twin_of(rig):
            starts(registry.create(device, rig.devices[device], rig, False))
        outcomes["started"] += 1

    one()
    assert min(outcomes.values()) >= 2, outcomes


@FEW
@given(seed=st.integers(-(2**70), 2**70) | st.floats(-2, 2) | st.text(max_size=3))
def test_a_simulated_device_starts_whatever_its_seed(seed: Any) -> None:
    rig = yaml.safe_load(PLANT)
    rig["devices"]["rig"]["options"] = {"seed": seed}
    text = yaml.safe_dump(rig)
    if not told(text):
        loaded = rig_from_text(text, "random.yaml")
        starts(registry.create("rig", loaded.devices["rig"], loaded, True))


@pytest.mark.slow
@FEW
@given(drawn=drawn_options(RtuOptions, {"transport": "rtu", **PATIENT}))
def test_a_serial_device_starts_against_a_slave(drawn: dict[str, Any]) -> None:
    """A pseudo terminal is the line; it has no parity, and any rate."""
    text = rig_text("gauges", drawn, None, "serial")
    if told(text):
        return
    units = drawn.get("unit_id", 1)
    slave = Slave(units=(units,), registers=2**16)
    try:
        line = {"port": slave.port, "parity": "none", "baud_rate": 115200}
        rig = rig_from_text(rig_text("gauges", drawn | line, None, "serial"), "random.yaml")
        starts(registry.create("gauges", rig.devices["gauges"], rig, False))
    finally:
        slave.close()


def test_channels_are_checked_while_other_options_are_wrong() -> None:
    """Each told with its line, in one run of `check`."""
    cases: list[tuple[str, dict[str, Any], str, str]] = [
        ("encoder", {"bus": {"interface": "virtual", "channel": "c"}, "node": 1, "resolution": 0}, "resolution", "positon"),
        ("gauges", {"transport": "tcp", "host": "h", "channels": {"suply": {"address": 0, "type": "int24"}}}, "int24", "supply"),
        ("module", {"bus": {"interface": "virtual", "channel": "c"}, "node": "one", "inputs": 1}, "whole number", "input_1"),
    ]
    for device, wrong, about_option, channel in cases:
        text = rig_text(device, wrong, None, "c").replace("channel: position", "channel: positon")
        if device == "module":
            text = text.replace("channel: input_1", "channel: input_2")
            channel = "input_2"
        errors = told(text)
        assert any(about_option in error for error in errors), errors
        assert any(f"has no input '{channel}'" in error for error in errors), errors


def test_what_the_wrong_options_decide_is_left_alone() -> None:
    """A module whose number of inputs is unreadable has channels that nobody knows: no word about them."""
    wrong = {"bus": {"interface": "virtual", "channel": "c"}, "node": 21, "inputs": "two", "outputs": 1}
    errors = told(rig_text("module", wrong, None, "c"))
    assert any("inputs must be a whole number" in error for error in errors)
    assert not any("has no input" in error for error in errors)


def test_a_device_that_would_call_us_dead_is_told() -> None:
    bus = {"interface": "virtual", "channel": "c", "load_limit": 1}
    text = rig_text("valve", {"bus": bus, "node": 11, "fault_reactions": {89: 2}}, 0.0025, "c")
    assert any("devices.valve.timeout is 2.5 ms; 3 heartbeats of ours in that time need 3 ms" in error for error in told(text))
