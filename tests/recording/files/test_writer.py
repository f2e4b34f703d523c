"""What a kill of the recorder costs, how fast a log grows, and what happens when the disk is full."""

from __future__ import annotations

import os
import random
import resource
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from config.errors import LogError
from recording.files.reader import read_log
from recording.files.writer import LogWriter
from recording.format.layout import CycleLayout
from tests.support.recording import logs

CHECKOUT = Path(__file__).parents[3]  # a child started with -c imports from where it stands
_RECORDER = """
import sys, time
from tests.support.recording import logs
from recording.format.layout import CycleLayout
from recording.files.writer import LogWriter
layout = CycleLayout(logs.JOINTS)
packed = [layout.pack(row) for row in logs.rows(layout, 3000)]
writer = LogWriter(sys.argv[1], layout, {}, logs.metadata())
start, flushed, k = time.monotonic(), 0.0, 0
while True:
    now = time.monotonic() - start
    while k < min(now * 1000, len(packed)):
        writer.cycle(k * 1_000_000, packed[k])
        k += 1
    if now - flushed >= 0.1:
        writer.flush()
        flushed = now
    sys.stdout.write(f"{k}\\n")
    sys.stdout.flush()
    time.sleep(0.002)
"""


def _last_number(process: subprocess.Popen[bytes], wanted: int) -> int:
    """Read what the recorder says it has taken until it has taken `wanted` records."""
    assert process.stdout is not None
    for line in process.stdout:
        if int(line) >= wanted:
            return int(line)
    raise AssertionError("the recorder ended by itself")


def _drained(process: subprocess.Popen[bytes], last: int) -> int:
    assert process.stdout is not None
    rest = process.stdout.read().split()
    return int(rest[-1]) if rest else last


@pytest.mark.clock
@pytest.mark.parametrize("records", [237, 700, 1404])
def test_sigkill_loses_no_more_than_250_ms(tmp_path: Path, records: int) -> None:
    assert _lost_to_a_kill(tmp_path, records) <= 250


@pytest.mark.clock
@pytest.mark.slow
def test_sigkill_at_many_random_moments(tmp_path: Path) -> None:
    moments = random.Random(7).sample(range(150, 1500), 25)
    lost = [_lost_to_a_kill(tmp_path, records) for records in moments]
    assert max(lost) <= 250, lost


def _lost_to_a_kill(tmp_path: Path, records: int) -> int:
    """Records that a recorder had taken but that are not in its file after a kill; what is in the file is right."""
    path = tmp_path / f"killed-{records}.mcap"
    command = [sys.executable, "-c", _RECORDER, str(path)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, cwd=CHECKOUT) as process:
        last = _last_number(process, records)
        os.kill(process.pid, signal.SIGKILL)
        last = _drained(process, last)
    log = read_log(path)
    assert not log.complete
    table = logs.rows(CycleLayout(logs.JOINTS), log.cycles)
    assert np.array_equal(log.columns["rotary.position"], [row[CycleLayout(logs.JOINTS).index("rotary.position")] for row in table])
    return last - log.cycles


def test_a_log_at_1_kHz_grows_by_less_than_a_megabyte_a_second(tmp_path: Path) -> None:
    layout = CycleLayout(logs.JOINTS)
    packed = [layout.pack(row) for row in logs.rows(layout, 5000)]
    writer = LogWriter(tmp_path / "a.mcap", layout, {}, {})
    for k, data in enumerate(packed):
        writer.cycle(k * 1_000_000, data)
        if k % 100 == 99:
            writer.flush()
    writer.close({})
    assert (tmp_path / "a.mcap").stat().st_size / 5.0 < 1e6  # bytes a second; 0.43 MB/s seen with noise in every field


def _write_all(writer: LogWriter, packed: list[bytes]) -> None:
    for k, data in enumerate(packed):
        writer.cycle(k, data)
        if k % 50 == 49:
            writer.flush()


def test_a_full_disk_is_refused_and_the_file_stays_readable(tmp_path: Path) -> None:
    """The file size limit of the process stands for the full disk: the write stops half way in the same manner."""
    layout = CycleLayout(logs.JOINTS)
    writer = LogWriter(tmp_path / "a.mcap", layout, {}, {})
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    previous = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, hard))
        with pytest.raises(LogError) as caught:
            _write_all(writer, [layout.pack(row) for row in logs.rows(layout, 400)])
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, previous)
        writer.abandon()
    assert "the log cannot be written: File too large. No file may grow that large here (`ulimit -f`): make room" in str(caught.value)
    log = read_log(tmp_path / "a.mcap")
    assert log.cycles >= 50
    assert log.damage.sentences == ["the file ends without having been closed"]


def test_every_checksum_of_a_closed_file_is_right_by_the_mcap_library(tmp_path: Path) -> None:
    from mcap.stream_reader import StreamReader

    logs.write(tmp_path / "a.mcap", 300, rig__yaml=b"x")
    with (tmp_path / "a.mcap").open("rb") as file:
        kinds = [type(record).__name__ for record in StreamReader(file, validate_crcs=True).records]
    assert kinds.count("Message") == 303
    assert {"Header", "Schema", "Channel", "Attachment", "Metadata", "MessageIndex", "DataEnd", "Statistics", "Footer"} <= set(kinds)


def test_sync_puts_the_file_on_the_disk(tmp_path: Path) -> None:
    layout = CycleLayout(("axis",))
    writer = LogWriter(tmp_path / "a.mcap", layout, {}, {})
    writer.cycle(0, layout.pack(layout.blank()))
    writer.sync()
    assert read_log(tmp_path / "a.mcap").cycles == 1
    writer.close({})


def test_a_directory_that_does_not_exist(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="the log cannot be written: No such file or directory"):
        LogWriter(tmp_path / "none" / "a.mcap", CycleLayout(("axis",)), {}, {})
