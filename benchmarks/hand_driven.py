"""How much the arm swings after it was driven by hand: keys pressed by a script, the whole simulated rig in lockstep, filter by filter.

    python -m benchmarks.hand_driven [--picture docs/pictures/driving-by-hand.png]

A held key repeats as a terminal's does: at once, after FIRST_REPEAT_S, then every REPEAT_S. Steering and set points are those of
`longreach jog`, fifty a second. `swing` is the largest deflection of the tip about its rest in the second after the reference rests.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt

from config.loading.load import load_rig
from daemon.cli.jog.steering import Steering
from daemon.lockstep import LockstepRig
from recording.files.reader import Log, read_log
from servo_control.planning.run_request import RunRequest
from servo_control.signals import Mode, SetPoint, Wanted
from servo_control.streaming.stream_plan import default_filter, plan_stream

FIRST_REPEAT_S, REPEAT_S = 0.25, 1.0 / 30.0
SET_POINT_S = 0.02
RESTING_S = 3.0  # after the last key
AFTER_S = 1.0

Floats = npt.NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Held:
    """A key held for some time, and the pause after it."""

    key: str
    for_s: float
    pause_s: float = 0.0


@dataclass(frozen=True, slots=True)
class Script:
    """`speed` of the limits; `tip`: the keys move the tip."""

    name: str
    keys: tuple[Held, ...]
    speed: float
    tip: bool = False


SCRIPTS = (
    Script("turn, 1.2 s at 20 %", (Held("left", 1.2),), 0.2),
    Script("turn, 1.2 s at 50 %", (Held("left", 1.2),), 0.5),
    Script("a tap at 50 %", (Held("left", 0.03),), 0.5),
    Script("to and fro at 20 %", (Held("left", 0.7), Held("right", 0.8), Held("left", 0.6)), 0.2),
    Script("out, then turn, at 50 %", (Held("up", 1.5, 0.3), Held("left", 1.0)), 0.5),
    Script("tip along x at 20 %", (Held("right", 1.5),), 0.2, tip=True),
)


@dataclass(frozen=True, slots=True)
class Swing:
    """After the reference rests: deflection about its rest in mm; how long after the last key the reference rested, and the tip was
    within 1 mm for good; the tip's largest acceleration on the way."""

    swing_mm: float
    reference_rests_s: float
    within_1mm_s: float
    peak_mps2: float


def strokes(script: Script) -> tuple[list[tuple[float, str]], float]:
    """When each key is heard of, and when the last one is let go."""
    heard, now = [], 0.0
    for held in script.keys:
        repeats = np.arange(now + FIRST_REPEAT_S, now + held.for_s, REPEAT_S)
        heard += [(now, held.key), *((float(t), held.key) for t in repeats)]
        now += held.for_s + held.pause_s
    return heard, now


def driven(script: Script, shaper: dict[str, Any] | None, directory: Path, seed: int = 0) -> Path:
    """The log of one run."""
    loaded = load_rig("ornl_testbed")
    with LockstepRig(loaded, directory, seed) as rig:
        rig.arm()
        run = rig.stream({"shaper": shaper} if shaper else {})
        rig.until(lambda: rig.mode is Mode.RUNNING)
        held = [rig.value(f"{joint}.reference") for joint in rig.rig.joints]
        content = {"name": "by hand", "kind": "stream"}
        plan = plan_stream(rig.rig, RunRequest(run, content, shaper or default_filter(rig.rig), start_position=held))
        for point in _set_points(script, plan.summary(), run, 1.0 / rig.rig.loop.rate_Hz):
            if point is not None:
                rig.set_points.post(point)
            rig.loop.cycle()
        rig.set_points.post(SetPoint(run, Wanted.END, (), 0.0))
        rig.until(lambda: rig.mode is not Mode.RUNNING)
        rig.disarm()
        return rig.recorder.finished[-1]


def _set_points(script: Script, answer: dict[str, Any], run: int, period_s: float) -> Iterator[SetPoint | None]:
    """Of every cycle, until the arm has rested."""
    steering = Steering(answer, script.tip, script.speed)
    heard, released_s = strokes(script)
    every = round(SET_POINT_S / period_s)
    for cycle in range(round((released_s + RESTING_S) / period_s)):
        now = cycle * period_s
        while heard and heard[0][0] <= now + 1e-9:
            steering.press(heard.pop(0)[1], now)
        if cycle % every:
            yield None
            continue
        motion = steering.motion(now)
        rates = tuple(motion.rates.get(joint, 0.0) for joint in answer["limits"])
        yield SetPoint(run, Wanted.RATE, rates, 0.0) if motion.tip_mps is None else SetPoint(run, Wanted.TIP, motion.tip_mps, 0.0)


def swing(log: Log, released_s: float) -> Swing:
    """Judged from the run's rows."""
    rows = log.columns["mode"] == Mode.RUNNING
    t = log.columns["t_s"][rows] - log.columns["t_s"][rows][0]
    references = np.column_stack([log.columns[f"{joint}.reference"][rows] for joint in log.layout.joint_names])
    rests_s = float(t[np.flatnonzero(np.any(np.diff(references, axis=0) != 0.0, axis=1))[-1] + 1])
    deflection = log.columns["tip.deflection_m"][rows]
    about_rest = 1e3 * np.abs(deflection - np.mean(deflection[t > rests_s + 1.5]))
    after = (t >= rests_s) & (t < rests_s + AFTER_S)
    outside = t[np.flatnonzero(about_rest > 1.0)]
    return Swing(
        float(np.max(about_rest[after])),
        rests_s - released_s,
        float(outside[-1]) - released_s if len(outside) else 0.0,
        float(np.nanmax(np.abs(log.columns["tip.acceleration_mps2"][rows]))),
    )


def filters() -> dict[str, dict[str, Any] | None]:
    both = ["rotary", "prismatic"]
    return {"none": {"kind": "none"}, "adaptive (default)": None, "adaptive_zv": {"kind": "adaptive_zv", "joints": both}}


def main() -> None:
    parser = argparse.ArgumentParser(description="swing after driving by hand, filter by filter")
    parser.add_argument("--picture", type=Path, help="also draw the first script")
    arguments = parser.parse_args()
    print("| keys | filter | swing, mm | reference rests after, s | within 1 mm after, s | largest tip acceleration, m/s² |")
    print("|---|---|--:|--:|--:|--:|")
    logs: dict[str, Log] = {}
    with TemporaryDirectory() as directory:
        for script in SCRIPTS:
            for name, shaper in filters().items():
                log = read_log(driven(script, shaper, Path(directory)))
                logs.setdefault(name, log) if script is SCRIPTS[0] else None
                found = swing(log, strokes(script)[1])
                numbers = (found.swing_mm, found.reference_rests_s, found.within_1mm_s, found.peak_mps2)
                print(f"| {script.name} | {name} | {' | '.join(f'{number:.2f}' for number in numbers)} |", flush=True)
        if arguments.picture:
            draw(logs, strokes(SCRIPTS[0])[1], arguments.picture)


def draw(logs: dict[str, Log], released_s: float, path: Path) -> None:
    """Reference and deflection over time, a line a filter."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 5.0), layout="constrained")
    above, below = figure.subplots(2, 1, sharex=True)
    for name, log in logs.items():
        rows = log.columns["mode"] == Mode.RUNNING
        t = log.columns["t_s"][rows] - log.columns["t_s"][rows][0]
        above.plot(t, np.degrees(log.columns["rotary.reference"][rows]), label=name)
        below.plot(t, 1e3 * log.columns["tip.deflection_m"][rows], label=name)
    for axes, label in ((above, "rotary reference, deg"), (below, "tip deflection, mm")):
        axes.axvline(released_s, color="0.6", linestyle="--", linewidth=1.0)
        axes.set_ylabel(label)
        axes.grid(alpha=0.3)
    above.legend()
    above.set_title(f"{SCRIPTS[0].name}; dashed: the key is let go")
    below.set_xlabel("time, s")
    figure.savefig(path, dpi=100, metadata={"Software": None})


if __name__ == "__main__":
    main()
