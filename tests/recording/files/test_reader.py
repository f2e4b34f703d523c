"""Reading whole, cut and altered logs: all that is whole comes back exactly, nothing is invented, and the text says where the cut is."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from config.errors import LogError, UsageError
from recording.files.catalogue import recorded
from recording.files.check import check_log
from recording.files.preceding import preceding
from recording.files.reader import Log, open_rig, read_log
from recording.files.recover import recover
from recording.files.writer import LogWriter
from recording.format.layout import CycleLayout
from tests.support.recording import logs

ZSTD_FRAME = b"\x28\xb5\x2f\xfd"


@dataclass(frozen=True, repr=False)
class Whole:
    """Bytes and rows of a closed log with attachments; `second_frame` is the byte where its second chunk's data start."""

    content: bytes
    table: list[list[float]]

    @property
    def second_frame(self) -> int:
        return self.content.index(ZSTD_FRAME, self.content.index(ZSTD_FRAME) + 4)


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> Whole:
    path = tmp_path_factory.mktemp("log") / "whole.mcap"
    table = logs.write(path, 300, flush_every=50, rig__yaml=b"longreach: rig/1\n", note__txt=b"x" * 400)
    return Whole(path.read_bytes(), table)


def assert_rows(log: Log, table: list[list[float]]) -> None:
    layout = CycleLayout(logs.JOINTS)
    for number, field in enumerate(layout.fields):
        written = np.array([row[number] for row in table], dtype=layout.dtype[field.name])
        assert np.array_equal(log.columns[field.name], written, equal_nan=field.ros_type == "float64"), field.name


def test_every_number_comes_back(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    table = logs.write(path, 500, rig__yaml=b"abc")
    log = read_log(path)
    assert_rows(log, table)
    assert log.complete
    assert log.cut_text == ""
    assert log.attachments == {"rig.yaml": b"abc"}
    assert log.metadata["recording"]["rig_name"] == "bench"
    assert log.metadata["closing"] == {"grade": "A", "cycles": "500", "complete": "true"}
    assert [event.cycle for event in log.events] == [50, 150, 250, 350, 450]
    assert log.time_ns[3] == logs.START_NS + 3_000_000
    assert log.duration_s == pytest.approx(0.499)


def test_a_log_that_was_not_closed_says_so(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    table = logs.write(path, 200, close=False)
    log = read_log(path)
    assert_rows(log, table)
    assert not log.complete
    assert log.cut_text == (
        "The log is still being recorded, or was cut at t = 0.199 s, after cycle 199: the file ends without having been closed. "
        "Everything before is here; `longreach log recover` makes a whole file of it."
    )


def _refused(path: Path) -> bool:
    try:
        read_log(path)
    except LogError:
        return True
    return False


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_cut_at_any_byte(whole: Whole, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    content, table = whole.content, whole.table
    length = data.draw(st.integers(0, len(content) - 1))
    path = tmp_path_factory.getbasetemp() / "cut.mcap"
    path.write_bytes(content[:length])
    if length < whole.second_frame and _refused(path):
        return  # cut before its first cycles reached the file
    log = read_log(path)
    assert not log.complete
    assert log.cut_text.startswith("The log is still being recorded, or was cut")
    assert log.cycles % 50 == 0
    assert_rows(log, table[: log.cycles])
    assert set(log.attachments.items()) <= {("rig.yaml", b"longreach: rig/1\n"), ("note.txt", b"x" * 400)}


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_any_altered_byte_is_noticed(whole: Whole, tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    """One flipped byte before the end record: either refused, or reported, and every row that is given is a row that was written."""
    content, table = whole.content, whole.table
    end_of_data = content.rindex(b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00")
    at = data.draw(st.integers(8, end_of_data - 1))
    flipped = bytearray(content)
    flipped[at] ^= data.draw(st.integers(1, 255))
    path = tmp_path_factory.getbasetemp() / "flipped.mcap"
    path.write_bytes(bytes(flipped))
    if _refused(path):
        return
    log = read_log(path)
    assert not log.complete
    kept = [table[int(cycle)] for cycle in log.columns["cycle"]]
    assert_rows(log, kept)


def test_a_folder_with_damaged_logs_is_read_all_the_same(whole: Whole, tmp_path: Path) -> None:
    """Bytes of the part that the MCAP library reads first, and of the chunks before it: none of its errors gets out."""
    logs.write(tmp_path / "b.mcap", 1)
    log = read_log(tmp_path / "b.mcap")
    log.time_ns[0] = logs.START_NS + 300_000_000
    end_of_data = whole.content.rindex(b"\x0f\x04\x00\x00\x00\x00\x00\x00\x00")
    for at in (*range(end_of_data, len(whole.content), 61), *range(whole.content.index(ZSTD_FRAME), end_of_data, 12_007)):
        flipped = bytearray(whole.content)
        flipped[at] ^= 0xA5
        (tmp_path / "a.mcap").write_bytes(bytes(flipped))
        assert preceding(log) is None
        try:
            assert recorded(tmp_path / "a.mcap").rig_name in ("bench", "")
        except LogError:
            continue


@pytest.mark.parametrize("tail", [b"\x00" * 8192, b"\xff" * 8192, b"\x06" + b"\xff" * 100])
def test_a_tail_of_nonsense_after_a_loss_of_power(whole: Whole, tmp_path: Path, tail: bytes) -> None:
    """File systems may leave blocks of zeros or old data where the last writes should be."""
    path = tmp_path / "a.mcap"
    path.write_bytes(whole.content[: len(whole.content) // 2] + tail)
    log = read_log(path)
    assert 0 < log.cycles < 300
    assert not log.complete
    assert_rows(log, whole.table[: log.cycles])


def test_a_damaged_chunk_costs_only_its_own_rows(whole: Whole, tmp_path: Path) -> None:
    flipped = bytearray(whole.content)
    flipped[whole.second_frame + 2000] ^= 0xFF
    path = tmp_path / "a.mcap"
    path.write_bytes(bytes(flipped))
    log = read_log(path)
    assert log.cycles == 250
    assert list(log.columns["cycle"][49:51]) == [49, 100]
    assert "a chunk" in log.cut_text
    assert "it was left out" in log.cut_text


def first_chunk_damaged(content: bytes) -> bytes:
    """A byte of the chunk in which the topics and their schemas stand before their messages."""
    flipped = bytearray(content)
    flipped[content.index(ZSTD_FRAME) + 2000] ^= 0xFF
    return bytes(flipped)


def test_the_first_chunk_costs_only_its_own_rows_where_the_log_was_closed(whole: Whole, tmp_path: Path) -> None:
    """Topics and schemas stand in it alone, and again at the end of a closed log."""
    (tmp_path / "a.mcap").write_bytes(first_chunk_damaged(whole.content))
    log = read_log(tmp_path / "a.mcap")
    assert_rows(log, whole.table[50:])
    assert [event.cycle for event in log.events] == [50, 150, 250]
    assert "1 chunk of records left out, the rest is here; `longreach log recover`" in log.cut_text
    report = recover(tmp_path / "a.mcap", tmp_path / "b.mcap")
    assert report.dropped_chunks == 1
    assert " Lost: 1 damaged chunk of records. Found: " in report.text()
    mended = read_log(tmp_path / "b.mcap")
    assert_rows(mended, whole.table[50:])
    assert (mended.events, mended.damage.sentences) == (log.events, [])


def test_a_damaged_first_chunk_of_a_cut_log_is_named(whole: Whole, tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(first_chunk_damaged(whole.content)[: len(whole.content) // 2])
    with pytest.raises(LogError, match=r"the part of the log that says what its messages hold is damaged: a chunk .* need another copy"):
        read_log(tmp_path / "a.mcap")


@pytest.mark.parametrize(
    ("name", "content", "text"),
    [
        ("a.mcap", b"", "the file is empty. Nothing was recorded into it."),
        ("a.mcap", b"SQLite format 3\x00", "this is not a log: the file does not start as an MCAP file: b'SQLite f'. Give a log"),
        ("d.csv", b"t_s,x\n0,1\n", "this is a table, not a log. Run `longreach import "),
        ("a.mcap", b"\x89MCAP0\r\n", "the log was cut before its first cycle, or has none yet. There is nothing in it to recover."),
    ],
)
def test_wrong_files_are_refused_with_the_next_step(tmp_path: Path, name: str, content: bytes, text: str) -> None:
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(LogError) as caught:
        read_log(path)
    assert text in str(caught.value)
    assert str(path) in str(caught.value)


def test_a_missing_file_and_a_directory(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="the log cannot be opened: No such file or directory"):
        read_log(tmp_path / "none.mcap")
    with pytest.raises(LogError, match=r"the log cannot be opened: Is a directory\. A log is one file; there is none here"):
        read_log(tmp_path)
    older, newest = tmp_path / "older.mcap", tmp_path / "newest.mcap"
    for age_s, log in ((60, older), (1, newest)):
        log.touch()
        os.utime(log, (1e9 - age_s, 1e9 - age_s))
    with pytest.raises(LogError, match=r"the newest here is newest\.mcap") as caught:
        read_log(tmp_path)
    assert caught.value.refusal.mend == {str(tmp_path): str(newest)}


def test_another_program_s_mcap_is_refused(tmp_path: Path) -> None:
    from mcap.writer import Writer

    path = tmp_path / "other.mcap"
    writer = Writer(str(path))
    writer.start()
    channel = writer.register_channel("/odom", "json", writer.register_schema("Odom", "jsonschema", b"{}"))
    writer.add_message(channel, 0, b"{}", 0)
    writer.finish()
    with pytest.raises(LogError, match="this MCAP file was not written by longreach: it has no /cycle records"):
        read_log(path)


def test_lz4_and_plain_chunks_are_read_too(tmp_path: Path) -> None:
    from mcap.writer import CompressionType, Writer

    layout = CycleLayout(logs.JOINTS)
    table = logs.rows(layout, 20)
    for kind in (CompressionType.LZ4, CompressionType.NONE):
        path = tmp_path / f"{kind.name}.mcap"
        writer = Writer(str(path), compression=kind)
        writer.start()
        channel = writer.register_channel(
            "/cycle", "cdr", writer.register_schema(layout.schema_name, "ros2msg", layout.schema_text.encode())
        )
        for row in table:
            writer.add_message(channel, 0, layout.pack(row), 0)
        writer.finish()
        assert_rows(read_log(path), table)


def test_a_log_without_rig_says_so(tmp_path: Path) -> None:
    logs.write(tmp_path / "a.mcap", 100)
    with pytest.raises(LogError, match="the log has no rig file inside"):
        open_rig(read_log(tmp_path / "a.mcap"))


def test_an_existing_recording_is_never_written_over(tmp_path: Path) -> None:
    logs.write(tmp_path / "a.mcap", 100)
    before = (tmp_path / "a.mcap").read_bytes()
    with pytest.raises(LogError, match=r"the log exists already\. Choose another name; recordings are never written over."):
        LogWriter(tmp_path / "a.mcap", CycleLayout(("axis",)), {}, {})
    assert (tmp_path / "a.mcap").read_bytes() == before


def test_recover_of_a_cut_log(whole: Whole, tmp_path: Path) -> None:
    content, table = whole.content, whole.table
    (tmp_path / "cut.mcap").write_bytes(content[: len(content) * 2 // 3])
    report = recover(tmp_path / "cut.mcap", tmp_path / "good.mcap")
    log = read_log(tmp_path / "good.mcap")
    assert report.cycles == log.cycles == 200
    assert log.damage.sentences == []
    assert_rows(log, table[:200])
    assert log.attachments["note.txt"] == b"x" * 400
    assert log.cut_text == "This log was recovered: the recording had been cut at t = 0.199 s."
    assert log.metadata["recovered"]["from"] == "cut.mcap"
    assert report.text().startswith(f"{tmp_path / 'good.mcap'}: 200 cycles and 2 events kept, up to t = 0.199 s. Lost: ")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["cut.mcap", "good.mcap"]
    from mcap.reader import make_reader

    with (tmp_path / "good.mcap").open("rb") as file:
        assert sum(1 for _ in make_reader(file).iter_messages(["/cycle"])) == 200


def test_recover_of_a_damaged_log_whose_end_is_there_speaks_of_no_cut(whole: Whole, tmp_path: Path) -> None:
    flipped = bytearray(whole.content)
    flipped[whole.second_frame + 2000] ^= 0xFF
    (tmp_path / "a.mcap").write_bytes(bytes(flipped))
    assert "makes a whole file of the rest" in read_log(tmp_path / "a.mcap").cut_text
    report = recover(tmp_path / "a.mcap", tmp_path / "b.mcap")
    lost = "Lost: 50 cycles before the end, and 1 damaged chunk of records."
    assert (report.closed, report.lost_bytes, lost in report.text(), "cut" in report.text()) == (True, 0, True, False)
    assert read_log(tmp_path / "b.mcap").cut_text == f"This log was recovered: the recording had been damaged. {lost}"


def test_recover_has_nothing_to_do_for_a_whole_log(whole: Whole, tmp_path: Path) -> None:
    (tmp_path / "a.mcap").write_bytes(whole.content)
    report = recover(tmp_path / "a.mcap", tmp_path / "b.mcap")
    assert report.text() == f"{tmp_path / 'a.mcap'} is whole (300 cycles); nothing to repair, no file written."
    assert not (tmp_path / "b.mcap").exists()


@pytest.mark.parametrize("tail", [b"x", b"more of something else\n" * 40])
def test_what_follows_the_end_mark_is_told_and_left_out_by_a_repair(whole: Whole, tmp_path: Path, tail: bytes) -> None:
    """The reader of the mcap library ends in an error there."""
    from mcap.reader import make_reader

    (tmp_path / "a.mcap").write_bytes(whole.content + tail)
    assert not check_log(tmp_path / "a.mcap").good
    assert f"{len(tail)} byte" in read_log(tmp_path / "a.mcap").cut_text
    assert recover(tmp_path / "a.mcap", tmp_path / "b.mcap").cycles == 300
    assert check_log(tmp_path / "b.mcap").findings[0].grade != "error"
    with (tmp_path / "b.mcap").open("rb") as file:
        assert sum(1 for _ in make_reader(file).iter_messages(["/cycle"])) == 300


def test_a_recovered_log_needs_no_second_repair(whole: Whole, tmp_path: Path) -> None:
    (tmp_path / "cut.mcap").write_bytes(whole.content[:-100])
    recover(tmp_path / "cut.mcap", tmp_path / "a.mcap")
    assert recover(tmp_path / "a.mcap", tmp_path / "b.mcap").written is None


def test_a_recovered_log_that_was_damaged_since_is_repaired_again(whole: Whole, tmp_path: Path) -> None:
    (tmp_path / "cut.mcap").write_bytes(whole.content[:-100])
    recover(tmp_path / "cut.mcap", tmp_path / "a.mcap")
    content = bytearray((tmp_path / "a.mcap").read_bytes())
    content[content.index(ZSTD_FRAME, content.index(ZSTD_FRAME) + 4) + 2000] ^= 0xFF
    (tmp_path / "a.mcap").write_bytes(bytes(content))
    report = recover(tmp_path / "a.mcap", tmp_path / "b.mcap")
    assert report.written == tmp_path / "b.mcap"
    assert 0 < report.cycles == read_log(report.written).cycles < 300
    assert "a chunk" in report.text()
    assert next(each.grade for each in check_log(tmp_path / "a.mcap").findings if each.name == "whole") == "error"
    assert next(each.grade for each in check_log(tmp_path / "b.mcap").findings if each.name == "whole") == "warning"


def test_recover_does_not_write_over_a_file(whole: Whole, tmp_path: Path) -> None:
    (tmp_path / "cut.mcap").write_bytes(whole.content[:-100])
    (tmp_path / "b.mcap").write_bytes(b"mine")
    with pytest.raises(UsageError, match="the file to write exists already"):
        recover(tmp_path / "cut.mcap", tmp_path / "b.mcap")
    assert (tmp_path / "b.mcap").read_bytes() == b"mine"
