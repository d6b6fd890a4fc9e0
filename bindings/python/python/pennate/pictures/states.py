"""The states that a figure shows, with what they share: colours, view, frame, and their places on paper."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from .._look.fields import Scale, number, with_unit
from . import colours
from .colours import Theme
from .paper import MILLIMETRE
from .results import Array, PictureError, Run, Shape, State
from .scene import Scene, build
from .view import Frame, View, frame_of

# Sizes on paper, in points: around a network, above it, below all, and between two.
MARGIN, HEAD, FOOT, GUTTER = 18.0, 15.0, 33.0, 8.0
# A network has at least so much room, in points.
ROOM = 12.0
# The thinnest radius that can be seen on paper, in points.
THINNEST = 0.55
# A figure is at most so high over its width, with one state and with several.
TALLEST = (0.95, 0.75)


@dataclasses.dataclass(frozen=True)
class Options:
    """What a user may choose."""

    theme: Theme = colours.LIGHT
    transparent: bool = False
    field: str = "axial_force"
    # Steps that are drawn, None being the unloaded state; all by default.
    steps: tuple[int | None, ...] = ()
    # The width on paper in millimetres, and pixels per inch.
    width: float = 170.0
    resolution: int = 200
    ghost: bool = True
    names: str = "auto"


@dataclasses.dataclass(frozen=True)
class Panel:
    """One state on the sheet."""

    state: State
    shape: Shape
    scene: Scene
    title: str
    note: str


@dataclasses.dataclass(frozen=True)
class Sheet:
    """All states, with what they share."""

    run: Run
    panels: tuple[Panel, ...]
    unloaded: Scene
    colouring: Scale
    view: View
    frame: Frame
    # Pictures of the unloaded network, which all frames of a film share.
    ghosts: dict[object, Any] = dataclasses.field(default_factory=dict, compare=False, repr=False)


@dataclasses.dataclass(frozen=True)
class Layout:
    """Rows and columns of panels, and the size of a unit of the network in points."""

    columns: int
    rows: int
    scale: float


def default_steps(run: Run) -> tuple[int | None, ...]:
    """The ends of the steps that were reached: of more than four the first, the last, and two between them."""
    reached = [index for index in range(len(run.steps)) if any(state.step == index for state in run.states)]
    if len(reached) > 4:
        reached = [reached[place] for place in np.linspace(0, len(reached) - 1, 4).round().astype(int)]
    return tuple(reached) or (None,)


def make_sheet(
    run: Run, options: Options, view: View, room: Array | None = None, states: Sequence[State] | None = None
) -> Sheet:
    """Reads the states and builds what is drawn of them; `room` is the size of a tile in points, if it is given.

    The states are those at the ends of the steps of the options, side by side, unless they are given: then each is to
    have a picture of its own.
    """
    beside = states is None
    if states is None:
        states = [run.state_after(step) for step in options.steps or default_steps(run)]
    chosen = [(state, state.load()) for state in states]
    first = run.state_after(None).load()
    field = colours.field_named(run, options.field)
    colouring = colours.colouring(field, run, chosen)

    def scenes(thinnest: float) -> tuple[Scene, list[Scene]]:
        unloaded = build(run, first, colours.values(field, first), first, thinnest)
        return unloaded, [build(run, shape, colours.values(field, shape), first, thinnest) for _, shape in chosen]

    # How thick the thinnest visible line is depends on the scale, which depends on the size of the scenes.
    unloaded, built = scenes(0.0)
    frame = frame_of(view, [unloaded, *built] if options.ghost else built)
    across = len(built) if beside else 1
    scale = lay_out(frame, across, options).scale if room is None else float((room / frame.size).min())
    thinnest = THINNEST / scale
    unloaded, built = scenes(thinnest)
    frame = frame_of(view, [unloaded, *built] if options.ghost else built)
    panels = [Panel(state, shape, scene, *captions(run, state, shape)) for (state, shape), scene in zip(chosen, built)]
    return Sheet(run, tuple(panels), unloaded, colouring, view, frame)


def captions(run: Run, state: State, shape: Shape) -> tuple[str, str]:
    """The title of a state, and what is to be known of it: pressures, and how far it came."""
    if state.step is None:
        return "as built", ""
    step = run.steps[state.step]
    parts = []
    pressures = shape.cell_data["pressure"][shape.cell_data["kind"] == 0]
    if len(pressures) and np.any(pressures):
        low, high = float(pressures.min()), float(pressures.max())
        text = with_unit(high, run.pressure_unit)
        parts.append(text if low == high else f"{number(low)} to {text}")
    if step.status != "converged":
        parts.append(f"{step.status.replace('_', ' ')} at {100 * state.fraction:.0f}\N{NO-BREAK SPACE}%")
    return step.name, ", ".join(parts)


def lay_out(frame: Frame, count: int, options: Options) -> Layout:
    """As many columns as make the network largest on a sheet of the width."""
    width = options.width * MILLIMETRE
    least = min(least_width(columns, count) for columns in range(1, count + 1))
    if width < least:
        states = f"{count} states need" if count > 1 else "one state needs"
        raise PictureError(f"width: {states} {math.ceil(least / MILLIMETRE)} mm or more, not {options.width:g}")
    best: tuple[float, Layout] | None = None
    for columns in range(1, count + 1):
        rows = math.ceil(count / columns)
        across = (width - GUTTER * (columns - 1)) / columns - 2 * MARGIN
        high = (TALLEST[count > 1] * width - FOOT) / rows - HEAD - 2 * MARGIN
        scale = min(across / float(frame.size[0]), high / float(frame.size[1]))
        # A place without a panel is worth it only where the others become much larger.
        worth = scale if columns * rows == count else 0.6 * scale
        if best is None or worth >= best[0]:
            best = worth, Layout(columns, rows, scale)
    assert best is not None and best[1].scale > 0
    return best[1]


def least_width(columns: int, count: int) -> float:
    """The width of a sheet, in points, from which on so many columns leave some room for the network in every direction."""
    rows = math.ceil(count / columns)
    across = columns * (ROOM + 2 * MARGIN) + GUTTER * (columns - 1)
    return max(across, (rows * (ROOM + HEAD + 2 * MARGIN) + FOOT) / TALLEST[count > 1])


def largest_force(panels: Sequence[Panel]) -> float:
    """The largest force that gets an arrow; one where there is none."""
    forces = [
        float(np.linalg.norm(vector))
        for panel in panels
        for joint in panel.scene.joints
        for vector in (joint.force, joint.held_by_force)
    ]
    return max(forces, default=0.0) or 1.0
