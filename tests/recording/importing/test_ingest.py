"""Measured tables become logs: exact numbers, right units, and refusals that name the line."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from config.errors import ConfigError, LogError, UsageError
from config.loading.import_map import load_map
from recording.files.check import check_log
from recording.files.reader import read_log
from recording.importing.ingest import ingest, ingest_parts
from recording.importing.read_table import read_table
from recording.importing.suggestion import suggested_map
from tests.support.measured_data import EMPS

MAP = """\
longreach: map/1
name: bench
joints: {boom: rotary}
columns:
  t_s: {source: time, unit: ms}
  boom.position: {source: angle, unit: deg, offset: -90}
  boom.command_V: {source: u, scale: 0.001}
  boom.supply_temperature_C: {source: oil, unit: degF}
constants: {boom.supply_pressure_Pa: 2000 psi, maneuver: 1}
ignored: [comment]
"""
TABLE = "time,angle,u,oil,comment,extra\n0,90,1000,32,1,7\n1,180,-500,212,2,7\n2,0,0,50,3,7\n"


def make(tmp_path: Path, table: str, the_map: str | None = None, name: str = "data.csv") -> tuple[Path, Path | None, Path]:
    data = tmp_path / name
    data.write_text(table)
    map_path = None
    if the_map is not None:
        map_path = tmp_path / "map.yaml"
        map_path.write_text(the_map)
    return data, map_path, tmp_path / "out.mcap"


@pytest.mark.skipif(not EMPS.is_dir(), reason="the measured EMPS data (../shared/data/emps) are not here")
@pytest.mark.parametrize("name", ["emps_estimation.csv", "emps_pulses_test.csv"])
def test_the_measured_emps_files(tmp_path: Path, name: str) -> None:
    report = ingest(EMPS / name, "emps", tmp_path / "a.mcap")
    assert report.rows == 24841
    assert report.rate_Hz == pytest.approx(1000.0)
    assert "force_N" in report.ignored
    assert report.unknown == ()
    log = read_log(tmp_path / "a.mcap")
    with (EMPS / name).open() as file:
        rows = list(csv.DictReader(file))
    for column, source in (("t_s", "t_s"), ("axis.reference", "q_ref_m"), ("axis.position", "q_m"), ("axis.command_V", "u_V")):
        assert np.array_equal(log.columns[column], [float(row[source]) for row in rows])
    assert np.all(np.isnan(log.columns["axis.velocity"]))
    assert 0.2 < np.ptp(log.columns["axis.position"]) < 0.3  # the published stroke, about 0.24 m
    assert np.max(np.abs(log.columns["axis.command_V"])) <= 10.0  # the drive's published limit
    assert log.metadata["recording"]["rig_name"] == "force_axis"
    assert check_log(tmp_path / "a.mcap").good


def test_a_map_renames_converts_and_fills(tmp_path: Path) -> None:
    data, the_map, out = make(tmp_path, TABLE, MAP)
    report = ingest(data, the_map, out)
    log = read_log(out)
    assert log.columns["t_s"] == pytest.approx([0.0, 0.001, 0.002])
    assert log.columns["boom.position"] == pytest.approx([0.0, np.pi / 2, -np.pi / 2])
    assert log.columns["boom.command_V"] == pytest.approx([1.0, -0.5, 0.0])
    assert log.columns["boom.supply_temperature_C"] == pytest.approx([0.0, 100.0, 10.0])
    assert log.columns["boom.supply_pressure_Pa"] == pytest.approx([13_789_514.6] * 3)
    assert list(log.columns["maneuver"]) == [1, 1, 1]
    assert list(log.columns["mode"]) == [3, 3, 3]
    assert report.text().splitlines() == [
        f"{out}: 3 rows, 0.002 s at 1000 Hz, columns t_s, boom.position, boom.command_V, boom.supply_temperature_C, "
        "boom.supply_pressure_Pa, maneuver.",
        "Left out as the map says: comment.",
        "Left out because nothing says what they are: extra.",
    ]
    assert log.attachments["map.yaml"].decode() == MAP
    assert log.metadata["recording"]["kind"] == log.kind == "imported"


def test_contract_names_need_no_map(tmp_path: Path) -> None:
    table = "t_s;rotary.position;rotary.command_V;tip.deflection_m;rotary.comand\n0;1;2;;4\n0.01;1.5;2.5;0.25;4\n"
    data, _, out = make(tmp_path, "# measured by hand\n" + table)
    report = ingest(data, None, out)
    log = read_log(out)
    assert log.layout.joint_names == ("rotary",)
    assert np.array_equal(log.columns["tip.deflection_m"], [np.nan, 0.25], equal_nan=True)
    assert report.unknown == ("rotary.comand: nearest is 'rotary.command_V'",)
    assert report.warnings == ("tip.deflection_m is empty in 1 rows and stays NaN there.",)


@pytest.mark.parametrize(
    ("table", "text"),
    [
        ("", "data.csv: the table is empty. It needs a line of column names and rows of numbers."),
        ("t_s,axis.position\n", "data.csv: the table has column names but no rows."),
        ("0,1\n1,2\n", "data.csv: the table has no line of column names: 0,1."),
        ("t_s,t_s\n0,1\n", "data.csv: column names stand twice: t_s."),
        ("t_s,axis.position\n0,1\n1,x\n", "data.csv:3: column 'axis.position' holds something that is no number: 'x'."),
        ("t_s,axis.position\n0,1\n1,1_000\n", "data.csv:3: column 'axis.position' holds something that is no number: '1_000'."),
        (
            't_s,axis.position\n0,999\n1,"1,234"\n',
            "data.csv:3: a comma stands in a number, in a table with commas between cells: '1,234'. Write a point for decimals and nothing",
        ),
        ("t_s,axis.position\n0,inf\n", "data.csv:2: column 'axis.position' is infinite: inf."),
        ("t_s,axis.position\n0,1\n1\n", "data.csv:3: wrong number of cells: 1 (limit: 2)."),
        ("t_s,axis.position\n0,1\n2,1\n1,1\n", "data.csv:4: time does not increase: 2.0 s, then 1.0 s."),
        ("t_s,axis.position\n0,1\n0,1\n", "data.csv:3: time does not increase: 0.0 s, then 0.0 s."),
        ("t_s,axis.position\n0,1\n1,\n2,nan\n", "data.csv:3: axis.position is missing (empty or NaN) in 2 of 3 rows."),
        ("time,axis.position\n0,1\n", "data.csv: the table has no time. A column t_s (seconds) is needed"),
        ("t_s,q\n0,1\n", "data.csv: no column of the table is a joint's position or command: t_s"),
        ("t_s,axis.position,mode\n0,1,2.5\n", "data.csv:2: mode is no whole number: 2.5 (limit: 0 to 255)."),
    ],
)
def test_unusable_tables(tmp_path: Path, table: str, text: str) -> None:
    data, _, out = make(tmp_path, table)
    with pytest.raises(LogError) as caught:
        ingest(data, None, out)
    assert text in str(caught.value)
    assert caught.value.refusal.next_step
    assert [path.name for path in tmp_path.iterdir()] == ["data.csv"]


@pytest.mark.parametrize(
    ("change", "text"),
    [
        (("source: angle", "source: angel"), "the table lacks columns that the map bench needs: angel: nearest is 'angle'."),
        (
            ("boom.command_V:", "boom.comand:"),
            "map.yaml:7:3: 'boom.comand' is no column of a log of these joints: nearest is 'boom.command_V'",
        ),
        (("unit: deg,", "unit: kg,"), "map.yaml:6:"),
        (("unit: ms", "unti: ms"), "nearest is 'unit'"),
        (("maneuver: 1", "t_s: 1"), "'t_s' is both a column and a constant"),
        (("joints: {boom: rotary}", "joints: {boom: sideways}"), "map.yaml:3:"),
    ],
)
def test_maps_that_do_not_fit(tmp_path: Path, change: tuple[str, str], text: str) -> None:
    data, the_map, out = make(tmp_path, TABLE, MAP.replace(*change))
    with pytest.raises((ConfigError, LogError)) as caught:
        ingest(data, the_map, out)
    assert text in str(caught.value)


def test_a_binary_file_is_no_table(tmp_path: Path) -> None:
    (tmp_path / "data.csv").write_bytes(b"\xff\xfe\x00\x01" * 40)
    with pytest.raises(LogError, match="this is not a text table"):
        ingest(tmp_path / "data.csv", None, tmp_path / "a.mcap")


def test_a_table_with_umlauts_of_windows_is_read_and_said_to_be(tmp_path: Path) -> None:
    text = "Zeit [s];Länge [mm]\n0;12,5\n0,001;13\n0,002;14\n"
    the_map = (
        "longreach: map/1\nname: lab\njoints: {axis: linear}\ncolumns:\n  t_s: {source: 'Zeit [s]'}\n"
        "  axis.position: {source: 'Länge [mm]', unit: mm}\n"
    )
    data, map_path, out = make(tmp_path, text, the_map)
    data.write_bytes(text.encode("cp1252"))
    report = ingest(data, map_path, out)
    assert read_log(out).columns["axis.position"] == pytest.approx([0.0125, 0.013, 0.014])
    assert "Read as cp1252, not UTF-8." in report.warnings


def test_an_unknown_map_names_the_shipped_ones(tmp_path: Path) -> None:
    with pytest.raises(ConfigError, match="emps"):
        load_map("emsp")
    assert load_map("emps").map.rig == "force_axis"


def test_uneven_rows_are_a_warning(tmp_path: Path) -> None:
    data, _, out = make(tmp_path, "t_s,axis.position\n0,1\n0.001,1\n0.003,1\n0.004,1\n")
    report = ingest(data, None, out)
    assert report.warnings == ("The rows are not evenly spaced: 1 to 2 ms. A command is taken to hold until the next row.",)
    assert "warning" in check_log(out).text()


def test_an_existing_log_is_not_written_over(tmp_path: Path) -> None:
    data, _, out = make(tmp_path, "t_s,axis.position\n0,1\n1,1\n")
    out.write_bytes(b"mine")
    with pytest.raises(UsageError, match="the log exists already"):
        ingest(data, None, out)
    assert out.read_bytes() == b"mine"


def rows(*spans: tuple[float, float]) -> str:
    """A table at 100 Hz over these spans of time."""
    times = [t for first, last in spans for t in np.arange(first, last, 0.01)]
    return "t_s,axis.position\n" + "".join(f"{t:.2f},{np.sin(t):.9g}\n" for t in times)


def test_a_long_gap_and_spans_make_several_logs(tmp_path: Path) -> None:
    data, _, out = make(tmp_path, rows((0.0, 3.0), (5.0, 9.0)))
    reports = ingest_parts(data, None, out)
    assert [report.written.name for report in reports] == ["out-1.mcap", "out-2.mcap"]
    assert [(report.rows, round(report.duration_s, 2)) for report in reports] == [(300, 2.99), (400, 3.99)]
    second = read_log(tmp_path / "out-2.mcap").columns
    np.testing.assert_allclose(second["axis.position"], np.sin(second["t_s"]), atol=1e-8)
    assert second["t_s"][0] == pytest.approx(5.0)
    cut = ingest_parts(data, None, tmp_path / "cut.mcap", spans=[(0.5, 1.0), (6.0, np.inf)])
    assert [(report.rows, report.written.name) for report in cut] == [(51, "cut-1.mcap"), (300, "cut-2.mcap")]
    with pytest.raises(LogError, match=r"no rows in this span of time: 3.5 to 4 s \(limit: 0 to 8.99 s\)"):
        ingest_parts(data, None, tmp_path / "none.mcap", spans=[(3.5, 4.0)])


def test_a_row_alone_between_pauses_is_left_out_and_told(tmp_path: Path) -> None:
    data, _, out = make(tmp_path, rows((0.0, 1.0), (3.0, 3.01), (6.0, 7.0)))
    reports = ingest_parts(data, None, out)
    assert [report.rows for report in reports] == [100, 100]
    said = "1 row is left out, alone between pauses of more than 1 s: the first at t_s = 3 s."
    assert [report.warnings for report in reports] == [(said,), (said,)]


def test_what_is_wrong_outside_the_spans_does_not_count(tmp_path: Path) -> None:
    """Empty at first, and a clock that was set back in the end."""
    table = "t_s,axis.position\n" + "".join(f"{k / 100},{'' if k < 60 else k}\n" for k in range(100)) + "0.2,5\n"
    data, _, out = make(tmp_path, table)
    with pytest.raises(LogError, match=r"missing \(empty or NaN\) in 60 of 101 rows.*--from S --to S"):
        ingest(data, None, out)
    (report,) = ingest_parts(data, None, out, spans=[(0.6, 0.9)])
    assert (report.rows, report.warnings) == (31, ())
    assert list(read_log(out).columns["axis.position"]) == list(range(60, 91))


def test_decimal_commas_units_below_the_names_and_separators_at_the_end(tmp_path: Path) -> None:
    """As a laboratory's program writes them; the same numbers as with points."""
    table = "Zeit;Weg;u;;\nms;mm;V;;\n0;12,5;-1,25e1;;\n10;13;0,5;;\n20;,5;1;;\n"
    the_map = (
        "longreach: map/1\nname: lab\njoints: {axis: linear}\ncolumns:\n  t_s: {source: 'Zeit [ms]', unit: ms}\n"
        "  axis.position: {source: 'Weg [mm]', unit: mm}\n  axis.command_V: {source: 'u [V]'}\n"
    )
    data, map_path, out = make(tmp_path, table, the_map)
    report = ingest(data, map_path, out)
    log = read_log(out)
    assert log.columns["t_s"] == pytest.approx([0.0, 0.01, 0.02])
    assert log.columns["axis.position"] == pytest.approx([0.0125, 0.013, 0.0005])
    assert log.columns["axis.command_V"] == pytest.approx([-12.5, 0.5, 1.0])
    assert report.unknown == ("column 4", "column 5")
    assert report.warnings == ("Numbers have decimal commas.",)
    assert 't_s: {source: "Zeit [ms]", unit: ms}' in suggested_map(read_table(data), "lab", "", {"axis": "linear"})


@pytest.mark.parametrize("beside", ["0.5", "1.25e3"])
def test_points_beside_commas_are_refused(tmp_path: Path, beside: str) -> None:
    data, _, out = make(tmp_path, f"t_s;axis.position\n0;1,234\n1;{beside}\n")
    with pytest.raises(LogError, match=f"data.csv:3: decimal points stand beside decimal commas: {beside}"):
        ingest(data, None, out)


def test_a_long_table_is_packed_in_pieces(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("recording.importing.ingest._ROWS_AT_ONCE", 64)
    data, _, out = make(tmp_path, rows((0.0, 3.0)))
    ingest(data, None, out)
    columns = read_log(out).columns
    assert list(columns["cycle"]) == list(range(300))
    np.testing.assert_allclose(columns["axis.position"], np.sin(columns["t_s"]), atol=1e-8)


def test_single_empty_cells_cost_their_rows_and_are_told(tmp_path: Path) -> None:
    data, _, out = make(tmp_path, "t_s,axis.position\n0,1\n0.001,\n0.002,3\n0.003,4\n0.004,5\n")
    report = ingest(data, None, out)
    assert report.rows == 4
    assert report.warnings[0] == "axis.position is empty in 1 rows, which are left out."
    assert list(read_log(out).columns["axis.position"]) == [1.0, 3.0, 4.0, 5.0]


def test_a_column_that_no_verdict_needs_may_be_missing_from_one_table(tmp_path: Path) -> None:
    the_map = MAP.replace("{source: oil, unit: degF}", "{source: oil_temp, unit: degF}")
    data, map_path, out = make(tmp_path, TABLE, the_map)
    report = ingest(data, map_path, out)
    assert report.warnings[0].startswith("boom.supply_temperature_C is missing: the table has no oil_temp")
    assert np.all(np.isnan(read_log(out).columns["boom.supply_temperature_C"]))
