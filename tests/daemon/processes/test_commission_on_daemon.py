"""`commission` through the daemon, on the wall clock: the same steps as in lockstep, and the arm is disarmed after each."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from daemon.cli.commission.steps import NAMES
from daemon.cli.main import main
from tests.support.daemon.running_daemon import RunningDaemon, patient_rig

pytestmark = [pytest.mark.slow, pytest.mark.long, pytest.mark.clock]


@pytest.mark.timeout(600)
def test_every_step_on_a_daemon(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    rig = str(patient_rig(tmp_path))
    with RunningDaemon(tmp_path, rig) as daemon, daemon.wait_until_ready() as client:
        words = ["--socket", str(daemon.socket), "commission", rig, "--yes", "--out", str(tmp_path / "out"), "--json"]
        words += ["--identify", "payload", "--effort", "1"]
        status = main(words)
        said = capsys.readouterr()
        answer = json.loads(said.out)
        assert status == 0, said.err
        passed = {name: step["outcome"]["passed"] for name, step in answer["steps"].items()}
        assert passed == {name: None if name == "safe state" else True for name in NAMES}, "no device of this rig is asked for a proof"
        stopped = {value["what"]: value["value"] for value in answer["steps"]["stop in motion"]["outcome"]["values"]}
        assert stopped["mode after the stop"] == "holding"
        assert {step["on"] for step in answer["steps"].values()} == {"rig"}
        assert client.call("status")["mode"] == "disarmed"
        assert main(words) == 0, "nothing is made again"
        assert json.loads(capsys.readouterr().out)["steps"] == answer["steps"]
