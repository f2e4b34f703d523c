"""Columns of dates: beside numpy's own reading of them, over midnight, and what cannot be told."""

from __future__ import annotations

from datetime import UTC, datetime, timedelta
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from config.errors import ConfigError, LogError
from recording.files.reader import read_log
from recording.importing.date_times import seconds_of
from recording.importing.ingest import ingest
from recording.importing.read_table import read_table
from recording.importing.suggestion import suggested_map

MOMENTS = st.datetimes(datetime(1990, 1, 1), datetime(2090, 1, 1))


@given(MOMENTS)
def test_iso_and_german_dates_are_what_numpy_says(moment: datetime) -> None:
    expected = float(np.datetime64(moment, "us").astype(np.int64)) * 1e-6
    iso, german = moment.isoformat(sep=" ", timespec="microseconds"), f"{moment:%d.%m.%Y %H:%M:%S},{moment.microsecond:06d}"
    for cell in (iso, iso.replace(" ", "T") + "Z", german):
        found = seconds_of(cell)
        assert found is not None
        assert found[1]
        assert found[0] == pytest.approx(expected, abs=1e-6)


def test_a_zone_is_taken_off() -> None:
    assert seconds_of("2026-11-25T12:00:00+02:00") == seconds_of("2026-11-25 10:00")
    assert seconds_of("2026-11-25T12:00:00-0330") == seconds_of("2026-11-25 15:30:00")


@pytest.mark.parametrize(
    "cell", ["3/4/2026 12:00:00", "2026-13-01 12:00:00", "2026-02-30 12:00", "24:00:01", "12:60", "12", "1.5", "abc", ""]
)
def test_what_is_no_moment_is_none(cell: str) -> None:
    assert seconds_of(cell) is None


def table(folder: Path, *cells: str) -> Path:
    path = folder / "table.csv"
    path.write_text("Zeit;pos_mm\n" + "".join(f"{cell};{k}\n" for k, cell in enumerate(cells)))
    return path


def test_a_column_of_dates_becomes_seconds_since_its_first_row(tmp_path: Path) -> None:
    start = datetime(2026, 12, 31, 23, 59, 59, 500_000, tzinfo=UTC)
    times = [start + timedelta(milliseconds=20 * k) for k in range(60)]  # into the next year
    found = read_table(table(tmp_path, *(f"{t:%Y-%m-%d %H:%M:%S.%f}" for t in times)))
    assert found.columns["Zeit"] == pytest.approx(0.02 * np.arange(60), abs=1e-6)
    assert any("seconds since its first row" in note for note in found.notes)


def test_times_of_day_go_on_over_midnight(tmp_path: Path) -> None:
    found = read_table(table(tmp_path, "23:59:59,0", "23:59:59,5", "00:00:00,0", "00:00:00,5"))
    assert found.columns["Zeit"] == pytest.approx([0.0, 0.5, 1.0, 1.5])


@pytest.mark.parametrize("cells", [("2026-11-25 12:00:00", "12:00:01"), ("12:00:00", "1.5"), ("0.5", "2026-11-25 12:00:00")])
def test_a_mixed_column_is_refused_with_its_name(tmp_path: Path, cells: tuple[str, ...]) -> None:
    with pytest.raises(LogError, match="stand in one column") as refusal:
        read_table(table(tmp_path, *cells))
    assert "Zeit" in str(refusal.value)


def test_days_with_slashes_are_refused_as_no_number(tmp_path: Path) -> None:
    with pytest.raises(LogError, match="no number"):
        read_table(table(tmp_path, "3/4/2026 12:00:00"))


MAP = """
longreach: map/1
name: lab
joints: {axis: linear}
columns:
  t_s: {source: "Zeit [ms]", unit: UNIT}
  axis.position: {source: pos_mm, unit: mm}
  axis.command_V: {source: u, unit: V}
"""


def test_a_map_that_gives_dates_another_unit_is_refused_and_the_proposed_one_is_right(tmp_path: Path) -> None:
    data = tmp_path / "dated.csv"
    start = datetime(2026, 11, 25, 12, tzinfo=UTC)
    rows = "".join(f"{start + timedelta(milliseconds=10 * k):%Y-%m-%d %H:%M:%S.%f},{0.1 * k:.3f},{k % 7}\n" for k in range(100))
    data.write_text("Zeit [ms],pos_mm,u\n" + rows)
    (tmp_path / "ms.yaml").write_text(MAP.replace("UNIT", "ms"))
    with pytest.raises(ConfigError, match="holds dates or times of day, which are read as seconds"):
        ingest(data, tmp_path / "ms.yaml", tmp_path / "log.mcap")
    (tmp_path / "proposed.yaml").write_text(suggested_map(read_table(data), "lab", "", {"axis": "linear"}))
    ingest(data, tmp_path / "proposed.yaml", tmp_path / "log.mcap")
    read = read_log(tmp_path / "log.mcap").columns
    assert read["t_s"] - read["t_s"][0] == pytest.approx(0.01 * np.arange(100), abs=1e-6)
    assert read["axis.position"] == pytest.approx(1e-4 * np.arange(100))


def test_a_column_of_the_log_that_is_no_time_holds_no_dates(tmp_path: Path) -> None:
    data = tmp_path / "dated.csv"
    data.write_text("t_s,axis.position,axis.command_V\n" + "".join(f"{0.01 * k},12:00:{k:02d},1\n" for k in range(40)))
    with pytest.raises(LogError, match=r"'axis\.position' holds dates or times of day"):
        ingest(data, None, tmp_path / "log.mcap")


def test_scale_and_offset_of_a_time_hold_for_dates_too(tmp_path: Path) -> None:
    data = tmp_path / "dated.csv"
    data.write_text("when,pos_mm,u\n" + "".join(f"12:00:00.{10 * k:03d},{0.1 * k:.3f},{k % 7}\n" for k in range(90)))
    (tmp_path / "map.yaml").write_text(MAP.replace('source: "Zeit [ms]", unit: UNIT', "source: when, scale: 2.0"))
    ingest(data, tmp_path / "map.yaml", tmp_path / "log.mcap")
    read = read_log(tmp_path / "log.mcap").columns
    assert read["t_s"] - read["t_s"][0] == pytest.approx(0.02 * np.arange(90), abs=1e-6)
