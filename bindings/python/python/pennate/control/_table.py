"""Tips computed beforehand, and interpolated by tensor products of cubic splines."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ._arms import Arm, Array

if TYPE_CHECKING:
    from pennate import Network

# Rows of states that are evaluated at once: what is gathered for them stays in the cache.
BLOCK = 4096


class Table:
    """An arm by a table of another one: its tips on a lattice, and cubic splines between them.

    The interpolant of an input is twice continuously differentiable but at the `kinks` of that input, where it is continuous
    only: there one-sided splines meet. Inputs beyond the limits are taken to the nearest limit.
    """

    def __init__(self, arm: Arm, counts: Sequence[int], kinks: Sequence[Sequence[float]] | None = None) -> None:
        """
        Args:
            arm: What the table is made from, by one call with all its states.
            counts: Points of the lattice along each input, limits included; each stretch between kinks has at least four.
            kinks: Of each input, values at which the slope of the tip jumps.
        """
        self.names, self.lower, self.upper = arm.names, arm.lower.copy(), arm.upper.copy()
        if len(counts) != len(self.names) or min(counts) < 4:
            raise ValueError(f"counts: {len(self.names)} numbers expected, each 4 or more, not {tuple(counts)}")
        places = [()] * len(counts) if kinks is None else kinks
        if len(places) != len(counts):
            raise ValueError(f"kinks: {len(counts)} lists expected, one for each input, not {len(places)}")
        each = zip(self.names, self.lower, self.upper, counts, places)
        self._axes = [_Axis(name, low, high, count, kinks) for name, low, high, count, kinks in each]
        lattice = np.meshgrid(*(axis.points for axis in self._axes), indexing="ij")
        states = np.stack([grid.ravel() for grid in lattice], axis=1)
        tips = arm.tip(states)
        bad = np.isnan(tips).any(axis=1)
        if bad.any():
            where = ", ".join(f"{name} = {value:.6g}" for name, value in zip(self.names, states[bad][0]))
            raise ValueError(
                f"no table: {bad.sum()} of {len(states)} states have no equilibrium, such as that at {where}"
            )
        self.network: Network | None = getattr(arm, "network", None)
        self.states = len(states)
        """How many states were solved for."""
        self._nodes = self._with_slopes(tips.reshape(*lattice[0].shape, 3))

    def _with_slopes(self, tips: Array) -> Array:
        """(points of all axes…, 2**k, 3): the tips and, in the order of `_corners`, their mixed derivatives."""
        kinds = [tips]
        for place, axis in enumerate(self._axes):
            kinds = [each for kind in kinds for each in (kind, axis.slopes(kind, place))]
        stacked = np.stack(kinds, axis=-2)
        return np.ascontiguousarray(stacked.reshape(-1, len(kinds), 3))

    def tip(self, inputs: Array) -> Array:
        return self._blocks(inputs, False)[0]

    def jacobian(self, inputs: Array) -> tuple[Array, Array]:
        return self._blocks(inputs, True)

    def _blocks(self, inputs: Array, derivatives: bool) -> tuple[Array, Array]:
        found = [self._interpolate(inputs[at : at + BLOCK], derivatives) for at in range(0, max(1, len(inputs)), BLOCK)]
        return np.concatenate([tips for tips, _ in found]), np.concatenate([slopes for _, slopes in found])

    def _interpolate(self, inputs: Array, derivatives: bool) -> tuple[Array, Array]:
        """Sums written out, so that a state has the same digits whatever its neighbours are."""
        width = len(self._axes)
        inside = np.clip(inputs, self.lower, self.upper)
        each = [axis.weights(inside[:, place], derivatives) for place, axis in enumerate(self._axes)]
        sums = np.zeros((1 + width * derivatives, len(inputs), 3))
        strides = [int(np.prod([len(axis.points) for axis in self._axes[place + 1 :]])) for place in range(width)]
        for ends in product((0, 1), repeat=width):
            node = np.zeros(len(inputs), dtype=np.intp)
            for place, end in enumerate(ends):
                node += (each[place][0] + end) * strides[place]
            values = self._nodes[node]
            for kind, kinds in enumerate(product((0, 1), repeat=width)):
                for row in range(len(sums)):
                    # Row 0 is the tip, row 1 + i its derivative by input i.
                    weight = np.ones(len(inputs))
                    for place, (end, order) in enumerate(zip(ends, kinds)):
                        weight = weight * each[place][1][int(row == 1 + place), end, order]
                    sums[row] += weight[:, None] * values[:, kind]
        return sums[0], np.moveaxis(sums[1:], 0, 2)


class _Axis:
    """Lattice points along one input, in stretches between kinks; a kink is the last point of one and the first of the next."""

    def __init__(self, name: str, low: float, high: float, count: int, kinks: Sequence[float]) -> None:
        ends = [low, *sorted(kinks), high]
        if not all(a < b for a, b in zip(ends, ends[1:])):
            raise ValueError(f"the kinks of '{name}' are {list(kinks)}, not between its limits {low} and {high}")
        shares = [(b - a) / (high - low) for a, b in zip(ends, ends[1:])]
        counts = [max(4, 1 + round(share * (count - 1))) for share in shares]
        self.stretches = [np.linspace(a, b, n) for a, b, n in zip(ends, ends[1:], counts)]
        self.points = np.concatenate(self.stretches)
        self._begins = np.array(ends[:-1])
        self._steps = np.array([points[1] - points[0] for points in self.stretches])
        self._cells = np.array([n - 1 for n in counts])
        self._firsts = np.concatenate([[0], np.cumsum(counts)[:-1]])

    def slopes(self, values: Array, axis: int) -> Array:
        """Derivatives of the splines through values along an axis of an array."""
        moved = np.moveaxis(values, axis, 0)
        found, first = np.empty_like(moved), 0
        for points in self.stretches:
            part = slice(first, first + len(points))
            found[part] = np.tensordot(_spline(len(points)) / (points[1] - points[0]), moved[part], axes=1)
            first += len(points)
        return np.moveaxis(found, 0, axis)

    def weights(self, x: Array, derivatives: bool) -> tuple[npt.NDArray[np.intp], Array]:
        """The left point of each cell, and weights [of the value or the derivative, end, order of the datum, state]."""
        stretch = np.clip(np.searchsorted(self._begins, x, side="right") - 1, 0, None)
        h = self._steps[stretch]
        s = (x - self._begins[stretch]) / h
        cell = np.clip(np.floor(s).astype(np.intp), 0, self._cells[stretch] - 1)
        t = s - cell
        u = 1.0 - t
        # Cubic Hermite polynomials, and their derivatives.
        value = [[u * u * (1 + 2 * t), h * t * u * u], [t * t * (1 + 2 * u), -h * t * t * u]]
        weights = [value]
        if derivatives:
            weights.append([[-6 * t * u / h, u * (1 - 3 * t)], [6 * t * u / h, t * (3 * t - 2)]])
        return self._firsts[stretch] + cell, np.array(weights)


def _spline(count: int) -> Array:
    """(count, count), values on points of distance 1 to slopes of the cubic spline through them, not a knot at its ends."""
    left, right = np.eye(count), np.zeros((count, count))
    for row in range(1, count - 1):
        left[row, row - 1 : row + 2] = [1.0, 4.0, 1.0]
        right[row, [row - 1, row + 1]] = [-3.0, 3.0]
    left[0, :2] = left[-1, [-1, -2]] = [1.0, 2.0]
    right[0, :3] = [-2.5, 2.0, 0.5]
    right[-1, -3:] = [-0.5, -2.0, 2.5]
    return np.asarray(np.linalg.solve(left, right), dtype=np.float64)
