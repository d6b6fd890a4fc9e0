"""What there is to show of one state: tubes, joints, bodies, supports and loads, with places in space.

A drawing is what `Solution.drawing` gives: points, of which the first are the nodes of the network in their order, lines
between points, and arrays on both.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]
Drawing = Mapping[str, Any]

MUSCLE, MEMBER, RIGID = 0, 1, 2
# Bits of `held`.
UX, UY, UZ, RX, RY, RZ = (1 << component for component in range(6))
TRANSLATIONS, ROTATIONS = UX | UY | UZ, RX | RY | RZ
# A tube turns by no more than this from one cylinder to the next, in radians, while there are no more cylinders than that.
SMOOTH, MANY = np.deg2rad(6.0), 3000
# The radius of what no member says the thickness of, as a part of the extent of the nodes.
MARK = 0.01


@dataclasses.dataclass(frozen=True)
class Cylinders:
    """Straight round pieces: (n, 3) ends, (n,) radii, and where each comes from: line of the drawing and member."""

    start: Array
    end: Array
    radius: Array
    line: Integers
    member: Integers


@dataclasses.dataclass(frozen=True)
class Support:
    """A symbol of a support: `"block"` or `"cone"` behind a node, `"guide"` beside it, or `"bar"` along the way that is free."""

    kind: str
    node: int
    place: Array
    # Away from the network; for a bar along it.
    axis: Array
    size: float


@dataclasses.dataclass(frozen=True)
class Arrow:
    """A force, a moment, or the force or moment that a step takes to hold a node; the tip is at the node."""

    # `"force"`, `"moment"`, `"held by"` or `"held by moment"`.
    kind: str
    node: int
    tail: Array
    tip: Array
    strength: float


@dataclasses.dataclass(frozen=True)
class Extent:
    """The cube in which a network lies: its centre and the length of its diagonal."""

    centre: Array
    size: float


def places(drawing: Drawing) -> Array:
    """(points, 3), where points are in this state."""
    return np.asarray(drawing["points"] + drawing["point_data"]["displacement"])


def mark(places: Array) -> float:
    """The radius of what no member says the thickness of, from the places of the nodes."""
    return MARK * (float(np.linalg.norm(np.ptp(places, axis=0))) or 1.0)


def extent(*drawings: Drawing) -> Extent:
    """The box of all of them, tubes included."""
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for drawing in drawings:
        at, radius = places(drawing), drawing["point_data"]["radius"][:, None]
        low, high = np.minimum(low, (at - radius).min(axis=0)), np.maximum(high, (at + radius).max(axis=0))
    return Extent((low + high) / 2, float(np.linalg.norm(high - low)) or 1.0)


def tubes(drawing: Drawing, parts: int | None = None, runs: Integers | None = None) -> Cylinders:
    """The members as cylinders; each line makes so many, or as many as look smooth, and each of `runs` makes so many."""
    if runs is None:
        own = np.flatnonzero(drawing["cell_data"]["kind"] != RIGID)
        runs = np.stack([own, own], axis=1)
    first_lines, last_lines = drawing["lines"][runs[:, 0]], drawing["lines"][runs[:, 1]]
    begin, end = first_lines[:, 0], last_lines[:, 1]
    at, first = places(drawing), drawing["point_data"]["frame_e1"]
    parts = smooth(drawing) if parts is None else parts
    a, b = at[begin], at[end]
    chord = np.linalg.norm(b - a, axis=1)[:, None]
    # A cubic through both ends along the tangents there.
    tangents = first[begin] * chord, first[end] * chord
    stations = np.linspace(0.0, 1.0, parts + 1)
    rows = [cubic(a, tangents[0], b, tangents[1], float(s)) for s in stations]
    rows[0], rows[-1] = a, b
    line = np.tile(runs.mean(axis=1).astype(np.int64), parts)
    radius = drawing["point_data"]["radius"][first_lines].mean(axis=1)
    member = drawing["cell_data"]["member_id"][line]
    return Cylinders(np.concatenate(rows[:-1]), np.concatenate(rows[1:]), np.tile(radius, parts), line, member)


def runs(drawing: Drawing, length: int) -> Integers:
    """(n, 2), first and last line of pieces of members, each of at most so many lines in a row and of one radius."""
    own = np.flatnonzero(drawing["cell_data"]["kind"] != RIGID)
    lines, ids = drawing["lines"][own], drawing["cell_data"]["member_id"][own]
    radius = drawing["point_data"]["radius"][lines].mean(axis=1)
    follows = (ids[1:] == ids[:-1]) & (lines[1:, 0] == lines[:-1, 1]) & np.isclose(radius[1:], radius[:-1])
    fresh = np.concatenate([[True], ~follows]) if len(own) else np.zeros(0, dtype=bool)
    # How far each line is from the beginning of its row.
    count = np.arange(len(own))
    place = count - np.maximum.accumulate(np.where(fresh, count, 0))
    starts = np.flatnonzero(place % length == 0)
    ends = np.append(starts[1:], len(own))[: len(starts)] - 1
    return np.stack([own[starts], own[ends]], axis=1)


def shoulders(drawing: Drawing, joined: Integers, nodes: int) -> tuple[Array, Array, Array, Integers]:
    """Places, tangents and radii where the end of a section is seen, and the lines that end there.

    An end in the ball of a joint is not seen, nor one beside a section that is as thick.
    """
    own = np.flatnonzero(drawing["cell_data"]["kind"] != RIGID)
    lines = np.asarray(drawing["lines"], dtype=np.int64)[own]
    meet = np.bincount(lines.ravel(), minlength=len(drawing["points"]))
    line, side = np.nonzero(meet[lines] == 1)
    points = lines[line, side]
    data, ids = drawing["point_data"], drawing["cell_data"]["member_id"][own]
    at, radius = places(drawing), data["radius"]
    tips = ends(drawing, len(joined))
    closed = balls(drawing, joined, nodes)[2]
    hidden = set(tips[np.isin(joined, closed)].tolist())
    # The next line of the member, or the one before: the other section at a shoulder.
    beside = np.clip(line + np.where(side == 1, 1, -1), 0, len(lines) - 1)
    neighbour = np.where(ids[beside] == ids[line], radius[lines[beside, 1 - side]], 0.0)
    seen = (radius[points] > neighbour) & ~np.isin(points, np.array(sorted(hidden), dtype=np.int64))
    points = points[seen]
    return at[points], data["frame_e1"][points], radius[points], own[line[seen]]


def smooth(drawing: Drawing) -> int:
    """Into how many parts lines are divided to look smooth."""
    lines = drawing["lines"][drawing["cell_data"]["kind"] != RIGID]
    first = drawing["point_data"]["frame_e1"]
    turn = np.arccos(np.clip((first[lines[:, 0]] * first[lines[:, 1]]).sum(axis=1), -1.0, 1.0)).max(initial=0.0)
    return int(np.clip(np.ceil(turn / SMOOTH), 1, max(1, MANY // max(len(lines), 1))))


def cubic(a: Array, ta: Array, b: Array, tb: Array, s: float) -> Array:
    """Hermite's cubic at a part of the way."""
    return np.asarray(
        (2 * s**3 - 3 * s**2 + 1) * a + (s**3 - 2 * s**2 + s) * ta + (3 * s**2 - 2 * s**3) * b + (s**3 - s**2) * tb
    )


def ends(drawing: Drawing, members: int) -> Integers:
    """(members, 2), first and last point of each member."""
    ids, lines = drawing["cell_data"]["member_id"], drawing["lines"]
    kinds = drawing["cell_data"]["kind"]
    own = np.flatnonzero(kinds != RIGID)
    found = np.zeros((members, 2), dtype=np.int64)
    # Later lines overwrite: from behind the first line of each member stays, from the front the last one.
    found[ids[own[::-1]], 0] = lines[own[::-1], 0]
    found[ids[own], 1] = lines[own, 1]
    return found


def balls(drawing: Drawing, joined: Integers, count: int) -> tuple[Array, Array, Integers]:
    """Places, radii and nodes of the balls that close joints, and of those that stand for nodes alone.

    `joined` has the nodes at the ends of each member.
    """
    at, radius = places(drawing), drawing["point_data"]["radius"]
    tips = ends(drawing, len(joined))
    largest, many = np.zeros(count), np.zeros(count, dtype=int)
    for side in (0, 1):
        np.maximum.at(largest, joined[:, side], radius[tips[:, side]])
        np.add.at(many, joined[:, side], 1)
    rigid = drawing["lines"][drawing["cell_data"]["kind"] == RIGID]
    of_body = np.isin(np.arange(count), rigid)
    held = drawing["point_data"]["held"][:count]
    pinned = (held & (UX | UY) == UX | UY) & (held & RZ == 0)
    alone = (many == 0) & ~of_body
    largest[alone] = mark(drawing["points"][:count])
    shown = np.flatnonzero(alone | (largest > 0) & ((many > 1) | of_body | pinned))
    return at[shown], largest[shown], shown


def bars(drawing: Drawing) -> tuple[Array, Array, float]:
    """Ends of the bars that rigid bodies are made of, and their radius."""
    at, radius = places(drawing), drawing["point_data"]["radius"]
    own = drawing["cell_data"]["kind"] != RIGID
    thick = 0.45 * float(radius[drawing["lines"][own]].mean()) if own.any() else mark(drawing["points"])
    found = bar_nodes(drawing)
    return at[found[:, 0]], at[found[:, 1]], thick


def bar_nodes(drawing: Drawing) -> Integers:
    """(bars, 2), the nodes between which a rigid body has bars: spokes from its reference, and a rim of three or more."""
    at = places(drawing)
    rigid = np.asarray(drawing["lines"][drawing["cell_data"]["kind"] == RIGID], dtype=np.int64)
    pairs = [rigid]
    for reference in np.unique(rigid[:, 0]) if len(rigid) else ():
        others = rigid[rigid[:, 0] == reference, 1]
        if len(others) < 3:
            continue
        offsets = at[others] - at[others].mean(axis=0)
        _, sizes, axes = np.linalg.svd(offsets, full_matrices=False)
        if sizes[1] > 1e-6 * sizes[0]:
            order = others[np.argsort(np.arctan2(offsets @ axes[1], offsets @ axes[0]))]
            pairs.append(np.stack([order, np.roll(order, -1)], axis=1))
    return np.concatenate(pairs)


def inward(drawing: Drawing, joined: Integers, node: int) -> Array:
    """The mean direction from a node into the members that end there; zero where they balance."""
    first, tips = drawing["point_data"]["frame_e1"], ends(drawing, len(joined))
    total = np.zeros(3)
    for side, sign in ((0, 1.0), (1, -1.0)):
        total += sign * first[tips[joined[:, side] == node, side]].sum(axis=0)
    length = float(np.linalg.norm(total))
    return total / length if length > 0.2 else np.zeros(3)


def supports(drawing: Drawing, at_rest: Drawing, joined: Integers, nodes: int, plane: bool) -> list[Support]:
    """Symbols of what holds the network; what steps hold is no support."""
    at, data = places(drawing), drawing["point_data"]
    lines = drawing["lines"] if len(drawing["lines"]) else np.arange(nodes)
    radius = data["radius"][lines].mean()
    found = []
    for node in np.flatnonzero(at_rest["point_data"]["held"][:nodes] & (TRANSLATIONS if not plane else UX | UY)):
        held = int(at_rest["point_data"]["held"][node] & data["held"][node])
        if not held & (TRANSLATIONS if not plane else UX | UY):
            # A step has freed it.
            continue
        if plane:
            # Out of the plane it is held as a plane network is.
            held = held & (UX | UY) | UZ | (ROTATIONS if held & RZ else 0)
        away = -inward(drawing, joined, int(node))
        if not away.any():
            away = np.array([0.0, -1.0, 0.0]) if plane else np.array([0.0, 0.0, -1.0])
        size = max(float(data["radius"][node]), float(radius))
        axes = np.array([data["held_x"][node], data["held_y"][node], np.zeros(3)], dtype=np.float64)
        axes[2] = np.cross(axes[0], axes[1])
        free = [axis for bit, axis in zip((UX, UY, UZ), axes) if not held & bit]
        if not free:
            kind = "block" if held & ROTATIONS == ROTATIONS else "cone"
            found.append(Support(kind, int(node), at[node], away, size))
        elif len(free) == 1 and not plane:
            found.append(Support("bar", int(node), at[node], free[0], size))
        else:
            normal = next((axis for bit, axis in zip((UX, UY, UZ), axes) if held & bit), axes[2])
            normal = normal if normal @ away >= 0 else -normal
            found.append(Support("guide", int(node), at[node] + size * normal, normal, size))
    return found


def held_by(data: Mapping[str, Any], at_rest: Mapping[str, Any], nodes: int) -> tuple[Array, Array]:
    """(nodes, 3) each, the forces and the moments that prescribed motions take: the reactions along what steps alone hold.

    Args:
        data: Arrays of the points of a state.
        at_rest: Those of the unloaded state, in which supports alone hold.
        nodes: How many there are.
    """
    prescribed = data["held"][:nodes] & ~at_rest["held"][:nodes]
    first, second = (np.asarray(data[name][:nodes], dtype=np.float64) for name in ("held_x", "held_y"))
    axes = np.stack([first, second, np.cross(first, second)], axis=1)
    found = []
    for name, bits in (("reaction_force", (UX, UY, UZ)), ("reaction_moment", (RX, RY, RZ))):
        along = np.einsum("nij,nj->ni", axes, data[name][:nodes]) * (prescribed[:, None] & np.array(bits) != 0)
        found.append(np.einsum("ni,nij->nj", along, axes))
    return found[0], found[1]


def arrows(drawing: Drawing, at_rest: Drawing, nodes: int, size: float) -> list[Arrow]:
    """Forces and moments on nodes, and those that steps take to hold nodes; the largest force and the largest moment are longest."""
    at, data = places(drawing), drawing["point_data"]
    held_force, held_moment = held_by(data, at_rest["point_data"], nodes)
    kinds = {
        "force": data["load_force"][:nodes],
        "held by": held_force,
        "moment": data["load_moment"][:nodes],
        "held by moment": held_moment,
    }
    found = []
    strengths = {kind: np.linalg.norm(vectors, axis=1) for kind, vectors in kinds.items()}
    forces, moments = (
        max(float(strengths[kind].max(initial=0.0)) for kind in pair)
        for pair in (("force", "held by"), ("moment", "held by moment"))
    )
    for kind, vectors in kinds.items():
        strength = strengths[kind]
        longest = moments if kind.endswith("moment") else forces
        for node in np.flatnonzero(strength > 1e-9 * longest):
            length = size * (0.07 + 0.09 * strength[node] / longest)
            direction = vectors[node] / strength[node]
            tip = at[node] - 1.1 * data["radius"][node] * direction
            found.append(Arrow(kind, int(node), tip - length * direction, tip, float(strength[node])))
    return found
