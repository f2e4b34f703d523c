"""The mode machine, as one function of mode, event and conditions. It knows nothing else, so every combination is tested.

DISARMED --arm--> ARMING --settled--> HOLDING --start--> RUNNING --stop--> STOPPING --at rest--> HOLDING
                                        ^                   |
                                        +-----finished------+
FAULT: from anywhere, latched; only a reset leaves it, always to DISARMED. Nothing leads to motion but `start` while HOLDING.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from control.signals import Mode


class Event(IntEnum):
    """What an operator asks for. One event a cycle."""

    NONE = 0
    ARM = 1
    DISARM = 2
    START = 3
    STOP = 4
    ESTOP = 5
    RESET = 6


@dataclass(slots=True)
class Conditions:
    """What holds in this cycle."""

    fault: bool = False  # an interlock with the reaction "fault" has tripped
    stop: bool = False  # one with the reaction "controlled stop" has
    fault_at_rest: bool = False  # one with "controlled stop, then fault" has
    checks_pass: bool = True  # every arming check passes
    settled: bool = False  # arming has lasted long enough
    finished: bool = False  # the run has come to rest at its end
    at_rest: bool = False  # the controlled stop has
    overdue: bool = False  # the controlled stop takes too long
    leaving: bool = False  # the daemon ends: controlled stop, then disarm


def update(mode: Mode, event: Event, now: Conditions) -> Mode:
    """The mode of this cycle, from the mode of the last one."""
    if event is Event.ESTOP:
        return Mode.FAULT
    if mode is Mode.FAULT:
        return Mode.DISARMED if event is Event.RESET else Mode.FAULT
    if mode is Mode.DISARMED:
        return Mode.ARMING if event is Event.ARM and now.checks_pass and not now.leaving else Mode.DISARMED

    # ARMING, HOLDING, RUNNING, STOPPING: outputs act
    if now.fault:
        return Mode.FAULT
    if event is Event.DISARM:
        return Mode.DISARMED
    return _ARMED[mode](event, now)


def _arming(event: Event, now: Conditions) -> Mode:
    if now.leaving or event is Event.STOP or not now.checks_pass:
        return Mode.DISARMED
    return Mode.HOLDING if now.settled else Mode.ARMING


def _holding(event: Event, now: Conditions) -> Mode:
    if now.leaving:
        return Mode.DISARMED
    if now.fault_at_rest:
        return Mode.FAULT
    return Mode.RUNNING if event is Event.START and not now.stop else Mode.HOLDING


def _running(event: Event, now: Conditions) -> Mode:
    if event is Event.STOP or now.stop or now.fault_at_rest or now.leaving:
        return Mode.STOPPING
    return Mode.HOLDING if now.finished else Mode.RUNNING


def _stopping(event: Event, now: Conditions) -> Mode:
    if now.overdue:
        return Mode.FAULT
    if not now.at_rest:
        return Mode.STOPPING
    return Mode.HOLDING  # where `leaving` and `fault_at_rest` lead on in the next cycle


_ARMED = {Mode.ARMING: _arming, Mode.HOLDING: _holding, Mode.RUNNING: _running, Mode.STOPPING: _stopping}
