"""Every move of a program gets its corrected time law; holds and excitations stay as they are."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from config.errors import ManeuverError
from config.schema.rig import Rig
from servo_control.path.pieces import JointMove, LineMove, Piece, Vector
from servo_control.path.trajectory import Trapezoid
from servo_control.shapers.shaper_choice import WHERE, ShaperChoice
from servo_control.shapers.zero_delay import FINENESS, corrected


def correct_moves(pieces: Sequence[Piece], rig: Rig, choice: ShaperChoice, planning: int) -> None:
    """Exchange the time law of every move. `planning`: see `RunRequest`.

    Raises ManeuverError on an arm without a link, and for what this kind cannot do.
    """
    names = list(rig.joints)
    if rig.link_mode is None or "rotary" not in names or "prismatic" not in names:
        raise ManeuverError(
            "zero_delay needs `link_mode` in the rig file and the joints rotary and prismatic",
            value=choice.kind,
            where=WHERE,
            next_step="Use a fixed filter, and give its frequency in Hz with --focal.",
        )
    if choice.joints and len(choice.joints) < len(names):
        raise ManeuverError(
            "zero_delay corrects when the arm is where on its path, so it always moves all joints",
            value=", ".join(choice.joints),
            limit=", ".join(names),
            where=WHERE,
            next_step="Leave out `joints`.",
        )
    rotary, prismatic = names.index("rotary"), names.index("prismatic")
    for piece in pieces:
        if isinstance(piece, LineMove | JointMove) and isinstance(piece.path, Trapezoid) and _turns(piece, rotary):
            joints = partial(_pair, piece.place, rotary, prismatic)
            scale, share = choice.frequency_scale, choice.frequency_range
            piece.path = corrected(piece.path, joints, rig.link_mode, scale, share, FINENESS[planning])


def _turns(piece: LineMove | JointMove, rotary: int) -> bool:
    """A move of the other joints alone does not bend the link."""
    return piece.path.distance != 0.0 and piece.place(0.0)[rotary] != piece.place(0.5 * piece.path.distance)[rotary]


def _pair(place: Callable[[float], Vector], rotary: int, prismatic: int, s: float) -> tuple[float, float]:
    position = place(s)
    return position[rotary], position[prismatic]
