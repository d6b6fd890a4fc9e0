"""One design, solved as `Network.solve` solves it, and told as a row of `pennate sweep`."""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Callable, Sequence
from typing import Any

from .. import _core
from .._errors import InternalError, MechanismError, NetworkError
from .._network import Network

NOTHING = float("nan")


@dataclasses.dataclass(frozen=True)
class Row:
    """What came of a design."""

    values: list[float]
    """One a probe; not a number where there is none."""
    status: str
    stable: bool | None = None
    error: float = NOTHING
    reason: str = ""


def solved_alone(
    network: Network,
    parameters: Sequence[str],
    row: Sequence[float],
    probes: Sequence[str],
    accuracy: float,
    wanted: Callable[[], bool],
) -> Row:
    """Solves a network with values for some of its parameters, as `Network.set` takes them.

    `probes` are read at the ends of steps that converged with all before them: behind them the state is another one than the
    name says. The solve is given up where it is not wanted any longer.
    """
    settings = network._set(dict(zip(parameters, row)))
    try:
        solution, raised = network._read.with_settings(settings).solve(accuracy, 1, False, None, wanted)
    except MechanismError as error:
        motions = [str(motion) for motion in error.motions] or [each.message for each in error.errors]
        return _refused(probes, (motions or ["the network is a mechanism"])[0])
    except NetworkError as error:
        return _refused(probes, error.errors[0].message if error.errors else str(error))
    except InternalError as error:
        return Row([NOTHING] * len(probes), "failed", reason=" ".join(str(error).split()))
    if raised is not None:
        raise raised
    return _told(solution, network, probes)


def _refused(probes: Sequence[str], reason: str) -> Row:
    return Row([NOTHING] * len(probes), "wrong_input", reason=reason)


def _told(solution: _core.Solution, network: Network, probes: Sequence[str]) -> Row:
    facts = solution.facts()
    statuses, steps = facts["statuses"], facts["steps"]
    whole = next((place for place, status in enumerate(statuses) if status != "converged"), len(steps))
    table = solution.probes()[0]
    names = facts["probes"]
    values = []
    for wanted in probes:
        probe, _, step = wanted.partition("@")
        place = steps.index(step) if step else len(steps) - 1
        values.append(float(table[place, names.index(probe)]) if place < whole else NOTHING)
    estimated = facts["accuracy"][1]
    status, reason = _reason(solution, facts)
    return Row(values, status, _stable(facts), NOTHING if estimated is None else float(estimated), reason)


def _stable(facts: dict[str, Any]) -> bool | None:
    """Whether the ends of all steps that got somewhere are stable."""
    ends = [stable for stable, count in zip(facts["stable"], facts["increments"]) if count]
    if any(stable is False for stable in ends):
        return False
    return True if ends and all(stable is True for stable in ends) else None


def _reason(solution: _core.Solution, facts: dict[str, Any]) -> tuple[str, str]:
    """How it ended, and what a person should know about it."""
    status = str(facts["status"])
    if status != "converged" or facts["accuracy"][3] != "met":
        failures = solution.failures()
        if failures:
            return "no_estimate" if status == "converged" else status, failures[0].message
    ends = list(zip(facts["steps"], facts["statuses"], facts["stable"]))
    for step, ended, stable in ends:
        if ended == "converged" and stable is False:
            return status, f"step '{step}' ends in an unstable state"
    if any(stable is None for _, _, stable in ends):
        for step in json.loads(solution.json())["steps"]:
            if step.get("undecided"):
                return status, f"step '{step['name']}' ends {step['undecided']}"
    return status, ""
