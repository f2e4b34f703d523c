"""What a loss of power leaves: the disk is asked for the file after its last write, and for its name in the folder."""

from __future__ import annotations

import errno
import os
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from config.errors import LogError
from recording.files.writer import LogWriter
from recording.format.layout import CycleLayout

LAYOUT = CycleLayout(("axis",))
Calls = list[tuple[str, Path]]


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> Calls:
    """Writes and syncs of the system, in order, each with its file."""
    made: Calls = []

    def recorded(name: str, call: Callable[..., Any]) -> Callable[..., Any]:
        def with_record(descriptor: int, *rest: Any) -> Any:
            made.append((name, Path(os.readlink(f"/proc/self/fd/{descriptor}"))))
            return call(descriptor, *rest)

        return with_record

    for name in ("write", "fdatasync", "fsync"):
        monkeypatch.setattr(os, name, recorded(name, getattr(os, name)))
    return made


@pytest.fixture
def writer(tmp_path: Path, calls: Calls) -> LogWriter:
    return LogWriter(tmp_path / "a.mcap", LAYOUT, {}, {})


def refuse(*_: Any) -> None:
    raise OSError(errno.EIO, os.strerror(errno.EIO))


def a_cycle(writer: LogWriter) -> None:
    writer.cycle(0, LAYOUT.pack(LAYOUT.blank()))


def test_the_name_is_on_the_disk_from_the_start(tmp_path: Path, writer: LogWriter, calls: Calls) -> None:
    assert ("fsync", tmp_path) in calls
    writer.abandon()


def test_sync_follows_the_last_write_and_flush_syncs_nothing(tmp_path: Path, writer: LogWriter, calls: Calls) -> None:
    calls.clear()
    a_cycle(writer)
    writer.flush()
    assert {name for name, _ in calls} == {"write"}
    a_cycle(writer)
    writer.sync()
    assert calls[-2:] == [("write", tmp_path / "a.mcap"), ("fdatasync", tmp_path / "a.mcap")]
    writer.abandon()


def test_a_closed_file_is_on_the_disk_with_its_index(tmp_path: Path, writer: LogWriter, calls: Calls) -> None:
    a_cycle(writer)
    writer.close({})
    assert calls[-2:] == [("write", tmp_path / "a.mcap"), ("fdatasync", tmp_path / "a.mcap")]


@pytest.mark.parametrize("end", [LogWriter.sync, lambda writer: writer.close({})], ids=["sync", "close"])
def test_a_disk_that_fails_to_sync_is_told(writer: LogWriter, end: Callable[[LogWriter], None], monkeypatch: pytest.MonkeyPatch) -> None:
    a_cycle(writer)
    monkeypatch.setattr(os, "fdatasync", refuse)
    with pytest.raises(LogError, match=r"a\.mcap: the log cannot be written: Input/output error"):
        end(writer)
    writer.abandon()


def test_a_folder_that_fails_to_sync_is_told_and_leaves_no_file_open(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(os, "fsync", refuse)
    open_before = len(os.listdir("/proc/self/fd"))
    with pytest.raises(LogError, match=r"a\.mcap: the log cannot be written: Input/output error"):
        LogWriter(tmp_path / "a.mcap", LAYOUT, {}, {})
    assert len(os.listdir("/proc/self/fd")) == open_before
