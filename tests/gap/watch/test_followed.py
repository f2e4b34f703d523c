"""One number over many logs, against its limits: alarms, time left, what is unknown. Logs are given; nothing is simulated."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest

from gap.fitting.model import Free
from gap.outcome.file_units import Shown
from gap.watch.dated_logs import DatedLog
from gap.watch.followed import Followed, followed
from gap.watch.limits import NumberLimits
from gap.watch.log_fit import FittedValue, LogFit
from gap.watch.page import HEAD, row
from gap.watch.watched import Watched
from tests.support.gap.worn_axis import moments

NAME = "axis.cross_leakage.conductance"
FREE = Free(("effects", 0, "conductance"), "plant.effects.0.conductance", "m^3/s/Pa", 10.0, 1.0, 6.0, 14.0, True, "D")
NUMBER = Watched(NAME, FREE, Free(FREE.path, FREE.key, FREE.unit, 10.0, 5.0, 0.0, 100.0, True, "D"))
LIMITS = NumberLimits(7.0, 13.0)


def one(truth: np.ndarray, again_sd: float = 0.3, sd: float = 0.4, seed: int = 1) -> Followed:
    draw = np.random.default_rng(seed)
    logs = [DatedLog(Path(f"{k}.mcap"), moment) for k, moment in enumerate(moments(len(truth)))]
    fits = [LogFit(1.0, {NAME: FittedValue(float(value), sd, again_sd)}) for value in truth + again_sd * draw.standard_normal(len(truth))]
    (found,) = followed([NUMBER], {NAME: LIMITS}, list(zip(logs, fits, strict=True)))
    return found


def test_healthy_logs_are_steady_and_raise_no_alarm() -> None:
    found = [one(np.full(24, 10.0), seed=seed) for seed in range(25)]
    assert sum(each.word == "steady" for each in found) >= 24
    assert not any(each.alarm for each in found)
    assert all(each.limit_in_days is None for each in found if each.word == "steady")


def test_a_drift_says_when_the_limit_is_reached() -> None:
    """From 10 by 0.05 a day: 12.3 after 46 days, 14 days before 13."""
    found = one(10.0 + 0.1 * np.arange(24))
    assert found.word == "drifts"
    assert not found.alarm
    assert found.limit_in_days == pytest.approx((13.0 - 12.3) / 0.05, abs=6.0)


def test_every_number_of_a_row_has_its_unit() -> None:
    """Shown in a unit of half the size: a rise of 3 is one of 6."""
    cells = dict(zip(HEAD, row(one(np.repeat([10.0, 13.0], 12)), Shown("lpm/bar", 2.0)), strict=True))
    assert cells["rig file"] == "20 lpm/bar"
    assert cells["limits"] == "14 to 26 lpm/bar"
    assert re.fullmatch(r"-?[\d.]+ ± [\d.]+ lpm/bar", cells["change a week (95 %)"])
    step, width = re.fullmatch(r"([\d.]+) ± ([\d.]+) lpm/bar at 12.mcap .*", cells["steps"]).groups()  # type: ignore[union-attr]
    assert float(step) == pytest.approx(6.0, abs=2.0 * float(width))


def test_beyond_a_limit_is_an_alarm_only_where_it_is_sure() -> None:
    assert one(np.full(12, 14.0)).alarm
    assert one(np.full(12, 5.0)).alarm
    assert not one(np.full(12, 13.3)).alarm, "what may be equally wrong in all logs reaches back over the limit"
    assert one(np.full(12, 13.9), sd=0.31).alarm
    repaired = one(np.where(np.arange(24) < 12, 16.0, 10.0))
    assert (repaired.word, repaired.alarm, repaired.as_dict()["steps"][0]["log"]) == ("steps", False, "12.mcap")


def test_what_many_logs_know_no_better_than_the_rig_file_is_unknown() -> None:
    found = one(np.linspace(5.0, 25.0, 24), again_sd=0.1, sd=4.0)
    assert (found.word, found.course, found.alarm) == ("unknown", None, False)
    assert found.as_dict()["now"] is None


def test_too_few_logs_have_no_course() -> None:
    assert one(np.full(3, 10.0)).word == "3 of 4 logs"
    assert one(np.full(4, 10.0)).word == "steady"


def test_the_interval_now_holds_the_truth_at_the_right_rate() -> None:
    """100 series of ten logs, a common error of each series beside their own: 95 % within binomial error."""
    draw, held = np.random.default_rng(5), 0
    for seed in range(100):
        found = one(np.full(10, 10.0 + 0.5 * draw.standard_normal()), sd=math.hypot(0.3, 0.5), seed=seed)
        assert found.course is not None
        value, width = found.now
        held += abs(value - 10.0) < width
    assert 0.88 < held / 100 <= 1.0
