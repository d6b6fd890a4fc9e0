"""The BR2 arm where it buckles: near full bending pressure, under heavy loads, it falls to one side or the other."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pennate
from pennate import Lives

from ._arms import Array, Bounds, Solved, differences

# From so much bending pressure on (kPa), below so much rotating pressure, an arm with 18 g may have two stable states.
BENT, STRAIGHT = 140.0, 7.0
# At least this rotating pressure is taken there: with less the way to a state that is about to buckle is lost.
LEAST = 0.01
# Inputs, kPa, at which it has one, and from which that of its side is followed: the sign of the second is that of the side.
ALONE = (100.0, 20.0)


class Leaning(Solved):
    """An arm that leans to the side of the rotating actuator in use, as far as that is left to it.

    A state that is solved for by itself ends on either side, where both are stable and hardly anything pushes to one of them:
    so here it is followed from a state that leans to its own. Without rotating pressure that is the side of the first actuator.
    """

    def __init__(self, network: pennate.Network, inputs: Bounds) -> None:
        super().__init__(network, inputs)
        self._place = [self.names.index(name) for name in ("Pb", "Pr")]

    def tip(self, inputs: Array) -> Array:
        """(n, k) inputs to (n, 3) positions; not a number where there is no equilibrium."""
        tips = super().tip(inputs)
        either = self._either(inputs)
        if either.any():
            tips[either] = self._followed(*inputs[either][:, self._place].T)
        return tips

    def jacobian(self, inputs: Array) -> tuple[Array, Array]:
        """(n, 3) positions and their derivatives by the inputs, (n, 3, k)."""
        tips, slopes = super().jacobian(inputs)
        either = self._either(inputs)
        if either.any():
            tips[either] = self.tip(inputs[either])
            # From where the least rotating pressure is no longer what counts.
            rows = inputs[either]
            rows[:, self._place[1]] = _at_least(rows[:, self._place[1]])
            slopes[either] = differences(self, rows, tips[either])
            self.differences += int(either.sum())
        return tips, slopes

    def _either(self, inputs: Array) -> npt.NDArray[np.bool_]:
        bending, rotating = inputs[:, self._place].T
        found: npt.NDArray[np.bool_] = (bending > BENT) & (np.abs(rotating) < STRAIGHT)
        return found

    def _followed(self, bending: Array, rotating: Array) -> Array:
        """(n, 3), the tips of states that are followed side by side."""
        lives = Lives(self.problem, len(bending))
        away = np.where(rotating < 0, -ALONE[1], ALONE[1])
        failed = np.zeros(len(bending), dtype=bool)
        for Pb, Pr in ((ALONE[0], away), (bending, away), (bending, _at_least(rotating))):
            lives.set(Pb=Pb, Pr=Pr).solve()
            failed |= [reason is not None for reason in lives.reasons]
        return np.where(failed[:, None], np.nan, lives.values)


def _at_least(rotating: Array) -> Array:
    return np.where(rotating < 0, -1.0, 1.0) * np.maximum(np.abs(rotating), LEAST)
