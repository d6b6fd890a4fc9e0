"""Shapes between nodes that are known: a drawing carried to other places and turns of its nodes.

Each end of a member takes along what is near it, as a rigid body; between the ends the two motions are mixed by a smooth step.
So places and tangents at both ends are right, and a motion of the whole stays one. It is what pages show while the equilibrium
itself is still being computed, and of modes, of which the nodes alone are known.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from .shapes import Array, Drawing, Integers, ends, places


def rotations(vectors: Array) -> Array:
    """(n, 3, 3), rotation matrices of rotation vectors, (n, 3) in radians."""
    angles = np.linalg.norm(vectors, axis=1)
    safe = np.where(angles > 0, angles, 1.0)
    x, y, z = (vectors / safe[:, None]).T
    zero = np.zeros_like(x)
    skew = np.stack([zero, -z, y, z, zero, -x, -y, x, zero], axis=1).reshape(-1, 3, 3)
    sine, versine = np.sin(angles)[:, None, None], (1.0 - np.cos(angles))[:, None, None]
    return np.asarray(np.eye(3) + sine * skew + versine * (skew @ skew))


def chord_turns(before: Array, after: Array) -> Array:
    """(n, 3, 3), the smallest turns that bring some directions to others."""
    a = before / np.linalg.norm(before, axis=1)[:, None]
    b = after / np.linalg.norm(after, axis=1)[:, None]
    axis = np.cross(a, b)
    sine, cosine = np.linalg.norm(axis, axis=1), (a * b).sum(axis=1)
    angle = np.arctan2(sine, cosine)
    return rotations(axis * (angle / np.where(sine > 0, sine, 1.0))[:, None])


def carried(drawing: Drawing, joined: Integers, displacement: Array, turn: Array) -> dict[str, Any]:
    """The drawing with its nodes elsewhere.

    Args:
        drawing: Of any state of the network.
        joined: (members, 2), the nodes at the ends of each member.
        displacement: (nodes, 3), from the unloaded places.
        turn: (nodes, 3, 3), the turns of the nodes from this drawing to the new state.
    """
    at, lines = places(drawing), drawing["lines"]
    data, nodes = drawing["point_data"], len(displacement)
    moved = at.copy()
    moved[:nodes] = drawing["points"][:nodes] + displacement
    own = np.flatnonzero(drawing["cell_data"]["member_id"] >= 0)
    ids = drawing["cell_data"]["member_id"][own]
    # Each point of a member, and how far along it is.
    member = np.full(len(at), -1)
    member[lines[own, 0]], member[lines[own, 1]] = ids, ids
    along = np.zeros(len(at))
    lengths = np.linalg.norm(at[lines[own, 1]] - at[lines[own, 0]], axis=1)
    reached = np.cumsum(lengths)
    first = np.concatenate([[True], ids[1:] != ids[:-1]]) if len(ids) else np.zeros(0, dtype=bool)
    begin = np.maximum.accumulate(np.where(first, reached - lengths, 0.0))
    along[lines[own, 0]], along[lines[own, 1]] = reached - lengths - begin, reached - begin
    total = np.zeros(len(joined))
    np.maximum.at(total, ids, reached - begin)
    inner = np.flatnonzero(member >= 0)
    of = member[inner]
    part = np.clip(along[inner] / np.where(total > 0, total, 1.0)[of], 0.0, 1.0)
    weight = (part * part * (3.0 - 2.0 * part))[:, None]
    turns = end_turns(drawing, joined, moved, turn)
    tips = ends(drawing, len(joined))
    there = [moved[joined[:, side]] + (at[tips[:, side]] - at[joined[:, side]]) for side in (0, 1)]
    by = [there[side][of] + np.einsum("nij,nj->ni", turns[side][of], at[inner] - at[tips[of, side]]) for side in (0, 1)]
    moved[inner] = (1.0 - weight) * by[0] + weight * by[1]
    frames = {}
    for key in ("frame_e1", "frame_e2", "frame_e3"):
        old = data[key]
        new = old.copy()
        two = [np.einsum("nij,nj->ni", turns[side][of], old[inner]) for side in (0, 1)]
        mixed = (1.0 - weight) * two[0] + weight * two[1]
        new[inner] = mixed / np.maximum(np.linalg.norm(mixed, axis=1), 1e-12)[:, None]
        frames[key] = new
    return {**drawing, "point_data": {**data, **frames, "displacement": moved - drawing["points"]}}


def end_turns(drawing: Drawing, joined: Integers, moved: Array, turn: Array) -> tuple[Array, Array]:
    """By how much both ends of each member turn: with their nodes, or where they are free to turn with the chord."""
    at, released = places(drawing), drawing["point_data"]["released"]
    tips = ends(drawing, len(joined))
    chords = chord_turns(at[joined[:, 1]] - at[joined[:, 0]], moved[joined[:, 1]] - moved[joined[:, 0]])
    found = [np.where((released[tips[:, side]] != 0)[:, None, None], chords, turn[joined[:, side]]) for side in (0, 1)]
    return found[0], found[1]
