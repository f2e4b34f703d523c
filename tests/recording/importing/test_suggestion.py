"""Which signal a column is, by its name; the map that is proposed from it reads as one."""

from __future__ import annotations

from pathlib import Path

import pytest

from config.loading.import_map import load_map
from recording.importing.read_table import read_table
from recording.importing.suggestion import guess, suggested_map

SUGGESTED = [
    ("Time [ms]", "t_s", "ms"),
    ("pos_mm", "axis.position", "mm"),
    ("Valve command (V)", "axis.command_V", "V"),
    ("pA [bar]", "axis.pressure_a_Pa", "bar"),
    ("Pressure B [psi]", "axis.pressure_b_Pa", "psi"),
    ("supply_bar", "axis.supply_pressure_Pa", "bar"),
    ("Tank pressure [bar]", "axis.return_pressure_Pa", "bar"),
    ("comment", "", ""),
]


def written(tmp_path: Path, table: str) -> Path:
    path = tmp_path / "data.csv"
    path.write_text(table)
    return path


def test_a_map_is_proposed_from_column_names_and_reads_as_one(tmp_path: Path) -> None:
    header = ",".join(name for name, _, _ in SUGGESTED)
    data = written(tmp_path, header + "\n" + ",".join("1" for _ in SUGGESTED) + "\n")
    text = suggested_map(read_table(data), "my bench", "", {"axis": "linear"})
    (tmp_path / "map.yaml").write_text(text)
    found = load_map(tmp_path / "map.yaml").map
    assert {entry.source: (name, entry.unit) for name, entry in found.columns.items()} == {
        source: (name, unit) for source, name, unit in SUGGESTED if name
    }
    assert found.ignored == ("comment",)


@pytest.mark.parametrize(
    ("source", "field", "unit"),
    [
        ("vel_mm_s", "axis.velocity", "mm/s"),
        ("speed_m_s", "axis.velocity", "m/s"),
        ("rod speed mm/s", "axis.velocity", "mm/s"),
        ("v_mps", "axis.velocity", "m/s"),
        ("Velocity [mm/s]", "axis.velocity", "mm/s"),
        ("acc_m_s2", "", ""),
        ("delay_s", "", ""),
        ("pressure_rate_bar_s", "", ""),
        ("time_s", "t_s", "s"),
        ("time_in_s", "t_s", "s"),
        ("elapsed_ms", "t_s", "ms"),
        ("X [s]", "t_s", "s"),
    ],
)
def test_a_bare_second_is_the_time_only_of_what_is_called_so(tmp_path: Path, source: str, field: str, unit: str) -> None:
    data = written(tmp_path, f"{source}\n1\n")
    (found,) = guess(read_table(data), {"axis": "linear"})
    assert (found.field, found.unit) == (field, unit), found.why


def test_german_names_are_known(tmp_path: Path) -> None:
    """As a bench with a German data logger writes them."""
    columns = {
        "Zeit [s]": ("t_s", "s"), "Kolbenweg [mm]": ("axis.position", "mm"), "Druck A [bar]": ("axis.pressure_a_Pa", "bar"),
        "Druck B [bar]": ("axis.pressure_b_Pa", "bar"), "Versorgungsdruck [bar]": ("axis.supply_pressure_Pa", "bar"),
        "Rücklaufdruck [bar]": ("axis.return_pressure_Pa", "bar"), "Öltemperatur [°C]": ("axis.supply_temperature_C", "degC"),
        "Ventilspannung [V]": ("axis.command_V", "V"), "Sollweg [mm]": ("axis.reference", "mm"),
    }  # fmt: skip
    data = written(tmp_path, ",".join(columns) + "\n" + ",".join("1" for _ in columns) + "\n")
    (tmp_path / "map.yaml").write_text(suggested_map(read_table(data), "pruefstand", "", {"axis": "linear"}))
    found = load_map(tmp_path / "map.yaml").map.columns
    assert {entry.source: (name, entry.unit) for name, entry in found.items()} == columns


def test_a_proposed_map_says_where_no_column_is_the_time(tmp_path: Path) -> None:
    data = written(tmp_path, "pos_mm,remark\n1,0\n2,1\n")
    text = suggested_map(read_table(data), "bench", "", {"axis": "linear"})
    assert "# t_s: {source: '', unit: s}  # no column's name says that it is the time: name it here" in text
    (tmp_path / "map.yaml").write_text(text)
    assert list(load_map(tmp_path / "map.yaml").map.columns) == ["axis.position"]
