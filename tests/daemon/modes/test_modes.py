"""The mode machine over every mode, action and combination of conditions."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import fields

import pytest

from daemon.modes.mode_machine import Conditions, OperatorAction, update
from servo_control.signals import Mode

NAMES = [field.name for field in fields(Conditions)]
# Where each mode can go at all. A mode or a way that is not here is a mistake.
WAYS = {
    Mode.DISARMED: {Mode.DISARMED, Mode.ARMING, Mode.PROVING, Mode.FAULT},
    Mode.PROVING: {Mode.PROVING, Mode.DISARMED, Mode.FAULT},
    Mode.ARMING: {Mode.ARMING, Mode.HOLDING, Mode.DISARMED, Mode.FAULT},
    Mode.HOLDING: {Mode.HOLDING, Mode.RUNNING, Mode.DISARMED, Mode.FAULT},
    Mode.RUNNING: {Mode.RUNNING, Mode.STOPPING, Mode.HOLDING, Mode.DISARMED, Mode.FAULT},
    Mode.STOPPING: {Mode.STOPPING, Mode.HOLDING, Mode.DISARMED, Mode.FAULT},
    Mode.FAULT: {Mode.FAULT, Mode.DISARMED},
}


def everything() -> Iterator[tuple[Mode, OperatorAction, Conditions, Mode]]:
    for mode, action, *flags in itertools.product(Mode, OperatorAction, *[(False, True)] * len(NAMES)):
        now = Conditions(**dict(zip(NAMES, flags, strict=True)))
        yield mode, action, now, update(mode, action, now)


def test_every_mode_goes_only_where_it_may_and_everywhere_it_may() -> None:
    seen: dict[Mode, set[Mode]] = {mode: set() for mode in Mode}
    for mode, _, _, after in everything():
        seen[mode].add(after)
    assert seen == WAYS


def test_e_stop_is_a_fault_from_everywhere() -> None:
    assert all(after is Mode.FAULT for _, action, _, after in everything() if action is OperatorAction.ESTOP)


def test_a_fault_is_left_only_by_a_reset_and_only_to_disarmed() -> None:
    for mode, action, _, after in everything():
        if mode is Mode.FAULT:
            assert after is (Mode.DISARMED if action is OperatorAction.RESET else Mode.FAULT)


def test_motion_begins_only_with_start_while_holding_and_nothing_tripped() -> None:
    for mode, action, now, after in everything():
        if after is Mode.RUNNING and mode is not Mode.RUNNING:
            assert (mode, action) == (Mode.HOLDING, OperatorAction.START)
            assert not any((now.fault, now.stop, now.fault_at_rest, now.leaving))


def test_arming_begins_only_with_arm_while_every_check_passes() -> None:
    for mode, action, now, after in everything():
        if after is Mode.ARMING and mode is not Mode.ARMING:
            assert (mode, action) == (Mode.DISARMED, OperatorAction.ARM)
            assert now.checks_pass
            assert not now.leaving


def test_a_proof_begins_only_with_prove_while_disarmed_and_what_it_needs_holds() -> None:
    for mode, action, now, after in everything():
        if after is Mode.PROVING and mode is not Mode.PROVING:
            assert (mode, action) == (Mode.DISARMED, OperatorAction.PROVE)
            assert now.may_prove
            assert not now.leaving


def test_a_proof_is_given_up_by_everything_an_operator_can_ask_to_end_it_and_never_leads_to_arming() -> None:
    for mode, action, now, after in everything():
        if mode is not Mode.PROVING:
            continue
        if not now.may_prove or action is OperatorAction.ESTOP:
            assert after is Mode.FAULT, "pressure came while valves were open"
        elif action in (OperatorAction.DISARM, OperatorAction.STOP, OperatorAction.RESET) or now.leaving or now.proof_over:
            assert after is Mode.DISARMED
        else:
            assert after is Mode.PROVING


def test_a_fault_condition_ends_every_mode_in_which_outputs_act() -> None:
    for mode, _, now, after in everything():
        if now.fault and mode not in (Mode.DISARMED, Mode.FAULT, Mode.PROVING):  # without pressure its check fails, as it must
            assert after is Mode.FAULT


def test_disarm_makes_outputs_safe_in_the_same_cycle() -> None:
    for mode, action, _, after in everything():
        if action is OperatorAction.DISARM:
            assert after in (Mode.DISARMED, Mode.FAULT), mode


def test_a_run_under_way_is_stopped_by_every_reason_to_stop() -> None:
    for mode, action, now, after in everything():
        if mode is Mode.RUNNING and (action is OperatorAction.STOP or now.stop or now.fault_at_rest or now.leaving):
            assert after in (Mode.STOPPING, Mode.FAULT, Mode.DISARMED)


def test_when_the_daemon_ends_every_mode_comes_to_disarmed_or_fault() -> None:
    now = Conditions(leaving=True, at_rest=True)
    for mode in Mode:
        for _ in range(4):
            mode = update(mode, OperatorAction.NONE, now)
        assert mode in (Mode.DISARMED, Mode.FAULT)


def test_a_lost_recorder_stops_first_and_faults_at_rest() -> None:
    mode = update(Mode.RUNNING, OperatorAction.NONE, Conditions(fault_at_rest=True))
    assert mode is Mode.STOPPING
    assert update(mode, OperatorAction.NONE, Conditions(fault_at_rest=True)) is Mode.STOPPING
    mode = update(mode, OperatorAction.NONE, Conditions(fault_at_rest=True, at_rest=True))
    assert mode is Mode.HOLDING
    assert update(mode, OperatorAction.NONE, Conditions(fault_at_rest=True)) is Mode.FAULT


# Every mode with every action while nothing has tripped: the whole machine as an operator meets it. Modes by their first letter, P proving.
BY_ACTION = """
          NONE ARM DISARM START STOP ESTOP RESET PROVE
disarmed  D    A   D      D     D    F     D     P
arming    A    A   D      A     D    F     A     A
holding   H    H   D      R     H    F     H     H
running   R    R   D      R     S    F     R     R
stopping  S    S   D      S     S    F     S     S
proving   P    P   D      P     D    F     D     P
fault     F    F   F      F     F    F     D     F
"""
# Every mode when one condition alone changes and nobody asks for anything; `!` before a condition that is true while all is well.
BY_CONDITION = """
          fault stop fault_at_rest !checks_pass settled finished at_rest !may_prove proof_over overdue leaving
disarmed  D     D    D             D            D       D        D       D          D          D       D
arming    F     A    A             D            H       A        A       A          A          A       D
holding   F     H    F             H            H       H        H       H          H          H       D
running   F     S    S             R            R       H        R       R          R          R       S
stopping  F     S    S             S            S       S        H       S          S          F       S
proving   P     P    P             P            P       P        P       F          D          P       D
fault     F     F    F             F            F       F        F       F          F          F       F
"""
LETTERS = {
    "D": Mode.DISARMED,
    "A": Mode.ARMING,
    "H": Mode.HOLDING,
    "R": Mode.RUNNING,
    "S": Mode.STOPPING,
    "P": Mode.PROVING,
    "F": Mode.FAULT,
}


def cells(table: str) -> list[tuple[Mode, str, Mode]]:
    """(mode, heading of the column, mode that follows) of every cell."""
    head, *rows = table.strip("\n").splitlines()
    split = [row.split() for row in rows]
    return [
        (Mode[mode.upper()], column, LETTERS[after]) for mode, *afters in split for column, after in zip(head.split(), afters, strict=True)
    ]


@pytest.mark.parametrize(("mode", "action", "after"), cells(BY_ACTION))
def test_every_mode_meets_every_action(mode: Mode, action: str, after: Mode) -> None:
    assert update(mode, OperatorAction[action], Conditions()) is after


@pytest.mark.parametrize(("mode", "condition", "after"), cells(BY_CONDITION))
def test_every_mode_meets_every_condition(mode: Mode, condition: str, after: Mode) -> None:
    now = Conditions(**{condition.removeprefix("!"): not condition.startswith("!")})
    assert update(mode, OperatorAction.NONE, now) is after


def test_both_tables_are_complete() -> None:
    assert {(mode, column) for mode, column, _ in cells(BY_ACTION)} == set(
        itertools.product(Mode, (action.name for action in OperatorAction))
    )
    conditions = {column.removeprefix("!") for _, column, _ in cells(BY_CONDITION)}
    assert {mode for mode, _, _ in cells(BY_CONDITION)} == set(Mode)
    assert conditions == set(NAMES)


def test_more_than_one_condition_by_hand() -> None:
    assert update(Mode.ARMING, OperatorAction.NONE, Conditions(settled=True, checks_pass=False)) is Mode.DISARMED
    assert update(Mode.HOLDING, OperatorAction.START, Conditions(stop=True)) is Mode.HOLDING
    assert update(Mode.DISARMED, OperatorAction.ARM, Conditions(checks_pass=False)) is Mode.DISARMED
    assert update(Mode.DISARMED, OperatorAction.PROVE, Conditions(may_prove=False)) is Mode.DISARMED
