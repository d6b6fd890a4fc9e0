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
    discount: float
    strides: tuple[int, ...] = br2.STRIDES
    batch: int = 256


RECIPES = {
    # 2 x 500 [G]; rates five and ten times those printed (2e-5, 1e-4), with which a prototype had 32 % after 3,700 episodes.
    "ddpg": Recipe("continuous", br2.CONTINUOUS, 500, (1e-4, 1e-3), 2000, 0.9),
    # 3 x 512, tanh [G]; errors in mm, no rounding, a falling rate and much exploration: a prototype with the printed ones (0.002,
    # 0.1) came to 8 to 60 %. The way to the target is seen in 5 cm.
    "dqn": Recipe("discrete", replace(br2.DISCRETE, unit=1.0, rounding=0.0, scale=50.0), 512, (1e-3,), 3000, 0.9),
    # The same with the smallest strides alone, for Fig. 35: four times as many moves, and as many more of them looked ahead.
    "fine": Recipe(
        "discrete",
        replace(br2.DISCRETE, unit=1.0, rounding=0.0, scale=50.0, steps=160),
        512,
        (1e-3,),
        3000,
        0.97,
        (1,),
    ),
}
