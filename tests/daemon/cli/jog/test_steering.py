"""What keys mean: nothing moves unless a key repeats, and a key that was let go, or any other, stops it."""

from __future__ import annotations

from typing import Any

import pytest

from daemon.cli.jog.jog_command import FILTERS, RIG_FILTER
from daemon.cli.jog.keyboard import Key, keys_in
from daemon.cli.jog.steering import DEAD_MAN_S, SPEEDS, Steering
from servo_control.streaming import stream_plan

ANSWER: dict[str, Any] = {"limits": {"rotary": {"rate": 1.0}, "prismatic": {"rate": 0.2}}, "tip_speed_mps": 1.5}


def test_a_key_counts_until_the_dead_mans_time_is_over() -> None:
    steering = Steering(ANSWER)
    assert not steering.motion(0.0).moves
    steering.press("left", 1.0)
    assert steering.motion(1.0).rates == {"rotary": 0.1}
    assert steering.motion(0.999 + DEAD_MAN_S).moves
    assert not steering.motion(1.001 + DEAD_MAN_S).moves
    assert not steering.motion(1.0).moves  # it has to be pressed again
    assert DEAD_MAN_S + 0.02 + 0.005 <= 0.15  # with a period of the command and the way to the loop


def test_a_key_that_repeats_goes_on() -> None:
    steering = Steering(ANSWER)
    for number in range(40):
        steering.press("down", 0.09 * number)
        assert steering.motion(0.09 * number + 0.085).rates == {"prismatic": pytest.approx(-0.02)}


@pytest.mark.parametrize("key", [" ", "x", "\x1b", "t"])
def test_any_other_key_stops(key: str) -> None:
    steering = Steering(ANSWER)
    steering.press("left", 0.0)
    steering.press(key, 0.01)
    assert not steering.motion(0.02).moves


def test_letting_go_stops_at_once_and_only_that_key() -> None:
    steering = Steering(ANSWER)
    steering.press("left", 0.0)
    steering.release("right")
    assert steering.motion(0.0).moves
    steering.release("left")
    assert not steering.motion(0.0).moves


def test_speed_steps_stay_between_their_ends() -> None:
    steering = Steering(ANSWER)
    for _ in range(20):
        steering.press("+", 0.0)
    assert steering.speed == SPEEDS[-1]
    for _ in range(20):
        steering.press("-", 0.0)
    assert steering.speed == SPEEDS[0]


def test_tip_moves_along_x_and_y_and_an_arm_without_tip_never_does() -> None:
    steering = Steering(ANSWER, tip=True)
    found = {}
    for key in ("left", "right", "up", "down"):
        steering.press(key, 0.0)
        found[key] = steering.motion(0.0).tip_mps
    ways = {"left": (-0.15, 0.0), "right": (0.15, 0.0), "up": (0.0, 0.15), "down": (0.0, -0.15)}
    assert found == {key: pytest.approx(way) for key, way in ways.items()}
    axis = Steering({"limits": {"slide": {"rate": 1.0}}, "tip_speed_mps": 0.0}, tip=True)
    axis.press("t", 0.0)
    axis.press("left", 0.0)
    assert axis.motion(0.0).rates == {"slide": 0.1}
    axis.press("up", 0.0)
    assert not axis.motion(0.0).moves


@pytest.mark.parametrize(
    ("sent", "keys"),
    [
        (b"\x1b[A\x1b[B", [Key("up"), Key("down")]),
        (b"\x1bOC\x1bOD", [Key("right"), Key("left")]),
        (b"\x1b[1;1:3D", [Key("left", released=True)]),
        (b"\x1b[1;1:2D", [Key("left")]),
        (b"\x1b[99;5u", [Key("\x03")]),
        (b"\x1b[113u\x1b[101;1:3u", [Key("q"), Key("e", released=True)]),
        (b"e+q", [Key("e"), Key("+"), Key("q")]),
        (b"\x1b[5~", []),
        (b"\xff\xfe", [Key("\xff"), Key("\xfe")]),
    ],
)
def test_what_terminals_send(sent: bytes, keys: list[Key]) -> None:
    assert keys_in(sent) == (keys, b"")


def test_a_key_cut_in_two_is_put_together() -> None:
    keys, rest = keys_in(b"\x1b[1;1")
    assert keys == []
    assert keys_in(rest + b":3A") == ([Key("up", released=True)], b"")


def test_the_command_offers_the_filters_that_the_plan_takes() -> None:
    assert (RIG_FILTER, *stream_plan.FILTERS) == FILTERS
