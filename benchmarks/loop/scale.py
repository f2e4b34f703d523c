"""How large a rig fits: processor time of a cycle with 1 to 12 joints beside the period, and what their CAN frames take of a bus.

    python -m benchmarks.loop.scale [--cycles 4000]

The cycle is the daemon's whole loop (read, checks, controller, write, record packed) without waiting, with devices in memory and one joint
moving; rigs of more than one joint are made here from the shipped servo axis, because a rig file's single axis has one. Frames are those of
the shipped CAN rig, an encoder and a valve a joint, worst case with stuffing. Processor time, and its p90: on a busy machine one cycle in
thirty is the first after another process, with cold caches, and takes 250 us whatever the rig.
"""

from __future__ import annotations

import argparse
import gc
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from statistics import median

import numpy as np

from config.checking.bus_budget import BusLoad, bus_loads
from config.errors import DaemonError
from config.loading.load import load_rig
from config.schema.rig import Device, Rig
from daemon.checks.interlocks import rig_facts
from daemon.cycle.clock import LockstepClock
from daemon.cycle.log_stream import LogStream
from daemon.cycle.timing import WORDS, Timing
from daemon.lockstep import SingleProcessHealth
from daemon.loop.command import CommandQueue, LoopCommand
from daemon.loop.control_loop import ControlLoop
from daemon.loop.device_bank import DeviceBank
from daemon.loop.other_processes import OtherProcesses
from daemon.loop.recording_span import Recording
from daemon.modes.mode_machine import OperatorAction
from daemon.processes.paths import log_directory
from daemon.server.start_request import start_run
from drivers.contract import Quality, Sample
from recording.format.layout import CycleLayout
from servo_control.signals import Mode

JOINTS = (1, 2, 3, 4, 6, 8, 10, 12)
TURNS = 5  # medians over them
RATES_HZ = (250.0, 500.0, 1000.0, 2000.0, 4000.0)
SHARE = 0.25  # of the period that a cycle may take (p90): the rest is for drivers, late wake-ups and the other processes
BUS_LIMIT = 0.70
LOOP_GAIN_PER_S = 15.0  # of the joints in memory, as the testbed's
JOG = {"maneuver": {"name": "jog"}, "parameters": {"joint": "axis1", "by": "0.15 m", "speed": "0.01 m/s"}, "countdown_s": 0.0}


def rig_of(joints: int) -> Rig:
    """So many of the shipped servo axis, all on one device."""
    single = load_rig("force_axis").rig
    names = [f"axis{number + 1}" for number in range(joints)]
    servo = single.servo["axis"]
    servo = servo.model_copy(update={"gain": LOOP_GAIN_PER_S * servo.velocity_feedforward})
    parts = {"joints": dict.fromkeys(names, single.joints["axis"]), "servo": dict.fromkeys(names, servo)}
    outputs = {name: single.outputs["axis"].model_copy(update={"channel": f"{name}.command"}) for name in names}
    signal = single.signals["axis.position"]
    signals = {f"{name}.position": signal.model_copy(update={"channel": f"{name}.position"}) for name in names}
    return single.model_copy(update={**parts, "outputs": outputs, "signals": signals, "plant": None})


class JointsInMemory:
    """Every joint's rate is its command over the servo's feed-forward: what the servo expects of it."""

    def __init__(self, name: str, device: Device, rig: Rig, lockstep: bool) -> None:
        self.inputs = tuple(signal.channel for signal in rig.signals.values())
        self.outputs = tuple(output.channel for output in rig.outputs.values())
        self._scale = next(iter(rig.signals.values())).calibration.scale
        self._gains = [1.0 / (rig.servo[joint].velocity_feedforward * rig.loop.rate_Hz) for joint in rig.joints]
        self._positions = [0.1] * len(self._gains)
        self._samples = [Sample(quality=Quality.GOOD) for _ in self.inputs]

    def read(self, now_ns: int) -> Sequence[Sample]:
        for sample, position in zip(self._samples, self._positions, strict=True):
            sample.raw, sample.stamp_ns = position / self._scale, now_ns
        return self._samples

    def write(self, values: Sequence[float], now_ns: int) -> None:
        for joint, gain in enumerate(self._gains):
            self._positions[joint] += gain * values[joint]

    def open(self) -> None: ...

    configure = activate = safe = close = open


class Forgotten:
    """Takes every record."""

    dropped = 0

    def write(self, kind: int, stamp_ns: int, data: bytes) -> bool:
        return True


class BareLoop:
    """The daemon's loop on the virtual clock, without a recorder."""

    def __init__(self, rig: Rig) -> None:
        facts, sink = rig_facts(rig), Forgotten()
        self.commands = CommandQueue()
        others = OtherProcesses(self.commands, SingleProcessHealth(facts, log_directory(".")))
        bank = DeviceBank(rig, facts, lockstep=True, create=JointsInMemory)
        recording = Recording(LogStream(CycleLayout.of_rig(rig), sink, sink), Timing([0] * WORDS))
        self.loop = ControlLoop(rig, facts, LockstepClock(), bank, others, recording)
        self._rig, self._at = rig, [facts.index(f"{joint}.reference") for joint in rig.joints]

    def moving(self) -> None:
        """Armed, the first joint on a long move. DaemonError where it does not come to that."""
        self._cycles(2)
        for action in (OperatorAction.RESET, OperatorAction.ARM):
            self.commands.post(LoopCommand(action))
            self._cycles(400)
        position = [self.loop.values[index] for index in self._at]
        self.commands.post(LoopCommand(start=start_run(self._rig, 1, JOG, position)))
        self._cycles(400)
        if self.loop.keeper.mode is not Mode.RUNNING:
            raise DaemonError("the arm does not move", value=self.loop.keeper.mode.name.lower(), next_step=self.loop.keeper.why_fault)

    def timed(self, cycles: int) -> list[float]:
        """Processor time of each of so many cycles, in us."""
        times, cycle, clock = [0.0] * cycles, self.loop.cycle, time.thread_time_ns
        gc.disable()
        for number in range(cycles):
            before = clock()
            cycle()
            times[number] = (clock() - before) * 1e-3
        gc.enable()
        return times

    def _cycles(self, count: int) -> None:
        for _ in range(count):
            self.loop.cycle()


def bus_of(joints: float, rate_Hz: float) -> BusLoad:
    """The shipped CAN rig's bus with this many joints, each with the frames and heartbeats of its rotary one."""
    (shipped,) = bus_loads(load_rig("ornl_testbed_can").rig)
    sync, *frames = shipped.cyclic
    of_joint = [frame for frame in frames if frame.name.startswith("rotary")]
    beats = [frame for frame in shipped.others if frame.name.startswith("rotary")]
    ours = [frame for frame in shipped.others if frame.name.startswith("our")]
    cyclic = [replace(frame, per_second=rate_Hz) for frame in [sync, *of_joint * int(joints)]]
    return BusLoad(shipped.bus, rate_Hz, tuple(cyclic), (*beats * int(joints), *ours))


def most(fits: Callable[[int], bool], highest: int) -> int:
    """The largest number up to `highest` that fits; 0: none does."""
    return next((number for number in range(highest, 0, -1) if fits(number)), 0)


def cycle_table(cycles: int) -> tuple[list[str], dict[int, float]]:
    """A line for each number of joints; and the p90 in us."""
    lines = [
        f"{'joints':>6}{'cycle p50, us':>15}{'p90':>8}   share of the period (p90) at Hz" + "".join(f"{rate:>7.0f}" for rate in RATES_HZ)
    ]
    p90s = {}
    loops = {joints: BareLoop(rig_of(joints)) for joints in JOINTS}
    found: dict[int, list[tuple[float, float]]] = {joints: [] for joints in JOINTS}
    for bare in loops.values():
        bare.moving()
    for _ in range(TURNS):
        for joints, bare in loops.items():
            p50, p90 = np.quantile(bare.timed(cycles // TURNS), (0.5, 0.9))
            found[joints].append((float(p50), float(p90)))
    for joints, each in found.items():
        p50, p90 = (median(figures) for figures in zip(*each, strict=True))
        shares = "".join(f"{100 * p90 * rate * 1e-6:>6.0f}%" for rate in RATES_HZ)
        lines.append(f"{joints:>6}{p50:>15.0f}{p90:>8.0f}{'':34}{shares}")
        p90s[joints] = p90
    return lines, p90s


def fits_table(p90s: dict[int, float]) -> list[str]:
    """What a rate leaves room for, and what stops it first."""
    fixed, each = np.polynomial.polynomial.polyfit(list(p90s), list(p90s.values()), 1)
    frames = ", ".join(f"{frame.name.partition(' ')[2]} {frame.bits} bits" for frame in bus_of(1, 1000.0).cyclic[1:])
    lines = [
        f"a cycle takes {fixed:.0f} us and {each:.0f} us a joint (p90); a joint's frames: {frames}; 1 Mbit/s",
        f"{'rate, Hz':>8}{'joints in a cycle':>19}{'joints on a bus':>17}{'load with 2':>13}   first to stop it",
    ]
    for rate in RATES_HZ:
        loop = int(max(0.0, (SHARE * 1e6 / rate - fixed) / each))
        bus = most(lambda joints, rate=rate: bus_of(joints, rate).load <= BUS_LIMIT, 64)  # type: ignore[misc]
        first = "the bus: share the joints among buses" if bus < loop else "the cycle: a lower rate, or a loop in another language"
        lines.append(f"{rate:>8.0f}{loop:>19}{bus:>17}{100 * bus_of(2, rate).load:>12.0f}%   {first}")
    return lines


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--cycles", type=int, default=4000, metavar="N", help="timed for each number of joints (default %(default)s)")
    lines, p90s = cycle_table(parser.parse_args().cycles)
    print("\n".join([*lines, "", *fits_table(p90s)]))
    print(f"\nfits: a cycle takes at most {100 * SHARE:.0f} % of the period (p90), a bus is loaded at most {100 * BUS_LIMIT:.0f} %")


if __name__ == "__main__":
    main()
