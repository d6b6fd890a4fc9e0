"""How policies are trained: what the text does not give, or gives and does not lead anywhere, is assumed."""

from __future__ import annotations

from dataclasses import dataclass, replace

from . import br2
from ._task import Rules


@dataclass(frozen=True)
class Recipe:
    """How a policy is trained. Sources: [G] given by the text, [A] assumed; see the book."""

    kind: str
    rules: Rules
    width: int
    rates: tuple[float, ...]
    memory: int
    """Moves of all arms that are remembered."""
    discount: float
    exploring: tuple[float, float, float]
    """At first, at last, and in which share of the training it falls from one to the other: random strides, or noise."""
    worth: float
    """Rewards are divided by it."""
    strides: tuple[int, ...] = br2.STRIDES
    batch: int = 256
    steps: int = 6000
    """Moves of all arms in a training, unless asked for otherwise."""
    pairs: int = 2000
    """By so many validation pairs it is judged."""

    def explores(self, step: int, last: int) -> float:
        """How much, at a move of so many."""
        first, end, share = self.exploring
        return max(end, first - (first - end) * step / (share * last))


# Errors in mm, no rounding, a falling rate: a prototype with the printed ones came to 8 to 60 %. The way to the target is seen in 5 cm.
DISCRETE = replace(br2.DISCRETE, unit=1.0, rounding=0.0, scale=50.0)

RECIPES = {
    # 2 x 500 [G]; rates five and ten times those printed (2e-5, 1e-4), with which a prototype had 32 % after 3,700 episodes.
    "ddpg": Recipe("continuous", br2.CONTINUOUS, 500, (1e-4, 1e-3), 2000, 0.9, (1.0, 0.15, 0.7), 10.0, steps=4800),
    # 3 x 512, tanh [G].
    "dqn": Recipe("discrete", DISCRETE, 512, (1e-3,), 3000, 0.9, (1.0, 0.1, 0.5), 100.0),
    # The same with the smallest strides alone, for Fig. 35: four times as many moves, and as many more of them looked ahead.
    "fine": Recipe(
        "discrete",
        replace(DISCRETE, steps=160),
        512,
        (1e-3,),
        3000,
        0.97,
        (1.0, 0.1, 0.5),
        100.0,
        (1,),
        pairs=500,
    ),
}
