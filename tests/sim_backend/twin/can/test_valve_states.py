"""The valve's device control, state by state and word by word, against the tables of the profile written out here."""

from __future__ import annotations

import itertools

import pytest

from sim_backend.twin.can.valve_states import ValveState, commanded, faulted

V = ValveState
LADDER = {0b000: V.INIT, 0b001: V.DISABLED, 0b010: V.INIT, 0b011: V.HOLD, 0b100: V.INIT, 0b101: V.DISABLED, 0b110: V.INIT, 0b111: V.ACTIVE}
ORDINARY = (V.INIT, V.DISABLED, V.HOLD, V.ACTIVE)
FAULTS = (V.FAULT_INIT, V.FAULT_DISABLED, V.FAULT_HOLD)


@pytest.mark.parametrize(("state", "word"), list(itertools.product(ORDINARY, range(16))))
def test_ordinary_states_follow_the_word_and_the_reset_bit_means_nothing(state: V, word: int) -> None:
    assert commanded(state, word, 0) is LADDER[word & 0b111]


@pytest.mark.parametrize(("state", "word", "old"), list(itertools.product(FAULTS, range(16), range(16))))
def test_a_fault_is_left_by_a_rising_edge_of_reset_and_never_into_active(state: V, word: int, old: int) -> None:
    new = commanded(state, word, old)
    if not (word & 8 and not old & 8):
        assert new in FAULTS
    assert new is not V.ACTIVE


@pytest.mark.parametrize(
    ("fault", "word", "goal"), [(V.FAULT_INIT, 0b000, V.INIT), (V.FAULT_DISABLED, 1, V.DISABLED), (V.FAULT_HOLD, 3, V.HOLD)]
)
def test_reset_as_in_the_manual(fault: V, word: int, goal: V) -> None:
    assert commanded(fault, word | 8, word) is goal
    assert commanded(fault, word | 8, word | 8) is fault


def test_faults_sink_with_the_word() -> None:
    assert commanded(V.FAULT_HOLD, 0b001, 0b011) is V.FAULT_DISABLED
    assert commanded(V.FAULT_HOLD, 0b000, 0b011) is V.FAULT_INIT
    assert commanded(V.FAULT_DISABLED, 0b111, 0) is V.FAULT_DISABLED


@pytest.mark.parametrize(("state", "reaction"), list(itertools.product(V, range(4))))
def test_no_fault_ever_leads_upwards(state: V, reaction: int) -> None:
    after = faulted(state, reaction)
    assert after is state if reaction < 2 or state is V.NOT_READY else after in FAULTS
    if state in (V.INIT, V.DISABLED, V.FAULT_DISABLED):
        assert after is not V.FAULT_HOLD  # a spool in its fail-safe position does not start to be controlled by a fault


def test_status_bits() -> None:
    table = {V.INIT: "1000", V.DISABLED: "1001", V.HOLD: "1011", V.ACTIVE: "1111", V.FAULT_HOLD: "0011", V.FAULT_DISABLED: "0001"}
    assert {state: f"{state.status_bits:04b}" for state in table} == table
    assert V.NOT_READY.status_bits == V.FAULT_INIT.status_bits == 0
