"""Slow devices: a plug-in driver from outside, polled by the I/O process, aged by the interlocks."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest
import yaml

from config.errors import DriverError
from config.loading.load import load_rig, rig_from_text
from config.schema.rig import Device, Rig
from daemon.checks.interlocks import rig_facts
from daemon.ipc.slow_samples import slow_mailbox
from daemon.loop.device_bank import DeviceBank
from daemon.processes.io_process import SlowDevice
from drivers.contract import Driver, Quality, Sample
from tests.support.daemon.running_daemon import RunningDaemon, arm, until

pytestmark = pytest.mark.clock

# A driver as a stranger would write it: no import of ours, 20 ms a read. It answers while the file of its options exists.
PLUG_IN = """
import time
from pathlib import Path

class Sample:
    def __init__(self): self.raw, self.stamp_ns, self.quality = float("nan"), 0, 2

class Thermometer:
    inputs, outputs = ("spare", "oil"), ()
    def __init__(self, name, device, rig, lockstep):
        self.name, self.cable, self.samples = name, Path(device.options["cable"]), [Sample(), Sample()]
    def open(self):
        if not self.cable.exists(): raise OSError("no answer")
    def configure(self): pass
    def activate(self): pass
    def read(self, now_ns):
        time.sleep(0.02)
        self.open()
        for sample in self.samples: sample.raw, sample.stamp_ns, sample.quality = 405.0, time.monotonic_ns(), 0
        return self.samples
    def write(self, values, now_ns): pass
    def safe(self): pass
    def close(self): pass
"""


def rig_text(cable: Path, **device: object) -> str:
    """The Oak Ridge rig with its reservoir temperature on a slow device."""
    content = yaml.safe_load(load_rig("ornl_testbed").text)
    content["devices"]["box"] = {"driver": "thermometer", "slow": True, "options": {"cable": str(cable)}, **device}
    content["signals"]["reservoir_temperature"] |= {"device": "box", "channel": "oil", "max_age": "0.3 s"}
    return yaml.safe_dump(content, sort_keys=False)


def plug_in(directory: Path) -> dict[str, str]:
    """Installs the plug-in in `directory`; returns the environment in which it is found."""
    (directory / "thermometer.py").write_text(PLUG_IN)
    info = directory / "thermometer-1.0.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: thermometer\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text("[longreach.drivers]\nthermometer = thermometer:Thermometer\n")
    return {"PYTHONPATH": os.pathsep.join([str(directory), os.environ.get("PYTHONPATH", "")])}


def test_a_slow_device_serves_the_daemon_and_its_silence_is_a_fault(tmp_path: Path) -> None:
    cable = tmp_path / "cable"
    cable.touch()
    rig = tmp_path / "rig.yaml"
    rig.write_text(rig_text(cable))
    with RunningDaemon(tmp_path, rig=str(rig), environment=plug_in(tmp_path)) as daemon, daemon.wait_until_ready() as client:
        until(lambda: client.call("status")["reservoir_temperature_C"] == pytest.approx(40.5))
        arm(client)
        age = next(check for check in client.call("checks")["checks"] if check["name"] == "reservoir_temperature age")
        assert age["ok"]
        assert 0.0 < age["value"] < 0.3
        cable.unlink()
        until(lambda: client.call("status")["mode"] == "fault")
        assert "reservoir_temperature age (box.oil)" in client.call("status")["fault"]["text"]
        assert client.call("status")["loop"]["phases"]["read"]["p99_us"] < 20_000, "the loop never waited for the device"
        cable.touch()
        os.kill(daemon.child("io"), signal.SIGKILL)
        until(lambda: any(event["name"] == "io_died" for event in client.call("events", since=0)["events"]))
        client.call("reset")
        until(lambda: all(check["ok"] or check["name"] == "e-stop" for check in client.call("checks")["checks"]))


def test_a_device_that_does_not_answer_ends_the_start_with_its_name_and_reason(tmp_path: Path) -> None:
    rig = tmp_path / "rig.yaml"
    rig.write_text(rig_text(tmp_path / "no cable", slow=False))
    with RunningDaemon(tmp_path, rig=str(rig), environment=plug_in(tmp_path)) as daemon:
        assert daemon.process.wait(60) == 1
        assert "devices.box: the device did not open: OSError: no answer" in daemon.text()


class Blocking:
    """Answers after `released` is set."""

    inputs, outputs = ("oil",), ()

    def __init__(self, released: threading.Event) -> None:
        self.name, self.released, self.reads = "box", released, 0

    def open(self) -> None: ...
    def configure(self) -> None: ...
    def activate(self) -> None: ...
    def write(self, values: Sequence[float], now_ns: int) -> None: ...
    def safe(self) -> None: ...
    def close(self) -> None: ...

    def read(self, now_ns: int) -> Sequence[Sample]:
        self.reads += 1
        self.released.wait(10)
        return [Sample(300.0, time.monotonic_ns(), Quality.GOOD)]


def bank_with_slow_box(rig: Rig) -> tuple[DeviceBank, list[float], Callable[[str], int], SlowDevice, threading.Event]:
    facts, released = rig_facts(rig), threading.Event()
    box = slow_mailbox(rig, "box")

    def create(name: str, device: Device, rig: Rig, lockstep: bool) -> Driver:
        return Blocking(released)

    return (
        DeviceBank(rig, facts, lockstep=False, slow={"box": box}),
        facts.blank(),
        facts.index,
        SlowDevice("box", rig, box, create),
        released,
    )


def test_a_blocked_device_never_blocks_the_loops_read(tmp_path: Path) -> None:
    rig = rig_from_text(rig_text(tmp_path), "slow.yaml")
    bank, values, at, device, released = bank_with_slow_box(rig)
    bank.open()
    ended = threading.Event()
    thread = threading.Thread(target=device.run, args=(ended,))
    thread.start()
    started = time.monotonic_ns()
    for _ in range(50):
        bank.read(time.monotonic_ns(), values)
    assert time.monotonic_ns() - started < 2e9
    assert values[at("reservoir_temperature.quality")] == Quality.BAD
    assert values[at("reservoir_temperature_C")] != values[at("reservoir_temperature_C")]
    released.set()
    until(lambda: bank.read(time.monotonic_ns(), values) or values[at("reservoir_temperature.quality")] == Quality.GOOD)
    assert values[at("reservoir_temperature_C")] == pytest.approx(30.0)
    ended.set()
    thread.join(10)
    bank.close()


def test_a_channel_that_no_device_has_is_refused() -> None:
    content = yaml.safe_load(load_rig("ornl_testbed").text)
    content["signals"]["rotary.position"]["channel"] = "rotary.angle"
    rig = rig_from_text(yaml.safe_dump(content), "wrong.yaml")
    with pytest.raises(DriverError, match=r"signals\.rotary\.position\.channel.*rotary\.angle"):
        DeviceBank(rig, rig_facts(rig), lockstep=True)


def test_a_driver_that_cannot_be_made_is_told_and_tried_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A wrong entry point is no end of the thread, which nobody would see."""
    monkeypatch.setattr("daemon.processes.io_process.RETRY_S", 0.01)
    rig, released, ended = rig_from_text(rig_text(tmp_path), "slow.yaml"), threading.Event(), threading.Event()
    released.set()
    made: list[Blocking] = []

    def create(name: str, device: Device, rig: Rig, lockstep: bool) -> Driver:
        made.append(Blocking(released))
        if len(made) == 1:
            raise AttributeError("no create in it")
        return made[-1]

    device = SlowDevice("box", rig, slow_mailbox(rig, "box"), create)
    thread = threading.Thread(target=device.run, args=(ended,))
    thread.start()
    until(lambda: made and made[-1].reads > 0)
    ended.set()
    thread.join(10)
    assert "slow device box: no create in it; trying again" in capsys.readouterr().err
