"""A maneuver on a simulated rig under the real controller, as a log in memory: what a rival model would have measured."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from config.load import load_maneuver
from config.maneuver import maneuver_content
from config.rig import Rig
from control.controller import Controller
from control.planning import plan_run
from control.run_request import RunRequest
from control.signals import Inputs, Mode
from gap.measured import Measured, field_of, on_grid
from sim_backend.batch import quiet
from sim_backend.layout import S
from sim_backend.plant import SimulatedRig

_HOLD_S = 0.5  # at rest before the run


def measured_on(rig: Rig, maneuver: str) -> Measured:
    """Run a shipped maneuver (or a file) and return what sensors without noise would have logged.

    ManeuverError when the rig does not allow it.
    """
    simulated, controller = SimulatedRig(rig), Controller(rig)
    simulated.parameters.values[:] = quiet(simulated.parameters)
    simulated.reset()
    content = maneuver_content(load_maneuver(maneuver).maneuver)
    request = RunRequest(1, content, start_position=list(simulated.true_position), approach=True)
    plan = plan_run(rig, request)
    controller.prepare(plan)
    period = 1.0 / rig.loop.rate_Hz
    resolutions = np.array(
        [simulated.parameters.values[simulated.parameters.offset(S.RESOLUTION, f"sensor:{n}")] for n in simulated.channels]
    )
    places = [simulated.channels.index(f"{joint}.position") for joint in rig.joints]
    tip = [simulated.channels.index(name) if name in simulated.channels else -1 for name in ("tip.deflection", "tip.acceleration")]
    rows, commands = [], []
    holding = round(_HOLD_S / period)
    for cycle in range(holding + round(plan.duration_s / period)):
        reading = np.array(simulated.sense()) * resolutions
        mode = Mode.HOLDING if cycle < holding else Mode.RUNNING
        run = 1 if mode is Mode.RUNNING else 0
        position = tuple(float(reading[k]) for k in places)
        deflection, acceleration = (float(reading[k]) if k >= 0 else float("nan") for k in tip)
        outputs = controller.step(Inputs(cycle, mode, run, position, deflection, acceleration))
        command = [joint.command_V for joint in outputs.joints]
        rows.append(reading)
        commands.append(command)
        simulated.advance(command, period)
    table = np.array(rows)
    columns = {field_of(name)[0]: table[:, k] for k, name in enumerate(simulated.channels)}
    columns |= {f"{joint}.command_V": np.array(commands)[:, k] for k, joint in enumerate(rig.joints)}
    columns |= {"t_s": period * np.arange(len(table))}
    return on_grid(Path(maneuver), columns, rig, "")
