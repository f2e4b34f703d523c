"""A maneuver on a simulated rig under the real controller, as a log in memory: what a rival model would have measured."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from config.loading.load import load_maneuver
from config.schema.maneuver import maneuver_content
from config.schema.rig import Rig
from gap.data.measured import Array, Measured, field_of, on_grid
from gap.maneuvers.envelope import check_envelope
from servo_control.controller import Controller
from servo_control.planning.planning import plan_run
from servo_control.planning.run_plan import RunPlan
from servo_control.planning.run_request import RunRequest
from servo_control.signals import Inputs, Mode, Outputs
from sim_backend.kernel.batch import quiet
from sim_backend.memory.layout import S
from sim_backend.plant import SimulatedRig

_HOLD_S = 0.5  # at rest before the run


@dataclass(frozen=True, slots=True)
class ClosedLoop:
    """One simulated run at every cycle: sensors without noise, commands, and following errors (rows × joints)."""

    signals: Mapping[str, Array]
    commands_V: Array
    following_error: Array
    running: int  # rows of the run itself, at the end


def measured_on(rig: Rig, maneuver: str | Mapping[str, Any], plan: RunPlan | None = None) -> Measured:
    """Run a maneuver (name of a shipped one, a file, or its content) and return what sensors without noise would have logged. `plan`: its
    run on this rig, where that has been planned already.

    ManeuverError when the rig's limits do not allow it or the run would come near an interlock.
    """
    content, name = _content(maneuver)
    simulated = _quiet_rig(rig)
    run = closed_loop(rig, simulated, plan or planned(rig, content, simulated.true_position))
    errors = {joint: float(np.max(np.abs(run.following_error[:, k]))) for k, joint in enumerate(rig.joints)}
    check_envelope(rig, run.signals, errors, name)
    columns = {field_of(name)[0]: values for name, values in run.signals.items()}
    columns |= {f"{joint}.command_V": run.commands_V[:, k] for k, joint in enumerate(rig.joints)}
    columns |= {"t_s": np.arange(len(run.commands_V)) / rig.loop.rate_Hz}
    return on_grid(Path(name), columns, rig, "")


def planned(rig: Rig, maneuver: str | Mapping[str, Any], position: list[float] | None = None) -> RunPlan:
    """The run, with an approach from `position` (default: where the simulated rig stands at first). ManeuverError as plan_run."""
    content, _ = _content(maneuver)
    here = position or _quiet_rig(rig).true_position
    return plan_run(rig, RunRequest(1, content, start_position=list(here), approach=True))


def closed_loop(rig: Rig, simulated: SimulatedRig, plan: RunPlan, longest_s: float = float("inf")) -> ClosedLoop:
    """Hold, then the run (`longest_s` of it at most), with the controller the daemon uses."""
    controller, period = Controller(rig), 1.0 / rig.loop.rate_Hz
    controller.prepare(plan)
    resolutions = np.array(
        [simulated.parameters.values[simulated.parameters.offset(S.RESOLUTION, f"sensor:{n}")] for n in simulated.channels]
    )
    places = [simulated.channels.index(f"{joint}.position") for joint in rig.joints]
    tip = [simulated.channels.index(name) if name in simulated.channels else -1 for name in ("tip.deflection", "tip.acceleration")]
    rows, commands, errors = [], [], []
    running = round(min(plan.duration_s, longest_s) / period)
    for cycle, mode in _modes(round(_HOLD_S / period), running):
        reading = np.array(simulated.sense()) * resolutions
        position = tuple(float(reading[k]) for k in places)
        deflection, acceleration = (float(reading[k]) if k >= 0 else float("nan") for k in tip)
        outputs: Outputs = controller.step(Inputs(cycle, mode, plan.run if mode is Mode.RUNNING else 0, position, deflection, acceleration))
        command = [joint.command_V for joint in outputs.joints]
        rows.append(reading)
        commands.append(command)
        errors.append([joint.reference - here for joint, here in zip(outputs.joints, position, strict=True)])
        simulated.advance(command, period)
    table = np.array(rows)
    signals = {name: table[:, k] for k, name in enumerate(simulated.channels)}
    return ClosedLoop(signals, np.array(commands), np.array(errors), running)


def _modes(holding: int, running: int) -> Iterator[tuple[int, Mode]]:
    for cycle in range(holding + running):
        yield cycle, Mode.HOLDING if cycle < holding else Mode.RUNNING


def _quiet_rig(rig: Rig) -> SimulatedRig:
    simulated = SimulatedRig(rig)
    simulated.parameters.values[:] = quiet(simulated.parameters)
    simulated.reset()
    return simulated


def _content(maneuver: str | Mapping[str, Any]) -> tuple[dict[str, Any], str]:
    if isinstance(maneuver, str):
        return maneuver_content(load_maneuver(maneuver).maneuver), maneuver
    return dict(maneuver), str(maneuver.get("name", "maneuver"))
