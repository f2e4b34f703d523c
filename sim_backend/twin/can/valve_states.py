"""Device control of a CiA 408 valve: its states, and where the control word, faults and resets lead. Pure: states in, states out.

Status word bits R M H D (3 to 0) and control word bits of the same names as in Moog's manual of the ACV (rev. A, 2018, §5.2).
"""

from __future__ import annotations

from enum import IntEnum

D, H, M, R = 1, 2, 4, 8


class ValveState(IntEnum):
    """States with their status bits RMHD. (NOT_READY and FAULT_INIT show the same bits.)"""

    NOT_READY = 0x10
    INIT = R
    DISABLED = R | D
    HOLD = R | H | D
    ACTIVE = R | M | H | D
    FAULT_REACTION = M | H | D
    FAULT_HOLD = H | D
    FAULT_DISABLED = D
    FAULT_INIT = 0

    @property
    def status_bits(self) -> int:
        return 0 if self is ValveState.NOT_READY else int(self)


_ORDINARY = (ValveState.INIT, ValveState.DISABLED, ValveState.HOLD, ValveState.ACTIVE)
_FAULTS = (ValveState.FAULT_INIT, ValveState.FAULT_DISABLED, ValveState.FAULT_HOLD)
_LEVEL = {0: 0, D: 1, D | H: 2, D | H | M: 3}  # control word bits MHD → how far up the chain they allow


def commanded(state: ValveState, word: int, old_word: int) -> ValveState:
    """The state after a control word. In the ordinary chain any state is reached at once, in both directions.

    A fault is left only by a rising edge of R while the lower bits ask for the state the fault stands for
    (FAULT_HOLD → HOLD with 0011 → 1011, ...); with lower bits a fault sinks to FAULT_DISABLED and FAULT_INIT.
    """
    level = _allowed_level(word)
    if state in _ORDINARY:
        return _ORDINARY[level]
    if state not in _FAULTS:
        return state
    sunk = _FAULTS[min(_FAULTS.index(state), level)]
    is_reset = word & R and not old_word & R
    return _ORDINARY[_FAULTS.index(sunk)] if is_reset and level == _FAULTS.index(sunk) else sunk


def faulted(state: ValveState, reaction: int) -> ValveState:
    """The state after a fault with this reaction (0x2830): 0, 1 none; 2 FAULT_DISABLED; 3 FAULT_HOLD, which DISABLED turns into 2."""
    if reaction in (0, 1) or state is ValveState.NOT_READY:
        return state
    if state in (ValveState.INIT, ValveState.FAULT_INIT):
        return ValveState.FAULT_INIT
    if reaction == 3 and state in (ValveState.HOLD, ValveState.ACTIVE, ValveState.FAULT_HOLD):
        return ValveState.FAULT_HOLD
    return ValveState.FAULT_DISABLED


def _allowed_level(word: int) -> int:
    """H counts only with D, M only with H and D."""
    for bits in (D | H | M, D | H, D):
        if word & bits == bits:
            return _LEVEL[bits]
    return 0
