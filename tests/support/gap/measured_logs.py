"""Measured public data as logs, through the shipped import maps; tests are skipped where the data are absent."""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

from gap.find import find
from gap.settings import Settings
from recording.importing.ingest import ingest
from tests.support.measured_data import MEASURED_DATA

Rows = Callable[[dict[str, float]], bool]


def logs(folder: Path, data: str, map_name: str, names: Sequence[str], rows: Rows | None = None) -> list[Path]:
    """One MCAP log a name, in `folder`; with `rows` only the rows of the table for which it is true."""
    made = []
    for name in names:
        source = MEASURED_DATA / data / f"{name}.csv"
        if not source.exists():
            pytest.skip(f"the measured data are not beside the project (../shared/data/{data})")
        table = _cut(source, folder / f"{name}.csv", rows) if rows else source
        ingest(table, map_name, folder / f"{name}.mcap")
        made.append(folder / f"{name}.mcap")
    return made


def _cut(source: Path, target: Path, rows: Rows) -> Path:
    header, *lines = source.read_text().splitlines()
    names = header.split(",")
    kept = [line for line in lines if rows(dict(zip(names, map(float, line.split(",")), strict=True)))]
    target.write_text("\n".join([header, *kept]) + "\n")
    return target


def findings(folder: Path, rig: Path | str, fit: Sequence[Path], holdout: Sequence[Path]) -> dict[str, Any]:
    """findings.json of a search with the default settings, without a proposed maneuver."""
    find(rig, fit, holdout, folder / "out", lambda line: None, Settings(propose=False))
    content: dict[str, Any] = json.loads((folder / "out" / "findings.json").read_text())
    return content


def names(content: dict[str, Any]) -> list[str]:
    return [finding["effect"] for finding in content["findings"]]


def set_of(finding: dict[str, Any]) -> set[str]:
    """A name with its look-alikes."""
    return {finding["effect"]} | {other["effect"] for other in finding["look_alikes"]}
