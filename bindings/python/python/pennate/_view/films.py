"""Motions that are drawn and not computed: the snap from one equilibrium to another, and the mode in which a state gives way."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator
from typing import Any

import numpy as np

from .._errors import Error
from .._look import carry, fields
from .._look.fields import Array
from .follow import Follow, Now

# Seconds, and pictures a second.
SNAP, MODE, RATE = 0.6, 2.4, 25.0
# A mode moves what it moves most by this part of the size of the network.
REACH = 0.06
# The part of a mode that stands for an infinitesimal one.
SMALL = 1e-3

Drawing = dict[str, Any]


class NothingToShow(Exception):
    """There is no mode, and why; `good` where that is no mistake."""

    def __init__(self, sentences: list[str], kind: str) -> None:
        super().__init__(" ".join(sentences))
        self.sentences, self.kind = sentences, kind


def snap(drawing: Drawing, follow: Follow, before: Now, after: Now) -> Iterator[Drawing]:
    """From one equilibrium to another, nodes on straight lines, slow at both ends."""
    if before.displacement is None or after.displacement is None or before.turn is None:
        return
    whole = after.turn @ np.swapaxes(before.turn, 1, 2) if after.turn is not None else before.turn
    vectors = rotation_vectors(whole)
    for frame in np.linspace(0.0, 1.0, round(SNAP * RATE))[1:]:
        part = float(frame * frame * (3.0 - 2.0 * frame))
        between = (1.0 - part) * before.displacement + part * after.displacement
        yield carry.carried(drawing, follow.joined, between, carry.rotations(part * vectors))


@dataclasses.dataclass(frozen=True)
class Mode:
    """The motion of nodes in which a state is softest, and by which factor of its loads it would give way in it."""

    motion: Array
    turns: Array
    factor: float
    # Whether the factor is one of the ramp of a step that did not reach its end, and not of all loads.
    of_step: bool

    def words(self) -> str:
        """What is seen."""
        factor = fields.number(self.factor, 4)
        of = "the ramp of the step" if self.of_step else "all loads of this state"
        return (
            f"How it gives way: it would at {factor} times {of}, by linear buckling about it. "
            "The size of the motion is arbitrary."
        )

    def moved(self, drawing: Drawing, follow: Follow, part: float) -> Drawing:
        """The drawing with so much of the mode."""
        at = drawing["point_data"]["displacement"][: len(self.motion)]
        return carry.carried(drawing, follow.joined, at + part * self.motion, carry.rotations(part * self.turns))

    def frames(self, drawing: Drawing, follow: Follow, size: float) -> Iterator[Drawing]:
        """Back and forth, in a network of some size."""
        small = self.moved(drawing, follow, SMALL)["point_data"]["displacement"]
        largest = float(np.linalg.norm(small - drawing["point_data"]["displacement"], axis=1).max()) / SMALL
        if largest == 0.0 or size == 0.0:
            raise NothingToShow(["The mode lies within a member and moves no node: it cannot be shown here."], "wait")
        reach = REACH * size / largest
        for frame in np.linspace(0.0, 1.0, round(MODE * RATE)):
            yield self.moved(drawing, follow, reach * float(np.sin(4 * np.pi * frame)))


def softest(follow: Follow, values: dict[str, float]) -> Mode:
    """The mode of a state by linear buckling about it."""
    try:
        about = follow.network.set(**values)
        found = (
            about.buckle(1, step=about.steps[-1])
            if follow.live is not None
            else about.buckle(1, along=broken(follow))
        )
    except Error as error:
        raise NothingToShow(["There is no mode to show:", *str(error).splitlines()], "bad") from error
    if not len(found):
        raise NothingToShow(
            ["No factor of the loads makes it lose its stability, as far as linear buckling can say."], "good"
        )
    shape = found.shapes[0][: len(follow.network.nodes)]
    return Mode(shape[:, :3], shape[:, 3:], float(found.factor[0]), follow.live is None)


def broken(follow: Follow) -> str | None:
    """The step that did not reach its end."""
    if follow.solution is None:
        return None
    return next(
        (step for index, step in enumerate(follow.solution.steps) if follow.solution.fraction[index] < 1.0), None
    )


def rotation_vectors(matrices: Array) -> Array:
    """(n, 3), the rotation vectors of some rotations, of norm at most π."""
    cosine = np.clip((np.trace(matrices, axis1=1, axis2=2) - 1.0) / 2.0, -1.0, 1.0)
    angle = np.arccos(cosine)
    skew = matrices - np.swapaxes(matrices, 1, 2)
    axis = np.stack([skew[:, 2, 1], skew[:, 0, 2], skew[:, 1, 0]], axis=1) / 2.0
    sine = np.linalg.norm(axis, axis=1)
    return np.asarray(axis * np.where(sine > 1e-9, angle / np.maximum(sine, 1e-9), 1.0)[:, None])
