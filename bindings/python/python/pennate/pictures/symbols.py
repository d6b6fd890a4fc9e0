"""Symbols drawn over a network: supports in the plane, forces, moments, distributed loads, pins."""

from __future__ import annotations

import dataclasses

import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyArrowPatch, Polygon

from .._look.fields import with_unit
from .colours import Theme
from .results import Array, Run
from .scene import RZ, UX, UY, Joint, Rod, Scene, unit
from .view import View

HELD = UX | UY | RZ


@dataclasses.dataclass(frozen=True)
class Pen:
    """Where and how symbols are drawn: sizes are points on paper, of which `point` is one in units of the network."""

    axes: Axes
    view: View
    theme: Theme
    point: float
    # Of figures that are shown smaller than they are drawn, such as tiles.
    scale: float = 1.0

    def line(self, points: Array, width: float = 0.9, colour: str | None = None, order: float = 4) -> None:
        """A line through points on paper."""
        self.axes.plot(
            points[:, 0],
            points[:, 1],
            color=colour or self.theme.support,
            lw=width * self.scale,
            solid_capstyle="round",
            solid_joinstyle="round",
            zorder=order,
        )

    def hatch(self, start: Array, end: Array, away: Array) -> None:
        """The ground: a line with strokes on its far side."""
        self.line(np.array([start, end]), 1.3)
        along = end - start
        step = 2.6 * self.point * self.scale
        count = max(2, round(float(np.linalg.norm(along)) / step))
        length = 2.8 * self.point * self.scale
        for part in (np.arange(count) + 0.5) / count:
            foot = start + part * along
            self.line(np.array([foot, foot + length * (away - 0.7 * unit(along))]), 0.7)


@dataclasses.dataclass(frozen=True)
class Note:
    """A text that belongs to a symbol: where it is, how far the symbol reaches, and where the text would stand best."""

    text: str
    anchor: Array
    radius: float
    towards: Array


@dataclasses.dataclass(frozen=True)
class Noise:
    """What rounding and the mesh leave uncertain of forces and of moments: what is less gets no arrow."""

    force: float = 0.0
    moment: float = 0.0


def draw_supports(pen: Pen, scene: Scene) -> None:
    """Supports of a plane network, and pins of members that are free to turn about their nodes."""
    for joint in scene.joints:
        held = joint.held & ~joint.prescribed & HELD
        if held:
            draw_support(pen, joint, held)
    for index, joint in enumerate(scene.joints):
        ends = [(rod, which) for rod in scene.rods for which in (0, 1) if rod.nodes[which] == index]
        released = [(rod, which) for rod, which in ends if rod.released[which]]
        pinned = joint.held & (UX | UY) and not joint.held & RZ
        if released and len(released) == len(ends):
            # Nothing is welded here: one pin for all. A support that turns has drawn it already.
            if not pinned:
                draw_pin(pen, pen.view.flat(joint.place), joint.radius)
            continue
        for rod, which in released:
            place, direction, radius, _ = rod.end(which)
            draw_pin(pen, pen.view.flat(place + max(joint.radius, radius) * direction), radius)


def draw_support(pen: Pen, joint: Joint, held: int) -> None:
    """The symbol of one support."""
    place, inward = pen.view.flat(joint.place), unit(pen.view.flat(joint.inward()))
    away = -inward if inward.any() else np.array([0.0, -1.0])
    size = max(joint.radius, 3.0 * pen.point * pen.scale)
    axes = pen.view.flat(joint.axes)
    if held & (UX | UY) == UX | UY:
        if held & RZ:
            draw_clamp(pen, place, away, size)
        else:
            draw_hinge(pen, place, away, size)
    elif held & (UX | UY):
        normal = unit(axes[0] if held & UX else axes[1])
        normal = normal if normal @ away >= 0 else -normal
        if held & RZ:
            draw_slider(pen, place, normal, size)
        else:
            draw_roller(pen, place, normal, size, joint.radius)


def turned(direction: Array) -> Array:
    """A quarter turn to the left."""
    return np.array([-direction[1], direction[0]])


def draw_clamp(pen: Pen, place: Array, away: Array, size: float) -> None:
    """A wall at the end of the member."""
    reach = (size + 3.0 * pen.point * pen.scale) * turned(away)
    pen.hatch(place - reach, place + reach, away)


def draw_hinge(pen: Pen, place: Array, away: Array, size: float) -> None:
    """A triangle on the ground, with a pin at its tip."""
    height, half = size + 8.0 * pen.point * pen.scale, 0.75 * size + 3.5 * pen.point * pen.scale
    foot = place + height * away
    draw_triangle(pen, place, foot, half)
    reach = 1.3 * half * turned(away)
    pen.hatch(foot - reach, foot + reach, away)
    draw_pin(pen, place, size)


def draw_triangle(pen: Pen, tip: Array, foot: Array, half: float) -> None:
    """Filled with paper, behind the network."""
    across = half * turned(unit(foot - tip))
    pen.axes.add_patch(
        Polygon(
            [tip, foot - across, foot + across],
            closed=True,
            facecolor=pen.theme.paper,
            edgecolor=pen.theme.support,
            lw=1.0 * pen.scale,
            zorder=2.5,
            joinstyle="round",
        )
    )


def draw_pin(pen: Pen, place: Array, size: float) -> None:
    """A small white circle over the joint."""
    radius = min(0.42 * size, 2.4 * pen.point * pen.scale)
    radius = max(radius, 1.2 * pen.point * pen.scale)
    pen.axes.add_patch(
        Circle(tuple(place), radius, facecolor=pen.theme.paper, edgecolor=pen.theme.ink, lw=0.8 * pen.scale, zorder=6)
    )


def draw_roller(pen: Pen, place: Array, away: Array, size: float, radius: float) -> None:
    """A triangle on two wheels that roll along the ground."""
    height, half = size + 6.0 * pen.point * pen.scale, 0.75 * size + 3.0 * pen.point * pen.scale
    wheel = 1.3 * pen.point * pen.scale
    foot = place + height * away
    draw_triangle(pen, place, foot, half)
    for side in (-0.6, 0.6):
        centre = foot + wheel * away + side * half * turned(away)
        pen.axes.add_patch(
            Circle(
                tuple(centre),
                wheel,
                facecolor=pen.theme.paper,
                edgecolor=pen.theme.support,
                lw=0.8 * pen.scale,
                zorder=2.6,
            )
        )
    ground, reach = foot + 2 * wheel * away, 1.3 * half * turned(away)
    pen.hatch(ground - reach, ground + reach, away)
    draw_pin(pen, place, max(radius, size))


def draw_slider(pen: Pen, place: Array, normal: Array, size: float) -> None:
    """A sleeve between two rails: it moves along them and does not turn."""
    half, reach = size + 1.5 * pen.point * pen.scale, size + 6.0 * pen.point * pen.scale
    along = turned(normal)
    for side in (-1.0, 1.0):
        rail = place + side * half * normal
        pen.hatch(rail - reach * along, rail + reach * along, side * normal)


def draw_loads(pen: Pen, scene: Scene, run: Run, largest: float, noise: Noise) -> list[Note]:
    """Arrows for forces and moments; a step's prescribed motions show those that they take. Returns their texts."""
    notes = []
    moment_unit = f"{run.force_unit} {run.length_unit}"
    named = len({tuple(joint.force) for joint in scene.joints if np.any(joint.force)}) > 1
    for joint in scene.joints:
        index = f" on {joint.name}" if named else ""
        if np.linalg.norm(joint.force) > noise.force:
            notes.append(draw_force(pen, joint, joint.force, largest, f"F{index} = ", run.force_unit))
        if np.linalg.norm(joint.moment) > 0:
            notes.append(draw_moment(pen, joint, joint.moment, f"M{index} = ", moment_unit))
        if np.linalg.norm(joint.held_by_force) > noise.force:
            notes.append(draw_force(pen, joint, joint.held_by_force, largest, "held by ", run.force_unit))
        if np.linalg.norm(joint.held_by_moment) > noise.moment:
            notes.append(draw_moment(pen, joint, joint.held_by_moment, "held by ", moment_unit))
    for rod in scene.rods:
        if np.any(rod.load):
            notes.append(draw_distributed(pen, rod, f"{run.force_unit}/{run.length_unit}"))
    return notes


def draw_force(pen: Pen, joint: Joint, force: Array, largest: float, before: str, unit_name: str) -> Note:
    """An arrow whose tip touches the node; its length says how large the force is beside the others."""
    strength = float(np.linalg.norm(force))
    place = pen.view.flat(joint.place)
    direction = pen.view.flat(force / strength)
    seen = float(np.linalg.norm(direction))
    text = before + with_unit(strength, unit_name)
    if seen < 0.2:
        # Along the line of sight: the tip or the feathers of an arrow.
        radius = 3.5 * pen.point * pen.scale
        pen.axes.add_patch(Circle(tuple(place), radius, facecolor="none", edgecolor=pen.theme.load, lw=1.2, zorder=7))
        return Note(text, place, joint.radius + radius, np.zeros(2))
    direction = direction / seen
    length = (14.0 + 14.0 * strength / largest) * pen.point * pen.scale
    tip = place - (joint.radius + 1.0 * pen.point) * direction
    tail = tip - length * direction
    arrow(pen, tail, tip)
    return Note(text, tail, 1.0 * pen.point, -direction)


def arrow(pen: Pen, tail: Array, tip: Array, width: float = 1.6, style: str = "-|>", bend: str = "arc3,rad=0") -> None:
    """One arrow."""
    pen.axes.add_patch(
        FancyArrowPatch(
            tuple(tail),
            tuple(tip),
            arrowstyle=style,
            connectionstyle=bend,
            mutation_scale=9 * pen.scale,
            lw=width * pen.scale,
            color=pen.theme.load,
            shrinkA=0,
            shrinkB=0,
            zorder=7,
            joinstyle="miter",
        )
    )


def draw_moment(pen: Pen, joint: Joint, moment: Array, before: str, unit_name: str) -> Note:
    """An arc about the node where the moment turns in the picture, else an arrow with two heads along its axis."""
    strength = float(np.linalg.norm(moment))
    place = pen.view.flat(joint.place)
    turning = float(moment @ pen.view.towards) / strength
    text = before + with_unit(strength, unit_name)
    if abs(turning) > 0.7:
        radius = joint.radius + 7.0 * pen.point * pen.scale
        angles = np.deg2rad(np.linspace(-60, 170, 40)) * np.sign(turning) + np.pi / 2
        arc = place + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        pen.line(arc[:-2], 1.6, pen.theme.load, 7)
        arrow(pen, arc[-4], arc[-1])
        return Note(text, place, radius + 2.0 * pen.point, np.zeros(2))
    direction = unit(pen.view.flat(moment))
    tail = place + (joint.radius + 2.0 * pen.point) * direction
    tip = tail + 24.0 * pen.point * pen.scale * direction
    arrow(pen, tail, tip)
    arrow(pen, tail, tip - 4.5 * pen.point * pen.scale * direction)
    return Note(text, tip, 2.0 * pen.point, direction)


def draw_distributed(pen: Pen, rod: Rod, unit_name: str) -> Note:
    """A row of arrows along a member."""
    flat = pen.view.flat(rod.places)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(flat, axis=0), axis=1))])
    count = int(np.clip(along[-1] / (9.0 * pen.point * pen.scale), 3, 15))
    direction = unit(pen.view.flat(rod.load))
    radius = max(float(piece.radii.max()) for piece in rod.pieces)
    stations = np.linspace(0.0, along[-1], count)
    tips = np.stack([np.interp(stations, along, flat[:, axis]) for axis in (0, 1)], axis=1)
    chord = unit(flat[-1] - flat[0])
    if abs(float(direction @ chord)) > 0.9:
        # Along the member the arrows stand beside it, or they would hide it.
        tips = tips + (radius + 6.0 * pen.point * pen.scale) * turned(chord)
    else:
        tips = tips - (radius + pen.point) * direction
    tails = tips - 11.0 * pen.point * pen.scale * direction
    for tail, tip in zip(tails, tips):
        arrow(pen, tail, tip, 0.9)
    pen.line(tails, 1.0, pen.theme.load, 7)
    return Note(with_unit(float(np.linalg.norm(rod.load)), unit_name), tails[count // 2], pen.point, -direction)
