"""`longreach device scan|read|watch`: against the twin on a virtual bus and Modbus, and against servers that are not ours."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from config.loading.load import apply_overrides, rig_from_text
from daemon.cli.main import main
from sim_backend.twin.process import Twin
from tests.support.daemon.running_daemon import until
from tests.support.drivers.local_nodes import PRE_OPERATIONAL, IoNode, NodeBench
from tests.support.drivers.modbus_gauge import UNIT, VALUES, Gauge
from tests.support.sim_backend.twin_rig import IO, PRISMATIC_ENCODER, ROTARY_ENCODER, VALVE, free_port, twin_rig_text

DEVICES = {ROTARY_ENCODER: "rotary_encoder", PRISMATIC_ENCODER: "prismatic_encoder", VALVE: "rotary_valve", IO: "io"}
CHANNEL = "device verbs"


@pytest.fixture(scope="module")
def twin(tmp_path_factory: pytest.TempPathFactory) -> Iterator[tuple[Path, Twin]]:
    """A rig file, and the twin of its devices."""
    path = tmp_path_factory.mktemp("twin") / "rig.yaml"
    path.write_text(apply_overrides(twin_rig_text(CHANNEL, free_port()), ["devices.gauges.options.answer_timeout=2 s"]))
    made = Twin(rig_from_text(path.read_text()))
    thread = threading.Thread(target=made.run, daemon=True)
    thread.start()
    until(lambda: made.bench.clock.caught_up > 0, 60.0)
    yield path, made
    made.stop()
    thread.join(10)


def said(capsys: pytest.CaptureFixture[str], *words: str) -> Any:
    """The JSON of a verb that succeeds."""
    assert main(["device", *words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_scan_of_a_rig_finds_its_devices_and_starts_none(twin: tuple[Path, Twin], capsys: pytest.CaptureFixture[str]) -> None:
    path, running = twin
    found = said(capsys, "scan", str(path), "--listen", "0.1 s", "--units", "7")
    (bus,), (line,) = found["buses"], found["lines"]
    assert {node["node"]: node["device"] for node in bus["nodes"]} == DEVICES
    assert {node["node"]: node["identity"]["driver"] for node in bus["nodes"]} == {
        ROTARY_ENCODER: "canopen_encoder_406",
        PRISMATIC_ENCODER: "canopen_encoder_406",
        VALVE: "canopen_valve_408",
        IO: "canopen_io_401",
    }
    assert [(unit["unit"], unit["device"]) for unit in line["units"]] == [(7, "gauges")]
    assert {node.describe()["nmt"] for node in running.bench.nodes} == {"pre-operational"}


def test_scan_says_for_people_what_is_missing_and_that_it_only_reads(twin: tuple[Path, Twin], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["device", "scan", str(twin[0]), "--listen", "0.1 s", "--nodes", "3-5", "--units", "1"]) == 0
    text = capsys.readouterr().out
    assert "Nothing is started and nothing moves." in text
    assert f"not found: devices.io, node {IO} on CAN virtual {CHANNEL}" in text
    assert "not found: devices.gauges, unit_id 7 on Modbus TCP 127.0.0.1" in text
    assert "devices.rotary_valve" not in text.replace("rotary_valve\n", "")


def test_read_scales_as_the_rig_file_says(twin: tuple[Path, Twin], capsys: pytest.CaptureFixture[str]) -> None:
    path, running = twin
    encoder = {place["name"]: place for place in said(capsys, "read", str(path), "prismatic_encoder")["places"]}
    position = encoder["position"]
    assert (position["place"], position["type"], position["signal"], position["unit"]) == ("0x6004:0", "u32", "prismatic.position", "in")
    signal = running.bench.feed.plant.true_position[1]
    np.testing.assert_allclose(position["value"], signal / 0.0254, atol=0.01)
    gauges = {place["name"]: place for place in said(capsys, "read", str(path), "gauges")["places"]}
    assert gauges["rotary.supply_pressure"]["unit"] == "psi"
    np.testing.assert_allclose(gauges["rotary.supply_pressure"]["value"], 2000, atol=60)
    assert gauges["prismatic.supply_pressure"]["type"] == "uint32, low word first"


def test_objects_of_a_modbus_unit_are_refused(twin: tuple[Path, Twin], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["device", "read", str(twin[0]), "gauges", "--object", "6004"]) == 2
    assert "--object says nothing for a Modbus device of a rig: 6004" in capsys.readouterr().err


def test_watch_gives_lines_with_statistics_that_numpy_agrees_with(twin: tuple[Path, Twin], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["device", "watch", str(twin[0]), "gauges", "--every", "10 ms", "--for", "1 s", "--json"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert len(lines) > 3
    values = [line["places"][0]["value"] for line in lines]
    last = lines[-1]["places"][0]
    assert last["readings"] == len(values)
    expected = [min(values), max(values), np.mean(values), np.std(values, ddof=1)]
    np.testing.assert_allclose([last[key] for key in ("min", "max", "mean", "sd")], expected, rtol=1e-9)
    assert last["sd"] > 0, "the twin's gauge is noisy"


def test_a_node_without_rig_file_is_read_by_its_profile_and_by_objects(capsys: pytest.CaptureFixture[str]) -> None:
    """The canopen package's own node."""
    with NodeBench("no rig file") as bench:
        node = IoNode(bench, 21)
        node.put(0x6401, 2, -1234)
        where = "virtual:no rig file"
        by_profile = {place["place"]: place for place in said(capsys, "read", where, "--node", "21")["places"]}
        assert by_profile["0x6401:2"]["raw"] == -1234
        assert int(by_profile["0x1000:0"]["raw"]) & 0xFFFF == 401
        chosen = said(capsys, "read", where, "--node", "21", "--object", "6401:2", "6401:2/u16", "7000")
        assert [place["raw"] for place in chosen["places"]] == [-1234, 2**16 - 1234, None]
        assert "Object does not exist" in chosen["problems"][0]
        assert node.state == PRE_OPERATIONAL
        assert main(["device", "read", where, "--node", "22"]) == 1
        assert "the node does not answer: 22" in capsys.readouterr().err


def test_registers_of_a_server_that_is_not_ours(capsys: pytest.CaptureFixture[str]) -> None:
    gauge = Gauge()
    gauge.start()
    try:
        where = f"tcp:127.0.0.1:{gauge.port}"
        words = ["--unit", str(UNIT), "--answer-timeout", "2 s"]
        found = said(capsys, "scan", where, "--units", "1-4", "--answer-timeout", "2 s")["lines"][0]
        assert [unit["unit"] for unit in found["units"]] == [UNIT]
        floats = said(capsys, "read", where, *words, "--table", "holding", "--address", "40", "--type", "float32", "--count", "1")
        assert floats["places"][0] | {"raw": VALUES["temperature"][4]} == floats["places"][0]
        assert floats["places"][0]["type"] == "float32, high word first"
        swapped = said(capsys, "read", where, *words, "--address", "6", "--type", "uint32", "--word-order", "little", "--count", "1")
        assert swapped["places"][0]["raw"] == VALUES["hours"][4]
        assert {function for function, _, _ in gauge.requests} <= {3, 4}, "reads only"
    finally:
        gauge.stop()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["read", "virtual:x"], "--node is missing"),
        (["read", "tcp:127.0.0.1"], "--unit is missing"),
        (["read", "ornl_testbed_can", "rotary_encodr"], "no device 'rotary_encodr': nearest is 'rotary_encoder'"),
        (["read", "ornl_testbed", "plant"], "read by its driver alone: sim"),
        (["scan", "socketcna:can0"], "python-can has no such interface: nearest is 'socketcan'"),
        (["scan", "virtual:x", "--nodes", "0-5"], "not a range of numbers: 0-5"),
        (["scan", "virtual:x", "--bitrate", "9 Mbit/s"], "bitrate is out of range: 9 Mbit/s"),
        (["scan", "tcp:127.0.0.1:70000"], "not a range of numbers: 70000"),
        (["read", "ornl_testbed_can", "rotary_encoder", "--node", "9"], "--node says nothing for a rig file: 9"),
        (["read", "ornl_testbed_can", "rotary_encoder", "--table", "holding"], "--table says nothing for a rig file: holding"),
        (["watch", "ornl_testbed_can", "rotary_encoder", "--address", "0"], "--address says nothing for a rig file: 0"),
        (["scan", "ornl_testbed_can", "--bitrate", "1 Mbit/s"], "--bitrate says nothing for a rig file: 1 Mbit/s"),
        (["read", "tcp:127.0.0.1", "--unit", "1", "--node", "3"], "--node says nothing for a Modbus host: 3"),
        (["read", "virtual:x", "--node", "3", "--parity", "odd"], "--parity says nothing for a CAN bus: odd"),
        (["read", "rtu:./line", "gauge", "--unit", "3"], "DEVICE says nothing for a serial line: gauge"),
    ],
)
def test_wrong_words_are_refused_with_what_to_do(words: list[str], message: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["device", *words]) != 0
    said_of_it = capsys.readouterr().err
    assert message in said_of_it
    assert "next: " in said_of_it
