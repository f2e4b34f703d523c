"""What the loop does when things go wrong, on the virtual clock with a device that can be made to fail."""

from __future__ import annotations

from math import inf, nan
from pathlib import Path

import numpy as np
import pytest
from rigs import JOG, MS, names_of, simple_rig, texts_of

from config.errors import DaemonError
from control.signals import Mode
from daemon.command import Command
from daemon.lockstep import LockstepRig
from daemon.modes import Event
from daemon.run_watch import Verdict
from recording.reader import read_log
from recording.replay import reexecute


def delay_once(rig: LockstepRig, delay_ns: int) -> None:
    rig.clock.wait_until(rig.clock.now_ns() + delay_ns)


def test_starts_disarmed_with_the_e_stop_latched(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.cycles(5)
        assert rig.mode is Mode.DISARMED
        rig.post(Event.ARM)
        rig.cycles(5)
        assert rig.mode is Mode.DISARMED
        assert "activate" not in device.verbs
        rig.post(Event.RESET)
        rig.post(Event.ARM)
        rig.cycles(5)
        assert rig.mode is Mode.ARMING
        assert device.verbs[-1] == "activate"


def test_nothing_is_written_before_arming_and_zero_while_arming(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.cycles(20)
        assert device.written is None
        rig.post(Event.RESET)
        rig.post(Event.ARM)
        rig.until(lambda: rig.mode is Mode.ARMING)
        for _ in range(100):
            rig.cycles(1)
            assert rig.mode is Mode.ARMING
            assert device.written == [0.0, 0.0]


@pytest.mark.parametrize("signal", ["rotary.position", "prismatic.position", "rotary.supply_pressure", "tip.acceleration"])
def test_nan_in_a_required_sensor_is_a_fault_with_safe_outputs_in_that_cycle(tmp_path: Path, signal: str) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(300)
        assert rig.mode is Mode.RUNNING
        device.override[signal] = nan
        rig.cycles(1)
        assert rig.mode is Mode.FAULT
        assert device.written is None
        assert device.verbs[-1] == "safe"
        assert signal in texts_of(rig, "fault")[0]
        assert rig.loop.keeper.run.verdict is Verdict.INVALID
        device.override.clear()
        rig.cycles(50)
        assert rig.mode is Mode.FAULT, "latched although the sensor is back"
        rig.post(Event.RESET)
        rig.cycles(3)
        assert rig.mode is Mode.DISARMED


def test_nan_in_a_sensor_that_is_not_required_changes_nothing(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        device.override["tip.deflection"] = nan
        rig.cycles(10)
        assert rig.mode is Mode.HOLDING


@pytest.mark.parametrize(
    ("signal", "value", "check", "after"),
    [
        ("rotary.supply_pressure", 9e6, "rotary.supply_pressure limit", Mode.HOLDING),
        ("prismatic.supply_pressure", 5e6, "prismatic.supply_pressure lost", Mode.FAULT),
        ("rotary.supply_pressure", 17e6, "rotary.supply_pressure limit", Mode.HOLDING),
        ("prismatic.return_pressure", 2e6, "prismatic.return_pressure limit", Mode.HOLDING),
        ("reservoir_temperature", 66.0, "reservoir_temperature limit", Mode.HOLDING),
        ("reservoir_temperature", 9.0, "reservoir_temperature limit", Mode.HOLDING),
        ("tip.acceleration", -45.0, "tip.acceleration limit", Mode.HOLDING),
        ("rotary.supply_pressure", -1e6, "rotary.supply_pressure range", Mode.FAULT),
        ("rotary.position", 0.3, "rotary position rate", Mode.FAULT),
        ("reservoir_temperature", 200.0, "reservoir_temperature range", Mode.FAULT),
    ],
)
def test_interlocks_stop_or_fault_and_say_which(tmp_path: Path, signal: str, value: float, check: str, after: Mode) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(400)
        device.override[signal] = value
        rig.until(lambda: rig.mode not in (Mode.RUNNING, Mode.STOPPING), 3.0)
        assert rig.mode is after
        run = rig.loop.keeper.run
        assert run.verdict is Verdict.INVALID
        assert check in run.reason
        assert "limit" in run.reason
        rig.cycles(3)
        assert rig.loop.keeper.checks


def test_a_stale_sensor_is_a_fault_although_its_last_value_was_fine(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        device.age_ns["prismatic.position"] = 5 * MS
        rig.cycles(2)
        assert rig.mode is Mode.HOLDING, "as old as allowed"
        device.age_ns["prismatic.position"] = 5 * MS + 1000
        rig.cycles(1)
        assert rig.mode is Mode.FAULT
        assert "prismatic.position age" in rig.loop.keeper.why_fault


@pytest.mark.parametrize("verb", ["read", "write"])
def test_a_device_that_raises_is_a_fault_and_not_the_end(tmp_path: Path, verb: str) -> None:
    def cable_off() -> None:
        raise OSError("cable off")

    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        setattr(device, f"on_{verb}", cable_off)
        rig.cycles(2)
        assert rig.mode is Mode.FAULT
        assert device.written is None
        assert "cable off" in rig.loop.keeper.why_fault
        setattr(device, f"on_{verb}", lambda: None)
        rig.post(Event.RESET)
        rig.cycles(3)
        assert rig.mode is Mode.DISARMED
        rig.arm()
        assert rig.mode is Mode.HOLDING


def test_a_device_that_stays_dead_is_told_once_and_not_a_thousand_times_a_second(tmp_path: Path) -> None:
    def cable_off() -> None:
        raise OSError("cable off")

    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        device.on_read = device.on_safe = cable_off
        rig.cycles(1000)
        assert rig.mode is Mode.FAULT
        assert len(texts_of(rig, "fault")) == 1
        assert len(texts_of(rig, "device")) == 1
        device.on_read = device.on_safe = lambda: None
        rig.post(Event.RESET)
        rig.cycles(3)
        assert rig.mode is Mode.DISARMED


def test_an_exception_in_the_loop_itself_leaves_safe_outputs_and_a_closed_log(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.cycles(10)

        def broken() -> None:
            raise RuntimeError("a mistake of ours")

        monkeypatch.setattr(rig.loop, "_compute", broken)
        with pytest.raises(RuntimeError):
            rig.loop.run()
        assert device.written is None
        assert device.verbs[-1] == "close"
        assert read_log(rig.recorder.finished[-1]).metadata["closing"]["ended_by"] == "the loop ended"
        monkeypatch.undo()


def test_e_stop_while_running_is_safe_in_the_next_cycle_and_latched(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(300)
        rig.post(Event.ESTOP)
        rig.cycles(2)
        assert rig.mode is Mode.FAULT
        assert device.written is None
        with pytest.raises(DaemonError):
            rig.until(lambda: rig.mode is not Mode.FAULT, 0.5)


def test_stop_decelerates_and_holds_and_the_run_is_invalid(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(500)
        rig.post(Event.STOP)
        rig.cycles(2)
        assert rig.mode is Mode.STOPPING
        rig.until(lambda: rig.mode is Mode.HOLDING, 2.0)
        assert device.written is not None
        assert rig.loop.keeper.run.reason == "stop was asked for"
        before = rig.value("rotary.reference")
        rig.cycles(200)
        assert rig.value("rotary.reference") == before


def test_disarm_while_running_is_safe_at_once(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(300)
        rig.disarm()
        assert rig.mode is Mode.DISARMED
        assert device.written is None


def test_leaving_stops_the_run_disarms_and_ends(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(500)
        rig.commands.post(Command(leave=True))
        rig.until(lambda: rig.loop.left, 3.0)
        assert rig.mode is Mode.DISARMED
        modes = read_log(rig.recorder.finished[-1]).columns["mode"]
        assert {int(mode) for mode in modes[-100:]} >= {int(Mode.STOPPING), int(Mode.DISARMED)} or Mode.STOPPING in modes
        assert device.written is None
        assert rig.loop.keeper.run.reason == "the daemon ends"


def test_leaving_twice_is_safe_at_once(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(500)
        rig.commands.post(Command(leave=True))
        rig.commands.post(Command(Event.DISARM, leave=True))
        rig.cycles(3)
        assert rig.mode is Mode.DISARMED
        assert rig.loop.left
        assert device.written is None


def test_motion_is_announced_every_second_and_a_stop_takes_it_back(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, _):
        rig.arm()
        rig.start({**JOG, "countdown_s": 3.0})
        rig.cycles(2500)
        assert rig.mode is Mode.HOLDING
        assert texts_of(rig, "countdown") == [f"run 1: motion of rotary starts in {left} s" for left in (3, 2, 1)]
        rig.post(Event.STOP)
        rig.cycles(1000)
        assert rig.mode is Mode.HOLDING
        assert "run_started" not in names_of(rig)
        assert texts_of(rig, "run_ended") == ["run 1: invalid, because stop was asked for before it began"]


def test_a_run_is_not_started_while_a_stop_condition_holds(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start({**JOG, "countdown_s": 1.0})
        rig.cycles(500)
        device.override["reservoir_temperature"] = 66.0
        rig.cycles(700)
        assert rig.mode is Mode.HOLDING
        assert "reservoir_temperature limit" in texts_of(rig, "run_ended")[0]


def test_a_fault_during_the_countdown_ends_the_run(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start({**JOG, "countdown_s": 1.0})
        rig.cycles(100)
        device.override["rotary.position"] = nan
        rig.cycles(2)
        assert rig.loop.keeper.run.verdict is Verdict.INVALID
        assert "rotary.position quality" in rig.loop.keeper.run.reason


def test_overrun_of_5_ms_is_counted_with_its_culprit_and_does_not_spoil_the_run(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(100)
        device.on_write = lambda: delay_once(rig, 5 * MS)
        rig.cycles(1)
        device.on_write = lambda: None
        rig.until(lambda: not rig.loop.keeper.run.active, 3.0)
        assert rig.loop.keeper.run.verdict is Verdict.VALID
        assert rig.value("overruns") == 1
        assert "slowest: write" in texts_of(rig, "overrun")[0]
        rig.disarm()
        log = read_log(rig.recorder.finished[-1])
        assert np.diff(log.columns["t_s"]).max() == pytest.approx(5e-3), "the skipped periods show as a gap in t_s"
        assert set(np.diff(log.columns["cycle"])) == {1}
        assert log.metadata["closing"]["overrun_culprits"] == "write 1"
        assert log.metadata["closing"]["missed_periods"] == "4"


def test_repeated_overruns_of_5_ms_are_a_controlled_stop(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(100)
        device.on_read = lambda: delay_once(rig, 5 * MS)
        rig.cycles(21)
        assert rig.mode is Mode.STOPPING
        device.on_read = lambda: None
        rig.until(lambda: rig.mode is Mode.HOLDING, 3.0)
        assert "loop timing" in rig.loop.keeper.run.reason


def test_many_missed_periods_spoil_a_run_that_was_not_stopped(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(100)
        device.on_read = lambda: delay_once(rig, 5 * MS)
        rig.cycles(15)
        device.on_read = lambda: None
        rig.until(lambda: not rig.loop.keeper.run.active, 3.0)
        assert "periods were missed" in rig.loop.keeper.run.reason


def test_a_stall_of_100_ms_is_a_fault(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        device.on_read = lambda: delay_once(rig, 100 * MS)
        rig.cycles(1)
        device.on_read = lambda: None
        rig.cycles(1)
        assert rig.mode is Mode.FAULT
        assert "loop stall" in rig.loop.keeper.why_fault
        assert device.written is None


def test_a_lost_recorder_is_a_controlled_stop_and_then_a_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        rig.start(JOG)
        rig.cycles(500)
        update = rig.loop._surroundings.update

        def lost(values: list[float], now_ns: int) -> None:
            update(values, now_ns)
            values[rig.facts.index("recorder.failed")] = 1.0

        monkeypatch.setattr(rig.loop._surroundings, "update", lost)
        rig.cycles(1)
        assert rig.mode is Mode.STOPPING
        assert device.written is not None, "outputs act until the arm has come to rest"
        rig.until(lambda: rig.mode is Mode.FAULT, 3.0)
        assert "recorder lost" in rig.loop.keeper.why_fault
        assert device.written is None


def test_dropped_records_stop_the_run(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, _):
        rig.arm()
        rig.start(JOG)
        rig.cycles(300)
        rig.loop._log._recorder.dropped = 3  # type: ignore[misc]
        rig.until(lambda: rig.mode is Mode.FAULT, 3.0)
        assert "records dropped" in rig.loop.keeper.run.reason


def test_a_stop_that_takes_too_long_is_a_fault(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with simple_rig(tmp_path) as (rig, _):
        rig.arm()
        rig.start(JOG)
        rig.cycles(500)
        compute = rig.loop._compute

        def never_at_rest() -> None:
            compute()
            rig.loop.keeper.conditions.at_rest = False

        monkeypatch.setattr(rig.loop, "_compute", never_at_rest)
        rig.post(Event.STOP)
        rig.until(lambda: rig.mode is Mode.FAULT, 6.0)
        assert "longer than 5 s" in rig.loop.keeper.why_fault


def test_every_arming_has_a_recording_of_its_own_that_re_executes(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        for _ in range(3):
            rig.one_run(JOG)
        rig.arm()
        rig.start({"maneuver": {"name": "paper_line"}, "shaper": {"kind": "adaptive"}, "approach": True})
        rig.cycles(3000)
        device.override["rotary.position"] = nan
        rig.cycles(2100)
    assert len(rig.recorder.finished) == 4
    for path in rig.recorder.finished:
        result = reexecute(path)
        assert result.identical, result.text()
    log = read_log(rig.recorder.finished[-1])
    assert log.metadata["closing"]["ended_by"] == "fault"
    assert np.isnan(log.columns["rotary.position"][-1])
    assert log.columns["mode"][-1] == Mode.FAULT
    assert np.sum(log.columns["mode"] == Mode.FAULT) == pytest.approx(2000, abs=2)


def test_devices_may_take_their_time_to_become_active(tmp_path: Path) -> None:
    """A CANopen valve goes through its states meanwhile; longer than the stall limit, but nothing acts yet."""
    with simple_rig(tmp_path) as (rig, device):
        device.on_activate = lambda: delay_once(rig, 120 * MS)
        rig.arm()
        assert rig.mode is Mode.HOLDING
        assert rig.value("overruns") == 0


def test_infinite_values_are_no_numbers_either(tmp_path: Path) -> None:
    with simple_rig(tmp_path) as (rig, device):
        rig.arm()
        device.override["rotary.position"] = inf
        rig.cycles(2)
        assert rig.mode is Mode.FAULT
        assert device.written is None
