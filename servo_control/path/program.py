"""A program: pieces one after the other, as a function of path time. Pure and stateless; the position on it is kept by Motion."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Sequence
from dataclasses import dataclass

from servo_control.path.pieces import Kind, Piece, Sample

# Path time is cycles × period; a start that is not a multiple of the period in binary must not come one cycle late.
ROUNDING_S = 1e-9


@dataclass(frozen=True, slots=True)
class Segment:
    """One piece's place in the program; `kind` is "move" or "hold". The log stores number = index + 1."""

    name: str
    kind: Kind
    start_s: float
    end_s: float


class Program:
    """Pieces in order. `at` needs no search: the caller keeps the index of the piece it is in."""

    __slots__ = ("_starts", "duration_s", "pieces")

    def __init__(self, pieces: Sequence[Piece]) -> None:
        self.pieces = tuple(pieces)
        self._starts: list[float] = []
        self.duration_s = 0.0
        for piece in self.pieces:
            self._starts.append(self.duration_s)
            self.duration_s += piece.duration_s

    def index_at(self, t: float) -> int:
        """The piece that path time t (≥ 0) lies in."""
        return max(0, bisect_right(self._starts, t + ROUNDING_S) - 1)

    def next_index(self, index: int, t: float) -> int:
        """index_at(t), given that the piece is `index` or a later one."""
        while index + 1 < len(self._starts) and self._starts[index + 1] <= t + ROUNDING_S:
            index += 1
        return index

    def at(self, t: float, index: int) -> Sample:
        """Positions, rates, accelerations and volts at path time t, which lies in piece `index`."""
        piece = self.pieces[index]
        return piece.at(min(max(t - self._starts[index], 0.0), piece.duration_s))

    def segments(self) -> tuple[Segment, ...]:
        return tuple(
            Segment(piece.name, piece.kind, start, start + piece.duration_s) for piece, start in zip(self.pieces, self._starts, strict=True)
        )
