"""MATLAB files as tables, against scipy's own writer."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.io

from config.errors import LogError
from recording.files.reader import read_log
from recording.importing.ingest import ingest
from recording.importing.read_table import read_table


def test_a_matlab_file_gives_the_same_log_as_its_table(tmp_path: Path) -> None:
    """Written by scipy's own writer: vectors, a structure of vectors, and what is no signal beside them."""
    t = np.arange(200) / 100
    scipy.io.savemat(tmp_path / "run.mat", {"time": t, "rig": {"x": np.sin(t), "u": np.cos(t)}, "fs": 100.0, "note": "warm oil"})
    the_map = (
        "longreach: map/1\nname: mat\njoints: {axis: linear}\ncolumns:\n  t_s: {source: time}\n"
        "  axis.position: {source: rig.x, unit: mm}\n  axis.command_V: {source: rig.u}\n"
    )
    (tmp_path / "map.yaml").write_text(the_map)
    report = ingest(tmp_path / "run.mat", tmp_path / "map.yaml", tmp_path / "run.mcap")
    assert report.rows == 200
    columns = read_log(tmp_path / "run.mcap").columns
    np.testing.assert_allclose(columns["axis.position"], 1e-3 * np.sin(t), rtol=1e-12)
    np.testing.assert_array_equal(columns["axis.command_V"], np.cos(t))


def test_infinity_in_a_matlab_file_is_refused_with_its_row(tmp_path: Path) -> None:
    scipy.io.savemat(tmp_path / "run.mat", {"t_s": [0.0, 0.1, np.inf], "x": [1.0, 2.0, 3.0]})
    with pytest.raises(LogError, match=r"run.mat:3: column 't_s' is infinite: inf. Correct it, or leave it empty"):
        read_table(tmp_path / "run.mat")


def test_what_is_no_matlab_file_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.mat").write_bytes(b"MATLAB 7.3 MAT-file, Platform: GLNXA64" + b" " * 86 + b"\x00\x02IM" + b"\x00" * 300)
    with pytest.raises(LogError, match=r"format 7.3 \(HDF5\)"):
        read_table(tmp_path / "a.mat")
    (tmp_path / "b.mat").write_bytes(b"x" * 50)
    with pytest.raises(LogError, match="no MATLAB file"):
        read_table(tmp_path / "b.mat")
