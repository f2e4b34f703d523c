"""CSV logs from 100 Hz to 10 kHz: the true model stands at the noise floor, a missing effect far above it, and the search names it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from config.errors import LogError
from gap.data.measured import load
from gap.data.windows import prepare
from gap.find import find
from gap.fitting.evaluation import evaluate, mean_cost
from gap.fitting.model import Model
from gap.settings import Settings
from tests.support.gap import axis_logs

SIGMA = {"axis.position": float(np.hypot(2e-6, 1e-6 / np.sqrt(12)))}


@pytest.mark.parametrize("rate_Hz", [100, 5000, 10000])
def test_the_gap_is_the_same_at_every_rate(tmp_path: Path, rate_Hz: int) -> None:
    truth, blind = axis_logs.axis_rig(), axis_logs.axis_rig("coulomb_friction")
    path = axis_logs.write(tmp_path / "log.csv", axis_logs.simulated(truth, 4, 5.0, 1 / rate_Hz))
    costs = []
    for rig in (truth, blind):
        experiment = prepare(load(path, rig), rig, SIGMA, 0.2, ["axis.position"])
        costs.append(mean_cost([evaluate(experiment, Model(rig, (), np.empty(0)), None)]))
    assert costs[0] == pytest.approx(1.0, abs=0.25)
    assert costs[1] > 100


def test_faster_logs_are_refused(tmp_path: Path) -> None:
    path = axis_logs.write(tmp_path / "log.csv", axis_logs.simulated(axis_logs.axis_rig(), 4, 0.2, 1 / 20_000))
    with pytest.raises(LogError, match="too fast"):
        load(path, axis_logs.axis_rig())


@pytest.mark.slow
@pytest.mark.parametrize("rate_Hz", [100, 5000])
def test_the_search_names_the_effect_at_every_rate(tmp_path: Path, rate_Hz: int) -> None:
    truth = axis_logs.axis_rig()
    logs = [
        axis_logs.write(tmp_path / f"{name}.csv", axis_logs.simulated(truth, seed, 8.0, 1 / rate_Hz))
        for seed, name in enumerate(("fit", "hold"), 11)
    ]
    model = tmp_path / "axis.yaml"
    model.write_text(axis_logs.axis_text("coulomb_friction"))
    content = find(model, logs[:1], logs[1:], tmp_path / "out", lambda line: None, Settings(propose=False)).content
    assert content["verdict"] in ("named", "ambiguous")
    assert (content["findings"][0]["effect"], content["findings"][0]["where"]) == ("coulomb_friction", "axis")
    assert content["findings"][0]["parameters"]["friction"]["value"] == pytest.approx(20.39, rel=0.05)
    assert content["gap"]["holdout_after"] <= 1.3


@pytest.mark.slow
def test_logs_of_different_rates_are_searched_together(tmp_path: Path) -> None:
    """Two fit logs and two hold-outs, no two at one rate; the report is written."""
    truth = axis_logs.axis_rig()
    rates = {"fit_1": 1000, "fit_2": 250, "hold_1": 2000, "hold_2": 400}
    logs = [
        axis_logs.write(tmp_path / f"{name}.csv", axis_logs.simulated(truth, seed, 8.0, 1 / rate_Hz))
        for seed, (name, rate_Hz) in enumerate(rates.items(), 21)
    ]
    model = tmp_path / "axis.yaml"
    model.write_text(axis_logs.axis_text("coulomb_friction"))
    content = find(model, logs[:2], logs[2:], tmp_path / "out", lambda line: None, Settings(propose=False)).content
    assert [(f["effect"], f["where"]) for f in content["findings"]] == [("coulomb_friction", "axis")]
    assert content["findings"][0]["parameters"]["friction"]["value"] == pytest.approx(20.39, rel=0.05)
    assert (tmp_path / "out" / "report.html").exists()
