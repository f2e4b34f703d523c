"""An effect a little larger than the size that a search on logs without it says it would have named is named, or in the set."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from config.loading.load import LoadedRig, rig_from_text
from gap.data.measured import load
from gap.find import search_gap
from gap.settings import Settings
from tests.support.gap import axis_logs

pytestmark = pytest.mark.slow
TEXT = axis_logs.axis_text()
A_LITTLE = 1.3


def search(folder: Path, truth: str) -> dict[str, Any]:
    """Findings with the rig file on logs of `truth`."""
    rig = rig_from_text(truth)
    loaded = LoadedRig(rig_from_text(TEXT), TEXT, "axis.yaml")
    logs = [[load(axis_logs.write(folder / f"{seed}.csv", axis_logs.simulated(rig, seed)), loaded.rig)] for seed in (11, 12)]
    return search_gap(loaded, *logs, lambda line: None, Settings(propose=False)).content


@pytest.fixture(scope="module")
def claims(tmp_path_factory: pytest.TempPathFactory) -> dict[str, dict[str, Any]]:
    content = search(tmp_path_factory.mktemp("nothing"), TEXT)
    assert content["verdict"] == "no_gap"
    return {row["effect"]: row for row in content["not_seen"]}


@pytest.mark.parametrize("effect", ["asymmetric_friction", "gravity", "inertia_error", "sensor_delay", "transport_delay", "valve_deadband"])
def test_it_is_named(effect: str, claims: dict[str, dict[str, Any]], tmp_path: Path) -> None:
    claim = claims[effect]
    size = A_LITTLE * claim["smallest_visible"]
    last = TEXT.rindex("{effect:")
    indent, end = TEXT[TEXT.rindex("\n", 0, last) + 1 : last], TEXT.index("\n", last) + 1
    line = f"{indent}{{effect: {effect}, where: {claim['where']}, {claim['parameter']}: {size:.6g} {claim['unit']}}}\n"
    found = search(tmp_path, TEXT[:end] + line + TEXT[end:])["findings"]
    assert found, f"{effect} of {size:.4g} {claim['unit']}"
    assert effect in {found[0]["effect"], *(item["effect"] for item in found[0]["look_alikes"])}
