"""Every move of a program gets ramps without corners and keeps its duration; holds and excitations stay as they are.

A filter of half a cycle forgives little: of a frequency believed 20 % too high it leaves 31 %. Smooth ramps give it little
in the first place, whatever the frequency is: as long as 1.3 times the speed allows they last two cycles of the testbed's link.
"""

from __future__ import annotations

from collections.abc import Sequence

from servo_control.path.pieces import JointMove, LineMove, Piece
from servo_control.path.trajectory import Trapezoid, smoothed

FASTER = 1.3  # how much higher a speed the ramps may need; another value is another planning (`RunRequest`)


def smooth_moves(pieces: Sequence[Piece]) -> None:
    """Exchange the time law of every move; a move too short for smooth ramps keeps its own."""
    for piece in pieces:
        if isinstance(piece, LineMove | JointMove) and isinstance(piece.path, Trapezoid) and piece.path.distance != 0.0:
            piece.path = smoothed(piece.path, FASTER)
