"""The device state machine of CiA 408 as pure functions: what a status word means, which control word leads where.

Control word (0x6040): bit 0 D (not disabled), bit 1 H (hold), bit 2 M (device mode active), bit 3 R (reset a fault, rising edge).
Status word (0x6041): the same bits say the state; R set means ready, R clear means that the valve has a fault or is starting up:

    RMHD   1000 INIT   1001 DISABLED   1011 HOLD   1111 ACTIVE
           0000 FAULT_INIT (or NOT_READY)   0001 FAULT_DISABLED   0011 FAULT_HOLD   0111 FAULT_REACTION

A valve is taken up one state at a time and down at once. In INIT, DISABLED and their faults the spool stands in its hydraulic
fail-safe position; in HOLD and FAULT_HOLD it is controlled to the hold set point. (Moog, ACV with CANopen, user manual B99224.)
"""

from __future__ import annotations

from enum import IntEnum

RESET = 0b1000


class ValveState(IntEnum):
    """The value is the low four bits (RMHD) of the status word; UNKNOWN: a pattern the profile does not have, or not heard of yet."""

    UNKNOWN = -1
    FAULT_INIT = 0b0000
    FAULT_DISABLED = 0b0001
    FAULT_HOLD = 0b0011
    FAULT_REACTION = 0b0111
    INIT = 0b1000
    DISABLED = 0b1001
    HOLD = 0b1011
    ACTIVE = 0b1111


FAULTS = frozenset((ValveState.FAULT_INIT, ValveState.FAULT_DISABLED, ValveState.FAULT_HOLD, ValveState.FAULT_REACTION))
FAILSAFE = frozenset(
    (ValveState.INIT, ValveState.DISABLED, ValveState.FAULT_INIT, ValveState.FAULT_DISABLED)
)  # spool in its fail-safe position
HELD = frozenset((ValveState.HOLD, ValveState.FAULT_HOLD))  # spool at the hold set point
SAFE = FAILSAFE | HELD

_BY_BITS = tuple(ValveState(bits) if bits in ValveState._value2member_map_ else ValveState.UNKNOWN for bits in range(16))
_LADDER = (ValveState.INIT, ValveState.DISABLED, ValveState.HOLD, ValveState.ACTIVE)
_WORDS = (0b000, 0b001, 0b011, 0b111)


def state_of(status_word: int) -> ValveState:
    """The state a status word says."""
    return _BY_BITS[status_word & 0b1111]


def _word(state: ValveState, wanted: ValveState) -> int:
    goal = _LADDER.index(wanted)
    if state is ValveState.FAULT_INIT:
        return _WORDS[0]
    if state not in _LADDER:
        return _WORDS[min(goal, 1)]  # a fault is left by a reset only; until then ask for no more than DISABLED
    return _WORDS[min(goal, _LADDER.index(state) + 1)]


_CONTROL_WORDS = {wanted: {state: _word(state, wanted) for state in ValveState} for wanted in _LADDER}


def control_word(state: ValveState, wanted: ValveState) -> int:
    """What to tell a valve in `state` so that it comes nearer to `wanted` (INIT, DISABLED, HOLD or ACTIVE)."""
    return _CONTROL_WORDS[wanted][state]
