"""The twin's serial line: read through the driver and found by `device scan`, and gone with the twin."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from pathlib import Path

import pytest

from config.errors import PlantError
from config.loading.load import load_rig
from daemon.cli.main import main
from sim_backend.twin.modbus.serial_line import SerialLine
from sim_backend.twin.process import Twin
from tests.support.daemon.running_daemon import until


@pytest.fixture
def rig(tmp_path: Path) -> Iterator[Path]:
    """The shipped rig with its gauges on a serial line, and its twin."""
    text = load_rig("analogue_axis").text
    start, end = text.index("      transport: tcp\n"), text.index("      answer_timeout: 100 ms")
    line = f"      transport: rtu\n      port: {tmp_path / 'line'}\n      baud_rate: 9600\n      parity: none\n      unit_id: 3\n"
    path = tmp_path / "rig.yaml"
    path.write_text((text[:start] + line + text[end:]).replace("answer_timeout: 100 ms", "answer_timeout: 1 s"))
    twin = Twin(load_rig(path).rig, "virtual", "serial twin")
    thread = threading.Thread(target=twin.run, daemon=True)
    thread.start()
    until(lambda: twin.bench.clock.caught_up > 0, 60.0)
    yield path
    twin.stop()
    thread.join(20)
    assert not (tmp_path / "line").is_symlink(), "it goes with the twin"


def test_a_unit_on_the_line_is_found_and_read(rig: Path, capsys: pytest.CaptureFixture[str]) -> None:
    where = f"rtu:{rig.parent / 'line'}"
    assert main(["device", "scan", where, "--parity", "none", "--units", "2-4", "--answer-timeout", "0.5 s", "--json"]) == 0
    (line,) = json.loads(capsys.readouterr().out)["lines"]
    assert [unit["unit"] for unit in line["units"]] == [3]
    assert main(["device", "read", str(rig), "hydraulic_unit", "--json"]) == 0
    values = {place["name"]: place["value"] for place in json.loads(capsys.readouterr().out)["places"]}
    assert values["return_pressure"] == pytest.approx(2.0, abs=0.2)
    assert values["oil_temperature"] == pytest.approx(40.0, abs=1.0)


def test_a_port_that_is_there_is_left_alone(tmp_path: Path) -> None:
    port = tmp_path / "ttyUSB0"
    port.write_text("a device")
    with pytest.raises(PlantError, match="the serial line cannot be simulated there: File exists"):
        SerialLine(str(port))
    assert port.read_text() == "a device"


def test_what_a_killed_twin_left_is_replaced(tmp_path: Path) -> None:
    port = tmp_path / "line"
    port.symlink_to("/dev/pts/nowhere")
    line = SerialLine(str(port))
    assert port.exists()
    line.close()
    assert not port.is_symlink()
