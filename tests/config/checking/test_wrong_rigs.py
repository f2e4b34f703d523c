"""Wrong rig files, each told by `check` with its line: of devices, which never get as far as opening one, and of physics."""

from __future__ import annotations

import datetime
import re
from pathlib import Path

import pytest

from config.checking.check import check_rig, refuse_unusable
from config.checking.finding import Finding
from config.errors import ConfigError
from config.loading.load import LoadedRig, load_rig, rig_from_text
from daemon.checks.interlocks import rig_facts
from daemon.cli.main import main
from daemon.ipc.slow_samples import slow_mailbox
from daemon.loop.device_bank import DeviceBank
from daemon.processes import supervisor
from tests.support.config.bench_rigs import DEVICES, PLANT, replaced

TODAY = datetime.date(2026, 1, 1)

# what stands in the file, what is written instead, what is said of it; the line is that of the change
DEVICE_FAULTS = [
    ("transport: tcp", "transport: serial", "transport cannot be 'serial'.*Allowed: tcp, rtu"),
    ("      transport: tcp\n", "", "needs the key 'transport'.*tcp, rtu"),
    ("type: uint16", "type: int24", "tank.type cannot be 'int24': nearest is 'int32'"),
    ("parity: none", "parity: E", "parity cannot be 'E'.*none, even, odd"),
    ("table: holding", "table: coil", "table cannot be 'coil'.*input, holding"),
    ("unit_id: 3", "unit_id: 248", "unit_id is out of range: 248 .limit: 1 to 247"),
    ("port: 1502", "port: 70000", "port is out of range: 70000"),
    ("host: 127.0.0.1", "host: ''", "host must have at least 1 entries|host.*at least 1 character"),
    ("host: 127.0.0.1", "host: 127.0.0.1:1502", "host: neither a host name nor an IP address; the port has a key of its own"),
    ("host: 127.0.0.1", "host: 300.1.2.3", "host: neither a host name nor an IP address"),
    ("host: 127.0.0.1", "hots: 127.0.0.1", "hots is not a key here: nearest is 'host'"),
    ("supply: {address: 0}", "supply: {address: -1}", "supply.address is out of range: -1"),
    ("supply: {address: 0}", "supply: {adress: 0}", "adress is not a key here: nearest is 'address'"),
    ("{address: 1, type: uint16}", "{address: 0, type: int32}", "'supply' and 'tank' share a register"),
    ("address: 100, type: float32", "address: 65535, type: float32", "ends beyond the last register, 65535"),
    ("channel: supply,", "channel: suply,", "the device 'gauges' has no input 'suply': nearest is 'supply'. Its inputs: supply, tank"),
    ("    slow: true\n    options:\n      transport: tcp", "    options:\n      transport: tcp", "devices.gauges must be slow.*slow: true"),
    ("port: /dev/ttyUSB0", "port: /dev/ttyUSB0\n      baud_rate: 100", "baud_rate is out of range: 100 .limit: 1200 to 921600"),
    ("port: /dev/ttyUSB0", "port: /dev/ttyUSB0\n      stop_bits: 3", "stop_bits cannot be 3"),
    ("port: 1502", "port: 1502\n      answer_timeout: 1 min", "answer_timeout is out of range: 1 min"),
    ("port: 1502", "port: 1502\n      answer_timeout: 20 mm", "answer_timeout: wrong kind of unit"),
    ("channel: input_1", "channel: input_2", "the device 'module' has no input 'input_2': nearest is 'input_1'. Its inputs: input_1"),
    ("loopback: {1: 1}", "loopback: {1: 2}", "loopback {1: 2} is {output: input}, and outputs 1 to 1 and inputs 1 to 1 are in use"),
    ("loopback: {1: 1}", "loopback: {output_1: 1}", "loopback: the key 'output_1' must be a whole number"),
    ("fault_reactions: {89: 2, 75: 2}", "fault_reactions: {0x59: 2}", "fault_reactions: the key '0x59' must be a whole number"),
    ("      outputs: 1\n", "      outputs: 5\n", "outputs is out of range: 5 .limit: 0 to 4"),
    ("every_syncs: 4", "every_sync: 4", "every_sync is not a key here: nearest is 'every_syncs'"),
    ("every_syncs: 4", "counts_per_volt: 0", "counts_per_volt is out of range: 0"),
    ("node: 21", "node: 11", "device 'valve' on CAN bench0 has this number too: 11"),
    ("node: 21", "node: 127", "is our own number, bus.own_node: 127"),
    ("node: 21", "node: 128", "node is out of range: 128 .limit: 1 to 127"),
    ("      node: 1\n", "      node: one\n", "node must be a whole number"),
    ("resolution: 25000", "resolution: 0", "resolution is out of range: 0"),
    ("resolution: 25000", "resolutoin: 25000", "resolutoin is not a key here: nearest is 'resolution'"),
    ("      fault_reactions: {89: 2, 75: 2}\n", "", "needs the key 'fault_reactions'"),
    ("fault_reactions: {89: 2, 75: 2}", "fault_reactions: {}", "fault_reactions must have at least 1 entries"),
    ("fault_reactions: {89: 2, 75: 2}", "fault_reactions: {89: 2}\n      safe_state: open", "safe_state cannot be 'open'"),
    (
        "fault_reactions: {89: 2, 75: 2}",
        "fault_reactions: {89: 3, 75: 3}\n      safe_state: hold\n      hold_spool: 0.8",
        "hold_spool is 0.8, and a safe spool stands within spool_tolerance, 0.05, of its middle: an open valve moves the arm",
    ),
    (
        "fault_reactions: {89: 2, 75: 2}",
        "fault_reactions: {89: 2}\n      failsafe_spool: -0.06",
        "failsafe_spool is -0.06, and a safe spool stands within spool_tolerance, 0.05, of its middle",
    ),
    (
        "channel: spool, scale: 0.1",
        "channel: spool, scale: 0",
        "outputs.axis.scale: the device gets 0 whatever is commanded; give what it takes for 1 V",
    ),
    ("channel: spool, scale: 0.1", "channel: spool, scale: .nan", "outputs.axis.scale: a finite number was expected: nan"),
    ("channel: spool, scale: 0.1", "channel: spool, scale: -.inf", "outputs.axis.scale: a finite number was expected: -inf"),
    ("channel: spool", "channel: spol", "the device 'valve' has no output 'spol': nearest is 'spool'"),
    ("{device: valve, channel: spool", "{device: encoder, channel: spool", "the device 'encoder' has no output 'spool'. Its outputs: none"),
    ("channel: position", "channel: positon", "the device 'encoder' has no input 'positon': nearest is 'position'"),
    ("driver: canopen_valve_408", "driver: canopen_valve_480", "there is no driver 'canopen_valve_480': nearest is 'canopen_valve_408'"),
    ("driver: canopen_encoder_406", "driver: canopen_encoder_406\n    demand_proof: true", "cannot prove that the device goes safe"),
    ("bitrate: 1 Mbit/s}\n      node: 21", "bitrate: 500 kbit/s}\n      node: 21", "are on one link and differ in bus.bitrate: 500000"),
    ("bitrate: 1 Mbit/s}\n      node: 11", "bitrate: 9 Mbit/s}\n      node: 11", "bitrate is out of range: 9 Mbit/s"),
    (
        "interface: virtual, channel: bench0, bitrate: 1 Mbit/s}\n      node: 21",
        "interface: socketcna, channel: can0}\n      node: 21",
        "python-can has no such interface: nearest is 'socketcan'",
    ),
    (
        "driver: canopen_io_401\n    timeout: 60 ms",
        "driver: canopen_valve_408\n    timeout: 60 ms",
        "module.options.outputs is not a key here",
    ),
]

# The simulated rig cannot be built of these.
PLANT_FAULTS = [
    ("mass: 20 kg", "mass: 0 kg", "axis.mass: the joint moves none.*: 0 .limit: above 0"),
    ("  supply: {pressure: 10 MPa, return_pressure: 0.1 MPa}\n", "", "plant.joints.axis is hydraulic and needs plant.supply"),
    (
        "  oil: {density: 870 kg/m^3, specific_heat: 1900 J/kg/K, bulk_modulus: 1.2 GPa, walther_a: 8.9, walther_b: 3.5}\n",
        "",
        "plant.joints.axis is hydraulic and needs plant.oil",
    ),
    ("    axis.position: {resolution: 5 um, noise: 5 um, low: -10 mm, high: 220 mm}\n", "", "plant.sensors has no axis.position"),
    (
        "channel: axis.pressure_a",
        "channel: axis.pressure_b",
        "the device 'rig' has no input 'axis.pressure_b': nearest is",
    ),
    ("channel: axis.command", "channel: axis.comand", "the device 'rig' has no output 'axis.comand': nearest is 'axis.command'"),
    ("{driver: sim}", "{driver: sim, options: {sead: 1}}", "sead is not a key here: nearest is 'seed'"),
]
# No rig comes of such a file; the line is that of the mistake, or of what it breaks.
UNREADABLE = [
    ("bore: 16 mm", "bore: " + "9" * 5000, "bench.yaml:33:13: .*bore: a finite number was expected"),
    ("bore: 16 mm", "bore: " + "9" * 400, "bench.yaml:33:13: .*bore: a finite number was expected"),
    ("bore: 16 mm", "bore: " + "9" * 400 + " mm", "bench.yaml:33:13: .*bore: a finite number was expected: .{1,130}…[.] Allowed"),
    ("bore: 16 mm", "bore: .nan", "bench.yaml:33:13: .*bore: a finite number was expected: nan"),
    ("bore: 16 mm", "bore: 16,5 mm", "bench.yaml:33:13: .*bore: a decimal comma: '16,5 mm'. Write a point"),
    ("bore: 16 mm", "bore: !!float 16", "bench.yaml:33:13: .*tags .!. are not used here"),
    ("bore: 16 mm", "bore: &b 16 mm", "bench.yaml:33:13: .*anchors and aliases"),
    ("bore: 16 mm", "bore: " + "[" * 3000 + "]" * 3000, "bench.yaml:33:.*nested deeper than 60 levels"),
    ("bore: 16 mm", "bore: '16 mm", r"bench.yaml:46:1: .*unexpected end of stream \(while scanning a quoted scalar begun on line 33\)"),
    ("bore: 16 mm", "bore:16 mm", r"bench.yaml:34:7: .*could not find expected ':' \(while scanning a simple key begun on line 33\)"),
    ("bore: 16 mm", "\tbore: 16 mm", r"bench.yaml:33:\d+: .*\\t.*[.] Indent with spaces: YAML takes no tabs[.]"),
    ("bore: 16 mm", "bore: 16 mm\n      bore: 17 mm", "bench.yaml:34:7: .*bore stands twice: first on line 33"),
    ("bore: 16 mm", "bore: 16\0 mm", r"bench.yaml:33:15: .*character '\\x00' is not allowed"),
    ("travel: [0 m, 0.2 m]", "travel: [0.2 m]", r"bench.yaml:31:15: .*travel must have at least 2 entries: got \['0.2 m'\]"),
    ("name: bench", "name: " + "x" * 65, "bench.yaml:2:7: name is not a usable name: .* 64 in all"),
    ("  rig: {driver", "  rig/1: {driver", "bench.yaml:18:3: devices.rig/1 is not a usable name"),
    ("longreach: rig/1", "longreach: maneuver/1", "bench.yaml:1:12: this file is 'maneuver/1', not 'rig/1'"),
    ("plant:\n", "---\nplant:\n", "bench.yaml:27:1: .*another document"),
]

# Such a rig runs, perhaps not as meant: what is said of it has the number that makes it odd. By hand, with areas of 2.011 and 1.225 cm^2:
# full speed sqrt(9.9 / 7) x 5 l/min / 1.618 cm^2 = 0.6125 m/s; oil 1.2 GPa x (2.011^2 / 25.11 + 1.225^2 / 17.25) cm = 2.976 MN/m, which
# holds 20 kg at 385.8 rad/s and 0.1 kg at 868 Hz; noise sqrt(2 x 6 / pi) x 0.3 mm = 0.586 mm.
ODDITIES = [
    ("gain: 60 V/m", "gain: -60 V/m", r"servo.axis.gain is -60 V/m: .*runs away"),
    ("gain: 60 V/m", "gain: 0 V/m", r"servo.axis.gain is 0 V/m: nothing holds the joint"),
    ("velocity_feedforward: 8", "velocity_feedforward: -8", r"velocity_feedforward is -8 V\*s/m, the gain 60 V/m: one drives against"),
    ("velocity_filter: 50 Hz", "velocity_filter: 800 Hz", r"velocity_filter is 800 Hz, above half the loop's rate, 500 Hz"),
    ("gain: 60 V/m", "gain: 60000 V/m", r"3.68e\+03 1/s and crosses over at 585 Hz, above the natural frequency of mass and oil, 61.4 Hz"),
    (
        "gain: 60 V/m",
        "gain: 6000 V/m",
        r"velocity constant of 368 1/s and crosses over at 58.5 Hz; the loop at 1000 Hz loses 32 deg of phase",
    ),
    (  # |1 + 363j/20| / |1 + 363j/2| = 0.1001: that of a gain of 368 1/s
        "gain: 60 V/m",
        "gain: 60000 V/m\n    sections: [{zero: 20 rad/s, pole: 2 rad/s}]",
        r"3.68e\+03 1/s and crosses over at 57.8 Hz; the loop at 1000 Hz loses 31 deg",
    ),
    (
        "  supply: {pressure: 10 MPa, return_pressure: 0.1 MPa}",
        "  supply: {pressure: 10 MPa, return_pressure: 0.1 MPa}\n  effects: [{effect: coulomb_friction, where: axis, friction: 2 kN}]",
        r"coulomb_friction of 2000 N holds axis: supply pressure gives 1991 N at most",
    ),
    ("rated_flow: 5 lpm", "rated_flow: 75 lpm", r"89.2 l/min at 9.9 MPa, 9.19 m/s on 2.01 cm\^2: through the whole stroke in 22 ms"),
    ("rated_flow: 5 lpm", "rated_flow: 0.5 lpm", r"0.0613 m/s on 2.01 cm\^2; joints.axis.rate_limit is 0.2 m/s: the joint cannot reach it"),
    (
        "acceleration_limit: 5 m",
        "acceleration_limit: 150 m",
        r"but supply pressure on the piston gives 20 kg at most 99.5 m/s\^2",
    ),
    ("mass: 20 kg", "mass: 0.1 kg", r"mass and oil ring at 868 Hz; the loop at 1000 Hz has 1.2 cycles a period"),
    ("dead_volume_b: 5 cm^3", "dead_volume_b: 5 l", r"dead_volume_b is 5000 cm\^3, 204 times what the piston sweeps"),
    ("bulk_modulus: 1.2 GPa", "bulk_modulus: 12 MPa", r"bulk_modulus is 0.012 GPa; hydraulic fluids have 0.3 to 3"),
    ("walther_b: 3.5", "walther_b: 4.5", r"viscosity is .* cSt at 40 degC by walther_a and walther_b; hydraulic fluids have 2 to 3000"),
    ("density: 870", "density: 1990", r"density is 1.99e\+03 kg/m\^3; hydraulic fluids have 750 to 1250"),
    ("pressure: 10 MPa,", "pressure: 4 MPa,", r"supply_pressure_min is 5 MPa, but plant.supply.pressure is 4 MPa: .* can't be armed"),
    ("pressure: 10 MPa,", "pressure: 20 MPa,", r"supply_pressure_max is 15 MPa, but plant.supply.pressure is 20 MPa"),
    ("return_pressure: 0.1 MPa", "return_pressure: 2 MPa", r"return_pressure_max is 1 MPa, but plant.supply.return_pressure is 2 MPa"),
    ("pressure: 10 MPa, return_pressure: 0.1", "pressure: 10 MPa, return_pressure: 3", r"return_pressure_max"),
    (
        "resolution: 5 um, noise: 5 um",
        "resolution: 5 um, noise: 0.3 mm",
        r"0.0003 m rms looks like 0.000586 m .* stops the arm at 0.0002",
    ),
    ("following_error_limit: 20 mm", "following_error_limit: 0.04 mm", r"one count is 5e-06 m; interlocks.plausibility.stuck stops"),
    ("low: -10 mm, high: 220 mm", "low: -10 mm, high: 150 mm", r"reads -0.01 to 0.15 m only; joints.axis.travel is 0.02 to 0.18 m"),
    (
        "axis.return_pressure, calibration: {scale: 5 kPa}, low: -1 MPa",
        "axis.return_pressure, calibration: {scale: 5 kPa}, low: 50 kPa",
        r"low is 5e\+04 Pa; with noise of 2e\+04 Pa rms about 1e\+05 Pa the reading reaches 0 Pa and is refused",
    ),
]


# The same of devices, in the rig with hardware.
ODD_DEVICES = [
    (  # in 0.001 um
        "resolution: 25000",
        "resolution: 5000",
        r"axis.position: calibration.scale is 2.5e-05 m; devices.encoder.options.resolution, 5000, makes a count of axis.position 5e-06 m",
    ),
    ("{scale: 25 um}", "{scale: 0}", r"axis.position: calibration.scale is 0: the value would never change"),
    (
        "{scale: 25 um}",
        "{scale: -25 um}",
        r"counts 0 to 4.29497e\+09 of position mean -107400 to 0 m; the joint's travel is 0.02 to 0.18 m",
    ),
    (
        "supply: {address: 0}",
        "supply: {table: holding, address: 40003}",
        "address 40003 looks like the number of a register.*that register has the address 2 of the holding table",
    ),
    (
        "{scale: 100 Pa, offset: -0.5 MPa}",
        "{scale: 1 Pa}, high: 1 MPa",
        r"counts 0 to 65535 of tank mean 0 to 0.0655\d MPa; low to high is any to 1 MPa",
    ),
    ("channel: spool, scale: 0.1", "channel: spool", r"joints.axis.command_limit, 10 V, times scale 1 is 10, but the device ends at 1"),
    (
        "channel: tank",
        "channel: supply",
        r"return_pressure and signals.axis.supply_pressure are one channel, supply of gauges",
    ),
    (  # 0.2 m/s for 5 s
        "channel: position",
        "max_age: 5, channel: position",
        r"signals.axis.position.max_age is 5 s: axis moves up to 1 m on a position of that age; following_error_limit is 0.02 m",
    ),
    (
        "canopen_valve_408\n    timeout: 60 ms",
        "canopen_valve_408\n    timeout: 0.6",
        r"devices.valve.timeout is 0.6 s: axis moves up to 0.12 m before the device makes its output safe; half its travel is 0.08 m",
    ),
    ("resolution: 25000", "resolution: 25000\n    slow: true", r"devices.encoder.slow: its bus is served by the loop"),
    ("fault_reactions: {89: 2, 75: 2}", "fault_reactions: {89: 2}\n      proof_spool: 0.04", r"opens the spool by 0.04, .* 0.05"),
]


def findings(text: str) -> list[Finding]:
    """What `check` says, whether reading the file is refused or not."""
    try:
        return check_rig(LoadedRig(rig_from_text(text, "bench.yaml"), text, "bench.yaml"), TODAY)
    except ConfigError as refusal:
        return [Finding("error", problem.text()) for problem in refusal.problems]


def errors(text: str) -> list[str]:
    return [finding.text for finding in findings(text) if finding.level == "error"]


def warnings(text: str) -> list[str]:
    return [finding.text for finding in findings(text) if finding.level == "warning"]


def test_the_rigs_that_are_made_wrong_are_right() -> None:
    assert errors(DEVICES) == []
    assert warnings(DEVICES) == ["no plant section: the simulated backend and `longreach gap` cannot use this rig"]
    assert [finding for finding in findings(PLANT) if finding.level != "ok"] == []
    assert len(DEVICE_FAULTS) >= 40
    assert len(ODDITIES) >= 20


@pytest.mark.parametrize(("old", "new", "message"), DEVICE_FAULTS)
def test_a_wrong_device_is_told_and_never_reaches_the_daemon(old: str, new: str, message: str, tmp_path: Path, capsys) -> None:
    wrong = replaced(DEVICES, old, new)
    check_told_and_refused(wrong, DEVICES.index(old), old, message, tmp_path, capsys)


@pytest.mark.parametrize(("old", "new", "message"), PLANT_FAULTS)
def test_a_plant_that_cannot_be_simulated_is_told_and_never_reaches_the_daemon(
    old: str, new: str, message: str, tmp_path: Path, capsys
) -> None:
    check_told_and_refused(replaced(PLANT, old, new), PLANT.index(old), old, message, tmp_path, capsys)


@pytest.mark.parametrize(("old", "new", "message"), UNREADABLE)
@pytest.mark.parametrize("ending", ["\n", "\r\n"])
def test_a_file_that_says_nothing_is_told_and_never_reaches_the_daemon(
    old: str, new: str, message: str, ending: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """With a byte-order mark and the line ends of another system as well: both are read, and the lines stay those of the file."""
    content = replaced(PLANT, old, new).replace("\n", ending).encode("utf-8-sig" if ending == "\r\n" else "utf-8")
    told_by_check_and_daemon(content, message, tmp_path, capsys)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "bench.yaml:1:1: the file is empty"),
        (b"# a rig\n", "bench.yaml:1:1: the file is empty"),
        (b"t_s,axis.position\n0,1\n", "bench.yaml:1:1: the file must be a mapping of keys to values"),
        (bytes(range(256)) * 40, "bench.yaml:2:118: the file is not UTF-8 text: byte 0x80"),
        (PLANT.encode("utf-16"), "bench.yaml:1:1: the file is not UTF-8 text"),
        (
            PLANT.replace("name: bench", "name: bench # Prüfstand").encode("latin-1"),
            "bench.yaml:2:17: the file is not UTF-8 text: byte 0xfc",
        ),
        (PLANT[: len(PLANT) // 2].encode(), "bench.yaml:26:.*not readable as YAML"),
    ],
    ids=["empty", "comment", "table", "binary", "utf-16", "latin-1", "cut"],
)
def test_what_is_no_rig_file_at_all(content: bytes, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told_by_check_and_daemon(content, message, tmp_path, capsys)


def told_by_check_and_daemon(content: bytes, message: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = folder / "bench.yaml"
    file.write_bytes(content)
    for run in (["check", str(file)], ["daemon", str(file), "--runtime-dir", str(folder / "run"), "--log-dir", str(folder / "logs")]):
        command = main if run[0] == "check" else supervisor.main
        assert command(run if command is main else run[1:]) == 1
        assert re.search(message, capsys.readouterr().err)
    assert [path.name for path in folder.iterdir()] == ["bench.yaml"]


def test_line_and_brackets_of_a_finding_are_shown_as_they_are(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """`:100:` is the name of a picture to rich, and `[0, 0.2]` could be its markup."""
    lines = "".join(f"# {number}\n" for number in range(88))
    (tmp_path / "b.yaml").write_text(
        lines + replaced(PLANT, "travel: [0.02 m, 0.18 m]", "travel: [0.02 m, 0.5 m]").replace("\njoints", "\n\n\n\n\njoints")
    )
    monkeypatch.chdir(tmp_path)
    assert main(["check", "b.yaml"]) == 1
    said = re.sub(r"[│\s]+", " ", capsys.readouterr().out)
    assert "b.yaml:100:13: joints.axis.travel 0.02 to 0.5 m reaches beyond the stops of the simulated joint, 0 to 0.2 m" in said


def check_told_and_refused(wrong: str, at: int, old: str, message: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    told = errors(wrong)
    assert any(re.search(message, text) for text in told), told
    for text in told:
        assert re.match(r"bench.yaml:\d+:\d+: ", text), text
    (folder / "bench.yaml").write_text(wrong)
    assert supervisor.main([str(folder / "bench.yaml"), "--runtime-dir", str(folder / "run"), "--log-dir", str(folder / "logs")]) == 1
    assert re.search(message, capsys.readouterr().err)
    assert [path.name for path in folder.iterdir()] == ["bench.yaml"]  # it has not begun: no lock, no folder of logs


@pytest.mark.parametrize(
    ("right", "old", "new", "message"), [*((PLANT, *odd) for odd in ODDITIES), *((DEVICES, *odd) for odd in ODD_DEVICES)]
)
def test_what_is_odd_is_told_with_its_number_and_line(right: str, old: str, new: str, message: str) -> None:
    wrong = replaced(right, old, new)
    assert errors(wrong) == []
    (text,) = [text for text in warnings(wrong) if re.search(message, text)] or [str(warnings(wrong))]
    assert re.match(rf"bench.yaml:\d+:\d+: .*{message}", text), text


def test_all_problems_are_told_at_once(tmp_path: Path) -> None:
    """Of the schema, of devices and of channels, in the order of the file."""
    wrong = DEVICES
    changes = (("rate_limit: 0.2 m/s", "rate_limit: 0.2 m"), ("resolution: 25000", "resolution: 0"), ("type: uint16", "type: int24"))
    for old, new in (*changes, ("parity: none", "parity: E"), ("channel: input_1", "channel: input_2")):
        wrong = replaced(wrong, old, new)
    (tmp_path / "bench.yaml").write_text(wrong)
    with pytest.raises(ConfigError) as refusal:
        load_rig(tmp_path / "bench.yaml")
    told = [problem.text() for problem in refusal.value.problems]
    assert [word for text in told for word in ("rate_limit", "resolution", "int24", "parity", "input_2") if word in text] == [
        "rate_limit",
        "resolution",
        "int24",
        "parity",
        "input_2",
    ]


@pytest.mark.parametrize("text", [DEVICES, PLANT])
def test_what_passes_is_built_by_the_daemons_own_hands(text: str) -> None:
    rig = rig_from_text(text)
    refuse_unusable(LoadedRig(rig, text, "bench.yaml"))
    slow = {name: slow_mailbox(rig, name) for name, device in rig.devices.items() if device.slow}
    bank = DeviceBank(rig, rig_facts(rig), lockstep=False, slow=slow)
    assert set(bank.drivers) == {name for name, device in rig.devices.items() if not device.slow}
