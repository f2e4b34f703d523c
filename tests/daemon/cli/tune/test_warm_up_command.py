"""`warm-up` and `oil-table`: what they print, and what they refuse."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from config.loading.load import load_rig, rig_from_text
from config.loading.overrides import apply_overrides
from daemon.cli.main import main
from daemon.cli.shown.rich_console import console
from daemon.cli.tune import warm_up_command
from tuning.experiments.five_hours import FiveHours
from tuning.oil.warm_up_plot import warm_up_plot
from tuning.oil.warm_up_study import EqFour, Lag, WarmUpMoment, WarmUpStudy
from tuning.paper.row import SWEEP_HZ


@pytest.fixture
def study() -> WarmUpStudy:
    t = np.arange(1.0, 601.0)
    ran = FiveHours(t, 3e-4 + 0.0 * t, 22.0 + 0.01 * t, 23.0 + 0.01 * t, 24.0 + 0.01 * t, 24.0 + 0.01 * t, ())
    shares = {name: {"rotary": (level, level), "prismatic": (level, 0.95)} for name, level in (("without", 0.8), ("with", 1.0))}
    lag = {"without": Lag((0.002, 0.0012), (0.003, 0.002)), "with": Lag((0.0002, 0.0001), (0.0004, 0.0002))}
    response = np.full(len(SWEEP_HZ), 0.5 + 0.1j)
    return WarmUpStudy(ran, "paper_line", (WarmUpMoment(600.0, 28.0, 30.0, 1.1, EqFour(39.0, 12.0, 0.9), response, shares, lag),))


def test_the_table_the_numbers_and_the_picture(study: WarmUpStudy, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    console().print(warm_up_command._table(study))
    printed = capsys.readouterr().out
    for text in ("0.17 h", "+10 %", "39.0", "0.80 / 0.80", "1.00 / 0.95", "0.115", "0.10"):
        assert text in printed
    numbers = json.loads(json.dumps(warm_up_command._numbers_of(study)))
    assert len(numbers["five_hours"]["t_s"]) == 10
    assert numbers["moments"][0]["lag"]["with"]["rms"] == [0.0002, 0.0001]
    warm_up_plot(study, tmp_path / "warm-up.png")
    assert (tmp_path / "warm-up.png").read_bytes().startswith(b"\x89PNG")


def test_a_table_is_a_change_of_the_rig_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["oil-table", "--joint", "rotary", "--temperatures", "30, 50", "--json"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert [row["temperature_C"] for row in answer["rows"]] == [30.0, 50.0]
    assert "velocity_factor_back" not in answer["override"]  # a rotary actuator has equal areas
    changed = rig_from_text(apply_overrides(load_rig("ornl_testbed").text, [answer["override"]])).servo["rotary"].oil_compensation
    assert changed is not None
    assert [point.temperature_C for point in changed.points] == [30.0, 50.0]


@pytest.mark.parametrize(
    ("words", "text"),
    [
        (("warm-up", "--moments", "0, 9"), "outside the schedule"),
        (("warm-up", "--start", "300 degC"), "(limit: -20 to 90 degC)"),
        (("oil-table", "--joint", "elbow"), "unknown joint"),
    ],
)
def test_what_cannot_be_is_refused(words: tuple[str, ...], text: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(list(words)) == 1
    assert text in capsys.readouterr().err
