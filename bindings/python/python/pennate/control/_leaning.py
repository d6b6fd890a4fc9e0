"""The BR2 arm where it buckles: near full bending pressure, under heavy loads, it falls to one side or the other."""

from __future__ import annotations

import numpy as np
import pennate

from ._arms import Array, Bounds, Solved

# At least this rotating pressure is taken, kPa: with less the way to a state that is about to buckle is lost. With it, 16,500 random
# states with 16.5 to 100 g, followed from a state that has no choice, were those that are solved for by themselves, to 2e-8 mm.
LEAST = 0.01


class Leaning(Solved):
    """An arm that leans to the side of the rotating actuator in use, without rotating pressure to that of the first one.

    Without any, an arm that has buckled ends on either side, as nothing pushes it to one of them: so there is always a little.
    """

    def __init__(self, network: pennate.Network, inputs: Bounds) -> None:
        super().__init__(network, inputs)
        self._place = self.names.index("Pr")

    def tip(self, inputs: Array) -> Array:
        """(n, k) inputs to (n, 3) positions; not a number where there is no equilibrium."""
        return super().tip(self._pushed(inputs))

    def jacobian(self, inputs: Array) -> tuple[Array, Array]:
        """(n, 3) positions and their derivatives by the inputs, (n, 3, k)."""
        return super().jacobian(self._pushed(inputs))

    def _pushed(self, inputs: Array) -> Array:
        pushed = np.array(inputs, dtype=np.float64)
        rotating = pushed[:, self._place]
        pushed[:, self._place] = np.where(rotating < 0, -1.0, 1.0) * np.maximum(np.abs(rotating), LEAST)
        return pushed
