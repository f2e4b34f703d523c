"""What `commission` reads and asks through the daemon, against the daemon's own handlers over a loop in lockstep."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from pathlib import Path
from typing import Any, cast

import pytest

from config.errors import DaemonError
from config.loading.load import LoadedRig, apply_overrides, rig_from_text
from daemon.cli.commission import bench
from daemon.cli.commission.context import Context
from daemon.cli.commission.identified import identification
from daemon.lockstep import LockstepRig
from daemon.server.protocol import Client
from recording.files.reader import read_log
from recording.format.fields import field_of_signal
from tests.support.daemon.lockstep_requests import LockstepRequests
from tests.support.daemon.rigs import RIG


class Connection:
    """A client without a socket. `asked`: what was called with which parameters."""

    def __init__(self, requests: LockstepRequests) -> None:
        self._methods, self.asked = requests.handlers.methods, list[tuple[str, dict[str, Any]]]()

    def call(self, method: str, **params: Any) -> dict[str, Any]:
        self.asked.append((method, params))
        if method == "prove":
            return {"good": True}
        answer = asyncio.run(cast(Any, self._methods[method](params)))
        return {**answer, "safe_state": {"valve": {}}} if method == "status" else cast("dict[str, Any]", answer)


def test_a_signal_without_limits_is_read_too(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bench, "POLL_S", 0.0)
    text = apply_overrides(RIG.text, [f"signals.reservoir_temperature.{limit}=null" for limit in ("low", "high")])
    loaded = LoadedRig(rig_from_text(text), text, "rig.yaml")
    with LockstepRig(loaded, tmp_path) as rig:
        rig.cycles(10)
        read = bench.DaemonBench(loaded.rig, cast(Client, Connection(LockstepRequests(rig, text)))).readings()
        assert set(read) == set(loaded.rig.signals)
        for name, samples in read.items():
            assert len(samples) == bench.SAMPLES
            assert samples[-1] == pytest.approx(rig.value(field_of_signal(name)), nan_ok=True)


class Stopped(bench.DaemonBench):
    """A rig whose every run ends in the same fault."""

    def run(self, request: Mapping[str, Any], stop_after_s: float | None = None) -> bench.Ran:
        return bench.Ran(Path("run.mcap"), 1, False, "fault: rotary.position quality", "fault")


def test_runs_of_the_identification_that_are_not_valid_say_why(tmp_path: Path) -> None:
    with LockstepRig(RIG, tmp_path) as rig:
        stopped = Stopped(RIG.rig, cast(Client, Connection(LockstepRequests(rig, RIG.text))))
        found = identification(Context(RIG, stopped, tmp_path, lambda question: True, lambda line: None, identify="payload"))
    assert found.passed is False
    assert "fault: rotary.position quality" in found.text
    assert found.logs == ["run.mcap"]


class Late(bench.DaemonBench):
    """Its first runs end as `reasons` say; those after them are valid. `did`: what was asked of it."""

    reasons: list[str]
    did: list[str]

    def act(self, verb: str) -> str:
        self.did.append(verb)
        return "disarmed"

    def run(self, request: Mapping[str, Any], stop_after_s: float | None = None) -> bench.Ran:
        self.did.append("run")
        reason = self.reasons.pop(0) if self.reasons else ""
        return bench.Ran(Path("run.mcap"), 1, not reason, reason, "fault" if reason.startswith("fault") else "holding")


STALL = "fault: loop stall (loop): 0.06 s (limit at most 0.05 s). Look for other work on this computer."
SILENT = "fault: rotary.position quality (rotary_encoder): 2 (limit 0 to 1). Check the cable."
MISSED = "40 of 400 periods were missed (limit 5%); see the timing passport for the slowest phase"
ASTRAY = "fault: rotary following error (servo): 6 deg (limit 5 deg)."


@pytest.mark.parametrize(
    ("reasons", "allowed", "did", "valid"),
    [
        ([STALL], True, ["run", "reset", "run"], True),
        ([SILENT, MISSED], True, ["run", "reset", "run", "run"], True),
        ([STALL, STALL, STALL, STALL], True, ["run", "reset", "run", "reset", "run"], False),
        ([STALL], False, ["run"], False),
        ([ASTRAY], True, ["run"], False),
    ],
    ids=["a stall", "a device, then the loop", "every time", "the operator says no", "not late but wrong"],
)
def test_a_run_that_something_late_has_ended_is_made_again(
    tmp_path: Path, reasons: list[str], allowed: bool, did: list[str], valid: bool
) -> None:
    with LockstepRig(RIG, tmp_path) as rig:
        late = Late(RIG.rig, cast(Client, Connection(LockstepRequests(rig, RIG.text))))
    late.reasons, late.did = list(reasons), []
    said: list[str] = []
    ran = Context(RIG, late, tmp_path, lambda question: allowed, said.append).run({})
    assert late.did == did
    assert ran.valid is valid
    assert all(reason in " ".join(said) for reason in reasons if reason != ASTRAY)


class Behind(bench.DaemonBench):
    """A run whose log is still open when the loop has ended it, because the recorder writes behind the loop."""

    cut: Path

    def _armed_run(self, request: Mapping[str, Any], stop_after_s: float | None) -> bench.Ran:
        return bench.Ran(self.cut, 1, True, "", "holding")


@pytest.mark.parametrize("closes", [True, False])
def test_a_run_is_read_when_its_log_is_closed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, closes: bool) -> None:
    with LockstepRig(RIG, tmp_path) as rig:
        rig.arm()
        rig.disarm()
        connection = Connection(LockstepRequests(rig, RIG.text))
        behind = Behind(RIG.rig, cast(Client, connection))
    whole = rig.recorder.finished[-1].read_bytes()
    behind.cut = tmp_path / "cut.mcap"
    behind.cut.write_bytes(whole[: len(whole) // 2])
    monkeypatch.setattr(connection, "call", lambda method: None)
    monkeypatch.setattr(bench, "RESTED_S", 0.2)
    monkeypatch.setattr(bench.time, "sleep", lambda seconds: behind.cut.write_bytes(whole) if closes else None)
    if closes:
        assert read_log(behind.run({}).log).complete
    else:
        with pytest.raises(DaemonError, match=r"cut\.mcap: the log of the run is not closed"):
            behind.run({})


def test_the_operators_word_that_the_pressure_is_off_reaches_the_daemon(tmp_path: Path) -> None:
    """Where nothing measures the pressure, a proof is refused without it."""
    with LockstepRig(RIG, tmp_path) as rig:
        connection = Connection(LockstepRequests(rig, RIG.text))
        assert bench.DaemonBench(RIG.rig, cast(Client, connection)).prove() == {"good": True}
        assert connection.asked[-1] == ("prove", {"pressure_is_off": True})
