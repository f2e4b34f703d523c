"""Whoever drives by hand fails: falls silent, sends late or nonsense, is killed, or the network between stands still."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from math import nan
from signal import SIGKILL, SIGSTOP

from daemon.faults.benches.hand import HandProgram, LockstepHand
from daemon.faults.benches.lockstep_bench import LockstepTarget, MadeRig, loaded_rig, lockstep_trial
from daemon.faults.benches.process_bench import (
    ProcessBench,
    ProcessTarget,
    TrialCourse,
    process_trial,
    reaction_of_daemon,
)
from daemon.faults.fault import SEEN_MS, Expected, Fault, FaultPlace, Until
from servo_control.signals import SetPoint, Wanted

GROUP = "by hand"
REST_MS = 1000.0  # braking and the filter: one period of the link and a little
SOCKET_MS = 50.0  # a set point, or the end of a connection, goes through the supervisor
LATE_S = 0.3

Change = Callable[[LockstepHand], None]


def hand_faults(bench: ProcessBench) -> Iterator[Fault]:
    timeout_ms = loaded_rig().rig.loop.set_point_timeout_s * 1e3
    for name, check, change, began_ms in (
        ("set points stop", "set points arriving", _fall_silent, timeout_ms + 10.0),
        ("set point late", "set point in time", _with(late_s=LATE_S), SEEN_MS + SEEN_MS),
        ("set point not finite", "set point usable", _with(values=(nan, 0.0)), SEEN_MS + SEEN_MS),
        ("set point out of range", "set point in range", _with(values=(9.0, 0.0)), SEEN_MS + SEEN_MS),
        ("hand client hangs up", "driving client", _with(wanted=Wanted.CLIENT_LEFT, values=()), SEEN_MS + SEEN_MS),
    ):
        yield _in_loop(name, check, change, began_ms)
    yield _with_program(bench, "hand client SIGKILLed", "driving client", SOCKET_MS, lambda hand: hand.process.send_signal(SIGKILL))
    stalled_ms = timeout_ms + SOCKET_MS
    yield _with_program(bench, "hand client SIGSTOPped", "set points arriving", stalled_ms, lambda hand: hand.process.send_signal(SIGSTOP))
    yield _with_program(
        bench, "network of the hand client stalled", "set points arriving", stalled_ms, lambda hand: hand.relay.stalled.set()
    )


def _in_loop(name: str, check: str, change: Change, began_ms: float) -> Fault:
    """`began_ms`: from the injection, between two set points that are 20 ms apart, to the stop."""
    hands: list[LockstepHand] = []

    def begin(made: MadeRig) -> None:
        hands.append(LockstepHand(made.rig, "rotary"))
        made.device.before["read"] = hands[-1].before_cycle

    def inject(target: LockstepTarget) -> None:
        change(hands[-1])

    expected = Expected(f"controlled stop: {check}", Until.REST, began_ms + REST_MS)
    return Fault(name, GROUP, expected, lockstep_trial(inject, Until.REST, "rotary", begin), began_limit_ms=began_ms)


def _fall_silent(hand: LockstepHand) -> None:
    hand.silent = True


def _with(**changes: object) -> Change:
    def change(hand: LockstepHand) -> None:
        point = hand.point._asdict() | changes
        hand.point = SetPoint(**point)

    return change


def _with_program(bench: ProcessBench, name: str, check: str, began_ms: float, inject: Callable[[HandProgram], None]) -> Fault:
    hands: list[HandProgram] = []

    def begin(target: ProcessTarget) -> None:
        hands.append(HandProgram(target.client, target.daemon.socket, target.directory))

    def after(target: ProcessTarget) -> str:
        hands[-1].end()
        return reaction_of_daemon(target)

    limit_ms = began_ms + REST_MS
    course = TrialCourse(Until.REST, 2.0 * limit_ms + 1000.0, after, reusable=True, begin=begin)
    trial = process_trial(bench, lambda target: inject(hands[-1]), course)
    return Fault(name, GROUP, Expected(f"controlled stop: {check}", Until.REST, limit_ms), trial, where=FaultPlace.PROCESSES)
