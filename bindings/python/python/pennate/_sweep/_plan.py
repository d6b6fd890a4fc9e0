"""Which designs are solved: all combinations of some values, or a list."""

from __future__ import annotations

import decimal
from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from .. import _arguments, _core
from .._network import Network

Array = npt.NDArray[np.float64]

# More are a slip of the pen: what is kept of each design would not fit into memory.
MOST = 100_000_000
# Column with the numbers of the designs of a list.
DESIGN = "design"
# What tables have beside parameters and probes.
TAKEN = ("status", "stable", "error", "reason")
# Corners of more parameters than this are too many to be solved for the mesh.
CORNERS = 4


def digits(value: float) -> str:
    """A number as `pennate sweep` writes it: the shortest text that reads as the same double, without an exponent."""
    text = repr(value)
    if text.endswith(".0"):
        return text[:-2]
    return format(decimal.Decimal(text), "f") if "e" in text else text


class Plan:
    """Designs by number; each has one value of every parameter."""

    parameters: tuple[str, ...]
    count: int
    axes: list[Array] | None
    """The values of each parameter, where all combinations are solved, the last parameter running fastest."""

    def __init__(self, parameters: tuple[str, ...], axes: list[Array] | None, rows: Array | None) -> None:
        self.parameters, self.axes, self._rows = parameters, axes, rows
        self.count = len(rows) if rows is not None else int(np.prod([float(len(axis)) for axis in axes or []]))
        if not 0 < self.count <= MOST:
            raise ValueError(f"{self.count} designs: one at least, and {MOST} at most, expected")
        columns: list[Array] = axes if axes is not None else [] if rows is None else list(rows.T)
        self._texts = [[digits(value) for value in column.tolist()] for column in columns]
        self._places = [{text: place for place, text in enumerate(texts)} for texts in self._texts]

    @property
    def shape(self) -> tuple[int, ...]:
        """Of an array with one entry a design."""
        return tuple(len(axis) for axis in self.axes) if self.axes is not None else (self.count,)

    @property
    def heads(self) -> list[str]:
        """Columns that tell rows of the table from each other."""
        return list(self.parameters) if self.axes is not None else [DESIGN, *self.parameters]

    def rows(self, numbers: Sequence[int] | npt.NDArray[np.int64]) -> Array:
        """(n, k), the values of some designs."""
        if self._rows is not None:
            return self._rows[numbers]
        places = np.unravel_index(np.asarray(numbers), self.shape)
        return np.stack([axis[place] for axis, place in zip(self.axes or [], places)], axis=1)

    def keys(self, begin: int, end: int) -> list[tuple[str, ...]]:
        """The first columns of consecutive rows."""
        if self._rows is not None:
            numbers = [str(number) for number in range(begin + 1, end + 1)]
            return list(zip(numbers, *(texts[begin:end] for texts in self._texts)))
        places = np.unravel_index(np.arange(begin, end), self.shape)
        columns = [[texts[each] for each in place.tolist()] for texts, place in zip(self._texts, places)]
        return list(zip(*columns))

    def number(self, keys: Sequence[str]) -> int | None:
        """The design of a row; nothing where the plan has none like it."""
        if self._rows is not None:
            place = int(keys[0]) - 1 if keys[0].isdecimal() else -1
            known = 0 <= place < self.count and all(texts[place] == key for texts, key in zip(self._texts, keys[1:]))
            return place if known else None
        number = 0
        for places, key in zip(self._places, keys):
            place = places.get(key, -1)
            if place < 0:
                return None
            number = number * len(places) + place
        return number

    def sample(self) -> Array:
        """Designs that a common mesh is made for: the middle first, then the corners, or the least and greatest of each."""
        if self._rows is not None:
            low, high = self._rows.min(0), self._rows.max(0)
            span = np.where(high > low, high - low, 1.0)
            middle = self._rows[int(np.argmin((((self._rows - (low + high) / 2) / span) ** 2).sum(1)))]
            ends = [self._rows[int(place)] for place in (*self._rows.argmin(0), *self._rows.argmax(0))]
            return _distinct([middle, *ends])
        axes = [np.sort(axis) for axis in self.axes or []]
        middle = np.array([axis[len(axis) // 2] for axis in axes])
        ends = []
        if sum(len(axis) > 1 for axis in axes) <= CORNERS:
            corners = np.meshgrid(*([axis[0], axis[-1]] for axis in axes), indexing="ij")
            ends = list(np.stack(corners, axis=-1).reshape(-1, len(axes)))
        else:
            for place, axis in enumerate(axes):
                for value in (axis[0], axis[-1]):
                    ends.append(middle.copy())
                    ends[-1][place] = value
        return _distinct([middle, *ends])


def plan(network: Network, vary: Mapping[str, npt.ArrayLike], designs: Mapping[str, npt.ArrayLike] | None) -> Plan:
    """The designs that a caller asks for."""
    if designs is not None and vary:
        raise ValueError("either values to combine or designs=, a list, not both")
    if designs is None and not vary:
        raise ValueError("nothing to vary: name parameters with their values, as in sweep(network, beta=[10, 20, 30])")
    given = vary if designs is None else designs
    known = network.parameters
    for name in given:
        if name not in known:
            where = f"'{name}' is among {'the values to combine' if designs is None else 'the columns of designs='}"
            raise _core.unknown(f"the network has no parameter '{name}' to vary", name, list(known), "parameters", [where])
        if name in (TAKEN if designs is None else (DESIGN, *TAKEN)):
            raise ValueError(f"a parameter called '{name}' cannot be varied: the table has something of that name")
    columns = [_numbers(name, values) for name, values in given.items()]
    if designs is None:
        for name, column in zip(given, columns):
            if len(np.unique(column)) < len(column):
                raise ValueError(f"'{name}' has a value twice: each is solved once")
        return Plan(tuple(given), columns, None)
    lengths = {len(column) for column in columns}
    if len(lengths) > 1:
        counts = ", ".join(f"'{name}' {len(column)}" for name, column in zip(given, columns))
        raise ValueError(f"designs: as many values of every parameter expected, but there are of {counts}")
    return Plan(tuple(given), None, np.stack(columns, axis=1))


def _numbers(name: str, values: npt.ArrayLike) -> Array:
    column = np.atleast_1d(_arguments.numbers(values, f"'{name}'"))
    if column.ndim != 1 or not len(column):
        raise ValueError(f"'{name}': one or more numbers in a row expected, not an array of the shape {column.shape}")
    _arguments.finite(column, f"'{name}'")
    # -0 would be another row than 0.
    return column + 0.0


def _distinct(rows: Sequence[Array]) -> Array:
    return np.array(list(dict.fromkeys(tuple(row.tolist()) for row in rows)))
