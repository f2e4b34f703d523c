"""What a run would do, before it is asked for: its plan, its way in the plane, and the vibration its filter leaves. Nothing moves."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from config.errors import DaemonError, LongreachError
from config.loading.load import rig_from_text
from config.schema.rig import Rig
from daemon.live.page.background import Background
from daemon.live.source.connection import ask_once
from daemon.server.start_request import start_run
from servo_control.link.kinematics import forward
from servo_control.planning.run_plan import RunPlan

LIMIT_S = 60.0
PATH_POINTS = 400


class Planning:
    """Asks the daemon at `socket` where the arm is, and plans from there in the background."""

    def __init__(self, socket: str) -> None:
        self._socket = socket
        self._background = Background("planning", LIMIT_S)

    async def plan(self, params: Mapping[str, Any]) -> dict[str, Any]:
        """The plan of a `start` with these parameters from where the arm is held now: its summary, `path` (x and y of the tip in m, empty
        on an arm without one), `vibration` (see `_vibration`). Raises the refusals of `start`."""
        rig, status = await ask_once(self._socket, "rig", {}, 5.0), await ask_once(self._socket, "status", {}, 5.0)
        held = [joint["reference"] if status["mode"] == "holding" else joint["position"] for joint in status["joints"].values()]
        if None in held:
            raise DaemonError("no plan without positions", value=status["mode"], next_step="See `longreach why`.")
        return await self._background.run(planned, rig["text"], dict(params), held)

    def close(self) -> None:
        self._background.close()


def planned(rig_text: str, params: dict[str, Any], held: Sequence[float]) -> dict[str, Any]:
    """The answer of `plan`."""
    rig = rig_from_text(rig_text)
    plan = start_run(rig, 0, params, held).plan
    assert isinstance(plan, RunPlan)  # of a maneuver; a StreamPlan is driven by hand
    return {**plan.summary(), "path": _path(rig, plan), "vibration": _vibration(rig, plan)}


def _path(rig: Rig, plan: RunPlan) -> list[tuple[float, float]]:
    """Where the program takes the rigid arm's tip."""
    if rig.arm.kind != "rotary_prismatic":
        return []
    program = plan.program
    moments = [program.duration_s * number / (PATH_POINTS - 1) for number in range(PATH_POINTS)]
    positions = [program.at(t, program.index_at(t))[0] for t in moments]
    return [forward(rotary, extension, rig.arm.hub_offset_m) for rotary, extension in positions]


def _vibration(rig: Rig, plan: RunPlan) -> list[dict[str, Any]]:
    """Per move with a hold: amplitude of the tip's vibration (m/s²) one second after its end on ideal joints, with the believed frequency
    and the worst within ±10 % of it. Empty where nothing vibrates or no move can be judged."""
    from tuning.shaper_choice.shape_prediction import predicted  # scipy takes a while to load

    try:
        found = predicted(rig, plan)
    except LongreachError:
        return []
    middle = len(found.errors) // 2
    return [
        {"move": move, "nominal_mps2": float(residual[middle]), "worst_mps2": float(max(residual))}
        for move, residual in zip(found.moves, found.residual_mps2, strict=True)
    ]
