"""Finds places for names, where they cover neither the network nor each other."""

from __future__ import annotations

import dataclasses

import numpy as np
import numpy.typing as npt

from .results import Array

Mask = npt.NDArray[np.bool_]

# Distances from what is named that are tried, in points beyond the nearest possible one.
DISTANCES = (0.0, 4.0, 9.0, 15.0, 22.0)
DIRECTIONS = 24
# From this distance on a line leads from the name to what it names.
LEADER = 8.0
# Free space around a name, in points.
GAP = 2.0


@dataclasses.dataclass(frozen=True)
class Wish:
    """A name that wants a place: what it names is a disc on paper, in pixels from the lower left."""

    text: str
    style: str
    anchor: Array
    radius: float
    # Width and height of the text, in pixels.
    size: Array
    # The direction in which it would stand best; zero if all are alike.
    towards: Array
    # Whether it has to be there even if it covers something.
    needed: bool


@dataclasses.dataclass(frozen=True)
class Place:
    """Where a name stands: its centre in pixels, and whether it needs a line to what it names."""

    wish: Wish
    centre: Array
    leader: bool

    @property
    def line(self) -> tuple[Array, Array]:
        """From the rim of what is named to the text."""
        to = self.wish.anchor - self.centre
        # The text ends where the line crosses its box.
        inside = np.max(np.abs(to) / (self.wish.size / 2 + 1.0))
        start = self.centre + to / max(float(inside), 1.0)
        far = float(np.linalg.norm(to))
        return start, self.wish.anchor - to / far * min(self.wish.radius, far)


class Paper:
    """What is covered already, with sums over rectangles at the cost of four look-ups."""

    def __init__(self, covered: Mask) -> None:
        self.covered = covered.copy()
        self.add_up()

    def add_up(self) -> None:
        """Sums from the lower left corner."""
        self.sums = np.zeros((self.covered.shape[0] + 1, self.covered.shape[1] + 1))
        self.sums[1:, 1:] = self.covered.cumsum(axis=0).cumsum(axis=1)

    def share(self, low: Array, high: Array) -> float:
        """The part of a rectangle that is covered; everything beyond the paper counts as covered."""
        limits = np.array(self.covered.shape[::-1])
        (left, below), (right, above) = np.floor(low).astype(int), np.ceil(high).astype(int)
        area = int(max((right - left) * (above - below), 1))
        if left < 0 or below < 0 or right > limits[0] or above > limits[1]:
            return 1.0
        sums = self.sums
        inside = sums[above, right] - sums[below, right] - sums[above, left] + sums[below, left]
        return float(inside) / float(area)

    def cover(self, low: Array, high: Array) -> None:
        """Nothing else may stand here."""
        (left, below), (right, above) = np.maximum(np.floor(low), 0).astype(int), np.ceil(high).astype(int)
        self.covered[below:above, left:right] = True
        self.add_up()


def place_all(wishes: list[Wish], covered: Mask, shaded: Mask, points: float) -> list[Place]:
    """Places for as many names as fit, the needed ones first; `points` is the number of pixels in a point.

    Texts do not stand on what is covered, and rather not on what is shaded.
    """
    paper, pale = Paper(covered), Paper(shaded)
    places = []
    for wish in sorted(wishes, key=lambda wish: not wish.needed):
        place = best(wish, paper, pale, points)
        if place is not None:
            gap = GAP * points
            paper.cover(place.centre - wish.size / 2 - gap, place.centre + wish.size / 2 + gap)
            places.append(place)
    return places


def best(wish: Wish, paper: Paper, pale: Paper, points: float) -> Place | None:
    """The cheapest place: near, in the wished direction, covering nothing."""
    found: tuple[float, Place] | None = None
    gap = GAP * points
    for distance in DISTANCES:
        for angle in np.linspace(0.0, 2 * np.pi, DIRECTIONS, endpoint=False):
            direction = np.array([np.cos(angle), np.sin(angle)])
            centre = wish.anchor + direction * (wish.radius + gap + distance * points) + edge(direction, wish.size)
            low, high = centre - wish.size / 2 - 0.5 * gap, centre + wish.size / 2 + 0.5 * gap
            covered = paper.share(low, high)
            if covered > 0 and not wish.needed:
                continue
            cost = (
                1000.0 * covered
                + 4.0 * pale.share(low, high)
                + distance
                + 5.0 * (1.0 - float(direction @ wish.towards))
            )
            if found is None or cost < found[0]:
                found = cost, Place(wish, centre, distance >= LEADER)
    return found[1] if found else None


def edge(direction: Array, size: Array) -> Array:
    """From the point of a text that is nearest to what it names to its centre."""
    half = size / 2
    return np.array([half[0] * np.clip(1.4 * direction[0], -1, 1), half[1] * np.clip(1.4 * direction[1], -1, 1)])
