"""Quantities that can be shown along members, and their colours."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Bytes = npt.NDArray[np.uint8]

# Compression blue, tension red; both ends and the middle keep clear of white and of black.
SIGNED = ("#2148a8", "#3f77d0", "#86aee4", "#c9ced6", "#eba27c", "#d65b3d", "#a3132d")
POSITIVE = ("#c9ced6", "#7fc3b8", "#2f95a8", "#245f97", "#2a2f78")

# Below this part of the largest value of its kind, a value is rounding.
ROUNDING = 1e-7
# Limits stay while the largest value fills at least this part of them, so that colours do not flicker as a slider moves.
FILLED = 0.4


@dataclasses.dataclass(frozen=True)
class Field:
    """A quantity: its key, its name in words, its unit, the kind of quantity whose digits it has, and whether it has a sign."""

    key: str
    words: str
    unit: str
    kind: str
    signed: bool


def fields(length: str, force: str, pressure: str) -> dict[str, Field]:
    """Those that pages offer, the usual one first."""
    moment = f"{force} {length}"
    every = (
        Field("axial_force", "tension", force, "force", True),
        Field("bending_moment", "bending moment", moment, "moment", False),
        Field("torque", "torque", moment, "moment", True),
        Field("curvature", "curvature", f"1/{length}", "moment", False),
        Field("pressure", "pressure", pressure, "input", False),
        Field("strain_axial", "axial strain", "", "force", True),
        Field("strain_induced", "induced strain", "", "input", True),
        Field("displacement", "displacement", length, "displacement", False),
    )
    return {field.key: field for field in every}


def values(drawing: Mapping[str, Any], field: Field) -> Array:
    """(lines,), the quantity on every line of a drawing; rounding is zero."""
    cells = drawing["cell_data"]
    if field.key == "displacement":
        lengths = np.linalg.norm(drawing["point_data"]["displacement"], axis=1)
        return np.asarray(lengths[drawing["lines"]].mean(axis=1))
    if field.key == "bending_moment":
        found = np.hypot(cells["bending_moment_2"], cells["bending_moment_3"])
    else:
        found = np.asarray(cells[field.key], dtype=np.float64)
    noise = ROUNDING * largest(drawing, field)
    return np.where(np.abs(found) <= noise, 0.0, found)


def largest(drawing: Mapping[str, Any], field: Field) -> float:
    """The largest value of a kind in a state: what rounding is relative to."""
    cells = drawing["cell_data"]
    forces = float(
        max(np.abs(cells[key]).max(initial=0.0) for key in ("axial_force", "shear_force_2", "shear_force_3"))
    )
    if field.kind == "force":
        own = float(np.abs(cells[field.key]).max(initial=0.0))
        return forces if field.key == "axial_force" else own
    if field.kind == "moment" and field.key != "curvature":
        size = float(np.ptp(drawing["points"], axis=0).max(initial=0.0))
        moments = ("torque", "bending_moment_2", "bending_moment_3")
        own = float(max(np.abs(cells[key]).max(initial=0.0) for key in moments))
        # The moments of a truss are rounding of its forces.
        return max(own, 1e-3 * forces * size)
    if field.key == "curvature":
        size = float(np.ptp(drawing["points"], axis=0).max(initial=0.0))
        return max(float(np.abs(cells["curvature"]).max(initial=0.0)), 1e-3 / size if size else 0.0)
    return 0.0


@dataclasses.dataclass(frozen=True)
class Scale:
    """Colours between two limits; where these are equal there is one value, and nothing to tell apart."""

    field: Field
    low: float
    high: float
    # Round numbers from the lower to the upper limit.
    marks: tuple[float, ...] = ()

    @property
    def uniform(self) -> bool:
        """Whether there is but one value."""
        return self.low == self.high

    def words(self) -> str:
        """What stands over the legend, or the one value."""
        unit = f", {self.field.unit}" if self.field.unit else ""
        if not self.uniform:
            return self.field.words + unit
        value = "zero" if self.low == 0 else with_unit(self.low, self.field.unit)
        return f"{self.field.words}: {value} throughout"

    def colours(self, found: Array) -> Bytes:
        """(n, 3), red, green and blue of values, 0 to 255; one value alone is not the end of a range."""
        if self.field.signed:
            reach = max(abs(self.low), abs(self.high)) * (2.0 if self.uniform else 1.0) or 1.0
            return mixed(SIGNED, 0.5 + 0.5 * found / reach)
        if self.uniform:
            return mixed(POSITIVE, np.where(found == 0.0, 0.0, 0.5))
        return mixed(POSITIVE, (found - self.low) / (self.high - self.low))

    def stops(self, count: int = 13) -> list[str]:
        """Colours of the legend from the lower to the upper limit, as web pages write them."""
        return ["#" + bytes(colour.tolist()).hex() for colour in self.colours(np.linspace(self.low, self.high, count))]


def scale_of(field: Field, found: Array, before: Scale | None = None) -> Scale:
    """The colours of some values, with the limits from before where these still fit."""
    found = found[np.isfinite(found)]
    low, high = float(found.min(initial=np.inf)), float(found.max(initial=-np.inf))
    if not low <= high:
        low = high = 0.0
    if high - low <= 1e-6 * max(abs(low), abs(high)):
        return Scale(field, low, low)
    if before is not None and before.field == field and not before.uniform:
        reach = max(abs(before.low), abs(before.high))
        if before.low <= low and high <= before.high and max(abs(low), abs(high)) >= FILLED * reach:
            return before
    marks = ticks(min(low, 0.0), max(high, 0.0))
    return Scale(field, marks[0], marks[-1], marks)


def mixed(stops: tuple[str, ...], part: Array) -> Bytes:
    """Colours at parts 0 to 1 of the way through some stops."""
    table = np.array([list(bytes.fromhex(stop[1:])) for stop in stops], dtype=np.float64)
    places = np.clip(np.nan_to_num(part, nan=0.5), 0.0, 1.0) * (len(stops) - 1)
    channels = [np.interp(places, np.arange(len(stops)), table[:, channel]) for channel in range(3)]
    return np.stack(channels, axis=-1).round().astype(np.uint8)


def ticks(low: float, high: float, most: int = 6) -> tuple[float, ...]:
    """At most so many round numbers, equally far apart, of which the first and the last enclose a range."""
    span = high - low
    if not (span > 0 and math.isfinite(span)):
        return (low,)
    power = 10.0 ** math.floor(math.log10(span / (most - 1)))
    for factor in (1.0, 2.0, 2.5, 5.0, 10.0, 20.0, 50.0):
        step = factor * power
        first, last = math.floor(low / step + 1e-9), math.ceil(high / step - 1e-9)
        if last - first < most:
            return tuple(place * step for place in range(first, last + 1))
    return (low, high)


def number(value: float, digits: int = 3) -> str:
    """As a person would write it."""
    if not math.isfinite(value):
        return "–"
    if value == 0.0:
        return "0"
    if not 1e-3 <= abs(value) < 10.0 ** max(digits, 5):
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        mantissa = mantissa.rstrip("0").rstrip(".") if "." in mantissa else mantissa
        raised = str(int(exponent)).translate(str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"))
        return f"{mantissa}·10{raised}".replace("-", "\N{MINUS SIGN}")
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    text = f"{value:.{decimals}f}"
    text = text.rstrip("0").rstrip(".") if "." in text else text
    return text.replace("-", "\N{MINUS SIGN}")


def with_unit(value: float, unit: str, digits: int = 3) -> str:
    """A number and its unit, with a space that does not break."""
    return f"{number(value, digits)}\N{NO-BREAK SPACE}{unit}" if unit else number(value, digits)


def with_error(value: float, error: float, unit: str) -> str:
    """A number with as many digits as its error leaves, and the error behind it."""
    if not math.isfinite(value):
        return "–"
    if not (math.isfinite(error) and error > 0):
        return with_unit(value, unit, 7)
    digits = (
        7 if value == 0 else int(np.clip(math.floor(math.log10(abs(value))) - math.floor(math.log10(error)) + 1, 1, 10))
    )
    if abs(value) < error:
        return f"0 ± {number(error, 2)}\N{NO-BREAK SPACE}{unit}".rstrip()
    return f"{fixed(value, digits)} ± {number(error, 2)}\N{NO-BREAK SPACE}{unit}".rstrip()


def fixed(value: float, digits: int) -> str:
    """A number with so many digits, zeros at its end included."""
    if value == 0.0 or not 1e-3 <= abs(value) < 1e7:
        return number(value, digits)
    decimals = max(0, digits - 1 - math.floor(math.log10(abs(value))))
    return f"{value:.{decimals}f}".replace("-", "\N{MINUS SIGN}")
