"""What the page says of a state, in plain words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from .._look import fields, words
from .follow import Follow, Now
from .handles import Handle

STAYED = (
    "Shapes between nodes are carried along from the last one that was computed; the numbers are those of the state."
)
SNAPPED = (
    "It lost its stability on the way and snapped: shown is where the steps of the file lead at these values if they may "
    "snap. The motion between the two states is drawn, not computed."
)
LOST = "Here it ends: the equilibrium, or its stability, is lost."


def of_state(now: Now, follow: Follow, judged: str, asked: Mapping[str, float], handles: Sequence[Handle], snapped: bool) -> list[str]:
    """The verdict, or why the state is not the one that was asked for."""
    dimension = follow.network.dimension
    if now.lost and follow.live is not None:
        return [LOST, f"Shown is the last state before, at {stopped_at(now, asked, handles)}."]
    if now.failure:
        return [now.failure, "The last state that was reached is shown."] if follow.live else now.failure.splitlines()
    found = [words.verdict(now.stable, judged, dimension)] if now.probes else []
    return [*found, SNAPPED] if snapped else found


def stopped_at(now: Now, asked: Mapping[str, float], handles: Sequence[Handle]) -> str:
    """The values that are not those that were asked for."""
    return ", ".join(
        f"{handle.label} {fields.number(now.values[handle.name], 5)}"
        for handle in handles
        if abs(now.values[handle.name] - asked[handle.name]) > 0
    )


def judged_in(follow: Follow) -> str:
    """Whether stability was judged in space or in the plane alone."""
    if follow.network.dimension != "plane" or follow.solution is None:
        return "space"
    return str(follow.solution.to_dict()["steps"][-1]["stability"])
