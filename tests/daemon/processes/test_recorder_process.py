"""The recorder process's loop in a thread: a disk that cannot be written is told, and the ring is drained all the same."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from config.errors import LogError
from config.loading.load import apply_overrides, rig_from_text
from daemon.checks.declared.daemon_health import RECORDER_AGE_LIMIT_S
from daemon.checks.interlocks import rig_facts
from daemon.cycle.log_stream import LogStream, RecordKind
from daemon.processes.channels import Channels, RecorderHealth
from daemon.processes.recorder import Recorder
from daemon.processes.recorder_process import RecorderProcess
from recording.files.reader import read_log
from recording.files.session import Session
from recording.format.event import Level
from recording.format.layout import CycleLayout
from tests.support.daemon.rigs import RIG
from tests.support.daemon.running_daemon import until

LAYOUT = CycleLayout.of_rig(RIG.rig)


@contextmanager
def running(directory: Path, channels: Channels) -> Iterator[tuple[RecorderProcess, Recorder, threading.Thread]]:
    recorder = Recorder(Session.of(RIG, directory, {"clock": "wall"}))
    process = RecorderProcess(channels, recorder)
    thread = threading.Thread(target=process.run)
    thread.start()
    yield process, recorder, thread
    thread.join(20)
    assert not thread.is_alive()


def health(channels: Channels) -> RecorderHealth:
    latest = channels.recorder_health.get()
    return RecorderHealth(*latest.values) if latest else RecorderHealth(0.0, 0.0, 0.0)


def told(channels: Channels) -> list[dict[str, str]]:
    found = []
    while (record := channels.recorder_reports.read()) is not None:
        found.append(json.loads(record.data))
    return found


def send_rows(log: LogStream, count: int) -> None:
    values = LAYOUT.blank()
    for _ in range(count):
        log.now_ns += 1_000_000
        values[0] += 1
        log.cycle(values)


def test_rows_events_and_attachments_of_two_recordings_reach_two_files(tmp_path: Path) -> None:
    channels = Channels.create(RIG.rig)
    log = LogStream(LAYOUT, channels.records, channels.events)
    with running(tmp_path, channels) as (_, recorder, _):
        for number in (1, 2):
            log.now_ns = number * 10**18
            log.open({"made": number}, {"realtime": "no"})
            send_rows(log, 500)
            log.attach("run-1.json", "application/json", b"{}\0with a zero byte")
            log.event(Level.INFO, "hello", "text", {"x_m": 1.5})
            log.close({"ended_by": "test"})
        log.end()
    assert len(recorder.finished) == 2
    for number, path in enumerate(recorder.finished, 1):
        read = read_log(path)
        assert read.complete
        assert read.cycles == 500
        assert read.attachments["run-1.json"] == b"{}\0with a zero byte"
        assert json.loads(read.attachments["controller_state.json"]) == {"made": number}
        assert read.events[-1].values == {"x_m": 1.5}
        assert read.metadata["recording"]["realtime"] == "no"
    assert told(channels)[-1] == {"path": str(recorder.finished[-1])}, "the first may come and go between two reports"
    assert health(channels).file_bytes == recorder.finished[-1].stat().st_size


def test_rows_without_an_open_recording_are_left_out(tmp_path: Path) -> None:
    channels = Channels.create(RIG.rig)
    channels.records.write(RecordKind.CYCLE, 1, b"x" * LAYOUT.struct.size)
    channels.records.write(RecordKind.END, 1, b"")
    with running(tmp_path, channels) as (_, recorder, _):
        pass
    assert not recorder.finished
    assert not list(tmp_path.iterdir())


def test_a_disk_that_cannot_be_written_is_told_and_the_ring_still_drained(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    channels = Channels.create(RIG.rig)
    log = LogStream(LAYOUT, channels.records, channels.events)
    with running(tmp_path, channels) as (_, recorder, _):
        log.open({}, {})
        until(lambda: recorder.open)

        def full(*_: object) -> None:
            raise LogError("the log cannot be written", value="No space left on device")

        monkeypatch.setattr(recorder._writer, "cycle", full)
        send_rows(log, 5000)
        until(lambda: health(channels).failed == 1.0)
        until(lambda: channels.records.backlog_bytes == 0)
        log.end()
    assert any("No space left" in content.get("error", "") for content in told(channels))
    assert channels.records.dropped == 0


@pytest.mark.parametrize("rate", ["250 Hz", "1 kHz", "2 kHz"])
def test_a_disk_that_waits_as_long_as_the_check_allows_costs_no_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, rate: str) -> None:
    """The disk holds a sync up until twice the check's limit has passed in rows; then all of them are in the file."""
    rig = rig_from_text(apply_overrides(RIG.text, [f"loop.rate={rate}"]))
    channels = Channels.create(rig)
    log = LogStream(LAYOUT, channels.records, channels.events)
    asked, disk, rows = threading.Event(), threading.Event(), int(2.0 * RECORDER_AGE_LIMIT_S * rig.loop.rate_Hz)
    with running(tmp_path, channels) as (_, recorder, _):
        log.open({}, {})
        until(lambda: recorder.open)
        monkeypatch.setattr(recorder._writer, "sync", lambda: asked.set() or disk.wait())
        assert asked.wait(10)
        send_rows(log, rows)
        disk.set()
        log.end()
    assert channels.records.dropped == 0
    assert read_log(recorder.finished[-1]).cycles == rows


def test_asked_to_end_while_the_loop_is_dead_it_writes_what_there_is_and_closes(tmp_path: Path) -> None:
    channels = Channels.create(RIG.rig)
    channels.status.put(0, rig_facts(RIG.rig).blank())  # the loop's last sign of life was long ago
    log = LogStream(LAYOUT, channels.records, channels.events)
    with running(tmp_path, channels) as (process, recorder, _):
        log.open({}, {})
        send_rows(log, 100)
        process.on_signal(15, None)
    read = read_log(recorder.finished[-1])
    assert read.complete
    assert read.cycles == 100
    assert read.metadata["closing"]["ended_by"] == "the control process died"
