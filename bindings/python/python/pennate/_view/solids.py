"""Solids that move: many copies of a few meshes, sent as one mesh of each colour."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np
import numpy.typing as npt
import viser

from .._look.fields import Array, Bytes
from .._look.shapes import Integers
from .meshes import Mesh, across


@dataclasses.dataclass
class Instances:
    """Copies of one mesh: (n, 3) places, (n, 3) directions of its third axis, (n, 3) sizes, (n, 3) colours."""

    place: list[Array] = dataclasses.field(default_factory=list)
    axis: list[Array] = dataclasses.field(default_factory=list)
    size: list[Array] = dataclasses.field(default_factory=list)
    colour: list[Bytes] = dataclasses.field(default_factory=list)

    def add(self, place: Array, axis: Array, size: Array, colour: npt.ArrayLike) -> None:
        """More of them."""
        count = len(place)
        self.place.append(place)
        self.axis.append(np.broadcast_to(axis, (count, 3)))
        self.size.append(np.broadcast_to(size, (count, 3)))
        self.colour.append(np.broadcast_to(np.asarray(colour, dtype=np.uint8), (count, 3)))

    def between(self, start: Array, end: Array, radius: npt.ArrayLike, colour: npt.ArrayLike) -> None:
        """Pieces from one place to another."""
        along = end - start
        length = np.linalg.norm(along, axis=1)
        wide = np.broadcast_to(np.asarray(radius, dtype=np.float64), length.shape)
        axis = along / np.where(length > 0, length, 1.0)[:, None]
        self.add((start + end) / 2, axis, np.stack([wide, wide, length], axis=1), colour)

    def bodies(self, mesh: Mesh) -> tuple[Array, Integers]:
        """(n, points, 3), the points of every copy of a mesh, and (n,) its colour as one number."""
        if not sum(map(len, self.place)):
            return np.zeros((0, len(mesh[0]), 3)), np.zeros(0, dtype=np.int64)
        place, axis, size = (np.concatenate(each) for each in (self.place, self.axis, self.size))
        colour = np.concatenate(self.colour)
        second, third = across(axis)
        x, y, z = mesh[0].T
        points = (
            place[:, None]
            + (x * size[:, :1])[:, :, None] * second[:, None]
            + (y * size[:, 1:2])[:, :, None] * third[:, None]
            + (z * size[:, 2:])[:, :, None] * axis[:, None]
        )
        return points, colour.astype(np.int64) @ np.array([65536, 256, 1])


@dataclasses.dataclass
class Sent:
    """A node of the scene, and what was sent of it."""

    node: Any
    vertices: npt.NDArray[np.float32]
    faces: npt.NDArray[np.uint32]
    colour: int


class Solids:
    """All that moves, as one mesh a colour: viser has no colours of points that move.

    Copies of one mesh would need less data, but without a GPU each frame of them takes twice as long.
    """

    def __init__(self, server: viser.ViserServer) -> None:
        self.server = server
        self.sent: list[Sent] = []

    def show(self, parts: list[tuple[Mesh, Instances]]) -> None:
        """Sends what is different from before."""
        groups: dict[int, list[tuple[Array, Integers]]] = {}
        for mesh, instances in parts:
            points, colours = instances.bodies(mesh)
            for colour in np.unique(colours).tolist():
                own = points[colours == colour]
                shifts = len(mesh[0]) * np.arange(len(own))[:, None, None]
                groups.setdefault(colour, []).append((own.reshape(-1, 3), (mesh[1] + shifts).reshape(-1, 3)))
        free = [each for each in self.sent if each.colour not in groups]
        known = {each.colour: each for each in self.sent}
        for colour, found in groups.items():
            starts = np.cumsum([0, *(len(points) for points, _ in found)])
            vertices = np.concatenate([points for points, _ in found]).astype(np.float32)
            faces = np.concatenate([mesh + start for (_, mesh), start in zip(found, starts)]).astype(np.uint32)
            old = known.get(colour) or (free.pop() if free else None)
            if old is None:
                self._add(colour, vertices, faces)
            else:
                self._change(old, colour, vertices, faces)
        for each in free:
            if each.node.visible:
                each.node.visible = False

    def _add(self, colour: int, vertices: npt.NDArray[np.float32], faces: npt.NDArray[np.uint32]) -> None:
        node = self.server.scene.add_mesh_simple(
            f"/network/{len(self.sent)}",
            vertices,
            faces,
            color=rgb(colour),
            side="double",
            cast_shadow=False,
            receive_shadow=False,
        )
        self.sent.append(Sent(node, vertices, faces, colour))

    @staticmethod
    def _change(old: Sent, colour: int, vertices: npt.NDArray[np.float32], faces: npt.NDArray[np.uint32]) -> None:
        if colour != old.colour:
            old.node.color, old.colour = rgb(colour), colour
        if not np.array_equal(vertices, old.vertices):
            old.node.vertices, old.vertices = vertices, vertices
        if not np.array_equal(faces, old.faces):
            old.node.faces, old.faces = faces, faces
        if not old.node.visible:
            old.node.visible = True

    def remove(self) -> None:
        """Takes all of it away."""
        for each in self.sent:
            each.node.remove()
        self.sent = []


def rgb(colour: int) -> tuple[int, int, int]:
    """Red, green and blue of a colour that is one number."""
    return colour >> 16, colour >> 8 & 255, colour & 255
