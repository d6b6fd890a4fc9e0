"""The numbers of the picture that turns: states of the way through all steps, packed into one block of bytes."""

from __future__ import annotations

import base64
import dataclasses
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .._look import fields, shapes
from .._look.fields import Field, Scale, number

if TYPE_CHECKING:
    from .._solution import Solution

# The page holds at most so many bytes of states, before they are written as text.
ROOM = 4_000_000
# Grey of what has no value, ground, rigid bodies, and the unloaded shape; arrows by what they are.
GREY, GROUND, BODY, PALE = (0.62, 0.66, 0.71), (0.64, 0.68, 0.72), (0.40, 0.46, 0.54), (0.70, 0.74, 0.79)
HELD_BY = (0.75, 0.45, 0.05)
ARROWS = {"force": (0.04, 0.48, 0.23), "moment": (0.48, 0.25, 0.62), "held by": HELD_BY, "held by moment": HELD_BY}
# Seen from here, in radians: azimuth and elevation of plane and of spatial networks.
VIEWS = {"plane": (-np.pi / 2, np.pi / 2), "space": (-0.91, 0.38)}
LENGTHS = {"mm-N-MPa": ("mm", "N"), "m-N-Pa": ("m", "N")}


@dataclasses.dataclass
class State:
    """One state of the way: a drawing, and what is to be said of it."""

    drawing: dict[str, Any]
    label: str


class Block:
    """Arrays one behind the other; each is found again by its offset and its length."""

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self.length = 0

    def add(self, array: npt.NDArray[Any]) -> tuple[int, int]:
        """Where an array lies."""
        data = np.ascontiguousarray(array).tobytes()
        place = (self.length, array.size)
        data += bytes(-len(data) % 8)
        self.parts.append(data)
        self.length += len(data)
        return place

    def text(self) -> str:
        """All of it, as text."""
        return base64.b64encode(b"".join(self.parts)).decode("ascii")


def units(solution: Solution) -> tuple[str, str, str]:
    """Units of length, force and pressure."""
    return *LENGTHS[solution.network.units], solution.network.pressure_unit


def states(solution: Solution) -> list[State]:
    """The unloaded state, and those of all increments, or as many of them as there is room for."""
    way = [
        (step, increment, float(fraction))
        for step in range(len(solution.steps))
        for increment, fraction in enumerate(solution.fractions(step))
    ]
    first = solution.drawing("unloaded")
    size = 13 * len(first["points"]) + 16 * len(first["lines"])
    most = max(4, ROOM // size)
    ends = {place for place, (step, _, _) in enumerate(way) if place + 1 == len(way) or way[place + 1][0] != step}
    shown = (
        sorted(ends | set(np.linspace(0, len(way) - 1, most).round().astype(int).tolist()))
        if len(way) > most
        else range(len(way))
    )
    found = [State(first, "unloaded")]
    for place in shown:
        step, increment, fraction = way[place]
        label = f"{solution.steps[step]}, {number(100 * fraction)} %"
        found.append(State(solution.drawing(step, increment), label))
    return found


def data(solution: Solution) -> dict[str, Any]:
    """All that the picture needs, ready to be written as JSON."""
    network = solution.network
    way = states(solution)
    lined = [_own(state.drawing) for state in way]
    first, plane = way[0].drawing, network.dimension == "plane"
    whole = shapes.extent(*(state.drawing for state in way))
    length, force, pressure = units(solution)
    block = Block()
    nodes = {name: place for place, name in enumerate(network.nodes)}
    joined = np.array([[nodes[end] for end in network.ends[name]] for name in network.members], dtype=np.int64).reshape(
        -1, 2
    )
    reach = max(float(np.abs(shapes.places(state.drawing) - whole.centre).max()) for state in way)
    thickest = max(float(state.drawing["point_data"]["radius"].max()) for state in way) or 1.0
    shown = [(field, *_scaled(field, way, lined)) for field in fields.fields(length, force, pressure).values()]
    shown = [entry for entry in shown if entry[1].high != 0 or entry[1].low != 0 or entry[0].key == "axial_force"]
    own = lined[0]
    _, radii, closed = shapes.balls(first, joined, len(nodes))
    tips = shapes.ends(first, len(joined))
    thick = shapes.bars(first)[2]
    lines = [int(point) for point in np.asarray(first["lines"])[own].ravel()]
    found: dict[str, Any] = {
        "points": len(first["points"]),
        "lines": block.add(np.array(lines, dtype=np.uint32)),
        "member": first["cell_data"]["member_id"][own].tolist(),
        "members": list(network.members),
        "nodes": list(network.nodes),
        "reach": reach,
        "thickest": thickest,
        "thinnest": 0.0012 * whole.size,
        "size": whole.size,
        "middle": [0.0, 0.0, 0.0],
        "view": VIEWS["plane" if plane else "space"],
        "grey": GREY,
        "ground": GROUND,
        "body": BODY,
        "pale": PALE,
        "arrow": ARROWS,
        "balls": [
            [
                int(node),
                max(float(radius), 0.0012 * whole.size),
                [int(tips[member, side]) for member, side in np.argwhere(joined == node)],
            ]
            for node, radius in zip(closed, radii)
        ],
        "bars": [[int(a), int(b), max(thick, 0.002 * whole.size)] for a, b in shapes.bar_nodes(first)],
        "fields": [_legend(field, scale, reached) for field, scale, reached in shown],
        "states": [
            _state(block, state, whole, reach, thickest, own, shown, first, len(nodes))
            | {"supports": _supports(state, first, joined, len(nodes), plane, whole)}
            for state, own in zip(way, lined)
        ],
    }
    found["blob"] = block.text()
    return found


def _supports(
    state: State, first: dict[str, Any], joined: npt.NDArray[np.int64], nodes: int, plane: bool, whole: shapes.Extent
) -> list[list[Any]]:
    """What holds the network in a state: the page puts it behind its nodes."""
    return [
        [each.kind, each.node, _rounded(each.axis), _shift(each), max(each.size, 0.008 * whole.size)]
        for each in shapes.supports(state.drawing, first, joined, nodes, plane)
    ]


def _shift(support: shapes.Support) -> float:
    """How far behind its node a symbol stands."""
    return support.size if support.kind == "guide" else 0.0


def _own(drawing: dict[str, Any]) -> npt.NDArray[np.int64]:
    """The lines that are members."""
    return np.flatnonzero(drawing["cell_data"]["kind"] != shapes.RIGID)


def _scaled(field: Field, way: list[State], lined: list[npt.NDArray[np.int64]]) -> tuple[Scale, float]:
    """One scale for all states, and the largest value, to which the others are packed."""
    found = [fields.values(state.drawing, field)[own] for state, own in zip(way, lined)]
    every = np.concatenate(found) if found else np.zeros(1)
    return fields.scale_of(field, every), float(np.abs(every).max(initial=0.0)) or 1.0


def _legend(field: Field, scale: Scale, reach: float) -> dict[str, Any]:
    """A field as the page needs it, its legend included."""
    stops = scale.colours(np.linspace(scale.low, scale.high, 25))
    html = f"<div>{scale.words()}</div>"
    if not scale.uniform:
        marks = "".join(f"<span>{number(mark)}</span>" for mark in scale.marks)
        html = f'{html}<div class="bar" style="background:linear-gradient(90deg,{",".join(scale.stops())})"></div><div class="marks">{marks}</div>'
    return {
        "key": field.key,
        "words": field.words,
        "unit": field.unit,
        "low": scale.low,
        "high": scale.high,
        "reach": reach,
        "stops": stops.tolist(),
        "legend": html,
    }


def _state(
    block: Block,
    state: State,
    whole: shapes.Extent,
    reach: float,
    thickest: float,
    own: npt.NDArray[np.int64],
    shown: list[tuple[Field, Scale, float]],
    first: dict[str, Any],
    nodes: int,
) -> dict[str, Any]:
    """One state, packed: places to a thirty-thousandth of the size, axes to a hundredth."""
    drawing, points = state.drawing, state.drawing["point_data"]
    away = shapes.places(drawing) - whole.centre
    arrows = [
        [arrow.kind, _rounded(arrow.tail - whole.centre), _rounded(arrow.tip - whole.centre)]
        for arrow in shapes.arrows(drawing, first, nodes, whole.size)
    ]
    return {
        "label": state.label,
        "places": block.add((32767 * away / reach).round().astype(np.int16)),
        "second": block.add((127 * points["frame_e2"]).round().astype(np.int8)),
        "third": block.add((127 * points["frame_e3"]).round().astype(np.int8)),
        "radii": block.add((65535 * points["radius"] / thickest).round().astype(np.uint16)),
        "values": {
            field.key: block.add((32767 * fields.values(drawing, field)[own] / largest).round().astype(np.int16))
            for field, _, largest in shown
        },
        "arrows": arrows,
    }


def _rounded(vector: npt.NDArray[np.float64]) -> list[float]:
    return [float(f"{value:.5g}") for value in vector]
