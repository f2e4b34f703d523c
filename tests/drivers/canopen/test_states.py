"""Device control of CiA 408, every state against every goal, by the meaning of the bits in Moog's diagram."""

from __future__ import annotations

import itertools

import pytest

from drivers.canopen.valve_states import FAILSAFE, FAULTS, HELD, SAFE, ValveState, control_word, state_of

LADDER = ["INIT", "DISABLED", "HOLD", "ACTIVE"]
READY, ACTIVE, HOLD, ENABLED = 8, 4, 2, 1


@pytest.mark.parametrize(
    ("bits", "name"),
    [
        ("1000", "INIT"),
        ("1001", "DISABLED"),
        ("1011", "HOLD"),
        ("1111", "ACTIVE"),
        ("0000", "FAULT_INIT"),
        ("0001", "FAULT_DISABLED"),
        ("0011", "FAULT_HOLD"),
        ("0111", "FAULT_REACTION"),
    ],
)
@pytest.mark.parametrize("upper", [0x0000, 0x0010, 0xFFF0, 0x8A50])
def test_the_low_four_bits_say_the_state_whatever_the_others(bits: str, name: str, upper: int) -> None:
    assert state_of(upper | int(bits, 2)).name == name


def test_every_other_pattern_is_unknown() -> None:
    known = {0b1000, 0b1001, 0b1011, 0b1111, 0b0000, 0b0001, 0b0011, 0b0111}
    assert all((state_of(bits) is ValveState.UNKNOWN) == (bits not in known) for bits in range(16))


@pytest.mark.parametrize(("state", "goal"), list(itertools.product(LADDER, LADDER)))
def test_one_rung_up_at_a_time_and_down_at_once(state: str, goal: str) -> None:
    rung = min(LADDER.index(goal), LADDER.index(state) + 1)
    bits = [ENABLED, HOLD, ACTIVE][:rung]
    assert control_word(ValveState[state], ValveState[goal]) == sum(bits)


@pytest.mark.parametrize(("state", "goal"), list(itertools.product(ValveState, LADDER)))
def test_no_word_resets_a_fault_and_no_fault_is_asked_for_more_than_disabled(state: ValveState, goal: str) -> None:
    word = control_word(state, ValveState[goal])
    assert not word & READY
    if state in FAULTS or state is ValveState.UNKNOWN:
        assert word <= ENABLED


def test_active_is_the_only_state_that_follows_a_set_point() -> None:
    assert ValveState.ACTIVE not in SAFE
    assert ValveState.FAULT_REACTION not in SAFE
    assert not FAILSAFE & HELD
    assert FAILSAFE | HELD | {ValveState.ACTIVE, ValveState.FAULT_REACTION, ValveState.UNKNOWN} == set(ValveState)
