"""Set points in the log: every bit comes back, readers not written here decode them, and a log without them has no such topic."""

from __future__ import annotations

import struct
from itertools import pairwise
from math import isnan
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from config.errors import LogError
from daemon.lockstep import LockstepRig, run_lockstep
from recording.evaluation.replay import reexecute
from recording.files.reader import read_log
from recording.files.recover import recover
from recording.format.set_point import StampedSetPoint, decode_set_point, encode_set_point
from servo_control.signals import Mode, SetPoint, Wanted
from tests.support.daemon.rigs import JOG, RIG

FLOATS = st.floats(allow_nan=True, allow_infinity=True)


def bits(values: tuple[float, ...]) -> bytes:
    return struct.pack(f"<{len(values)}d", *values)


@given(
    cycle=st.integers(0, 2**63),
    t_s=st.floats(0, 1e6),
    run=st.integers(0, 2**32 - 1),
    wanted=st.integers(0, 255),
    values=st.lists(FLOATS, max_size=6),
    late_s=FLOATS,
)
def test_every_bit_comes_back(cycle: int, t_s: float, run: int, wanted: int, values: list[float], late_s: float) -> None:
    stamped = StampedSetPoint(cycle, t_s, SetPoint(run, wanted, tuple(values), late_s))
    back = decode_set_point(encode_set_point(stamped))
    assert back[:2] == stamped[:2]
    assert back.point[:2] == stamped.point[:2]
    assert bits(back.point.values) == bits(stamped.point.values)
    assert bits((back.point.late_s,)) == bits((late_s,))


@given(data=st.binary(max_size=35))
def test_a_message_that_is_too_short_is_refused(data: bytes) -> None:
    with pytest.raises(LogError, match="a set point of the log"):
        decode_set_point(data)


@given(count=st.integers(1, 2**32 - 1))
def test_more_values_than_there_are_bytes_are_refused(count: int) -> None:
    whole = encode_set_point(StampedSetPoint(1, 2.0, SetPoint(1, Wanted.RATE, (), 0.0)))
    with pytest.raises(LogError, match="a set point of the log"):
        decode_set_point(whole[:-4] + struct.pack("<I", count))


def driven_log(directory: Path) -> Path:
    """A little motion by hand, with a number that is not finite at its end."""
    with LockstepRig(RIG, directory) as rig:
        rig.arm()
        run = rig.stream({"shaper": {"kind": "none"}})
        rig.until(lambda: rig.mode is Mode.RUNNING)
        count = len(rig.rig.joints)
        for number in range(10):
            rig.set_points.post(SetPoint(run, Wanted.RATE, (0.01 * number,) * count, 1e-3 * number))
            rig.cycles(7)
        rig.set_points.post(SetPoint(run, Wanted.RATE, (float("nan"),) * count, 0.0))
        rig.until(lambda: rig.mode is Mode.HOLDING)
        rig.disarm()
        return rig.recorder.finished[-1]


def test_a_reader_of_others_decodes_them_and_ours_has_the_cycle_that_got_each(tmp_path: Path) -> None:
    path = driven_log(tmp_path)
    with path.open("rb") as file:
        theirs = [
            message for _, _, _, message in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages(["/set_point"])
        ]
    ours = read_log(path).set_points
    assert len(theirs) == len(ours) == 11
    for message, (cycle, t_s, point) in zip(theirs, ours, strict=True):
        assert (message.cycle, message.t_s, message.run, message.wanted, message.late_s) == (cycle, t_s, *point[:2], point.late_s)
        assert bits(tuple(message.values)) == bits(point.values)
    assert isnan(ours[-1].point.values[0])
    assert [later.cycle - before.cycle for before, later in pairwise(ours[:-1])] == [7] * 9


def test_the_run_re_executes_and_a_changed_set_point_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = driven_log(tmp_path)
    assert reexecute(path).identical
    log = read_log(path)
    cycle, t_s, point = log.set_points[5]
    log.set_points[5] = StampedSetPoint(cycle, t_s, point._replace(values=tuple(1.0000001 * value for value in point.values)))
    monkeypatch.setattr("recording.evaluation.replay.read_log", lambda path: log)
    result = reexecute(path)
    assert result.first is not None
    assert result.first.cycle == cycle


def test_a_cut_log_keeps_its_set_points(tmp_path: Path) -> None:
    path = driven_log(tmp_path)
    cut, repaired = tmp_path / "cut.mcap", tmp_path / "repaired.mcap"
    cut.write_bytes(path.read_bytes()[:-2000])
    recover(cut, repaired)
    kept = read_log(repaired).set_points
    assert [bits(stamped.point.values) for stamped in kept] == [
        bits(stamped.point.values) for stamped in read_log(path).set_points[: len(kept)]
    ]
    assert kept


def test_a_log_without_hand_driven_runs_has_no_such_topic(tmp_path: Path) -> None:
    (path,) = run_lockstep(RIG, [JOG], tmp_path)
    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert {channel.topic for channel in summary.channels.values()} == {"/cycle", "/event"}
