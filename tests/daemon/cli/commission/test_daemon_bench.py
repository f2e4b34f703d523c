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
from daemon.cli.commission.at_rest import safe_state
from daemon.cli.commission.context import Context
from daemon.cli.commission.identified import identification
from daemon.cli.commission.record import Commissioning, Outcome, hash_of, record_of
from daemon.cli.commission.steps import NAMES, walk
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
    latched, fault = False, ""

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


def test_a_fault_before_a_run_begins_is_told_and_where_it_was_of_lateness_the_run_is_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with LockstepRig(RIG, tmp_path) as rig:
        late = Late(RIG.rig, cast(Client, Connection(LockstepRequests(rig, RIG.text))))
    late.reasons, late.did, said = ["the daemon was fault, not holding"], [], list[str]()
    monkeypatch.setattr(Late, "fault", SILENT)
    assert Context(RIG, late, tmp_path, lambda question: True, said.append).run({}).valid
    assert late.did == ["run", "run"]
    assert SILENT in said[0]
    monkeypatch.setattr(Late, "fault", ASTRAY)
    late.reasons, late.did = ["the daemon was fault, not holding"], []
    assert not Context(RIG, late, tmp_path, lambda question: True, said.append).run({}).valid
    assert late.did == ["run"]


class Silent(bench.DaemonBench):
    """A module whose frames stay away until it is reset; `late`: how many cycles of the loop ended late meanwhile."""

    late: int
    did: list[str]
    latched, fault = False, ""
    heals_after: int

    def act(self, verb: str) -> str:
        self.did.append(verb)
        return "disarmed"

    def cycles(self) -> tuple[int, int]:
        return 1000 * len(self.did), self.late * len(self.did)

    def prove(self) -> dict[str, Any]:
        self.did.append("prove")
        if self.did.count("reset") < self.heals_after:
            raise DaemonError("proof refused: 1 of 4 checks fail: axis.supply_pressure age", value="3.88 s", limit="0.015 s")
        return {"good": True, "results": [], "failures": []}


def _silent(tmp_path: Path, late: int, heals_after: int) -> Silent:
    with LockstepRig(RIG, tmp_path) as rig:
        silent = Silent(RIG.rig, cast(Client, Connection(LockstepRequests(rig, RIG.text))))
    silent.late, silent.did, silent.heals_after = late, [], heals_after
    return silent


def test_a_fault_from_before_is_reset_where_the_walk_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    silent = _silent(tmp_path, 0, heals_after=1)
    monkeypatch.setattr(Silent, "latched", True)
    asked: list[str] = []
    Context(RIG, silent, tmp_path, lambda question: asked.append(question) is None, lambda line: None).prove()
    assert silent.did == ["reset", "prove"]
    assert "latched from before" in asked[0]


def test_a_proof_that_something_late_has_ended_is_made_again_after_a_reset(tmp_path: Path) -> None:
    silent = _silent(tmp_path, 0, heals_after=1)
    assert Context(RIG, silent, tmp_path, lambda question: True, lambda line: None).prove() == {"good": True, "results": [], "failures": []}
    assert silent.did == ["prove", "reset", "prove"]


@pytest.mark.parametrize(("late", "whose"), [(40, "200 of 5000 cycles of the loop ended late"), (0, "The loop itself kept time")])
def test_a_step_that_something_late_has_ended_says_whose_lateness_it_was_and_goes_on_there(tmp_path: Path, late: int, whose: str) -> None:
    silent, said = _silent(tmp_path, late, heals_after=9), list[str]()
    commissioning = Commissioning(tmp_path, RIG.rig.name)
    for done in NAMES[:3]:
        commissioning.keep(record_of(done, Outcome(True, ""), "", "rig", hash_of(RIG.text)))
    context = Context(RIG, silent, tmp_path, lambda question: True, said.append)
    failed = walk(context, commissioning, "safe state", None)
    assert failed is not None
    assert silent.did == ["prove", "reset", "prove", "reset", "prove"]
    assert whose in failed.outcome.text
    assert f"`longreach host --load --rig {RIG.path}`" in failed.outcome.text
    assert f"`longreach commission {RIG.path}` goes on with this step." in failed.outcome.text
    silent.heals_after = 0
    assert walk(context, commissioning, "safe state", None) is None


def test_a_proof_that_a_new_start_of_the_daemon_wants_again_leaves_what_rests_on_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    silent = _silent(tmp_path, 0, heals_after=0)
    monkeypatch.setattr(Silent, "proven", property(lambda bench: "prove" in bench.did))
    commissioning = Commissioning(tmp_path, RIG.rig.name)
    for done in NAMES[:6]:
        commissioning.keep(record_of(done, Outcome(True, ""), "", "rig", hash_of(RIG.text)))
    said: list[str] = []
    assert walk(Context(RIG, silent, tmp_path, lambda question: True, said.append), commissioning, NAMES[5], None) is None
    assert silent.did == ["prove"]
    assert "4. safe state" in said
    assert any(line.startswith(f"6. {NAMES[5]}: passed,") for line in said)


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


def test_a_rig_without_a_proof_is_not_asked_to_switch_its_pressure_off(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    silent = _silent(tmp_path, 0, heals_after=0)
    monkeypatch.setattr(Silent, "proves", False)
    asked: list[str] = []
    outcome = safe_state(Context(RIG, silent, tmp_path, lambda question: asked.append(question) is None, lambda line: None))
    assert (outcome.passed, outcome.text) == (None, "no device of this rig is asked for a proof")
    assert asked == []
    assert silent.did == []
    monkeypatch.setattr(Silent, "proves", True)
    assert safe_state(Context(RIG, silent, tmp_path, lambda question: asked.append(question) is None, lambda line: None)).passed
    assert "pressure must be off" in asked[0]
    assert silent.did == ["prove"]
