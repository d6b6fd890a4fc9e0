"""A stand-in for a physical arm: another rod than the model's, with play in its valves. All of it is assumed."""

from __future__ import annotations

from functools import cache

import numpy as np
import pennate

from . import br2
from ._arms import Arm, Array, Solved, Swivelled
from ._table import Table

# Half widths of the play in Pb and Pr, kPa, and in the swivel.
PLAY = (6.0, 8.0, 0.0)
# By which share stiffness, twist and curvature are less than the model's. Besides, the rod is bent when it is built: by 0.8 and
# 1.0 1/m about its axes 2 and 3.
LESS = {"EI": 0.15, "GJ": 0.10, "twist": 0.10, "bending": 0.08}


class Bench:
    """One arm with play: an input acts once it has moved through the play, so that the tip depends on the way there."""

    def __init__(self, arm: Arm, play: Array) -> None:
        """`play` is (k,), half the width of the play of each input."""
        self.arm, self.play = arm, play
        self.names, self.lower, self.upper = arm.names, arm.lower, arm.upper
        self.acting = (arm.lower + arm.upper) / 2
        """(k,), the inputs that act on the arm."""

    def tip(self, inputs: Array) -> Array:
        """Goes from each row of inputs to the next."""
        tips = np.empty((len(inputs), 3))
        for place, wanted in enumerate(inputs):
            self.acting = np.clip(self.acting, wanted - self.play, wanted + self.play)
            tips[place] = self.arm.tip(self.acting[None])[0]
        return tips

    def jacobian(self, inputs: Array) -> tuple[Array, Array]:
        """There is none."""
        raise NotImplementedError("nobody knows the derivatives of a physical arm: give `reach` a model")


def bench(load: float = 0.0, worse: float = 1.0) -> Bench:
    """The swivelling arm as it is built, with a load in g; `worse` multiplies all that makes it differ from the model."""
    return Bench(_table(load, worse), worse * np.array(PLAY))


@cache
def _table(load: float, worse: float) -> Swivelled:
    less = {name: 1.0 - worse * share for name, share in LESS.items()}
    changed = pennate.scene("br2", load=load).edit(
        parameters={
            "EI": f"= {less['EI']} * 10700 * (1 + 1.75 * p + 1.2 * abs(q))",
            "GJ": f"= {less['GJ']} * 2000 * (1 + 0.6 * abs(q))",
            "twist": f"= {less['twist']} * 1e-3 * q * (4.2 + 4.8 * q^2)",
            "sideways": f"= 1e-3 * (0.65 * q + {0.8 * worse})",
            "bending": f"= 1e-3 * ({less['bending']} * (16 * p - 8.1 * p^2) - 0.9 * abs(q) + {1.0 * worse})",
        }
    )
    bending, rotating = br2.LEVELS
    made = Table(Solved(changed, br2.BOTH), (bending, 2 * rotating - 1), ((), (0.0,)))
    return Swivelled(made, least=-br2.SWIVEL, greatest=br2.SWIVEL)
