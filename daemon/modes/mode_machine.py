"""The mode machine, as one function of mode, action and conditions. It knows nothing else, so every combination is tested.

DISARMED --arm--> ARMING --settled--> HOLDING --start--> RUNNING --stop--> STOPPING --at rest--> HOLDING
                                        ^                   |
                                        +-----finished------+
DISARMED --prove--> PROVING --over--> DISARMED: outputs are moved a little, with the hydraulic pressure off, to see them go safe.
FAULT: from anywhere, latched; only a reset leaves it, always to DISARMED. Nothing leads to motion but `start` while HOLDING.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

from servo_control.signals import Mode

SAFE_MODES = (Mode.DISARMED, Mode.FAULT)  # outputs are safe and stay so


class OperatorAction(IntEnum):
    """What an operator asks for. One action a cycle."""

    NONE = 0
    ARM = 1
    DISARM = 2
    START = 3
    STOP = 4
    ESTOP = 5
    RESET = 6
    PROVE = 7


@dataclass(slots=True)
class Conditions:
    """What holds in this cycle."""

    fault: bool = False  # an interlock with the reaction "fault" has tripped
    stop: bool = False  # one with the reaction "controlled stop" has
    fault_at_rest: bool = False  # one with "controlled stop, then fault" has; stays true until the stop it began has ended in FAULT
    checks_pass: bool = True  # every arming check passes
    settled: bool = False  # arming has lasted long enough
    finished: bool = False  # the run has come to rest at its end
    at_rest: bool = False  # the controlled stop has
    may_prove: bool = True  # the pressure is off, and what else a proof of the safe state needs
    proof_over: bool = False
    overdue: bool = False  # the controlled stop takes too long
    leaving: bool = False  # the daemon ends: controlled stop, then disarm


def update(mode: Mode, action: OperatorAction, now: Conditions) -> Mode:
    """The mode of this cycle, from the mode of the last one."""
    if action is OperatorAction.ESTOP:
        return Mode.FAULT
    if mode is Mode.FAULT:
        return Mode.DISARMED if action is OperatorAction.RESET else Mode.FAULT
    if mode is Mode.DISARMED:
        return _disarmed(action, now)
    if mode is Mode.PROVING:
        return _proving(action, now)

    # ARMING, HOLDING, RUNNING, STOPPING: outputs act
    if now.fault:
        return Mode.FAULT
    if action is OperatorAction.DISARM:
        return Mode.DISARMED
    return _ARMED[mode](action, now)


def _disarmed(action: OperatorAction, now: Conditions) -> Mode:
    if action is OperatorAction.ARM and now.checks_pass and not now.leaving:
        return Mode.ARMING
    return Mode.PROVING if action is OperatorAction.PROVE and now.may_prove and not now.leaving else Mode.DISARMED


def _proving(action: OperatorAction, now: Conditions) -> Mode:
    """Valves are open: should pressure come, that is a fault and not only the end of the proof."""
    if not now.may_prove:
        return Mode.FAULT
    given_up = action in (OperatorAction.DISARM, OperatorAction.STOP, OperatorAction.RESET) or now.leaving
    return Mode.DISARMED if given_up or now.proof_over else Mode.PROVING


def _arming(action: OperatorAction, now: Conditions) -> Mode:
    if now.leaving or action is OperatorAction.STOP or not now.checks_pass:
        return Mode.DISARMED
    return Mode.HOLDING if now.settled else Mode.ARMING


def _holding(action: OperatorAction, now: Conditions) -> Mode:
    if now.leaving:
        return Mode.DISARMED
    if now.fault_at_rest:
        return Mode.FAULT
    return Mode.RUNNING if action is OperatorAction.START and not now.stop else Mode.HOLDING


def _running(action: OperatorAction, now: Conditions) -> Mode:
    if action is OperatorAction.STOP or now.stop or now.fault_at_rest or now.leaving:
        return Mode.STOPPING
    return Mode.HOLDING if now.finished else Mode.RUNNING


def _stopping(action: OperatorAction, now: Conditions) -> Mode:
    if now.overdue:
        return Mode.FAULT
    if not now.at_rest:
        return Mode.STOPPING
    return Mode.HOLDING  # where `leaving` and `fault_at_rest` lead on in the next cycle


_ARMED = {Mode.ARMING: _arming, Mode.HOLDING: _holding, Mode.RUNNING: _running, Mode.STOPPING: _stopping}
