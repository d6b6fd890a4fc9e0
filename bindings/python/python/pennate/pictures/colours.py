"""Colours: those of a theme, and those of a field, or the words for a field that has one value alone."""

from __future__ import annotations

import dataclasses
import math

import numpy as np
from matplotlib.colors import LinearSegmentedColormap, to_rgb
from matplotlib.ticker import MaxNLocator

from .._look import fields as _stops
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

# Compression blue, tension red; both ends and the middle keep clear of white and of black, so that they can be told
# from either paper.
SIGNED = LinearSegmentedColormap.from_list("signed", _stops.SIGNED)
POSITIVE = LinearSegmentedColormap.from_list("positive", _stops.POSITIVE)


@dataclasses.dataclass(frozen=True)
class Field:
    """A quantity that can be drawn: its name in words, its unit, and the kind of quantity whose digits it has."""

    array: str
    words: str
    unit: str
    kind: str
    signed: bool


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
    return {field.array: field for field in every}


def field_named(run: Run, name: str) -> Field:
    """The field of a name."""
    known = fields(run)
    if name not in known:
        raise PictureError(f"there is no field '{name}'; there are {', '.join(known)}")
    return known[name]


def values(field: Field, shape: Shape) -> Array:
    """The value on every line between two points; NaN on the lines of rigid bodies."""
    rigid = shape.cell_data["member_id"] < 0
    if field.array == "displacement":
        lengths = np.linalg.norm(shape.point_data["displacement"], axis=1)
        found = lengths[shape.cells].mean(axis=1)
    else:
        found = np.asarray(shape.cell_data[field.array], dtype=np.float64)
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
    derived = field.array in ("strain_axial", "curvature")
    largest = own if derived else max(own, step.largest[field.kind])
    return float(largest * max(10.0**-digits, run.mesh_error))


@dataclasses.dataclass(frozen=True)
class Colouring:
    """How a field is coloured: between two limits, or where they are equal in one colour, with its value in words."""

    field: Field
    low: float
    high: float
    # Round numbers from the lower to the upper limit.
    marks: tuple[float, ...] = ()

    @property
    def uniform(self) -> bool:
        """Whether there is but one value, so that a bar of colours would say nothing."""
        return self.low == self.high

    def words(self) -> str:
        """The one value in words."""
        text = "zero" if self.low == 0 else with_unit(self.low, self.field.unit)
        return f"{self.field.words}: {text} throughout"

    def colormap(self) -> LinearSegmentedColormap:
        """Colours from the lower to the upper limit; zero has the colour of zero in every picture."""
        if not self.field.signed:
            return POSITIVE
        reach = max(abs(self.low), abs(self.high))
        places = np.linspace(0.5 + 0.5 * self.low / reach, 0.5 + 0.5 * self.high / reach, 256)
        return LinearSegmentedColormap.from_list(f"part of {SIGNED.name}", SIGNED(places))

    def colours(self, found: Array, default: str) -> Array:
        """Red, green and blue, 0 to 1, of values; the default colour where there is but one value."""
        if self.uniform:
            return np.tile(to_rgb(default), (len(found), 1))
        part = np.clip((found - self.low) / (self.high - self.low), 0.0, 1.0)
        return np.asarray(self.colormap()(part))[:, :3]


def colouring(field: Field, run: Run, states: list[tuple[State, Shape]]) -> Colouring:
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
        return Colouring(field, middle, middle)
    # Zero is always on the bar, so that a small variation of a large value does not look like a large one.
    marks = ticks(min(low, 0.0), max(high, 0.0))
    return Colouring(field, marks[0], marks[-1], marks)


def ticks(low: float, high: float) -> tuple[float, ...]:
    """Three to six round numbers, equally far apart, of which the first and the last enclose a range."""
    marks = MaxNLocator(5, steps=[1, 2, 2.5, 5, 10], min_n_ticks=3).tick_values(low, high)
    # A mark beyond the first one that encloses the range is of no use.
    inside = [
        float(mark)
        for mark, after, before in zip(marks, [*marks[1:], np.inf], [-np.inf, *marks[:-1]])
        if after > low and before < high
    ]
    reach = 1e-9 * (inside[-1] - inside[0])
    return tuple(0.0 if abs(mark) < reach else mark for mark in inside)


def number(value: float) -> str:
    """Three digits, as a person would write them."""
    if value == 0.0:
        return "0"
    if not 1e-3 <= abs(value) < 1e5:
        mantissa, exponent = f"{value:.2e}".split("e")
        mantissa = mantissa.rstrip("0").rstrip(".")
        return f"${mantissa}\\times 10^{{{int(exponent)}}}$"
    decimals = max(0, 2 - math.floor(math.log10(abs(value))))
    text = f"{value:.{decimals}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return text.replace("-", "\N{MINUS SIGN}")


def with_unit(value: float, unit: str) -> str:
    """A number and its unit, with a space that does not break."""
    return f"{number(value)}\N{NO-BREAK SPACE}{unit}" if unit else number(value)
