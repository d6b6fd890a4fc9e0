"""The way through all steps, in increments that are small enough to be looked at."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .._solution import Solution


def finer(solution: Solution, frames: int, accuracy: float) -> Solution:
    """The same solution with at least so many increments a step, where the network gives it again."""
    steps = solution.network.to_dict().get("steps", [])
    if not steps:
        return solution
    asked = [{**step, "increments": max(frames, increments(step))} for step in steps]
    again = solution.network.edit(steps=asked).solve(accuracy=accuracy)
    return again if again.status == solution.status else solution


def increments(step: dict[str, object]) -> int:
    """Those that a step asks for, where they are a number."""
    asked = step.get("increments", 0)
    return asked if isinstance(asked, int) else 0
