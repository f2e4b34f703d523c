"""`longreach.drive()`: a program drives a real daemon, and whatever happens in it the arm comes to rest."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

import longreach
from daemon.server.protocol import Client
from tests.support.daemon.running_daemon import RunningDaemon, until
from tests.support.live.gentle_daemon import gentle_daemon, holding

pytestmark = pytest.mark.clock


@pytest.fixture(scope="module")
def daemon(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningDaemon]:
    with gentle_daemon(tmp_path_factory.mktemp("daemon")) as running:
        yield running


@pytest.fixture
def client(daemon: RunningDaemon) -> Iterator[Client]:
    with holding(daemon) as client:
        yield client


def reached(client: Client, joint: str) -> float:
    return float(client.call("status")["joints"][joint]["target"])


def test_rates_targets_and_the_tip_move_the_arm_and_its_end_is_valid(daemon: RunningDaemon, client: Client) -> None:
    with longreach.drive(socket=daemon.socket, countdown_s=0.0) as stream:
        until(lambda: stream.rate(rotary=0.2) or reached(client, "rotary") > 0.02)
        where = {"rotary": 0.1, "prismatic": 1.0}
        until(lambda: stream.target(**where) or all(abs(reached(client, joint) - there) < 1e-6 for joint, there in where.items()))
        until(lambda: stream.tip(0.0, 0.05) or reached(client, "prismatic") > 1.01)
    assert stream.end()["validity"] == "valid"
    until(lambda: client.call("status")["mode"] == "holding")


def test_an_error_in_the_program_ends_the_run(daemon: RunningDaemon, client: Client) -> None:
    with pytest.raises(ZeroDivisionError), longreach.drive(socket=daemon.socket, countdown_s=0.0) as stream:
        stream.rate(rotary=1 / 0)
    until(lambda: client.call("status")["mode"] == "holding")
    assert client.call("wait", run=stream.run)["validity"] == "valid"


def drive_with_nan(daemon: RunningDaemon) -> None:
    with longreach.drive(socket=daemon.socket, countdown_s=0.0) as stream:
        stream.rate(rotary=float("nan"))
        with pytest.raises(longreach.LongreachError, match=r"the run is over: (a set point was no finite number|set point usable)"):
            until(lambda: stream.rate(rotary=0.1))


def test_the_end_of_the_run_is_an_error_with_its_reason(daemon: RunningDaemon, client: Client) -> None:
    """Also where the program does not look: leaving the block is one then."""
    with pytest.raises(longreach.LongreachError, match="the run is not valid: set point usable"):
        drive_with_nan(daemon)
    until(lambda: client.call("status")["mode"] == "holding")


def test_a_slip_in_a_joint_s_name_is_refused_and_ends_nothing(daemon: RunningDaemon, client: Client) -> None:
    with longreach.drive(socket=daemon.socket, countdown_s=0.0) as stream:
        with pytest.raises(longreach.LongreachError, match=r"no such joint: rotry \(limit: rotary, prismatic\)"):
            stream.rate(rotry=0.1)
        until(lambda: stream.rate(rotary=0.2) or reached(client, "rotary") > 0.02)
    assert stream.end()["validity"] == "valid"


def test_a_rig_that_is_not_armed_is_refused(daemon: RunningDaemon, client: Client) -> None:
    client.call("disarm")
    with pytest.raises(longreach.LongreachError, match="start refused"), longreach.drive(socket=daemon.socket):
        pytest.fail("it began")
