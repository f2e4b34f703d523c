"""Differences between logs of known content; signals picked by pattern, in the rig file's units."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from config.errors import UsageError
from recording.evaluation.chosen_signals import chosen_signals
from recording.evaluation.log_difference import difference
from recording.evaluation.panels import envelope, svg, write_png
from recording.files.reader import Log, read_log
from tests.support.recording import session

RING = {0: 2.8, 2: 2.7, 4: 3.6}


@pytest.fixture(scope="module")
def logs(tmp_path_factory: pytest.TempPathFactory) -> tuple[Log, Log]:
    folder = tmp_path_factory.mktemp("diff")
    session.recorded_run(folder / "a.mcap", ring_mps2=RING)
    session.recorded_run(folder / "b.mcap", shaper="zvd", ring_mps2={index: 0.1 * value for index, value in RING.items()})
    return read_log(folder / "a.mcap"), read_log(folder / "b.mcap")


@pytest.mark.slow
def test_a_log_does_not_differ_from_itself(logs: tuple[Log, Log]) -> None:
    found = difference(logs[0], logs[0])
    assert found.changed == ()
    assert {each.largest for each in found.signals} == {0.0}
    assert found.panels() == []
    assert "the same to the last bit" in found.text()


def test_what_could_not_be_compared_is_listed_and_not_called_the_same(logs: tuple[Log, Log]) -> None:
    """A signal of one log alone, rows that are NaN in B, and cycles that B lost."""
    log, nan_in_b = logs[0], slice(1000, 1007)
    columns = {name: values.copy() for name, values in log.columns.items() if name != "prismatic.velocity"}
    columns["rotary.supply_pressure_Pa"][:] = np.nan
    columns["rotary.position"][nan_in_b] = np.nan
    kept = np.r_[:2000, 2005 : log.cycles]
    other = replace(log, columns={name: values[kept] for name, values in columns.items()}, time_ns=log.time_ns[kept])
    found = difference(log, other)
    assert found.not_compared.only_a == ("rotary.supply_pressure_Pa", "prismatic.velocity")
    assert found.not_compared.rows == {"rotary.position": 7}
    assert found.not_compared.cycles == (0, 5)
    assert {each.largest for each in found.signals} == {0.0}
    assert found.text().splitlines()[-4:] == [
        "  only in A: rotary.supply_pressure_Pa, prismatic.velocity",
        "  not compared: 5 cycles that B lost",
        "  not compared: rotary.position in 7 rows, NaN in one log",
        "  what was compared is the same to the last bit",
    ]
    assert difference(other, log).not_compared.only_b == ("rotary.supply_pressure_Pa", "prismatic.velocity")
    assert found.as_dict()["not_compared"]["rows"] == {"rotary.position": 7}


def test_a_run_that_was_cut_is_not_the_same_as_far_as_it_goes(logs: tuple[Log, Log]) -> None:
    log, kept = logs[0], 3000
    cut = replace(log, columns={name: values[:kept] for name, values in log.columns.items()}, time_ns=log.time_ns[:kept])
    running = np.flatnonzero(log.columns["mode"] == 3)
    found = difference(log, cut)
    assert [(each.about, each.key) for each in found.changed] == [("run", "duration_s"), ("run", "verdict")]
    assert (found.changed[0].a, found.changed[0].b) == pytest.approx(((len(running) - 1) / 1000.0, (kept - 1 - running[0]) / 1000.0))
    assert found.changed[1].text().endswith("verdict: valid → not valid: the log ends before the run does")
    assert found.text().endswith("\n  what was compared is the same to the last bit")
    assert (found.same, difference(cut, cut).same) == (False, True)


def test_logs_without_a_number_in_common_are_not_the_same(logs: tuple[Log, Log]) -> None:
    log = logs[0]
    exact = {name for name, values in log.columns.items() if values.dtype != np.float64 or name == "t_s"}
    empty = {name: values if name in exact else np.full(log.cycles, np.nan) for name, values in log.columns.items()}
    assert (
        difference(log, replace(log, columns=empty))
        .text()
        .endswith("nothing was compared: in no row of a common time do both logs have numbers of a signal")
    )


def test_the_filter_and_the_tip_differ_by_what_was_put_in(logs: tuple[Log, Log]) -> None:
    found = difference(*logs)
    assert [(each.about, each.key, each.a, each.b) for each in found.changed] == [("filter", "kind", "none", "zvd")]
    assert found.vibration["move 1"] == pytest.approx((2.8, 0.28), rel=1e-2)
    tip = next(each for each in found.signals if each.name == "tip.acceleration_mps2")
    (row,) = [line for line in found.text().splitlines() if line.startswith("  tip.acceleration")]
    assert row.split()[:2] == ["tip.acceleration", tip.unit], "not the unit of the column beside another one"
    assert "tip.acceleration" in {panel.title for panel in found.panels()}
    assert tip.share == pytest.approx(0.9, abs=0.02)  # B rings by a tenth of A with the same phase
    assert "rotary.target" in {each.name for each in found.signals if each.largest == 0.0}


def test_runs_are_aligned_on_their_start(logs: tuple[Log, Log], tmp_path: Path) -> None:
    """The same run after half a second of holding more differs by nothing that is a function of the run's time."""
    late = session.Session(tmp_path / "late.mcap", ring_mps2=RING)
    late.position = [0.0, 40 * 0.0254]
    plan = late.plan("paper_line", 1)
    late.cycles(session.Mode.HOLDING, 520)
    late.start(plan)
    late.until(session.Mode.RUNNING, lambda outputs: outputs.finished, plan)
    found = difference(logs[0], read_log(late.close()))
    for name in ("rotary.target", "rotary.reference", "tip.acceleration_mps2"):
        assert next(each for each in found.signals if each.name == name).largest < 1e-6, name


def test_a_run_that_is_not_there_names_those_that_are(logs: tuple[Log, Log]) -> None:
    with pytest.raises(UsageError, match=r"no such run: 7 .limit: 1"):
        difference(*logs, runs=(1, 7))


def test_signals_are_picked_by_glob_and_shown_as_the_rig_file_writes_them(logs: tuple[Log, Log]) -> None:
    log = logs[0]
    chosen = {signal.name: signal for signal in chosen_signals(log, ["*.position", "rotary.supply_*"], (1.0, 2.0))}
    assert set(chosen) == {"rotary.position", "prismatic.position", "rotary.supply_pressure_Pa"}  # no temperature: NaN in this log
    rows = (log.columns["t_s"] >= 1.0) & (log.columns["t_s"] <= 2.0)
    assert chosen["rotary.position"].unit == "deg"
    np.testing.assert_allclose(chosen["rotary.position"].values, np.degrees(log.columns["rotary.position"][rows]))
    np.testing.assert_allclose(chosen["prismatic.position"].values, log.columns["prismatic.position"][rows] / 0.0254)
    np.testing.assert_allclose(chosen["rotary.supply_pressure_Pa"].values, 1.0e6 / 6894.757293168)
    si = chosen_signals(log, ["rotary.position"], si=True)
    np.testing.assert_array_equal(si[0].values, log.columns["rotary.position"])
    assert si[0].unit == "rad"


def test_a_pattern_that_matches_nothing_and_an_empty_span_are_refused(logs: tuple[Log, Log]) -> None:
    with pytest.raises(UsageError, match=r"nearest is 'rotary.position'"):
        chosen_signals(logs[0], ["rotary.positon"])
    with pytest.raises(UsageError, match="no cycle in this span"):
        chosen_signals(logs[0], ["*"], (500.0, 600.0))


def test_pictures_keep_the_extremes_and_names(logs: tuple[Log, Log], tmp_path: Path) -> None:
    t = np.linspace(0.0, 1.0, 20_001)
    spike = np.zeros_like(t)
    spike[12_345] = 7.0
    x, y = envelope(t, spike)
    assert (len(x) <= 1600, float(np.max(y)), float(x[np.argmax(y)])) == (True, 7.0, float(t[12_345]))
    panels = difference(*logs).panels()
    text = svg(panels, 'A & "B"')
    assert text.startswith('<svg role="img" aria-label="A &amp; &quot;B&quot;"')
    assert "tip.acceleration" in text
    write_png(panels, "A and B", tmp_path / "p.png")
    assert [path.name for path in tmp_path.iterdir()] == ["p.png"]
