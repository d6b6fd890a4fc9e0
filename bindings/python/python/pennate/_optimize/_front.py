"""Which designs are best: fronts, and how much they hold."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ._evaluate import error
from ._study import Study, Values
from ._table import Design


def costs(study: Study, designs: Sequence[Design]) -> Values:
    """(n, objectives), what is made least."""
    signs = np.array([each.sign for each in study.objectives])
    found: Values = np.array([design.wanted for design in designs]).reshape(len(designs), len(signs)) * signs
    return found


def front(study: Study, designs: Sequence[Design]) -> list[Design]:
    """Feasible designs that no other one is better than, by the first objective; of one objective or of targets the best one."""
    feasible = [design for design in designs if design.violation == 0.0]
    if len(study.objectives) < 2:
        return ranked(study, feasible)[:1]
    if not feasible:
        return []
    return [feasible[k] for k in undominated(costs(study, feasible))]


def ranked(study: Study, feasible: Sequence[Design]) -> list[Design]:
    """Designs of one objective or of targets, the best first; of equal ones the first stays first."""
    if not feasible:
        return []
    value = error(study, feasible) if study.targets else costs(study, feasible)[:, 0]
    return [feasible[k] for k in np.argsort(value, kind="stable")]


def undominated(cost: Values) -> list[int]:
    """Rows that no other row is at most equal to in all columns, in the order of the first column; of equal rows the first."""
    # In the order of all columns, a row is only dominated by those before it.
    order = np.lexsort((np.arange(len(cost)), *cost.T[::-1]))
    if cost.shape[1] == 2:
        least = np.minimum.accumulate(cost[order, 1])
        falls = np.concatenate([[True], cost[order[1:], 1] < least[:-1]])
        return [int(k) for k in order[falls]]
    kept: list[int] = []
    for k in order:
        if not (cost[kept] <= cost[k]).all(1).any():
            kept.append(int(k))
    return kept


def hypervolume(study: Study, best: Sequence[Design]) -> float:
    """What a front dominates beyond the reference; not a number where there is no reference."""
    return dominated(study, costs(study, best)) if study.reference else float("nan")


def dominated(study: Study, cost: Values) -> float:
    """The same of costs that do not dominate one another."""
    corner = np.array(study.reference) * np.array([each.sign for each in study.objectives])
    cost = cost[(cost < corner).all(1)]
    if not len(cost):
        return 0.0
    if cost.shape[1] == 2:
        return area(cost, corner)
    from pymoo.indicators.hv import Hypervolume

    return float(Hypervolume(ref_point=corner)(cost))


def area(cost: Values, corner: Values) -> float:
    """Of two columns: what rows of a front dominate up to a corner."""
    cost = cost[np.argsort(cost[:, 0], kind="stable")]
    heights = np.concatenate([[corner[1]], np.minimum.accumulate(cost[:, 1])])
    return float(((corner[0] - cost[:, 0]) * (heights[:-1] - np.minimum(heights[:-1], cost[:, 1]))).sum())
