"""How finely a network is drawn: the more there is of it, the smaller each piece is on the screen.

Without a GPU a frame takes some 45 ms of a processor for the page alone, and one microsecond more for each triangle. The detail
is that of the network as it was read and stays, so that only points have to be sent as it moves.
"""

from __future__ import annotations

import dataclasses

from .._look import shapes
from .._look.shapes import Drawing, Integers

# Networks of more lines than this are drawn more coarsely: each piece is small on the screen.
MANY = 400
# Straight pieces that all members together are made of, where that is smooth enough, and in a network of many lines.
PIECES, COARSE = 150, 1100
# What is straight as it is read may bend later.
LEAST, MOST = 1, 4


@dataclasses.dataclass(frozen=True)
class Detail:
    """Of tubes: straight pieces of a line, or lines of a straight piece, and sides; of balls: rows of faces, 0 for twenty faces."""

    parts: int
    lines: int
    sides: int
    rows: int
    ghost_sides: int
    # Shades of colour, each of which is a mesh of its own.
    shades: int

    def runs(self, drawing: Drawing) -> Integers:
        """The lines of each piece."""
        return shapes.runs(drawing, self.lines)


def detail_of(drawing: Drawing) -> Detail:
    """The detail for a network."""
    count = max(len(drawing["lines"]), 1)
    if count > MANY:
        return Detail(1, -(-count // COARSE), 6, 0, 5, 16)
    parts = max(shapes.smooth(drawing), min(max(PIECES // count, LEAST), MOST))
    return Detail(parts, 1, 24 if count < 40 else 16, 8, 12 if count < 40 else 8, 32)
