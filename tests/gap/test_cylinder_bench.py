"""A laboratory's CSV files of a cylinder that is no simulation of ours, from data sheet to friction: import, rig file, search.

Each variant has a flaw that real files have: rests on the stop, short steps in a file each, a pause in the recording, columns that differ
from file to file, a transducer that is noise about zero.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

from benchmarks.gap.cylinder_bench import COULOMB_N, STROKE_M, VISCOUS_N_S_PER_M, logs, write_table
from config.loading.load import load_rig
from daemon.cli.main import main
from gap.data.channel_check import comparable
from gap.data.data_check import check
from gap.data.log_parts import load_parts
from gap.find import find
from gap.fitting.nuisance import nuisances
from gap.outcome.file_units import FileUnits
from gap.report.headline import zero_lines
from gap.settings import Settings
from recording.importing.read_table import read_table
from recording.importing.suggestion import suggested_map

DATA_SHEET = [
    "--kind", "cylinder", "--bore", "16 mm", "--rod", "10 mm", "--stroke", "200 mm", "--mass", "5 kg", "--rated-flow", "10 l/min",
    "--supply", "70 bar", "--resolution", "5 um", "--noise", "5 um", "--chamber-pressures",
]  # fmt: skip
FRICTION = ("effect: coulomb_friction,", "effect: stiction,", "effect: viscous_friction,")
SHORT = [f"short_steps_{number}" for number in range(1, 9)]
RETURN = "axis.return_pressure"
RETURN_NOISE_BAR = 0.7
Columns = dict[str, Any]
pytestmark = pytest.mark.timeout(1200)  # of the wall clock, on a machine with much else to do


@pytest.fixture(scope="module")
def tables() -> dict[str, Columns]:
    """The laboratory's files, and copies of them with further flaws."""
    found = logs()
    noise = np.random.default_rng(7)
    for name in SHORT[::2]:
        found[f"{name}_b"] = {column: values for column, values in found[name].items() if column != "pA_bar"}
    for name in SHORT[1::2]:
        found[f"{name}_a"] = {column: values for column, values in found[name].items() if column != "pB_bar"}
    for name in ("free_steps", "sine"):
        rows = len(found[name]["time_s"])
        found[f"{name}_noisy"] = found[name] | {"pt_bar": RETURN_NOISE_BAR * noise.standard_normal(rows)}
    return found


@pytest.fixture(scope="module")
def bench(tmp_path_factory: pytest.TempPathFactory, tables: dict[str, Columns]) -> Path:
    """Imported logs, and a rig file that knows nothing of friction."""
    folder = tmp_path_factory.mktemp("cylinder")
    (folder / "data").mkdir()
    for name, columns in tables.items():
        write_table(folder / "data" / f"{name}.csv", columns)
    assert main(["new-rig", "bench", *DATA_SHEET, "-o", str(folder / "bench")]) == 0
    text = load_rig(folder / "bench" / "bench.yaml").text
    text = "".join(line for line in text.splitlines(keepends=True) if not any(name in line for name in FRICTION))
    (folder / "rig.yaml").write_text(text)
    (folder / "noisy.yaml").write_text(with_return_transducer(text))
    for table in sorted((folder / "data").glob("*.csv")):
        noisy = table.stem.endswith("_noisy")
        map_yaml = folder / f"map{'_noisy' if noisy else ''}.yaml"
        if not map_yaml.exists():
            like = folder / "data" / ("free_steps_noisy.csv" if noisy else "steps.csv")
            map_yaml.write_text(suggested_map(read_table(like), "bench", "bench", {"axis": "linear"}))
        assert main(["import", str(table), "--map", str(map_yaml), "-o", str(folder / f"{table.stem}.mcap")]) == 0
    return folder


def with_return_transducer(text: str) -> str:
    """The rig file with a transducer of 0 to 200 bar in the return line, and 0 bar there, as its maker gives them."""
    sensor = f"    {RETURN}: {{resolution: 0.05 bar, noise: {RETURN_NOISE_BAR} bar, low: 0 bar, high: 200 bar}}  # [DS]\n"
    text = text.replace("  sensors:\n", f"  sensors:\n{sensor}").replace(
        "return_pressure: 2 bar            # [A]", "return_pressure: 0 bar  # [A]"
    )
    assert RETURN in text
    assert "return_pressure: 0 bar" in text
    return text


def searched(bench: Path, out: Path, fit: list[str], holdout: str, rig: str = "rig.yaml") -> tuple[dict[str, Any], list[str]]:
    lines: list[str] = []
    paths = [bench / f"{name}.mcap" for name in fit]
    found = find(bench / rig, paths, [bench / f"{holdout}.mcap"], out, lines.append, Settings(propose=False))
    the_table_says_what_the_file_has(out / "rig.yaml", found.content)
    return found.content, lines


def the_table_says_what_the_file_has(rig_yaml: Path, content: dict[str, Any]) -> None:
    """They once had bulk moduli of 1.04 and 0.28 GPa."""
    written = {
        free.key: free.start for free in nuisances(load_rig(rig_yaml), frozenset(("axis.position", "axis.pressure_a", "axis.pressure_b")))
    }
    told = {key: item["value"] for key, item in content["parameters"].items() if key in written}
    assert "plant.oil.bulk_modulus" in told
    assert told == pytest.approx({key: written[key] for key in told}, rel=1e-4)


def friction_is_right(content: dict[str, Any], besides: frozenset[str] = frozenset()) -> None:
    friction = {item["effect"]: item["parameters"] for item in content["findings"] if item["where"] == "axis"}
    assert {item["where"] for item in content["findings"]} - {"axis"} <= besides
    assert set(friction) == {"coulomb_friction", "viscous_friction"}
    assert friction["coulomb_friction"]["friction"]["value"] == pytest.approx(COULOMB_N, rel=0.05)
    assert friction["viscous_friction"]["coefficient"]["value"] == pytest.approx(VISCOUS_N_S_PER_M, rel=0.3)
    assert content["gap"]["holdout_after"] < 1.2 < 100 < content["gap"]["holdout_before"]


@pytest.mark.slow
def test_the_files_have_the_flaws_that_they_are_named_for(tables: dict[str, Columns]) -> None:
    """Rests on the stop in the steps and none in the free ones; one pressure or the other; a reading that is often below 0."""
    assert (tables["steps"]["stroke_mm"] > 1e3 * STROKE_M - 0.01).sum() > 500
    free = tables["free_steps"]["stroke_mm"]
    assert 5.0 < free.min() < free.max() < 1e3 * STROKE_M - 5.0
    assert "pA_bar" not in tables[f"{SHORT[0]}_b"]
    assert "pB_bar" not in tables[f"{SHORT[1]}_a"]
    assert 0.4 < (tables["sine_noisy"]["pt_bar"] < 0.0).mean() < 0.6
    assert np.diff(tables["gaps"]["time_s"]).max() > 2.9


@pytest.mark.slow
@pytest.mark.parametrize(
    "fit",
    [
        pytest.param(["steps"], id="rests at the stop", marks=pytest.mark.long),
        pytest.param(["free_steps"], id="no rests", marks=pytest.mark.long),
        pytest.param(SHORT, id="short steps", marks=pytest.mark.long),
        pytest.param(["gaps-1", "gaps-2"], id="gap"),
    ],
)
def test_its_friction_is_named_within_five_per_cent(bench: Path, tmp_path: Path, fit: list[str]) -> None:
    """The hold-out lacks a chamber pressure that the fit logs have."""
    content, lines = searched(bench, tmp_path, fit, "sine")
    friction_is_right(content)
    assert any(line.startswith("sine.mcap: compared") and line.endswith("without axis.pressure_a") for line in lines)


# Four files have chamber A's pressure alone, four chamber B's.
MIXED = [f"{name}_{'ba'[number % 2]}" for number, name in enumerate(SHORT)]


@pytest.fixture(scope="module")
def by_short_steps(bench: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[dict[str, Any], list[str]]:
    return searched(bench, tmp_path_factory.mktemp("mixed"), MIXED, "sine")


@pytest.mark.slow
def test_with_columns_that_differ_from_file_to_file(bench: Path, by_short_steps: tuple[dict[str, Any], list[str]], tmp_path: Path) -> None:
    content, lines = by_short_steps
    (coulomb,) = (item for item in content["findings"] + content["leads"] if item["effect"] == "coulomb_friction")
    assert coulomb["probability"] > 0.99
    assert coulomb["parameters"]["friction"]["value"] == pytest.approx(COULOMB_N, rel=0.05)
    assert {item["effect"] for item in content["findings"] + content["leads"]} <= {"coulomb_friction", "viscous_friction"}
    told = [line for line in lines if ": compared" in line]
    assert sum(line.endswith("without axis.pressure_a") for line in told) == 5  # the hold-out too
    assert sum(line.endswith("without axis.pressure_b") for line in told) == 4
    friction_is_right(searched(bench, tmp_path, [*MIXED, "sine"], "free_steps")[0])


@pytest.mark.slow
def test_short_steps_name_the_viscous_friction_that_the_sines_show(by_short_steps: tuple[dict[str, Any], list[str]]) -> None:
    friction_is_right(by_short_steps[0])


@pytest.mark.slow
def test_a_transducer_that_is_noise_about_zero_keeps_no_log_from_the_search(bench: Path) -> None:
    """Half of its readings lie below its range, by less than 2 % of it: it is not compared there, and the log is not refused."""
    rig = load_rig(bench / "noisy.yaml").rig
    (log,) = load_parts([bench / "sine_noisy.mcap"], rig)
    told = [problem for problem in check([log], rig) if problem.channel == RETURN]
    assert told
    assert not any(problem.fatal for problem in check([log], rig))
    assert set(log.channels) - set(comparable(log, rig).channels) <= {RETURN}
    assert any(RETURN in problem.text() for problem in told)


@pytest.mark.slow
@pytest.mark.long
def test_with_a_return_line_whose_pressure_is_denied(bench: Path, tmp_path: Path) -> None:
    """It is at 2 bar; rig file and transducer say 0. Sets of effects are judged as a whole: friction and the return line's 2 bar."""
    content, _ = searched(bench, tmp_path, ["free_steps_noisy"], "sine_noisy", "noisy.yaml")
    friction_is_right(content, frozenset({"supply"}))
    (back,) = (item for item in content["findings"] if item["where"] == "supply")
    assert back["effect"] == "return_back_pressure"
    assert back["parameters"]["pressure"]["value"] == pytest.approx(2e5, rel=0.1)
    (told,) = (item for item in content["held"] if item["constant"] == "plant.supply.return_pressure")
    assert told["beside"] == "return_back_pressure at supply"
    assert told["wanted"]["value"] == back["parameters"]["pressure"]["value"]
    text = (bench / "noisy.yaml").read_text()
    assert "return_pressure: 0 bar" in text.splitlines()[told["line"] - 1]
    (line,) = zero_lines(content, FileUnits(text))
    assert "is 0 in the rig file" in line
    assert " bar " in line
