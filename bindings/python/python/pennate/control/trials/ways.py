"""Ways to bring tips to targets, side by side in one table: policies, Gauss-Newton, and both together."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from .._arms import Arm, Array
from .._hybrid import hybrid
from .._judge import setting
from .._policy import Policy, follow
from .._reach import Reach, reach
from .._servo import Servo
from .._task import Rules
from . import CM, percent, whole

HEAD = ["within 1.5 cm, %", "beyond 3 cm, %", "error, cm", "moves", "most", "states of the model", "ms"]


@dataclass(frozen=True)
class Result:
    """Where some arms ended, and what that took; arrays are over targets."""

    errors: Array
    moves: Array
    asked: Array
    """How many states the model was asked for."""
    seconds: float
    inputs: Array
    tips: Array

    def row(self) -> list[str]:
        """The figures of `HEAD`; milliseconds of processor time a target."""
        cells = [percent(self.errors <= 15.0), percent(self.errors > 30.0), f"{self.errors.mean() / CM:.2f}"]
        cells += [f"{self.moves.mean():.2f}", f"{self.moves.max():.0f}", f"{self.asked.mean():.0f}"]
        return [*cells, f"{1e3 * self.seconds / len(self.errors):.2f}"]


@lru_cache(maxsize=4)
def kept(name: str) -> Policy:
    """A policy that comes with the package."""
    return Policy.kept(name)


def by_policy(name: str, arm: Arm, starts: Array, targets: Array, rules: Rules | None = None) -> Result:
    """A kept policy by itself; its moves are at the same time what it asks the arm."""
    policy = kept(name)
    _, actions, usual = setting(policy.kind)
    begin = time.process_time()
    found = follow(policy, arm, starts, targets, actions=actions, rules=usual if rules is None else rules)
    passed = time.process_time() - begin
    return Result(found.errors, found.moves.astype(float), np.zeros(len(targets)), passed, found.inputs, found.tips)


def by_model(call: Callable[[], Reach]) -> Result:
    """Gauss-Newton, or the hybrid."""
    begin = time.process_time()
    found = call()
    passed = time.process_time() - begin
    return Result(
        found.error, found.moves.astype(float), found.jacobians.astype(float), passed, found.inputs, found.tip
    )


def ways(
    name: str, arm: Arm, model: Arm, starts: Array, targets: Array, tolerance: float, largest: tuple[float, ...] | None
) -> Iterator[tuple[str, Result]]:
    """Each way by its name, from the same starts to the same targets. What is measured is the arm's; derivatives are the model's."""

    def plain(restarts: int) -> Result:
        return by_model(
            lambda: reach(
                arm, targets, start=starts, model=model, tolerance=tolerance, largest=largest, restarts=restarts
            )
        )

    def both(policy: Policy | None) -> Result:
        return by_model(
            lambda: hybrid(arm, targets, policy, start=starts, model=model, tolerance=tolerance, largest=largest)
        )

    yield name.upper(), by_policy(name, arm, starts, targets)
    yield "Gauss–Newton", plain(0)
    yield "with restarts", plain(8)
    yield "hybrid", both(kept(name))
    yield "hybrid without policy", both(None)


def along(points: Array, start: Array, go: Callable[[Array, Array], tuple[float, int, Array, Array]]) -> Result:
    """To each waypoint from where the last one ended; `go` takes inputs and a point to error, moves, inputs and tip."""
    begin, found, inputs = time.process_time(), [], start
    for point in points:
        found.append(go(inputs, point))
        inputs = found[-1][2]
    errors, moves, ends, tips = (np.array(each, dtype=float) for each in zip(*found))
    return Result(errors, moves, np.zeros(len(points)), time.process_time() - begin, ends, tips)


def policy_along(arm: Arm, points: Array, start: Array, tolerance: float = 15.0) -> Result:
    """DDPG, waypoint by waypoint."""
    rules = replace(setting("continuous")[2], tolerance=tolerance)

    def go(inputs: Array, point: Array) -> tuple[float, int, Array, Array]:
        found = by_policy("ddpg", arm, inputs[None], point[None], rules)
        return float(found.errors[0]), int(found.moves[0]), found.inputs[0], found.tips[0]

    return along(points, start, go)


def reach_along(arm: Arm, points: Array, start: Array, tolerance: float, both: bool = False) -> Result:
    """Gauss-Newton with restarts, or the hybrid, waypoint by waypoint; the model is the arm without load."""

    def go(inputs: Array, point: Array) -> tuple[float, int, Array, Array]:
        if both:
            found = hybrid(arm, point, kept("ddpg"), start=inputs, model=whole(0), tolerance=tolerance)
        else:
            found = reach(arm, point, start=inputs, model=whole(0), tolerance=tolerance)
        return float(found.error), int(found.moves), found.inputs, found.tip

    return along(points, start, go)


def servo_along(arm: Arm, points: Array, start: Array, tolerance: float, most: int = 15) -> Result:
    """Feedback with integral action, waypoint by waypoint."""
    servo, tip = Servo(whole(0), start, tolerance=tolerance), arm.tip(start[None])[0]

    def go(inputs: Array, point: Array) -> tuple[float, int, Array, Array]:
        nonlocal tip
        moves = 0
        while np.linalg.norm(tip - point) > tolerance and moves < most:
            tip, moves = arm.tip(servo.step(tip, point)[None])[0], moves + 1
        return float(np.linalg.norm(tip - point)), moves, servo.inputs, tip

    return along(points, start, go)
