"""Repeating a program: pass after pass, with a slow way back to its start where it does not end there itself."""

from __future__ import annotations

import copy
from collections.abc import Sequence

from servo_control.path.joint_limits import SLOW_SHARE, JointLimits
from servo_control.path.pieces import JointMove, Piece

SAME_PLACE = 1e-9  # rad or m


def repeated(pieces: Sequence[Piece], passes: int, joints: Sequence[JointLimits]) -> list[Piece]:
    """The pieces of all passes; from the second on their names carry the number of the pass."""
    if passes == 1:
        return list(pieces)
    start = pieces[0].at(0.0)[0]
    end = pieces[-1].at(pieces[-1].duration_s)[0]
    one_pass = list(pieces)
    if any(abs(a - b) > SAME_PLACE for a, b in zip(start, end, strict=True)):
        speeds = tuple(SLOW_SHARE * joint.rate for joint in joints)
        one_pass.append(JointMove("return", end, start, speeds, tuple(SLOW_SHARE * joint.acceleration for joint in joints)))
    return one_pass + [_renamed(piece, number) for number in range(2, passes + 1) for piece in one_pass]


def _renamed(piece: Piece, number: int) -> Piece:
    same = copy.copy(piece)
    same.name = f"{piece.name}, pass {number}"
    return same
