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
# By this share of an input's range a limit from one side is taken beside its place.
WITHIN = 3e-6


class Table:
    """An arm by a table of another one: its tips on a lattice, and cubic splines between them.

    The interpolant of an input is twice continuously differentiable but at the `kinks` of that input: there one-sided splines
    meet, each through the limit of the tip from its side, so that a tip may jump there. Inputs beyond the limits are taken
    to the nearest limit.
    """

    def __init__(
        self,
        arm: Arm,
        counts: Sequence[int],
        kinks: Sequence[Sequence[float]] | None = None,
        extra: Sequence[Sequence[float]] | None = None,
    ) -> None:
        """
        Args:
            arm: What the table is made from, by one call with all its states.
            counts: Points of the lattice along each input, limits included; each stretch between kinks has at least four.
            kinks: Of each input, values at which the tip or its slope jumps. At a limit, what counts is the tip just within.
            extra: Of each input, further points of the lattice, where the tip changes fast.
        """
        self.names, self.lower, self.upper = arm.names, arm.lower.copy(), arm.upper.copy()
        if len(counts) != len(self.names) or min(counts) < 4:
            raise ValueError(f"counts: {len(self.names)} numbers expected, each 4 or more, not {tuple(counts)}")
        lists = [[()] * len(counts) if each is None else each for each in (kinks, extra)]
        for name, each in zip(("kinks", "extra"), lists):
            if len(each) != len(counts):
                raise ValueError(f"{name}: {len(counts)} lists expected, one for each input, not {len(each)}")
        self._axes = [_Axis(*each) for each in zip(self.names, self.lower, self.upper, counts, *lists)]
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
        """(n, k) inputs to (n, 3) positions; not a number where there is no equilibrium."""
        return self._blocks(inputs, False)[0]

    def jacobian(self, inputs: Array) -> tuple[Array, Array]:
        """(n, 3) positions and their derivatives by the inputs, (n, 3, k)."""
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

    def __init__(
        self, name: str, low: float, high: float, count: int, kinks: Sequence[float], extra: Sequence[float]
    ) -> None:
        for what, values in (("kinks", kinks), ("extra points", extra)):
            if not all(low <= value <= high for value in values):
                raise ValueError(f"the {what} of '{name}' are {list(values)}, not between its limits {low} and {high}")
        ends = sorted({low, high, *kinks})
        stretches = []
        for a, b in zip(ends, ends[1:]):
            even = np.linspace(a, b, max(4, 1 + round((b - a) / (high - low) * (count - 1))))
            points = np.union1d(even, [value for value in extra if a < value < b])
            stretches.append(_within(points, kinks, WITHIN * (high - low)))
        self.points = np.concatenate(stretches)
        counts = [len(stretch) for stretch in stretches]
        self._firsts = np.concatenate([[0], np.cumsum(counts)[:-1]])
        self._lasts = np.cumsum(counts) - 1
        self._begins = np.array(ends[:-1])
        self._matrices = [_spline(stretch) for stretch in stretches]

    def slopes(self, values: Array, axis: int) -> Array:
        """Derivatives of the splines through values along an axis of an array."""
        moved = np.moveaxis(values, axis, 0)
        parts = zip(self._firsts, self._lasts, self._matrices)
        found = [np.tensordot(matrix, moved[first : last + 1], axes=1) for first, last, matrix in parts]
        return np.moveaxis(np.concatenate(found), 0, axis)

    def weights(self, x: Array, derivatives: bool) -> tuple[npt.NDArray[np.intp], Array]:
        """The left point of each cell, and weights [of the value or the derivative, end, order of the datum, state]."""
        stretch = np.clip(np.searchsorted(self._begins, x, side="right") - 1, 0, None)
        node = np.searchsorted(self.points, x, side="right") - 1
        node = np.clip(node, self._firsts[stretch], self._lasts[stretch] - 1)
        h = self.points[node + 1] - self.points[node]
        t = (x - self.points[node]) / h
        u = 1.0 - t
        # Cubic Hermite polynomials, and their derivatives.
        value = [[u * u * (1 + 2 * t), h * t * u * u], [t * t * (1 + 2 * u), -h * t * t * u]]
        weights = [value]
        if derivatives:
            weights.append([[-6 * t * u / h, u * (1 - 3 * t)], [6 * t * u / h, t * (3 * t - 2)]])
        return node, np.array(weights)


def _within(stretch: Array, kinks: Sequence[float], by: float) -> Array:
    """The points of a stretch, with those that are kinks moved into it: there the tip is that of this side."""
    found = stretch.copy()
    found[0] += by * (stretch[0] in kinks)
    found[-1] -= by * (stretch[-1] in kinks)
    return found


def _spline(points: Array) -> Array:
    """(n, n), values at n points to slopes there of the cubic spline through them, not a knot next to its ends."""
    count, h = len(points), np.diff(points)
    left, right = np.zeros((count, count)), np.zeros((count, count))
    for row in range(1, count - 1):
        a, b = 1 / h[row - 1], 1 / h[row]
        left[row, row - 1 : row + 2] = [a, 2 * (a + b), b]
        right[row, row - 1 : row + 2] = [-3 * a**2, 3 * (a**2 - b**2), 3 * b**2]
    for end, one, two in ((0, 1, 2), (-1, -2, -3)):
        # The first two cells, or the last two, are one cubic polynomial.
        a, b = abs(points[one] - points[end]), abs(points[two] - points[one])
        sign = 1 if end == 0 else -1
        left[end, [end, one]] = [b, a + b]
        first, second = b * (2 * b + 3 * a) / (a + b), a**2 / (a + b)
        right[end, [end, one, two]] = [-sign * first / a, sign * (first / a - second / b), sign * second / b]
    return np.asarray(np.linalg.solve(left, right), dtype=np.float64)
