"""Where what has a name is seen, for the page to say what the pointer is on."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from .._look import shapes
from .._look.fields import Array, Field, number, values, with_unit
from .._look.shapes import Integers

# Points of a member at most, both ends included.
POINTS = 9
# Scene coordinates lie between -1 and 1.
DIGITS = 3


def places(
    drawing: Mapping[str, Any], nodes: Sequence[str], members: Sequence[str], joined: Integers, field: Field, scaled: Callable[[Array], Array]
) -> str:
    """Members and joints with their names, points in the scene and radii there, as JSON."""
    factor = float(np.linalg.norm(scaled(np.array([[1.0, 0.0, 0.0]])) - scaled(np.zeros((1, 3)))))
    radius, at = drawing["point_data"]["radius"], scaled(shapes.places(drawing))
    found = [
        thing(f"{name}: {text}", at[points], factor * float(radius[points].mean()))
        for name, points, text in zip(members, paths(drawing, len(members)), told(drawing, len(members), field), strict=True)
        if len(points)
    ]
    centres, radii, shown = shapes.balls(drawing, joined, len(nodes))
    known = {int(node): float(size) for node, size in zip(shown, radii, strict=True)}
    least = float(radii.min()) if len(radii) else float(radius.mean())
    # A joint is a little larger than what it joins, so that it can be pointed at.
    found += [thing(f"node {name}", at[[node]], 1.15 * factor * known.get(node, least)) for node, name in enumerate(nodes)]
    return json.dumps(found, ensure_ascii=False, separators=(",", ":"))


def thing(name: str, points: Array, radius: float) -> dict[str, Any]:
    """What has a name."""
    return {"name": name, "radius": round(radius, DIGITS + 1), "points": points.round(DIGITS).tolist()}


def paths(drawing: Mapping[str, Any], members: int) -> list[Integers]:
    """Some points of each member from one end to the other."""
    ids, lines = drawing["cell_data"]["member_id"], drawing["lines"]
    own = np.flatnonzero(drawing["cell_data"]["kind"] != shapes.RIGID)
    order = own[np.argsort(ids[own], kind="stable")]
    found = []
    for rows in np.split(order, np.searchsorted(ids[order], np.arange(1, members))):
        chosen = rows[np.linspace(0, len(rows) - 1, min(POINTS - 1, len(rows))).round().astype(int)] if len(rows) else rows
        found.append(np.append(lines[chosen, 0], lines[rows[-1:], 1]))
    return found


def told(drawing: Mapping[str, Any], members: int, field: Field) -> list[str]:
    """The values of a quantity on each member in words."""
    kinds, ids = drawing["cell_data"]["kind"], drawing["cell_data"]["member_id"]
    own = kinds != shapes.RIGID
    found = values(drawing, field)[own]
    low, high = np.full(members, np.inf), np.full(members, -np.inf)
    np.minimum.at(low, ids[own], found)
    np.maximum.at(high, ids[own], found)
    return [f"{field.words} {span(least, most, field.unit)}" for least, most in zip(low.tolist(), high.tolist(), strict=True)]


def span(least: float, most: float, unit: str) -> str:
    """From the least to the largest value, or the one that both are in three digits."""
    text = with_unit(most, unit)
    return text if number(least) == number(most) else f"{number(least)} to {text}"
