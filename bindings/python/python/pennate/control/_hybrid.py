"""Both together: a policy and Gauss-Newton plan the way on a model, and what is measured on the arm corrects it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from .. import _arguments
from . import _checks, br2
from ._arms import Arm, Array
from ._policy import Policy, follow
from ._reach import Reach, Rows, reach
from ._task import Changes, Levels, Rules

# The model is to come as near to a target as this share of the tolerance, before the arm is moved.
SHARE = 0.6
# The plan is followed as long as each arrival has left less than this share of the error of the one before.
WORTH = 0.7
# More than any number of moves: of plans that end short of the target and others, the others are taken.
BEYOND = 1e3


def hybrid(
    arm: Arm,
    target: npt.ArrayLike,
    policy: Policy | None,
    *,
    start: npt.ArrayLike,
    model: Arm | None = None,
    tolerance: float = 1.0,
    moves: int = 15,
    largest: npt.ArrayLike | None = None,
    restarts: int = 8,
) -> Reach:
    """Moves an arm to targets as `reach` does, but first along a plan that costs no move.

    On the model, put beside itself by what is measured, the policy goes to the target and Gauss-Newton ends its way; so it
    does by Gauss-Newton alone. The arm goes straight to the nearer of both ends, and after each move both plans are made again
    with what was measured. Once that no longer helps, `reach` goes on. The `jacobians` of what is returned count all states that
    the model was asked for.

    Args:
        policy: Of the kind of the arm's inputs; `None` plans by Gauss-Newton alone.
        start: (k,) or (n, k) inputs to begin with, within their limits.
        moves: At most so many along the plan, and as many after it from each start.
    """
    targets = _checks.rows("target", target, 3)
    alone = np.ndim(target) == 1
    tolerance, moves = _checks.length("tolerance", tolerance), _arguments.whole(moves, "moves")
    restarts, limit = _arguments.whole(restarts, "restarts"), _checks.largest(largest, arm)
    begin = _checks.starts(start, arm, len(targets))
    plan = _Plan(arm, arm if model is None else model, targets, begin, tolerance, limit)
    plan.make(policy, restarts)
    plan.follow(policy, moves)
    found = reach(
        arm,
        targets,
        start=plan.inputs,
        model=model,
        tolerance=tolerance,
        moves=moves,
        largest=largest,
        restarts=restarts,
    )
    made, asked = plan.moves + found.moves, plan.asked + found.jacobians
    parts = (found.inputs, found.tip, found.error, found.reached, made, asked, found.restarts)
    return Reach(*((each[0] for each in parts) if alone else parts))


class _Plan:
    """Inputs at which the model is at the targets, and arms on the straight way to them."""

    def __init__(self, arm: Arm, model: Arm, targets: Array, inputs: Array, tolerance: float, largest: Array) -> None:
        self.arm, self.model, self.targets, self.tolerance = arm, model, targets, tolerance
        self.range = arm.upper - arm.lower
        self.largest = largest
        self.inputs = np.clip(inputs, arm.lower, arm.upper)
        self.tips = arm.tip(self.inputs)
        self.goals = self.inputs.copy()
        self.moves, self.asked = np.zeros(len(targets), dtype=np.int64), np.zeros(len(targets), dtype=np.int64)

    @property
    def errors(self) -> Array:
        found: Array = np.linalg.norm(self.tips - self.targets, axis=1)
        return found

    def make(self, policy: Policy | None, restarts: int) -> None:
        """Plans by Gauss-Newton and by the policy, and takes what is nearer in moves."""
        late = np.flatnonzero(self.errors > self.tolerance)
        self._aim(late, self.inputs[late], policy, restarts)

    def _aim(self, which: Rows, start: Array, policy: Policy | None, restarts: int) -> None:
        """Goals by Gauss-Newton from `start` and by the policy from where the arm is: what is nearer in moves."""
        plain = self._ended(which, start, restarts)
        self.goals[which] = plain.inputs
        if policy is None or not len(which):
            return
        actions, rules = _process(policy, self.tolerance)
        led = follow(policy, self.model, self.inputs[which], self._beside(which), actions=actions, rules=rules)
        self.asked[which] += led.moves
        ended = self._ended(which, led.inputs, 0)
        far, near = (self._count(which, each.inputs) + BEYOND * ~each.reached for each in (plain, ended))
        away, beside = (np.abs(each.inputs - self.inputs[which]).max(axis=1) for each in (plain, ended))
        better = (near < far) | ((near == far) & (beside < away))
        self.goals[which] = np.where(better[:, None], ended.inputs, plain.inputs)

    def follow(self, policy: Policy | None, moves: int) -> None:
        """Goes towards the goals, which are mended after each move by what is measured."""
        last = self.errors
        going = self.errors > self.tolerance
        for _ in range(moves):
            which = np.flatnonzero(going)
            if not len(which):
                return
            count = self._count(which, self.goals[which])
            self.inputs[which] += (self.goals[which] - self.inputs[which]) / count[:, None]
            self.tips[which] = self.arm.tip(self.inputs[which])
            self.moves[which] += 1
            arrived = which[count == 1.0]
            going &= self.errors > self.tolerance
            # What is worse than before is left to `reach`.
            going[arrived] &= self.errors[arrived] < WORTH * last[arrived]
            last[arrived] = self.errors[arrived]
            which = np.flatnonzero(going)
            self._aim(which, self.goals[which], policy, 0)

    def _beside(self, which: Rows) -> Array:
        """The targets of the model: where the tip measured is beside that of the model, as far beside themselves."""
        self.asked[which] += 1
        found: Array = self.targets[which] + self.model.tip(self.inputs[which]) - self.tips[which]
        return found

    def _ended(self, which: Rows, start: Array, restarts: int) -> Reach:
        """Where Gauss-Newton ends on the model."""
        enough = SHARE * self.tolerance
        # The limits of the model may be others than those of the arm.
        start = np.clip(start, self.model.lower, self.model.upper)
        found = reach(self.model, self._beside(which), start=start, tolerance=enough, restarts=restarts)
        self.asked[which] += found.jacobians
        return found

    def _count(self, which: Rows, inputs: Array) -> Array:
        """How many moves lead to inputs, at least one."""
        found: Array = np.ceil((np.abs(inputs - self.inputs[which]) / self.largest).max(axis=1) - 1e-9)
        return np.maximum(found, 1.0)


def _process(policy: Policy, tolerance: float) -> tuple[Levels | Changes, Rules]:
    """What a policy of a kind may do on the model, and what is asked of it."""
    if policy.kind == "discrete":
        return Levels(br2.LEVELS), br2.DISCRETE
    return Changes(br2.LARGEST), replace(br2.CONTINUOUS, tolerance=tolerance)
