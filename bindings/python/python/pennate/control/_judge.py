"""By what a policy is judged, in training and afterwards: pairs of starts and targets that no test uses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from . import br2
from ._arms import Arm
from ._policy import Policy, Rollout, follow
from ._task import Changes, Levels, Rules, Task

# How many validation pairs there are, and the seed of all of them; the tests draw theirs from small seeds.
PAIRS, SEED = 2000, 987_654_321
# The share of pairs that one move less in the mean makes up for, where two policies are compared.
MOVE = 0.002


def setting(
    kind: str, load: float = 0.0, strides: tuple[int, ...] = br2.STRIDES
) -> tuple[Arm, Levels | Changes, Rules]:
    """The arm of a kind of policy with a load in g, what may be done with it, and what is asked for."""
    if kind == "discrete":
        rules = replace(br2.DISCRETE, rounding=0.0)
        # With smaller strides as many more moves, so that the same ways can be gone.
        return br2.table(load), Levels(br2.LEVELS, strides), replace(rules, steps=rules.steps * 4 // max(strides))
    return br2.table(load, both=True, swivel=True), Changes(br2.LARGEST), br2.CONTINUOUS


class Judge:
    """The validation pairs of a kind of policy, on the arm without load."""

    def __init__(self, kind: str, count: int = PAIRS, strides: tuple[int, ...] = br2.STRIDES) -> None:
        self.arm, self.actions, self.rules = setting(kind, strides=strides)
        task = Task(self.arm, self.actions, self.rules, count)
        task.begin(np.arange(count), [np.random.default_rng([SEED, place]) for place in range(count)])
        self.starts, self.targets = task.inputs.copy(), task.targets.copy()

    def follow(self, policy: Policy) -> Rollout:
        """Where the policy takes the arms."""
        return follow(policy, self.arm, self.starts, self.targets, actions=self.actions, rules=self.rules)

    def mark(self, policy: Policy) -> tuple[float, float]:
        """The share of pairs that end near enough to their targets, and the mean of the moves."""
        found = self.follow(policy)
        return float(np.mean(found.errors <= self.rules.success)), float(np.mean(found.moves))
