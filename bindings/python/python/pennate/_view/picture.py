"""The network in space, as nodes of viser's scene: few of them, whose points move.

Lengths are divided by half the size of the network when it was read, so that the camera finds everything as large as it expects.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
import viser

from .._look import fields, shapes
from .._look.fields import Array, Bytes, Scale
from .._look.shapes import Integers
from .detail import Detail, detail_of
from .meshes import Mesh, across, ball, cap, cone, rod, tube
from .solids import Instances, Solids

GROUND, BODY, JOINT, GHOST = (163, 172, 182), (102, 117, 138), (158, 168, 180), (170, 179, 191)
HELD_BY = (190, 115, 13)
LOADS = {"force": (11, 122, 59), "moment": (122, 64, 158), "held by": HELD_BY, "held by moment": HELD_BY}
# Names are shown of networks of so many nodes; of more they would be a thicket.
NAMED = 60
# The thinnest tube that is seen, in parts of the size.
THIN = 0.0012

# A direction for what is round.
UP = np.array([0.0, 0.0, 1.0])


class Picture:
    """The network as it is seen."""

    def __init__(
        self, server: viser.ViserServer, nodes: tuple[str, ...], members: tuple[str, ...], joined: Integers, plane: bool
    ):
        self.server, self.nodes, self.members, self.joined, self.plane = server, nodes, members, joined, plane
        self.whole: shapes.Extent | None = None
        self.solids = Solids(server)
        self.meshes: dict[str, Mesh] = {}
        self.ghost: Any = None
        self.ghost_of: Array | None = None
        self.names: list[Any] = []
        self.detail: Detail | None = None
        self.with_ghost, self.with_names, self.with_loads = True, len(nodes) <= 12, True
        self.tubes: shapes.Cylinders | None = None

    def begin(self, drawing: Mapping[str, Any], unloaded: Mapping[str, Any]) -> None:
        """Fixes the size, and places the camera for whoever comes."""
        self.whole = shapes.extent(drawing, unloaded)
        self.detail = detail = detail_of(drawing)
        self.meshes = {
            "tube": tube(detail.sides),
            "cap": cap(detail.sides),
            "ball": ball(detail.rows),
            "rod": rod(detail.sides),
            "cone": cone(12),
        }
        self._light()
        camera = self.server.initial_camera
        self.server.scene.set_up_direction("+y" if self.plane else "+z")
        towards = np.array([0.0, 0.0, 1.0]) if self.plane else np.array([0.55, -0.75, 0.42])
        camera.fov, camera.near, camera.far = 0.6, 0.01, 200.0
        camera.position = 4.2 * towards / np.linalg.norm(towards)
        camera.look_at = (0.0, 0.0, 0.0)

    def _light(self) -> None:
        """Two plain lights: viser's own, shadows and an image all around, take three times as long without a GPU."""
        scene = self.server.scene
        scene.configure_environment_map(None)
        scene.configure_default_lights(False, cast_shadow=False)
        overhead = (0.0, 1.0, 0.4) if self.plane else (-0.4, -0.5, 1.0)
        scene.add_light_hemisphere("/light", sky_color=(255, 255, 255), ground_color=(178, 184, 196), intensity=2.3)
        scene.add_light_directional("/sun", intensity=1.9, position=tuple(5.0 * np.array(overhead)), cast_shadow=False)

    @property
    def size(self) -> float:
        """Of the network when it was read; zero before it was seen."""
        return self.whole.size if self.whole is not None else 0.0

    def scaled(self, places: Array) -> Array:
        """Places of the network in those of the scene."""
        assert self.whole is not None
        return np.asarray((places - self.whole.centre) * self.factor)

    @property
    def factor(self) -> float:
        """Lengths of the scene over those of the network."""
        assert self.whole is not None
        return 2.0 / self.whole.size

    def show(self, drawing: Mapping[str, Any], unloaded: Mapping[str, Any], values: Array, scale: Scale) -> None:
        """Shows a state; `values` has one entry a line."""
        if self.whole is None:
            self.begin(drawing, unloaded)
        assert self.detail is not None
        colours = Colours(scale, self.detail.shades)
        rest, tips = self._rest(drawing, unloaded)
        parts = [
            (self.meshes["tube"], self._members(drawing, values, colours)),
            (self.meshes["ball"], self._joints(drawing, values, colours)),
            (self.meshes["cap"], self._shoulders(drawing, values, colours)),
            (self.meshes["rod"], rest),
            (self.meshes["cone"], tips),
        ]
        with self.server.atomic():
            self.solids.show(parts)
            self._ghost(unloaded)
            self._names(drawing)
        self.server.flush()

    def _members(self, drawing: Mapping[str, Any], values: Array, colours: Colours) -> Instances:
        assert self.detail is not None
        self.tubes = tubes = shapes.tubes(drawing, self.detail.parts, self.detail.runs(drawing))
        found = Instances()
        radius = np.maximum(tubes.radius * self.factor, 2 * THIN)
        found.between(self.scaled(tubes.start), self.scaled(tubes.end), radius, colours(values[tubes.line]))
        return found

    def _joints(self, drawing: Mapping[str, Any], values: Array, colours: Colours) -> Instances:
        places, radii, nodes = shapes.balls(drawing, self.joined, len(self.nodes))
        found = Instances()
        size = np.maximum(radii * self.factor, 2 * THIN)[:, None] * np.ones(3)
        found.add(self.scaled(places), UP, size, self._joint_colours(drawing, values, colours, nodes))
        return found

    def _shoulders(self, drawing: Mapping[str, Any], values: Array, colours: Colours) -> Instances:
        """Discs that close tubes where a section ends."""
        places, axes, radii, lines = shapes.shoulders(drawing, self.joined, len(self.nodes))
        found = Instances()
        radius = np.maximum(radii * self.factor, 2 * THIN)
        size = np.stack([radius, radius, np.full(len(radius), 1e-4)], axis=1)
        found.add(self.scaled(places), axes, size, colours(values[lines]))
        return found

    def _joint_colours(self, drawing: Mapping[str, Any], values: Array, colours: Colours, nodes: Integers) -> Bytes:
        """The mean of the members that end at a node, or the colour of joints where none does."""
        ids, kinds = drawing["cell_data"]["member_id"], drawing["cell_data"]["kind"]
        own = np.flatnonzero(kinds != shapes.RIGID)
        ends = np.zeros((len(self.members), 2), dtype=np.int64)
        ends[ids[own[::-1]], 0], ends[ids[own], 1] = own[::-1], own
        total, count = np.zeros(len(self.nodes)), np.zeros(len(self.nodes))
        for side in (0, 1):
            np.add.at(total, self.joined[:, side], values[ends[:, side]])
            np.add.at(count, self.joined[:, side], 1.0)
        found = colours((total / np.maximum(count, 1.0))[nodes])
        found[count[nodes] == 0] = JOINT
        return found

    def _rest(self, drawing: Mapping[str, Any], unloaded: Mapping[str, Any]) -> tuple[Instances, Instances]:
        """Bodies, supports and loads: what is round, and what is a cone."""
        assert self.whole is not None
        round_parts, tips = Instances(), Instances()
        start, end, radius = shapes.bars(drawing)
        round_parts.between(self.scaled(start), self.scaled(end), max(radius * self.factor, 3 * THIN), BODY)
        for each in shapes.supports(drawing, unloaded, self.joined, len(self.nodes), self.plane):
            place, size = self.scaled(each.place), max(each.size * self.factor, 0.015)
            if each.kind == "cone":
                # The tip of the mesh is where its third axis points to.
                tips.add((place + 0.95 * size * each.axis)[None], -each.axis, np.array([1.2, 1.2, 1.9]) * size, GROUND)
                place = place + 1.9 * size * each.axis
            if each.kind == "bar":
                reach = 2.2 * size * each.axis
                round_parts.between((place - reach)[None], (place + reach)[None], 0.35 * size, GROUND)
            else:
                round_parts.between(place[None], (place + 0.4 * size * each.axis)[None], 1.8 * size, GROUND)
        if self.with_loads:
            for arrow in shapes.arrows(drawing, unloaded, len(self.nodes), self.whole.size):
                tail, tip = self.scaled(arrow.tail), self.scaled(arrow.tip)
                along = (tip - tail) / np.linalg.norm(tip - tail)
                neck = tip - 0.07 * along
                round_parts.between(tail[None], neck[None], 0.011, LOADS[arrow.kind])
                for shift in (0.0, 0.06) if arrow.kind.endswith("moment") else (0.0,):
                    middle = ((tip + neck) / 2 - shift * along)[None]
                    tips.add(middle, along, np.array([0.028, 0.028, 0.07]), LOADS[arrow.kind])
        return round_parts, tips

    def _ghost(self, unloaded: Mapping[str, Any]) -> None:
        """The unloaded shape, which moves only where its geometry does."""
        at = shapes.places(unloaded)
        if self.ghost is None or self.ghost_of is None or not np.array_equal(at, self.ghost_of):
            vertices, faces = self._ghost_mesh(unloaded)
            if self.ghost is None:
                self.ghost = self.server.scene.add_mesh_simple(
                    "/unloaded", vertices, faces, color=GHOST, opacity=0.22, cast_shadow=False, receive_shadow=False
                )
            else:
                self.ghost.vertices = vertices.astype(np.float32)
                if len(faces) != len(self.ghost.faces):
                    self.ghost.faces = faces.astype(np.uint32)
            self.ghost_of = at
        if self.ghost.visible != self.with_ghost:
            self.ghost.visible = self.with_ghost

    def _ghost_mesh(self, unloaded: Mapping[str, Any]) -> Mesh:
        assert self.detail is not None
        # Cylinders one behind the other are seen where they let light through; straight tubes have as few as can be.
        parts = min(self.detail.parts, shapes.smooth(unloaded))
        tubes = shapes.tubes(unloaded, parts, self.detail.runs(unloaded))
        points, triangles = tube(self.detail.ghost_sides)
        start, end = self.scaled(tubes.start), self.scaled(tubes.end)
        along = end - start
        second, third = across(along / np.maximum(np.linalg.norm(along, axis=1), 1e-12)[:, None])
        radius = np.maximum(tubes.radius * self.factor, 2 * THIN)[:, None, None]
        around = points[:, 0, None] * second[:, None] + points[:, 1, None] * third[:, None]
        placed = ((start + end) / 2)[:, None] + radius * around + points[:, 2, None] * along[:, None]
        shifts = len(points) * np.arange(len(start))[:, None, None]
        return placed.reshape(-1, 3), (triangles[None] + shifts).reshape(-1, 3)

    def _names(self, drawing: Mapping[str, Any]) -> None:
        if not self.with_names or len(self.nodes) > NAMED:
            for label in self.names:
                label.visible = False
            return
        at = self.scaled(shapes.places(drawing)[: len(self.nodes)])
        lifted = at + np.array([0.0, 0.0, 0.03]) if not self.plane else at + np.array([0.02, 0.03, 0.1])
        if not self.names:
            self.names = [
                self.server.scene.add_label(f"/names/{index}", name, position=place, anchor="bottom-left")
                for index, (name, place) in enumerate(zip(self.nodes, lifted, strict=True))
            ]
        for label, place in zip(self.names, lifted, strict=True):
            label.position = place
            if not label.visible:
                label.visible = True

    def member_along(self, origin: Array, direction: Array) -> int | None:
        """The member that a ray through the scene meets first."""
        if self.tubes is None:
            return None
        start, end = self.scaled(self.tubes.start), self.scaled(self.tubes.end)
        along = np.asarray(direction) / np.linalg.norm(direction)
        best: tuple[float, int] | None = None
        for part in (0.1, 0.3, 0.5, 0.7, 0.9):
            away = start + part * (end - start) - np.asarray(origin)
            depth = away @ along
            far = np.linalg.norm(away - depth[:, None] * along, axis=1)
            reach = np.maximum(self.tubes.radius * self.factor, 0.012) + 0.1 * np.linalg.norm(end - start, axis=1)
            for place in np.flatnonzero((far <= reach) & (depth > 0)).tolist():
                if best is None or depth[place] < best[0]:
                    best = float(depth[place]), int(self.tubes.member[place])
        return None if best is None else best[1]

    def remove(self) -> None:
        """Takes all of it away, for another network."""
        self.solids.remove()
        for label in self.names:
            label.remove()
        if self.ghost is not None:
            self.ghost.remove()


@dataclasses.dataclass(frozen=True)
class Colours:
    """The colours of a scale in so many bands, so that there are not more meshes than these."""

    scale: Scale
    bands: int

    def __call__(self, values: Array) -> Bytes:
        """(n, 3), red, green and blue."""
        low, high = self.scale.low, self.scale.high
        if not self.scale.uniform:
            part = np.clip((values - low) / (high - low), 0.0, 1.0)
            values = low + (high - low) * np.round(part * (self.bands - 1)) / (self.bands - 1)
        return self.scale.colours(values)


def line_values(drawing: Mapping[str, Any], field: fields.Field) -> Array:
    """(lines,), the values of a field; those of rigid bodies count for nothing."""
    found = fields.values(drawing, field)
    return np.where(drawing["cell_data"]["kind"] == shapes.RIGID, np.nan, found)
