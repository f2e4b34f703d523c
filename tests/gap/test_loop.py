"""The rounds of find and run: what is held out, when it ends, and a pair that no maneuver can resolve."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from benchmarks.gap.look_alike_cases import BENCHES, FORCE_AXIS
from benchmarks.gap.look_alikes import rigs_of, run_case
from config.errors import DaemonError
from config.loading.load import load_rig, rig_from_text
from gap import loop
from gap.loop import LoopCourse, Round, first_designs, resolve
from gap.maneuvers.designs import ManeuverDesign

ASKED = {"name": "staircase", "parameters": {"steps": 3}, "repeats": 1, "sensor": None, "why": "expected t 9", "separates": ["a", "b"]}


def content(verdict: str, confirmed: bool, proposal: dict[str, Any] | None, alike: bool = False) -> dict[str, Any]:
    others = [{"effect": "valve_lag", "where": "axis"}] if alike else []
    item = {"effect": "transport_delay", "where": "axis", "confirmed": confirmed, "look_alikes": others}
    return {"verdict": verdict, "why": "because", "findings": [item], "gap": {"holdout_after": 1.0}, "next_maneuver": proposal}


class Searches:
    """Stands in for `find`: gives prepared contents and notes which logs it was given."""

    def __init__(self, *contents: dict[str, Any]) -> None:
        self.contents, self.given = list(contents), []

    def __call__(self, rig: Any, logs: list[Path], holdouts: list[Path], *_: Any) -> Any:
        self.given.append(([p.name for p in logs], [p.name for p in holdouts]))
        return SimpleNamespace(content=self.contents[len(self.given) - 1])


def course(monkeypatch: pytest.MonkeyPatch, searches: Searches, fault: bool = False) -> tuple[LoopCourse, list[Round]]:
    def run(design: ManeuverDesign, name: str) -> Path:
        if fault:
            raise DaemonError("the run is not valid", value="fault")
        return Path(f"{name}-{design.name}")

    shown: list[Round] = []
    monkeypatch.setattr(loop, "find", searches)
    found = resolve("rig", [Path("a")], [Path("b")], Path("out"), run, lambda line: None, shown.append, 3)
    return found, shown


def test_every_maneuver_is_run_once_to_fit_and_once_to_decide(monkeypatch: pytest.MonkeyPatch) -> None:
    """No log that has decided is ever fitted."""
    open_ = content("ambiguous", False, ASKED, alike=True)
    searches = Searches(open_, open_, content("named", True, None))
    found, shown = course(monkeypatch, searches)
    assert searches.given == [
        (["a"], ["b"]),
        (["a", "round-1-fit-staircase"], ["b", "round-1-decide-1-staircase"]),
        (
            ["a", "round-1-fit-staircase", "round-2-fit-staircase"],
            ["b", "round-1-decide-1-staircase", "round-2-decide-1-staircase"],
        ),
    ]
    assert (found.outcome, [one.number for one in shown]) == ("confirmed", [1, 2, 3])
    assert found.as_dict()["rounds"][0]["look_alikes"] == [["transport_delay at axis", "valve_lag at axis"]]


def test_a_maneuver_decides_as_often_as_is_proposed(monkeypatch: pytest.MonkeyPatch) -> None:
    twice = content("ambiguous", False, ASKED | {"repeats": 2}, alike=True)
    searches = Searches(twice, content("named", True, None))
    course(monkeypatch, searches)
    assert searches.given[1:] == [
        (["a", "round-1-fit-staircase"], ["b", "round-1-decide-1-staircase", "round-1-decide-2-staircase"]),
    ]


def test_a_wave_that_the_rig_stops_is_run_again_with_half_the_power(monkeypatch: pytest.MonkeyPatch) -> None:
    """The rig is another than any model of it. Half the power until it is run; logs of a wave that was stopped are used for nothing."""
    wave = ASKED | {"name": "multisine", "parameters": {"on": "command", "amplitude": "8 V"}, "repeats": 2}
    searches = Searches(content("ambiguous", False, wave, alike=True), content("named", True, None))
    monkeypatch.setattr(loop, "find", searches)
    tried: list[tuple[str, str]] = []

    def run(design: ManeuverDesign, name: str) -> Path:
        tried.append((name, design.parameters["amplitude"]))
        if design.parameters["amplitude"] == "8 V" and name.endswith("decide-1"):
            raise DaemonError("the run is not valid", value="fault")
        return Path(name)

    told: list[str] = []
    found = resolve("rig", [Path("a")], [Path("b")], Path("out"), run, told.append, lambda one: None)
    assert found.outcome == "confirmed"
    assert tried == [
        ("round-1-fit", "8 V"),
        ("round-1-decide-1", "8 V"),
        *((f"round-1-smaller-{use}", "5.66 V") for use in ("fit", "decide-1", "decide-2")),
    ]
    assert searches.given[1] == (["a", "round-1-smaller-fit"], ["b", "round-1-smaller-decide-1", "round-1-smaller-decide-2"])
    assert any("the run is not valid" in line and "Half the power" in line for line in told)


@pytest.mark.parametrize(
    ("last", "outcome"),
    [
        (content("no_gap", True, None), "confirmed"),
        (content("unknown", False, None), "not_separable"),
        (content("ambiguous", False, ASKED | {"repeats": None}, True), "not_separable"),
        (content("ambiguous", False, ASKED | {"sensor": ["axis.pressure_a"]}, True), "needs_sensor"),
    ],
)
def test_how_it_ends_after_one_search(monkeypatch: pytest.MonkeyPatch, last: dict[str, Any], outcome: str) -> None:
    found, shown = course(monkeypatch, Searches(last))
    assert found.outcome == outcome
    assert len(shown) == 1


def test_it_ends_when_the_rounds_are_used_up_or_the_run_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    open_ = content("ambiguous", False, ASKED, alike=True)
    assert course(monkeypatch, Searches(open_, open_, open_))[0].outcome == "rounds_used_up"
    found, _ = course(monkeypatch, Searches(open_), fault=True)
    assert found.outcome == "not_runnable"
    assert "staircase" in found.why


@pytest.mark.parametrize(
    ("name", "expected"), [("ornl_testbed", ("paper_line", "joint_steps")), ("force_axis", ("fast_strokes", "staircase"))]
)
def test_the_first_two_maneuvers_fit_the_rig(name: str, expected: tuple[str, str]) -> None:
    assert tuple(design.name for design in first_designs(load_rig(name).rig)) == expected


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.timeout(1200)
def test_what_slow_triangles_leave_open_is_run_on_the_daemon_and_searched_again(tmp_path: Path) -> None:
    """Through the daemon on the virtual clock. A valve that lags looks like a late command on them: the maneuver that is run tells."""
    row = run_case(FORCE_AXIS, FORCE_AXIS.cases[2], 120, tmp_path)
    assert row["hidden"] == "valve_lag at axis"
    assert row["unresolved_at_first"]
    assert row["in_first"]
    assert row["asked"]
    assert row["outcome"] == "confirmed"
    assert row["resolved"]
    assert len(list((tmp_path / "logs").rglob("*.mcap"))) >= 2 + 2 * len(row["asked"])


@pytest.mark.slow
@pytest.mark.parametrize("case", [0, pytest.param(1, marks=pytest.mark.long)])
def test_only_another_sensor_tells_a_late_command_from_a_late_encoder(tmp_path: Path, case: int) -> None:
    """4 and 8 ms late. With the position alone measured either is the same and about as probable, and no maneuver helps."""
    row = run_case(FORCE_AXIS, FORCE_AXIS.cases[case], 100 + 10 * case, tmp_path)
    assert row["hidden"] == "transport_delay at axis"
    assert row["asked"] == []
    assert row["outcome"] == "needs_sensor"
    assert {frozenset(names) for names in row["sets"]} == {frozenset({"transport_delay at axis", "sensor_delay at sensor:axis.position"})}
    assert "a second position sensor of axis" in row["why"]
    content = json.loads((tmp_path / "round-1" / "findings.json").read_text())
    (found,) = content["findings"]
    (alike,) = found["look_alikes"]
    assert found["probability"] + alike["share"] == pytest.approx(1.0, abs=0.05)
    assert min(found["probability"], alike["share"]) > 0.2


@pytest.mark.parametrize("name", BENCHES)
def test_every_case_of_a_bench_hides_an_effect_that_the_model_lacks(name: str) -> None:
    """An entry may be there once only: one that the rig file has already can only be taken out of the model."""
    bench = BENCHES[name]
    for case in bench.cases:
        text, truth, (effect, where) = rigs_of(bench, case)
        assert (effect, where) in {(entry.effect, entry.where) for entry in truth.rig.plant.effects}
        assert (effect, where) not in {(entry.effect, entry.where) for entry in rig_from_text(text).plant.effects}
