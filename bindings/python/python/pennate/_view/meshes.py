"""Meshes of one piece: what is round about an axis, and balls."""

from __future__ import annotations

import numpy as np

from .._look.fields import Array
from .._look.shapes import Integers

Mesh = tuple[Array, Integers]


def across(axes: Array) -> tuple[Array, Array]:
    """Two unit vectors normal to each of some directions and to each other."""
    second = np.cross(axes, np.eye(3)[np.abs(axes).argmin(axis=1)])
    second /= np.maximum(np.linalg.norm(second, axis=1), 1e-12)[:, None]
    return second, np.cross(axes, second)


def circle(sides: int, height: float) -> Array:
    """(sides, 3), a circle of radius 1 at a height."""
    turns = np.linspace(0.0, 2 * np.pi, sides, endpoint=False)
    return np.stack([np.cos(turns), np.sin(turns), np.full(sides, height)], axis=1)


def wall(sides: int) -> Integers:
    """Triangles between one circle and the next."""
    index, after = np.arange(sides), (np.arange(sides) + 1) % sides
    return np.concatenate(
        [np.stack([index, after, sides + after], axis=1), np.stack([index, sides + after, sides + index], axis=1)]
    )


def cap(sides: int, height: float = 0.0, up: bool = True) -> Mesh:
    """A flat disc of radius 1 that faces up or down."""
    index, after = np.arange(sides), (np.arange(sides) + 1) % sides
    points = np.concatenate([circle(sides, height), [[0.0, 0.0, height]]])
    around = (index, after) if up else (after, index)
    return points, np.stack([*around, np.full(sides, sides)], axis=1)


def tube(sides: int) -> Mesh:
    """A cylinder of radius and length 1 about the origin, open at both ends."""
    return np.concatenate([circle(sides, -0.5), circle(sides, 0.5)]), wall(sides)


def rod(sides: int) -> Mesh:
    """The same with its ends, whose corners are sharp."""
    return joined(tube(sides), cap(sides, -0.5, up=False), cap(sides, 0.5))


def cone(sides: int) -> Mesh:
    """A cone of radius and length 1 about the origin whose tip is up."""
    index, after = np.arange(sides), (np.arange(sides) + 1) % sides
    # A tip for each side, so that each is shaded by itself.
    points = np.concatenate([circle(sides, -0.5), np.tile([0.0, 0.0, 0.5], (sides, 1))])
    sloped = np.stack([index, after, sides + index], axis=1)
    return joined((points, sloped), cap(sides, -0.5, up=False))


def joined(*meshes: Mesh) -> Mesh:
    """Several meshes as one."""
    starts = np.cumsum([0, *(len(points) for points, _ in meshes[:-1])])
    faces = [triangles + start for (_, triangles), start in zip(meshes, starts, strict=True)]
    return np.concatenate([points for points, _ in meshes]), np.concatenate(faces)


def ball(rows: int) -> Mesh:
    """A ball of radius 1 with so many rows of faces from pole to pole; without any of twenty faces."""
    if rows == 0:
        return icosahedron()
    sides = 2 * rows
    heights = np.cos(np.linspace(0.0, np.pi, rows + 1)[1:-1])
    rings = [circle(sides, 0.0) * np.sqrt(1.0 - height**2) + [0.0, 0.0, height] for height in heights]
    points = np.concatenate([*rings, [[0.0, 0.0, 1.0], [0.0, 0.0, -1.0]]])
    index, after = np.arange(sides), (np.arange(sides) + 1) % sides
    # Rings go down from the upper pole.
    walls = [wall(sides)[:, ::-1] + sides * ring for ring in range(rows - 2)]
    upper, lower, last = (rows - 1) * sides, (rows - 1) * sides + 1, (rows - 2) * sides
    tops = np.stack([index, after, np.full(sides, upper)], axis=1)
    bottoms = np.stack([last + after, last + index, np.full(sides, lower)], axis=1)
    return points, np.concatenate([tops, *walls, bottoms])


def icosahedron() -> Mesh:
    """Twelve points of a ball of radius 1, and the twenty triangles of neighbours."""
    golden = (1.0 + np.sqrt(5.0)) / 2.0
    base = np.array([[0.0, side, other * golden] for side in (-1.0, 1.0) for other in (-1.0, 1.0)])
    points = np.concatenate([np.roll(base, shift, axis=1) for shift in range(3)])
    near = np.isclose(np.linalg.norm(points[:, None] - points[None], axis=2), 2.0)
    triples = [
        (a, b, c) if np.linalg.det(points[[a, b, c]]) > 0 else (a, c, b)
        for a in range(12)
        for b in range(a)
        for c in range(b)
        if near[a, b] and near[b, c] and near[c, a]
    ]
    return points / np.linalg.norm(points[0]), np.array(triples, dtype=np.int64)
