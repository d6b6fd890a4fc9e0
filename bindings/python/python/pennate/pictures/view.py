"""The direction of view, and places on paper in the units of the network."""

from __future__ import annotations

import dataclasses
import re

import numpy as np

from .results import Array, PictureError
from .scene import Scene


@dataclasses.dataclass(frozen=True)
class View:
    """A parallel projection: unit vectors to the right and up on paper, and towards the reader."""

    right: Array
    up: Array
    towards: Array

    def flat(self, places: Array) -> Array:
        """Places on paper: to the right and up."""
        return places @ np.stack([self.right, self.up], axis=1)


@dataclasses.dataclass(frozen=True)
class Frame:
    """A rectangle on paper, in the units of the network."""

    low: Array
    high: Array

    @property
    def size(self) -> Array:
        """Width and height."""
        return self.high - self.low

    def grown(self, left: float, right: float, below: float, above: float) -> Frame:
        """The same with margins."""
        return Frame(self.low - np.array([left, below]), self.high + np.array([right, above]))


NAMED = {"xy": (-90.0, 90.0), "xz": (-90.0, 0.0), "yz": (0.0, 0.0), "space": (-52.0, 22.0)}


def view_named(text: str) -> View:
    """A view by its name, or from an azimuth and an elevation in degrees, `"-60,20"`."""
    if text in NAMED:
        return from_angles(*NAMED[text])
    if match := re.fullmatch(r"\s*(-?[\d.]+)\s*,\s*(-?[\d.]+)\s*", text):
        return from_angles(float(match[1]), float(match[2]))
    raise PictureError(
        f"view '{text}': one of {', '.join(NAMED)} expected, or azimuth and elevation in degrees, '-60,20'"
    )


def from_angles(azimuth: float, elevation: float) -> View:
    """Seen from this azimuth, counted from x towards y, and elevation above the plane z = 0, in degrees."""
    turn, rise = np.deg2rad([azimuth, elevation])
    towards = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
    right = np.array([-np.sin(turn), np.cos(turn), 0.0])
    return View(right, np.cross(towards, right), towards)


def frame_of(view: View, scenes: list[Scene]) -> Frame:
    """The rectangle that holds all scenes."""
    low, high = np.full(2, np.inf), np.full(2, -np.inf)
    for scene in scenes:
        places, radii = scene.points()
        flat = view.flat(places)
        low = np.minimum(low, (flat - radii[:, None]).min(axis=0))
        high = np.maximum(high, (flat + radii[:, None]).max(axis=0))
    # A straight line has no height; it gets some. A body has no thickness before it is drawn: one that is a point gets some too.
    thin = np.maximum(0.02 * ((high - low).max() or 1.0) - (high - low), 0.0) / 2
    return Frame(low - thin, high + thin)
