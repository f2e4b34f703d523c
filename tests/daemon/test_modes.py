"""The mode machine over every mode, event and combination of conditions."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import fields

import pytest

from control.signals import Mode
from daemon.modes import Conditions, Event, update

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


def everything() -> Iterator[tuple[Mode, Event, Conditions, Mode]]:
    for mode, event, *flags in itertools.product(Mode, Event, *[(False, True)] * len(NAMES)):
        now = Conditions(**dict(zip(NAMES, flags, strict=True)))
        yield mode, event, now, update(mode, event, now)


def test_every_mode_goes_only_where_it_may_and_everywhere_it_may() -> None:
    seen: dict[Mode, set[Mode]] = {mode: set() for mode in Mode}
    for mode, _, _, after in everything():
        seen[mode].add(after)
    assert seen == WAYS


def test_e_stop_is_a_fault_from_everywhere() -> None:
    assert all(after is Mode.FAULT for _, event, _, after in everything() if event is Event.ESTOP)


def test_a_fault_is_left_only_by_a_reset_and_only_to_disarmed() -> None:
    for mode, event, _, after in everything():
        if mode is Mode.FAULT:
            assert after is (Mode.DISARMED if event is Event.RESET else Mode.FAULT)


def test_motion_begins_only_with_start_while_holding_and_nothing_tripped() -> None:
    for mode, event, now, after in everything():
        if after is Mode.RUNNING and mode is not Mode.RUNNING:
            assert (mode, event) == (Mode.HOLDING, Event.START)
            assert not any((now.fault, now.stop, now.fault_at_rest, now.leaving))


def test_arming_begins_only_with_arm_while_every_check_passes() -> None:
    for mode, event, now, after in everything():
        if after is Mode.ARMING and mode is not Mode.ARMING:
            assert (mode, event) == (Mode.DISARMED, Event.ARM)
            assert now.checks_pass
            assert not now.leaving


def test_a_proof_begins_only_with_prove_while_disarmed_and_what_it_needs_holds() -> None:
    for mode, event, now, after in everything():
        if after is Mode.PROVING and mode is not Mode.PROVING:
            assert (mode, event) == (Mode.DISARMED, Event.PROVE)
            assert now.may_prove
            assert not now.leaving


def test_a_proof_is_given_up_by_everything_an_operator_can_ask_to_end_it_and_never_leads_to_arming() -> None:
    for mode, event, now, after in everything():
        if mode is not Mode.PROVING:
            continue
        if not now.may_prove or event is Event.ESTOP:
            assert after is Mode.FAULT, "pressure came while valves were open"
        elif event in (Event.DISARM, Event.STOP, Event.RESET) or now.leaving or now.proof_over:
            assert after is Mode.DISARMED
        else:
            assert after is Mode.PROVING


def test_a_fault_condition_ends_every_mode_in_which_outputs_act() -> None:
    for mode, _, now, after in everything():
        if now.fault and mode not in (Mode.DISARMED, Mode.FAULT, Mode.PROVING):  # without pressure its check fails, as it must
            assert after is Mode.FAULT


def test_disarm_makes_outputs_safe_in_the_same_cycle() -> None:
    for mode, event, _, after in everything():
        if event is Event.DISARM:
            assert after in (Mode.DISARMED, Mode.FAULT), mode


def test_a_run_under_way_is_stopped_by_every_reason_to_stop() -> None:
    for mode, event, now, after in everything():
        if mode is Mode.RUNNING and (event is Event.STOP or now.stop or now.fault_at_rest or now.leaving):
            assert after in (Mode.STOPPING, Mode.FAULT, Mode.DISARMED)


def test_when_the_daemon_ends_every_mode_comes_to_disarmed_or_fault() -> None:
    now = Conditions(leaving=True, at_rest=True)
    for mode in Mode:
        for _ in range(4):
            mode = update(mode, Event.NONE, now)
        assert mode in (Mode.DISARMED, Mode.FAULT)


def test_a_lost_recorder_stops_first_and_faults_at_rest() -> None:
    mode = update(Mode.RUNNING, Event.NONE, Conditions(fault_at_rest=True))
    assert mode is Mode.STOPPING
    assert update(mode, Event.NONE, Conditions(fault_at_rest=True)) is Mode.STOPPING
    mode = update(mode, Event.NONE, Conditions(fault_at_rest=True, at_rest=True))
    assert mode is Mode.HOLDING
    assert update(mode, Event.NONE, Conditions(fault_at_rest=True)) is Mode.FAULT


@pytest.mark.parametrize(
    ("mode", "event", "now", "after"),
    [
        (Mode.ARMING, Event.NONE, Conditions(settled=True), Mode.HOLDING),
        (Mode.ARMING, Event.NONE, Conditions(settled=True, checks_pass=False), Mode.DISARMED),
        (Mode.RUNNING, Event.NONE, Conditions(finished=True), Mode.HOLDING),
        (Mode.STOPPING, Event.START, Conditions(), Mode.STOPPING),
        (Mode.STOPPING, Event.NONE, Conditions(at_rest=True), Mode.HOLDING),
        (Mode.STOPPING, Event.NONE, Conditions(overdue=True), Mode.FAULT),
        (Mode.DISARMED, Event.START, Conditions(), Mode.DISARMED),
        (Mode.DISARMED, Event.RESET, Conditions(), Mode.DISARMED),
    ],
)
def test_some_ways_by_hand(mode: Mode, event: Event, now: Conditions, after: Mode) -> None:
    assert update(mode, event, now) is after
