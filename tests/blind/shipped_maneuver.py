"""A shipped maneuver on the hidden machine under the real controller: what an operator does who follows the proposal."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from config.loading.load import load_maneuver
from config.schema.maneuver import maneuver_content
from config.schema.rig import Rig
from servo_control.controller import Controller
from servo_control.planning.planning import plan_run
from servo_control.planning.run_request import RunRequest
from servo_control.signals import Inputs, Mode
from tests.blind.truth.measure import lagged, reading
from tests.blind.truth.nominal import machine
from tests.blind.truth.plant import SIGNALS, advance, at_rest, signals
from tests.blind.truth.references import CENTRE
from tests.blind.truth.session import JITTER, PERIOD_S, SETTLE_S, Setting, numbers_of, sensors_of, temperatures, write_log


def record_shipped(rig: Rig, setting: Setting, maneuver: str, take: int, path: Path) -> None:
    """Run it from CENTRE, approach included, and write the log."""
    draw = np.random.default_rng([setting.seed, 7919, take])
    content = maneuver_content(load_maneuver(maneuver).maneuver)
    plan = plan_run(rig, RunRequest(1, content, start_position=list(CENTRE), approach=True))
    controller = Controller(rig)
    controller.prepare(plan)
    settle = round(SETTLE_S / PERIOD_S)
    rows = settle + round(plan.duration_s / PERIOD_S)
    starts = PERIOD_S * np.arange(rows + 1) + JITTER * PERIOD_S * draw.standard_normal(rows + 1)
    oil = temperatures(rows, draw, setting.jitter)
    readings, commands, asked = _driven(rig, setting, controller, settle, np.diff(starts), oil, draw)
    write_log(path, setting, starts[settle:-1] - starts[settle], readings[settle:], commands[settle:], asked[settle:], oil[settle:])


def _driven(
    rig: Rig, setting: Setting, controller: Controller, settle: int, periods: np.ndarray, oil: np.ndarray, draw: np.random.Generator
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Readings, commands and references of every cycle."""
    m = machine(numbers_of(rig, setting))
    sensors = sensors_of(rig, setting, np.random.default_rng([setting.seed, 104729]))
    rows = len(periods)
    readings, commands, asked = np.zeros((rows, SIGNALS)), np.zeros((rows, 2)), np.zeros((rows, 4))
    history, true, noise = np.zeros((rows, SIGNALS)), np.zeros(SIGNALS), np.zeros(SIGNALS)
    y, play, t = at_rest(m, CENTRE), np.array([m.rotary.null, m.prismatic.null]), 0.0
    white = draw.standard_normal((rows, SIGNALS))
    for k in range(rows):
        signals(y, t, y[[16, 18]], oil[k], m, true)
        lagged(history, k, periods[k], true, sensors)
        reading(history, k, periods[k], white[k], noise, sensors, readings[k])
        mode = Mode.HOLDING if k < settle else Mode.RUNNING
        run = 0 if k < settle else 1
        outputs = controller.step(Inputs(k, mode, run, (readings[k, 0], readings[k, 1]), readings[k, 7], readings[k, 6]))
        for n, joint in enumerate(outputs.joints):
            commands[k, n] = joint.command_V
            asked[k, 2 * n : 2 * n + 2] = joint.reference, joint.reference_rate
        advance(y, play, commands, k, t, periods[k], oil[k], m)
        t += periods[k]
    return readings, commands, asked
