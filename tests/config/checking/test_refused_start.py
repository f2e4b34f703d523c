"""An error that the rig file alone decides keeps the daemon from starting, with the words of `check`; what the day decides does not."""

from __future__ import annotations

import datetime
from pathlib import Path

import pytest

from config.checking.check import check_rig, refuse_unusable
from config.errors import ConfigError
from config.loading.load import LoadedRig, load_rig, rig_from_text
from daemon.lockstep import run_lockstep
from daemon.processes import supervisor
from tests.support.config.bench_rigs import DEVICES, PLANT, replaced

TODAY = datetime.date(2026, 1, 1)

# the rig, what stands in its file, what is written instead, what is said of it
WRONG = [
    (
        PLANT,
        "travel: [0.02 m, 0.18 m]",
        "travel: [0.02 m, 0.205 m]",
        "axis.travel 0.02 to 0.205 m reaches beyond the stops of the simulated joint",
    ),
    (PLANT, "low: -5 mm, high: 210 mm", "low: 50 mm, high: 210 mm", "axis.position: low = 0.05 m lies inside the travel"),
    (PLANT, "low: -5 mm, high: 210 mm", "low: -5 mm, high: 90 mm", "axis.position: high = 0.09 m lies inside the travel"),
    (PLANT, "axis.pressure_a, calibration: {scale: 5 kPa}", "axis.pressure_a, calibration: {scale: 6 kPa}", "is not the simulated count"),
    (PLANT, "high: 210 mm}", "high: 210 mm, max_age: 0.5 ms}", "axis.position: max_age 0.0005 s is less than one period of the loop"),
    (
        DEVICES,
        "scale: 1 degC}, max_age: 2 s",
        "scale: 1 degC}, max_age: 0.1 ms",
        "reservoir_temperature: max_age 0.0001 s is less than one",
    ),
    (
        DEVICES,
        "canopen_valve_408\n    timeout: 60 ms",
        "canopen_valve_408\n    timeout: 2 ms",
        "valve.timeout is 2 ms; 3 heartbeats of ours",
    ),
    (DEVICES, "rate: 1 kHz", "rate: 2 kHz", "bench0: 5 frames/cycle at 2000 Hz = "),
]


def loaded(text: str) -> LoadedRig:
    return LoadedRig(rig_from_text(text, "bench.yaml"), text, "bench.yaml")


@pytest.mark.parametrize(("right", "old", "new", "message"), WRONG)
def test_the_daemon_says_what_check_says_and_does_not_start(
    right: str, old: str, new: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("bench.yaml").write_text(replaced(right, old, new))
    (told,) = [finding.text for finding in check_rig(load_rig("bench.yaml"), TODAY) if finding.level == "error"]
    assert told.startswith("bench.yaml:")
    assert message in told
    assert supervisor.main(["bench.yaml", "--runtime-dir", "run", "--log-dir", "logs"]) == 1
    said = capsys.readouterr().err
    assert said.startswith(f"longreachd: {told}\nnext: longreach")
    assert said.count("\n") == 2
    assert [path.name for path in tmp_path.iterdir()] == ["bench.yaml"]


def test_all_of_them_at_once_and_in_the_order_of_the_file(tmp_path: Path) -> None:
    text = PLANT
    for _, old, new, _ in (WRONG[0], WRONG[1], WRONG[3]):
        text = replaced(text, old, new)
    text = replaced(text, "channel: axis.command", "channel: axis.comand")
    with pytest.raises(ConfigError) as refusal:
        run_lockstep(loaded(text), [], tmp_path)
    told = [problem.text() for problem in refusal.value.problems]
    assert sorted(told) == sorted(finding.text for finding in check_rig(loaded(text), TODAY) if finding.level == "error")
    words = ("axis.travel", "axis.position: low", "simulated count", "axis.comand")
    assert [word for each in told for word in words if word in each] == list(words)


def test_a_calibration_that_has_run_out_is_an_error_of_today_and_the_rig_starts(tmp_path: Path) -> None:
    """It can't be armed, and it takes a daemon that runs to say so: tests/daemon/checks/test_calibrations.py."""
    text = replaced(PLANT, "{scale: 5 um}", "{scale: 5 um, valid_until: 1999-12-31, on_expiry: block}")
    (error,) = [finding.text for finding in check_rig(loaded(text), TODAY) if finding.level == "error"]
    assert "the calibration was valid until 1999-12-31" in error
    assert run_lockstep(loaded(text), [], tmp_path) == []


@pytest.mark.parametrize("text", [PLANT, DEVICES])
def test_what_is_right_may_start(text: str) -> None:
    refuse_unusable(loaded(text))
