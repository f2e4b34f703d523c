"""One trial of a fault that the loop can see: the whole daemon loop on the virtual clock, the arm in motion, a fault at a random instant.

Lockstep time has no computing time in it: to a real cycle's time-to-safe belong the microseconds of its reading and checking.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from random import Random
from typing import Any, NamedTuple

from config.loading.load import LoadedRig, load_rig
from config.schema.rig import Device, Rig
from daemon.faults.benches.register_watch import RegisterWatch
from daemon.faults.fault import FaultTrial, Until
from daemon.faults.injections.faulty_device import FaultyDevice
from daemon.lockstep import LockstepRig
from drivers.contract import Driver
from drivers.output_register import OutputRegister
from recording.format.event import Event

MOVES: dict[str, dict[str, str]] = {
    "rotary": {"joint": "rotary", "by": "75 deg", "speed": "50 deg/s"},
    "prismatic": {"joint": "prismatic", "by": "-18 in", "speed": "10 in/s"},
}
BEFORE_CYCLES = (400, 900)  # of motion, at full speed
HELD_MS = {Until.SAFE: 200.0, Until.REST: 300.0, Until.RENEWED: 300.0}
LONGEST_MS = {Until.SAFE: 3000.0, Until.REST: 6000.0, Until.RENEWED: 300.0}
RUN_OVER = "running → holding"  # the run's own end is no reaction
MS = 1_000_000


class LockstepTarget:
    """What an injection may change."""

    def __init__(self, rig: LockstepRig, device: FaultyDevice, rng: Random, watch: RegisterWatch) -> None:
        self.rig, self.device, self.rng, self._watch = rig, device, rng, watch

    def stall(self, length_ms: float) -> None:
        """The loop does not get on for this long: the clock moves on, and the valves' own time-out with it."""
        clock = self.rig.clock
        end_ns = clock.now_ns() + round(length_ms * MS)
        while clock.now_ns() < end_ns:
            clock.wait_until(min(clock.now_ns() + MS, end_ns))
            self._watch.update(clock.now_ns())


class MadeRig(NamedTuple):
    """A rig that holds, and its device."""

    rig: LockstepRig
    device: FaultyDevice


Inject = Callable[[LockstepTarget], None]
Begin = Callable[[MadeRig], None]
_loaded: list[LoadedRig] = []


def loaded_rig() -> LoadedRig:
    """The shipped test bed, read once."""
    if not _loaded:
        _loaded.append(load_rig("ornl_testbed"))
    return _loaded[0]


def lockstep_trial(inject: Inject, until: Until, joint: str, begin: Begin | None = None) -> Callable[[Random, Path], FaultTrial]:
    """A trial that injects by `inject` while `joint` moves and watches until `until`. `begin` makes the arm move, by default a maneuver."""
    begin = begin or (lambda made: _start(made.rig, joint))
    return lambda rng, directory: _trial(inject, until, begin, rng, directory)


def _start(rig: LockstepRig, joint: str) -> None:
    rig.start({"maneuver": {"name": "jog"}, "parameters": MOVES[joint]})


def _trial(inject: Inject, until: Until, begin: Begin, rng: Random, directory: Path) -> FaultTrial:
    made: list[FaultyDevice] = []
    path = directory / "plant.outputs"

    def create(name: str, device: Device, rig: Rig, lockstep: bool) -> Driver:
        made.append(FaultyDevice(name, device, rig, path))
        return made[-1]

    with LockstepRig(loaded_rig(), directory / "logs", rng.randrange(1 << 30), create) as rig:
        rig.arm()
        begin(MadeRig(rig, made[0]))
        rig.cycles(rng.randint(*BEFORE_CYCLES))
        events_before = len(rig.events)
        injected_ns = rig.clock.now_ns() + round(rng.random() * 1e9 / rig.rig.loop.rate_Hz)  # between two cycles
        watch = RegisterWatch(OutputRegister.attach(path), injected_ns)
        inject(LockstepTarget(rig, made[0], rng, watch))
        _watch(rig, watch, until, injected_ns)
        made[0].before.clear()
        return _judged(watch, until, rig.events[events_before:], rig.clock.start_ns, injected_ns)


def _watch(rig: LockstepRig, watch: RegisterWatch, until: Until, injected_ns: int) -> None:
    while (rig.clock.now_ns() - injected_ns) * 1e-6 < LONGEST_MS[until]:
        rig.loop.cycle()
        now_ns = rig.clock.now_ns()
        watch.update(now_ns)
        held_ms = {Until.SAFE: watch.safe_for_ms, Until.REST: watch.rest_for_ms}.get(until)
        if held_ms and held_ms(now_ns) >= HELD_MS[until]:
            return


def _judged(watch: RegisterWatch, until: Until, events: Sequence[Event], start_ns: int, injected_ns: int) -> FaultTrial:
    times = {Until.SAFE: watch.safe_after_ms, Until.REST: watch.rest_after_ms, Until.RENEWED: watch.longest_pause_ms}
    event = reaction_event([{"name": event.name, "text": event.text} for event in events])
    reaction, number = (short(event), event.get("number")) if event else ("none: the run goes on", None)
    if number is None:
        return FaultTrial(times[until], reaction)
    began_ms = (start_ns + events[number].t_s * 1e9 - injected_ns) * 1e-6
    return FaultTrial(times[until], reaction, max(0.0, round(began_ms, 3)))


def reaction_event(events: Sequence[dict[str, Any]]) -> dict[str, Any] | None:
    """The first event that is a reaction, with its `number` in the list; an overrun is one only where nothing else is."""
    for names in (("fault", "mode"), ("overrun",)):
        for number, event in enumerate(events):
            if event["name"] in names and event["text"] != RUN_OVER:
                return {**event, "number": number}
    return None


def short(event: dict[str, Any]) -> str:
    """`fault: rotary position stuck`, `controlled stop: loop timing`, `disarmed`: what the reaction was and which check had it."""
    text = str(event["text"])
    if event["name"] == "overrun":
        return "counted as overrun: the run goes on"
    if event["name"] == "fault":
        return f"fault: {_cause(text)}"
    change, _, cause = text.partition(": ")
    what = {"stopping": "controlled stop", "disarmed": "disarmed"}.get(change.rpartition("→ ")[2], change)
    return f"{what}: {_cause(cause)}" if cause else what


def _cause(text: str) -> str:
    """Without the numbers and without the advice."""
    return text.partition(" (")[0].partition(". ")[0].rstrip(".")
