"""What there is to draw of one state: rods, joints, bodies, supports and loads, with places in space."""

from __future__ import annotations

import dataclasses

import numpy as np
from scipy.interpolate import CubicSpline

from .._look.shapes import held_by, mark
from .results import Array, Integers, Run, Shape

MUSCLE, MEMBER, RIGID = 0, 1, 2
# Bits of `held` in the files.
UX, UY, UZ, RX, RY, RZ = (1 << component for component in range(6))
TRANSLATIONS, ROTATIONS = UX | UY | UZ, RX | RY | RZ
# Members turn by no more than this between two drawn points (radians): 3 degrees look round on paper.
SMOOTH = np.deg2rad(3.0)


@dataclasses.dataclass(frozen=True)
class Piece:
    """A part of a member with one section: places, two axes of the section, radii and values of the field along it."""

    places: Array
    second_axes: Array
    third_axes: Array
    radii: Array
    values: Array


@dataclasses.dataclass(frozen=True)
class Rod:
    """A member as it is drawn."""

    name: str
    muscle: bool
    nodes: tuple[int, int]
    pieces: tuple[Piece, ...]
    # Whether the start and the end are free to turn about their nodes.
    released: tuple[bool, bool]
    # Force per unloaded length.
    load: Array

    @property
    def places(self) -> Array:
        """Points from start to end."""
        return np.concatenate([piece.places for piece in self.pieces])

    def end(self, which: int) -> tuple[Array, Array, float, float]:
        """Place of an end, direction from there into the member, radius and value there."""
        piece = self.pieces[0] if which == 0 else self.pieces[-1]
        order = slice(None) if which == 0 else slice(None, None, -1)
        places = piece.places[order]
        return places[0], unit(places[1] - places[0]), float(piece.radii[order][0]), float(piece.values[order][0])


@dataclasses.dataclass(frozen=True)
class Joint:
    """A node of the network."""

    name: str
    place: Array
    # Of the thickest member that ends here; without one that of the body, or of a mark where there is none either.
    radius: float
    # Of the members that end here: directions away from the node, radii, and values.
    directions: Array
    radii: Array
    values: Array
    # Components that are held, as bits, and the axes that they belong to, in rows.
    held: int
    axes: Array
    # What a step holds that no support does.
    prescribed: int
    force: Array
    moment: Array
    # What that takes.
    held_by_force: Array
    held_by_moment: Array
    of_body: bool

    @property
    def alone(self) -> bool:
        """Whether neither a member nor a body is at this node."""
        return not self.of_body and not len(self.directions)

    def inward(self) -> Array:
        """The mean direction of the members that end here; zero where they balance."""
        mean = self.directions.sum(axis=0) if len(self.directions) else np.zeros(3)
        return unit(mean) if np.linalg.norm(mean) > 0.2 else np.zeros(3)


@dataclasses.dataclass(frozen=True)
class Body:
    """A rigid body: the places of its nodes, the reference first."""

    nodes: tuple[int, ...]
    places: Array
    radius: float


@dataclasses.dataclass(frozen=True)
class Scene:
    """All that is drawn of one state."""

    rods: tuple[Rod, ...]
    joints: tuple[Joint, ...]
    bodies: tuple[Body, ...]

    def points(self) -> tuple[Array, Array]:
        """All places that are drawn, and how far around them something is drawn."""
        pieces = [piece for rod in self.rods for piece in rod.pieces]
        places = [piece.places for piece in pieces] + [joint.place[None] for joint in self.joints]
        radii = [piece.radii for piece in pieces] + [np.array([joint.radius]) for joint in self.joints]
        return np.concatenate(places), np.concatenate(radii)


def unit(vector: Array) -> Array:
    """A vector of length one; zero stays zero."""
    length = np.linalg.norm(vector)
    return vector / length if length > 0 else vector


def build(run: Run, shape: Shape, values: Array, at_rest: Shape, thinnest: float) -> Scene:
    """The scene of a state.

    `values` has one entry a line. What holds a node in `at_rest`, the unloaded state, is a support; what else holds it
    was prescribed by a step. Rods are drawn no thinner than `thinnest`, a radius.
    """
    places = shape.points + shape.point_data["displacement"]
    count = len(run.nodes)
    rods = tuple(rod_of(run, shape, places, values, member, count, thinnest) for member in range(len(run.members)))
    marked = max(mark(shape.points[:count]), thinnest)
    bodies = bodies_of(shape, places, rods, marked)
    # Where there is no member the thickness is that of the body.
    thick = {node: body.radius for body in bodies for node in body.nodes}
    taken = held_by(shape.point_data, at_rest.point_data, count)
    joints = tuple(
        joint_of(run, shape, places, at_rest, taken, rods, node, node in thick, thick.get(node, marked))
        for node in range(count)
    )
    return Scene(rods, joints, bodies)


def rod_of(run: Run, shape: Shape, places: Array, values: Array, member: int, nodes: int, thinnest: float) -> Rod:
    """One member."""
    lines = np.flatnonzero(shape.cell_data["member_id"] == member)
    cells = shape.cells[lines]
    # A new section begins where a line does not start at the point at which the last one ended.
    breaks = np.flatnonzero(cells[1:, 0] != cells[:-1, 1]) + 1
    pieces = tuple(
        piece_of(shape, places, part, values[lines[where]], thinnest)
        for part, where in zip(np.split(cells, breaks), np.split(np.arange(len(cells)), breaks))
    )
    first, last = int(cells[0, 0]), int(cells[-1, 1])
    released = shape.point_data["released"]
    return Rod(
        name=run.members[member],
        muscle=bool(shape.cell_data["kind"][lines[0]] == MUSCLE),
        nodes=(node_at(shape, first, nodes), node_at(shape, last, nodes)),
        pieces=pieces,
        released=(bool(released[first]), bool(released[last])),
        load=np.asarray(shape.cell_data["load_distributed"][lines[0]], dtype=np.float64),
    )


def node_at(shape: Shape, point: int, nodes: int) -> int:
    """The node where a member ends: nearest to it when unloaded, and of several there the one that moved with it."""
    moved = shape.point_data["displacement"]
    far = np.linalg.norm(shape.points[:nodes] - shape.points[point], axis=1)
    far = far + np.linalg.norm(moved[:nodes] - moved[point], axis=1)
    return int(np.argmin(far))


def piece_of(shape: Shape, places: Array, cells: Integers, values: Array, thinnest: float) -> Piece:
    """The lines of one section, drawn smoothly through their points."""
    points = np.append(cells[:, 0], cells[-1, 1])
    # Values belong to lines; at a point between two of them stands their mean.
    padded = np.concatenate([values[:1], values, values[-1:]])
    at_points = 0.5 * (padded[:-1] + padded[1:])
    radii = np.maximum(shape.point_data["radius"][points], thinnest)
    seconds, thirds = shape.point_data["frame_e2"][points], shape.point_data["frame_e3"][points]
    line = places[points]
    tangents = np.diff(line, axis=0)
    lengths = np.linalg.norm(tangents, axis=1)
    if len(line) < 3 or not (lengths > 0).all():
        return Piece(line, seconds, thirds, radii, at_points)
    tangents = tangents / lengths[:, None]
    largest = np.arccos(np.clip((tangents[1:] * tangents[:-1]).sum(axis=1), -1.0, 1.0)).max()
    between = int(np.clip(np.ceil(largest / SMOOTH), 1, 12))
    along = np.concatenate([[0.0], np.cumsum(lengths)])
    fine = np.concatenate([np.linspace(a, b, between, endpoint=False) for a, b in zip(along, along[1:])] + [along[-1:]])
    smooth = CubicSpline(along, np.hstack([line, seconds, thirds]))(fine)
    second = smooth[:, 3:6] / np.linalg.norm(smooth[:, 3:6], axis=1, keepdims=True)
    third = smooth[:, 6:9] / np.linalg.norm(smooth[:, 6:9], axis=1, keepdims=True)
    return Piece(smooth[:, :3], second, third, np.interp(fine, along, radii), np.interp(fine, along, at_points))


def bodies_of(shape: Shape, places: Array, rods: tuple[Rod, ...], marked: float) -> tuple[Body, ...]:
    """Rigid bodies: lines from one reference to the other nodes, thinner than members, where there are any."""
    lines = shape.cells[shape.cell_data["kind"] == RIGID]
    radii = [max(float(piece.radii.max()) for piece in rod.pieces) for rod in rods]
    mean = float(np.mean(radii)) if radii else marked / 0.45
    bodies = []
    for reference in dict.fromkeys(int(line[0]) for line in lines):
        nodes = (reference, *(int(line[1]) for line in lines if line[0] == reference))
        thickest = float(shape.point_data["radius"][list(nodes)].max())
        bodies.append(Body(nodes, places[list(nodes)], 0.45 * min(thickest, mean)))
    return tuple(bodies)


def joint_of(
    run: Run,
    shape: Shape,
    places: Array,
    at_rest: Shape,
    taken: tuple[Array, Array],
    rods: tuple[Rod, ...],
    node: int,
    of_body: bool,
    thick: float,
) -> Joint:
    """One node, with the members that end there."""
    ends = [rod.end(which) for rod in rods for which in (0, 1) if rod.nodes[which] == node]
    radii = np.array([radius for _, _, radius, _ in ends])
    data = shape.point_data
    held = int(data["held"][node])
    axes = np.array([data["held_x"][node], data["held_y"][node], np.zeros(3)], dtype=np.float64)
    axes[2] = np.cross(axes[0], axes[1])
    return Joint(
        name=run.nodes[node],
        place=places[node],
        radius=float(radii.max()) if ends else thick,
        directions=np.array([direction for _, direction, _, _ in ends]).reshape(-1, 3),
        radii=radii,
        values=np.array([value for _, _, _, value in ends]),
        held=held,
        axes=axes,
        prescribed=held & ~int(at_rest.point_data["held"][node]),
        force=data["load_force"][node],
        moment=data["load_moment"][node],
        held_by_force=taken[0][node],
        held_by_moment=taken[1][node],
        of_body=of_body,
    )
