"""The way through all steps, in increments that are small enough to be looked at."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from .._solution import Solution

# Estimated errors of two solutions may both be there, and both be wrong by some factor.
MARGIN = 10.0


def finer(solution: Solution, frames: int, accuracy: float) -> Solution:
    """The same solution with at least so many increments a step, where the network gives it again.

    A step that stops after a number of increments keeps its own, as it would stop elsewhere on its path with others. So does a
    step that ends in another state when its increments are finer; where that does not help, there is no finer way, and the
    solution itself is returned.
    """
    steps = solution.network.to_dict().get("steps", [])
    kept = {place for place, step in enumerate(steps) if counts_increments(step)}
    while len(kept) < len(steps):
        asked = [step if place in kept else in_increments(step, frames) for place, step in enumerate(steps)]
        again = solution.network.edit(steps=asked).solve(accuracy=accuracy)
        elsewhere = first_elsewhere(solution, again)
        if elsewhere is None:
            return again
        if elsewhere in kept:
            break
        kept.add(elsewhere)
    return solution


def counts_increments(step: Mapping[str, Any]) -> bool:
    """Whether a step stops after a number of increments."""
    stop = step.get("stop")
    return isinstance(stop, Mapping) and "increments" in stop


def in_increments(step: Mapping[str, Any], frames: int) -> dict[str, Any]:
    """A step with at least so many increments, and with no fewer than it asks for, be it by an expression."""
    asked = step.get("increments", 0)
    if isinstance(asked, str):
        return {**step, "increments": f"= max({frames}, {asked.strip().removeprefix('=')})"}
    return {**step, "increments": max(frames, asked)}


def first_elsewhere(solution: Solution, again: Solution) -> int | None:
    """The first step at whose end another solution of the same network is in another state.

    States are the same where displacements of nodes, and forces and moments at the ends of members, differ by no more than the
    errors that the meshes and rounding leave of the largest of each kind.
    """
    errors = [found for each in (solution, again) for found in (each.asked, each.accuracy) if np.isfinite(found)]
    mine, other = vectors(solution), vectors(again)
    for place, (step, twin) in enumerate(zip(solution.to_dict()["steps"], again.to_dict()["steps"])):
        if step["status"] != twin["status"]:
            return place
        # Near a singular point the state goes by the root of the distance from it, which is known to the error of the mesh.
        error = max(errors) if step["status"] == "converged" else max(errors) ** 0.5
        for kind, digits in (step["digits"] or {}).items():
            if digits is None or kind not in mine:
                continue
            allowed = MARGIN * max(error, 10.0**-digits) * float(np.abs(mine[kind][place]).max(initial=0.0))
            if not (np.abs(mine[kind][place] - other[kind][place]) <= allowed).all():
                return place
    return None


def vectors(solution: Solution) -> dict[str, npt.NDArray[np.float64]]:
    """(steps, …, 3), what states are compared by, under the names that their digits have."""
    forces = solution.end_forces
    return {"displacement": solution.displacement, "force": forces[..., :3], "moment": forces[..., 3:]}
