"""Surfaces of rods, joints, bodies and supports: triangles with normals and colours."""

from __future__ import annotations

import dataclasses
import functools

import numpy as np
import pyvista
from matplotlib.colors import to_rgb
from scipy.spatial import ConvexHull

from .._look.fields import Scale
from .colours import Theme, painted
from .results import Array, Integers
from .scene import ROTATIONS, TRANSLATIONS, Body, Joint, Piece, Rod, Scene, unit

SIDES = 48
# Nodes of a body lie in one plane, or on one line, within this part of its size.
FLAT = 1e-6
# Sine of the angle between a surface and the line of sight below which it is seen from its rim.
RIM = 1e-3


@dataclasses.dataclass
class Surface:
    """Triangles with a normal and a colour at each point."""

    points: list[Array]
    normals: list[Array]
    colours: list[Array]
    triangles: list[Integers]
    count: int = 0

    @staticmethod
    def empty() -> Surface:
        """Nothing yet."""
        return Surface([], [], [], [])

    def add(self, points: Array, normals: Array, colours: Array, triangles: Integers) -> None:
        """More triangles, which name their points by place among those given."""
        self.points.append(points)
        self.normals.append(normals)
        self.colours.append(np.broadcast_to(colours, points.shape))
        self.triangles.append(triangles + self.count)
        self.count += len(points)

    def mesh(self, towards: Array) -> pyvista.PolyData:
        """For VTK, without the triangles that a reader in this direction sees from their rim."""
        points, normals = np.concatenate(self.points), np.concatenate(self.normals)
        triangles = np.concatenate(self.triangles)
        # VTK lights the side from which the corners run to the left: that must be the side of the normals.
        a, b, c = (points[triangles[:, corner]] for corner in range(3))
        across = np.cross(b - a, c - a)
        wrong = (across * normals[triangles].sum(axis=1)).sum(axis=1) < 0
        triangles[wrong] = triangles[wrong][:, ::-1]
        # A disc seen from its rim would leave dark specks where its line happens to meet the middle of a pixel.
        triangles = triangles[np.abs(across @ towards) > RIM * np.linalg.norm(across, axis=1)]
        faces = np.hstack([np.full((len(triangles), 1), 3), triangles]).ravel()
        mesh = pyvista.PolyData(points, faces=faces)
        mesh.point_data["Normals"] = normals.astype(np.float32)
        mesh.point_data["colour"] = (255 * np.concatenate(self.colours)).round().astype(np.uint8)
        return mesh


def network(scene: Scene, colouring: Scale, theme: Theme, plane: bool) -> Surface:
    """The whole network; in space with its supports."""
    surface = Surface.empty()
    for rod in scene.rods:
        default = theme.muscle if rod.muscle else theme.member
        add_rod(surface, scene, rod, [painted(colouring, piece.values, default) for piece in rod.pieces])
    muscles = {node for rod in scene.rods if rod.muscle for node in rod.nodes}
    for index, joint in enumerate(scene.joints):
        if joint.alone:
            add_ball(surface, joint.place, joint.radius, np.array(to_rgb(theme.body)))
        elif closed(joint):
            add_joint(surface, joint, colouring, theme.muscle if index in muscles else theme.member)
    for body in scene.bodies:
        add_body(surface, body, theme, plane)
    if not plane:
        add_supports(surface, scene, theme)
    return surface


def closed(joint: Joint) -> bool:
    """Whether a ball closes a joint: where members meet, on bodies, and where a member may turn about its support."""
    pinned = joint.held & TRANSLATIONS and joint.held & ROTATIONS != ROTATIONS
    return len(joint.directions) > 1 or (len(joint.directions) > 0 and bool(joint.of_body or pinned))


def ghost(scene: Scene, theme: Theme, plane: bool) -> Surface:
    """The shape alone, in one colour."""
    surface = Surface.empty()
    colour = np.array(to_rgb(theme.ghost))
    for rod in scene.rods:
        add_rod(surface, scene, rod, [colour] * len(rod.pieces))
    for joint in scene.joints:
        if joint.alone or closed(joint):
            add_ball(surface, joint.place, joint.radius, colour)
    for body in scene.bodies:
        add_body(surface, body, dataclasses.replace(theme, body=theme.ghost), plane)
    return surface


def add_rod(surface: Surface, scene: Scene, rod: Rod, colours: list[Array]) -> None:
    """The tubes of a member, with a flat end where one is seen: at shoulders, and where no ball closes the joint."""
    # Radii of what an end would be hidden in; an end in a ball or beside a thicker tube is left open.
    beyond = [np.inf if closed(scene.joints[node]) else 0.0 for node in rod.nodes]
    for index, (piece, colour) in enumerate(zip(rod.pieces, colours)):
        before = float(rod.pieces[index - 1].radii[-1]) if index else beyond[0]
        after = float(rod.pieces[index + 1].radii[0]) if index + 1 < len(rod.pieces) else beyond[1]
        add_tube(surface, piece, colour, (before < piece.radii[0], after < piece.radii[-1]))


def add_tube(surface: Surface, piece: Piece, colours: Array, ends: tuple[bool, bool] = (True, True)) -> None:
    """A tube; `ends` says which of its ends are closed by a flat disc."""
    angles = np.linspace(0.0, 2 * np.pi, SIDES, endpoint=False)
    radial = (
        np.cos(angles)[None, :, None] * piece.second_axes[:, None]
        + np.sin(angles)[None, :, None] * piece.third_axes[:, None]
    )
    rings = piece.places[:, None] + piece.radii[:, None, None] * radial
    colours = np.broadcast_to(colours, piece.places.shape)
    index = np.arange(rings.shape[0] * SIDES).reshape(-1, SIDES)
    a, b = index[:-1], np.roll(index[:-1], -1, axis=1)
    c, d = index[1:], np.roll(index[1:], -1, axis=1)
    triangles = np.concatenate([np.stack(corners, axis=-1).reshape(-1, 3) for corners in ((a, b, d), (a, d, c))])
    surface.add(rings.reshape(-1, 3), radial.reshape(-1, 3), np.repeat(colours, SIDES, axis=0), triangles)
    for end, inner in [pair for pair, flat in zip(((0, 1), (-1, -2)), ends) if flat]:
        outward = unit(piece.places[end] - piece.places[inner])
        add_disc(surface, rings[end], outward, colours[end])


def add_disc(surface: Surface, ring: Array, normal: Array, colour: Array) -> None:
    """A flat polygon."""
    points = np.concatenate([ring.mean(axis=0)[None], ring])
    around = np.arange(1, len(ring) + 1)
    triangles = np.stack([np.zeros(len(ring), dtype=int), around, np.roll(around, -1)], axis=1)
    surface.add(points, np.tile(normal, (len(points), 1)), colour, triangles)


@functools.cache
def sphere() -> tuple[Array, Integers]:
    """Directions and triangles of a sphere."""
    mesh = pyvista.Sphere(radius=1.0, theta_resolution=SIDES, phi_resolution=SIDES // 2)
    directions, triangles = np.array(mesh.points, dtype=np.float64), mesh.faces.reshape(-1, 4)[:, 1:].astype(np.int64)
    # All balls share them.
    directions.flags.writeable = triangles.flags.writeable = False
    return directions, triangles


def add_ball(surface: Surface, centre: Array, radius: float, colours: Array) -> None:
    """A sphere."""
    directions, triangles = sphere()
    surface.add(centre + radius * directions, directions, colours, triangles)


def add_joint(surface: Surface, joint: Joint, colouring: Scale, default: str) -> None:
    """A ball that closes the wedge between members that meet; each side has the colour of the member nearest to it."""
    directions, triangles = sphere()
    thick = joint.radii > 0.5 * joint.radius
    # The members share the ball by how near they are: a fourth power fades within some 40 degrees.
    weights = np.maximum(directions @ joint.directions[thick].T + 1.0, 1e-3) ** 4
    values = (weights @ joint.values[thick]) / weights.sum(axis=1)
    surface.add(joint.place + joint.radius * directions, directions, painted(colouring, values, default), triangles)


def add_bar(surface: Surface, start: Array, end: Array, radius: float, colour: Array) -> None:
    """A straight round bar with round ends."""
    along = unit(end - start)
    second, third = across(along)
    add_tube(
        surface,
        Piece(np.array([start, end]), np.tile(second, (2, 1)), np.tile(third, (2, 1)), np.full(2, radius), np.zeros(2)),
        colour,
    )
    add_ball(surface, start, radius, colour)
    add_ball(surface, end, radius, colour)


def across(along: Array) -> tuple[Array, Array]:
    """Two unit vectors normal to a direction and to each other."""
    second = unit(np.cross(along, np.eye(3)[int(np.argmin(np.abs(along)))]))
    return second, np.cross(along, second)


def add_body(surface: Surface, body: Body, theme: Theme, plane: bool) -> None:
    """A bar where its nodes lie on a line, a plate where they lie in a plane in space, else bars from the reference."""
    colour = np.array(to_rgb(theme.body))
    centred = body.places - body.places.mean(axis=0)
    _, sizes, axes = np.linalg.svd(centred, full_matrices=False)
    if len(sizes) < 2 or sizes[1] <= FLAT * sizes[0]:
        along = centred @ axes[0]
        ends = body.places[[int(along.argmin()), int(along.argmax())]]
        add_bar(surface, ends[0], ends[1], body.radius, colour)
    elif not plane and len(sizes) > 2 and sizes[2] <= FLAT * sizes[0]:
        add_plate_or_ring(surface, body, centred, axes, colour)
    else:
        for place in body.places[1:]:
            add_bar(surface, body.places[0], place, body.radius, colour)


def add_plate_or_ring(surface: Surface, body: Body, centred: Array, axes: Array, colour: Array) -> None:
    """A plate over the hull of the nodes of a body; a ring with spokes where members are fixed inside of the hull."""
    hull = ConvexHull(centred @ axes[:2].T).vertices
    rim = body.places[hull]
    inner = [place for index, place in enumerate(body.places) if index and index not in hull]
    if inner:
        for start, end in zip(rim, np.roll(rim, -1, axis=0)):
            add_bar(surface, start, end, body.radius, colour)
        for place in inner:
            add_bar(surface, body.places[0], place, body.radius, colour)
        return
    normal = np.cross(axes[0], axes[1])
    upper, lower = rim + 0.7 * body.radius * normal, rim - 0.7 * body.radius * normal
    add_disc(surface, upper, normal, colour)
    add_disc(surface, lower, -normal, colour)
    add_sides(surface, upper, lower, colour)


def add_sides(surface: Surface, upper: Array, lower: Array, colour: Array) -> None:
    """Flat faces between two polygons."""
    middle = upper.mean(axis=0)
    for a, b, c, d in zip(upper, np.roll(upper, -1, axis=0), np.roll(lower, -1, axis=0), lower):
        normal = unit(np.cross(b - a, d - a))
        normal = normal if normal @ (0.5 * (a + b) - middle) > 0 else -normal
        surface.add(np.array([a, b, c, d]), np.tile(normal, (4, 1)), colour, np.array([[0, 1, 2], [0, 2, 3]]))


def add_supports(surface: Surface, scene: Scene, theme: Theme) -> None:
    """Symbols in space: plates for clamps, cones for pins, rails and planes for guides."""
    colour = np.array(to_rgb(theme.ground))
    thickest = max((joint.radius for joint in scene.joints), default=0.0)
    for index, joint in enumerate(scene.joints):
        held = joint.held & ~joint.prescribed
        if not held & TRANSLATIONS:
            continue
        size = max(joint.radius, 0.5 * thickest)
        if held & TRANSLATIONS == TRANSLATIONS:
            inward = joint.inward()
            if held & ROTATIONS != ROTATIONS:
                # On the ground, unless the network hangs from it.
                away = np.array([0.0, 0.0, 1.0 if inward[2] < -0.3 else -1.0])
                add_cone(surface, joint.place, away, size, colour)
            elif len(joint.directions) == 1:
                add_block(surface, joint.place, -inward, 1.5 * size, 0.5 * size, colour)
            elif inward.any():
                # Several members stand on one plate, along the axis that they have most in common.
                away = -np.sign(inward) * (np.abs(inward) == np.abs(inward).max())
                add_block(surface, joint.place + 0.9 * joint.radius * away, unit(away), 1.5 * size, 0.5 * size, colour)
            else:
                half = max(
                    (float(np.abs(body.places - joint.place).max()) for body in scene.bodies if index == body.nodes[0]),
                    default=1.2 * size,
                )
                ground = joint.place - np.array([0.0, 0.0, 1.2 * size])
                add_block(surface, ground, np.array([0.0, 0.0, -1.0]), 0.85 * half, 0.5 * size, colour)
        else:
            add_guide(surface, joint, held, size, colour)


def add_block(surface: Surface, place: Array, away: Array, half: float, thick: float, colour: Array) -> None:
    """A square plate behind a place."""
    second, third = across(away)
    corners = np.array([second + third, third - second, -second - third, second - third]) * half
    front, back = place + corners, place + corners + thick * away
    add_disc(surface, front, -away, colour)
    add_disc(surface, back, away, colour)
    add_sides(surface, front, back, colour)


def add_cone(surface: Surface, place: Array, away: Array, size: float, colour: Array) -> None:
    """A cone with its tip at a place, on a plate."""
    second, third = across(away)
    length, wide = 1.9 * size, 1.2 * size
    axes = np.tile(second, (2, 1)), np.tile(third, (2, 1))
    places = np.array([place, place + length * away])
    add_tube(surface, Piece(places, *axes, np.array([0.35 * size, wide]), np.zeros(2)), colour)
    add_block(surface, place + length * away, away, 1.25 * wide, 0.35 * size, colour)


def add_guide(surface: Surface, joint: Joint, held: int, size: float, colour: Array) -> None:
    """A rail along the one direction that is free, or a plate normal to the one that is held."""
    free = [axis for bit, axis in zip((1, 2, 4), joint.axes) if not held & bit]
    if len(free) == 1:
        reach = 2.2 * size * free[0]
        add_bar(surface, joint.place - reach, joint.place + reach, 0.35 * size, colour)
    else:
        normal = next(axis for bit, axis in zip((1, 2, 4), joint.axes) if held & bit)
        away = normal if normal @ joint.inward() <= 0 else -normal
        add_block(surface, joint.place + joint.radius * away, away, 1.7 * size, 0.3 * size, colour)
