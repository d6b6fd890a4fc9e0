"""By what a policy is judged, in training and afterwards: pairs of starts and targets that no test uses."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from . import br2
from ._arms import Arm
from ._policy import Policy, Rollout, follow
from ._task import Changes, Levels, Rules, Task

# The seed of all validation pairs; the tests draw theirs from small seeds.
SEED = 987_654_321
# The shares of pairs that one move less in the mean makes up for, and one millimetre, where two policies are compared.
MOVE, MILLIMETRE = 0.002, 0.002


def setting(
    kind: str, load: float = 0.0, strides: tuple[int, ...] = br2.STRIDES
) -> tuple[Arm, Levels | Changes, Rules]:
    """The arm of a kind of policy with a load in g, what may be done with it, and what is asked for."""
    if kind == "discrete":
        rules = replace(br2.DISCRETE, rounding=0.0)
        # With smaller strides as many more moves, so that the same ways can be gone.
        return br2.table(load), Levels(br2.LEVELS, strides), replace(rules, steps=rules.steps * 4 // max(strides))
    return br2.table(load, both=True, swivel=True), Changes(br2.LARGEST), br2.CONTINUOUS


def setting_of(policy: Policy, load: float = 0.0) -> tuple[Arm, Levels | Changes, Rules]:
    """The setting of a policy of the BR2 arm, with those of the strides for which it has values."""
    # Two inputs, each up and down by each stride.
    return setting(policy.kind, load, br2.STRIDES[: len(policy.layers[-1][1]) // 4])


class Judge:
    """The validation pairs of a kind of policy, on the arm without load."""

    def __init__(self, kind: str, count: int = 2000, strides: tuple[int, ...] = br2.STRIDES) -> None:
        self.arm, self.actions, self.rules = setting(kind, strides=strides)
        task = Task(self.arm, self.actions, self.rules, count)
        task.begin(np.arange(count), [np.random.default_rng([SEED, place]) for place in range(count)])
        self.starts, self.targets = task.inputs.copy(), task.targets.copy()

    def follow(self, policy: Policy) -> Rollout:
        """Where the policy takes the arms."""
        return follow(policy, self.arm, self.starts, self.targets, actions=self.actions, rules=self.rules)

    @property
    def limits(self) -> dict[str, list[float]]:
        """The inputs of the arm, each with its least and greatest value."""
        return {name: [low, high] for name, low, high in zip(self.arm.names, self.arm.lower, self.arm.upper)}

    def mark(self, policy: Policy) -> tuple[float, float, float]:
        """The share of pairs that end near enough to their targets, and the means of the moves and of the errors, mm."""
        found = self.follow(policy)
        share = float(np.mean(found.errors <= self.rules.success))
        return share, float(np.mean(found.moves)), float(np.mean(found.errors))


def worth(share: float, moves: float, error: float) -> float:
    """By what policies are compared: the share of pairs, less what their moves and errors are worth."""
    return share - MOVE * moves - MILLIMETRE * error
