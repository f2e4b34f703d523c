"""`import longreach`: the examples of its docstring, on short runs."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
import scipy.io

import longreach
from config.errors import UsageError
from daemon.cli.main import main
from recording.files.export import export
from recording.files.reader import read_log


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("api") / "run.mcap"
    found = longreach.simulate("ornl_testbed", "jog", out=out, shaper="zvd", parameters={"by": "1 deg"})
    assert found.columns["rotary.target"][-1] == pytest.approx(np.radians(1.0), abs=5e-4)
    return out


def test_a_simulated_run_replays_bit_for_bit_and_with_a_change_it_differs(log: Path) -> None:
    assert longreach.replay(log).identical
    changed = longreach.replay(log, {"servo.rotary.gain": "0.3 V/deg"})
    assert {difference.signal for difference in changed.differences if difference.largest > 0} >= {"rotary.command_V"}
    with pytest.raises(UsageError, match="the log exists already"):
        longreach.simulate("ornl_testbed", "jog", out=log)


def test_the_plant_alone_integrates_a_constant_command() -> None:
    run = longreach.run_plant("force_axis", np.full((200, 1), 2.0), 0.001, start=[0.0])
    assert run["axis.position"].shape == (200,)
    # m v' = F - friction: 70.3 N of drive, 20.4 N of Coulomb friction and 3.2 N of offset leave about 0.49 m/s² at first
    assert run["axis.velocity"][100] == pytest.approx(0.47 * 0.1, rel=0.1)


@pytest.mark.slow
def test_design_gives_changes_of_the_rig_file() -> None:
    lines = longreach.design("ornl_testbed", effort=1)
    assert any(line.startswith("servo.rotary.") for line in lines)


def test_importing_it_imports_nothing_heavy() -> None:
    code = "import sys, longreach; print([name for name in ('numpy', 'scipy', 'numba', 'matplotlib', 'pydantic') if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


def test_a_log_for_matlab_reads_back_with_every_bit(log: Path, tmp_path: Path) -> None:
    out = tmp_path / "run.mat"
    assert main(["log", "export", str(log), "-o", str(out), "--columns", "rotary.position", "rotary.command_V"]) == 0
    content, columns = scipy.io.loadmat(out), longreach.load_log(log).columns
    for name in ("t_s", "rotary.position", "rotary.command_V"):
        np.testing.assert_array_equal(content[name.replace(".", "_")][:, 0], columns[name])


def test_a_frame_and_a_parquet_file_read_back(log: Path, tmp_path: Path) -> None:
    pandas, parquet = pytest.importorskip("pandas"), pytest.importorskip("pyarrow.parquet")
    read = longreach.load_log(log)
    assert longreach.frame(read)["rotary.position"].to_numpy() == pytest.approx(read.columns["rotary.position"], nan_ok=True)
    assert main(["log", "export", str(log), "-o", str(tmp_path / "run.parquet")]) == 0
    table = parquet.read_table(tmp_path / "run.parquet").to_pandas()
    assert isinstance(table, pandas.DataFrame)
    np.testing.assert_array_equal(table["rotary.command_V"], read.columns["rotary.command_V"])


def test_an_unknown_kind_of_file_names_those_known(log: Path, tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"\.csv, \.mat, \.parquet"):
        export(read_log(log), tmp_path / "run.xlsx")
