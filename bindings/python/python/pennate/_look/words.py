"""Verdicts and findings in plain sentences."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .._solution import Solution

STABLE = "Stable: after a small push it comes back."
UNSTABLE = "Unstable: the smallest push makes it leave this state."
UNKNOWN = "Stability is not known: the loads have no potential, so that no count of signs can say it."
IN_PLANE = "Stable in its plane: after a small push in the plane it comes back. Out of the plane nothing was judged."


def verdict(stable: bool | None, judged: str = "space", dimension: str = "space") -> str:
    """The verdict of stability; `judged` is `"plane"` where a plane network was judged in its plane alone."""
    if stable is None:
        return UNKNOWN
    if not stable:
        return UNSTABLE
    return IN_PLANE if judged == "plane" and dimension == "plane" else STABLE


def status(step: Mapping[str, Any]) -> str:
    """How a step of `results.json` ended, in words."""
    kind = str(step["status"]).replace("_", " ")
    if kind == "converged":
        return "reached its end"
    if kind == "not reached":
        return "was not tried"
    if "prestress" in step:
        return f"ended at {100 * step['prestress']:.4g} % of the prestress, before its ramp: {kind}"
    return f"ended at {100 * step['fraction']:.4g} % of its ramp: {kind}"


def critical(step: Mapping[str, Any], units: str) -> list[str]:
    """What a path passed or stopped at, a sentence each; `units` are those of the network."""
    length, force = {"mm-N-MPa": ("mm", "N"), "m-N-Pa": ("m", "N")}[units]
    found = [
        f"{point['kind'].replace('_', ' ').capitalize()} at {100 * point['fraction']:.5g} % of "
        + ("the prestress before " if point.get("prestress") else "")
        + f"step '{step['name']}'"
        + (f", where {_place(point)} moves most." if point.get("node") else ".")
        for point in step["critical_points"]
    ]
    for jump in step.get("jumps", []):
        found.append(
            f"At {100 * jump['fraction']:.5g} % of step '{step['name']}' it snaps to the next stable equilibrium: "
            f"{_place(jump)} moves by {jump['moved']:.6g} {length}, {jump['energy_released']:.6g} {force} {length} of energy are released."
        )
    return found


def _place(of: Mapping[str, Any]) -> str:
    """The member that a point or a snap is of, or else the node."""
    return f"member {of['member']}" if "member" in of else f"node {of['node']}"


def findings(solution: Solution) -> list[tuple[str, str, list[str], str]]:
    """What the run said: severity, message, notes and help of each."""
    every = (*solution.warnings, *solution.failures)
    return [(each.severity, each.message, list(each.notes), each.help or "") for each in every]
