"""Identification and shaped moves through a running daemon on the wall clock."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from config.loading.calibration_record import load_record
from daemon.cli.main import main
from tests.support.daemon.running_daemon import RunningDaemon, arm

pytestmark = [pytest.mark.slow, pytest.mark.clock]


@pytest.fixture(scope="module")
def daemon(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningDaemon]:
    with RunningDaemon(tmp_path_factory.mktemp("daemon")) as running, running.wait_until_ready() as client:
        arm(client)
        yield running
        client.call("disarm")


def test_the_payload_of_the_armed_rig(daemon: RunningDaemon, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["identify", "--on-rig", "--what", "payload", "--extensions", "45 in", "--out", str(tmp_path), "--json"]
    assert main(["--socket", str(daemon.socket), *words]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["links"][0]["payload"][0]["payload_kg"] == pytest.approx(45 * 0.45359237, rel=0.03)
    assert load_record(Path(answer["record"])).source == "rig"


def test_a_shaped_run_says_what_it_left(daemon: RunningDaemon, capsys: pytest.CaptureFixture[str]) -> None:
    words = ["start", "joint_steps", "--shaper", "zvd", "--approach", "--countdown", "0", "--wait", "--no-report", "--json"]
    assert main(["--socket", str(daemon.socket), *words]) == 0
    printed = capsys.readouterr()
    assert "the tip reaches" in printed.err
    moves = json.loads(printed.out)["shaped_moves"]
    assert [move["move"] for move in moves] == ["move 1", "move 2", "move 3", "move 4"]
    assert all(0.0 < move["measured_mps2"] < 2.0 and move["ideal_mps2"] < 2.0 and move["coupled_mps2"] < 2.0 for move in moves)
    assert all(0.0 <= move["measured_late_s"] < 1.0 for move in moves)
