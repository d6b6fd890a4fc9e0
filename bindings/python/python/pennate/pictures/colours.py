"""Colours: those of a theme, and the limits of those of a field, which the digits of the results decide."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from matplotlib.colors import to_rgb

from .._look.fields import Field, Scale, ticks
from .results import Array, PictureError, Run, Shape, State

Colour = tuple[float, float, float]


@dataclasses.dataclass(frozen=True)
class Theme:
    """Colours of everything that has no value."""

    paper: str
    ink: str
    # Names of members, and what else may stand back.
    faint: str
    # Loads and the reactions of what steps hold.
    load: str
    # Symbols of supports in the plane, and surfaces of supports in space.
    support: str
    ground: str
    body: str
    ghost: str
    ghost_opacity: float
    muscle: str
    member: str
    # Lines along the edges of what is seen; on dark paper they must not swallow thin members.
    edge: str
    edge_opacity: float


LIGHT = Theme(
    paper="#ffffff",
    ink="#1a1d21",
    faint="#5b6470",
    load="#0b7a3b",
    support="#454d57",
    ground="#a3acb6",
    body="#66758a",
    ghost="#aab3bf",
    ghost_opacity=0.42,
    muscle="#d9a48f",
    member="#8fa9c4",
    edge="#15181c",
    edge_opacity=0.75,
)
DARK = Theme(
    paper="#0d1117",
    ink="#e8ebef",
    faint="#a4adb8",
    load="#57d98a",
    support="#aeb7c2",
    ground="#97a1ad",
    body="#7d8ba0",
    ghost="#7c8794",
    ghost_opacity=0.45,
    muscle="#d9a48f",
    member="#8fa9c4",
    edge="#05070a",
    edge_opacity=0.35,
)


def fields(run: Run) -> dict[str, Field]:
    """All fields that can be drawn, by the names that the command line knows."""
    force, moment = run.force_unit, f"{run.force_unit} {run.length_unit}"
    every = [
        Field("axial_force", "axial force", force, "force", True),
        Field("shear_force_2", "shear force along axis 2", force, "force", True),
        Field("shear_force_3", "shear force along axis 3", force, "force", True),
        Field("torque", "torque", moment, "moment", True),
        Field("bending_moment_2", "bending moment about axis 2", moment, "moment", True),
        Field("bending_moment_3", "bending moment about axis 3", moment, "moment", True),
        Field("strain_axial", "axial strain", "", "force", True),
        Field("strain_induced", "induced strain", "", "input", True),
        Field("curvature", "curvature", f"1/{run.length_unit}", "moment", False),
        Field("pressure", "pressure", run.pressure_unit, "input", False),
        Field("displacement", "displacement", run.length_unit, "displacement", False),
    ]
    return {field.key: field for field in every}


def field_named(run: Run, name: str) -> Field:
    """The field of a name."""
    known = fields(run)
    if name not in known:
        raise PictureError(f"there is no field '{name}'; there are {', '.join(known)}")
    return known[name]


def values(field: Field, shape: Shape) -> Array:
    """The value on every line between two points; NaN on the lines of rigid bodies."""
    rigid = shape.cell_data["member_id"] < 0
    if field.key == "displacement":
        lengths = np.linalg.norm(shape.point_data["displacement"], axis=1)
        found = lengths[shape.cells].mean(axis=1)
    else:
        found = np.asarray(shape.cell_data[field.key], dtype=np.float64)
    return np.where(rigid, np.nan, found)


def noise(field: Field, run: Run, state: State, found: Array) -> float:
    """What rounding and the mesh leave uncertain of the values of a state.

    Both are stated relative to the largest value of the kind in the step: digits of rounding for each kind, one figure
    for the mesh. A kind that has no digits is rounding alone, so everything is uncertain.
    """
    if field.kind == "input" or state.step is None:
        return 0.0
    step = run.steps[state.step]
    digits = step.digits.get(field.kind)
    if digits is None:
        return math.inf
    own = float(np.nanmax(np.abs(found), initial=0.0))
    # Strains and curvatures are as certain as the forces and moments that they come from.
    derived = field.key in ("strain_axial", "curvature")
    largest = own if derived else max(own, step.largest[field.kind])
    return float(largest * max(10.0**-digits, run.mesh_error))


def painted(colouring: Scale, found: Array, default: str) -> Array:
    """Red, green and blue, 0 to 1, of values; the default colour where there is but one value."""
    if colouring.uniform:
        return np.tile(to_rgb(default), (len(found), 1))
    return colouring.colours(found) / 255.0


def colouring(field: Field, run: Run, states: list[tuple[State, Shape]]) -> Scale:
    """The colours of a field in several states, with one legend for all of them."""
    lows, highs, uncertain = [], [], []
    for state, shape in states:
        found = values(field, shape)
        error = noise(field, run, state, found)
        if np.isnan(found).all():
            continue
        # What is below the noise is zero, and the ends of a range narrower than it are one value.
        significant = np.where(np.abs(found) <= error, 0.0, found)
        lows.append(float(np.nanmin(significant)))
        highs.append(float(np.nanmax(significant)))
        uncertain.append(error)
    low, high = min(lows, default=0.0), max(highs, default=0.0)
    spread = max((error for error in uncertain if math.isfinite(error)), default=0.0)
    if high - low <= spread:
        middle = 0.5 * (low + high)
        return Scale(field, middle, middle)
    # Zero is always on the bar, so that a small variation of a large value does not look like a large one.
    marks = ticks(min(low, 0.0), max(high, 0.0))
    return Scale(field, marks[0], marks[-1], marks)
