"""NSGA-II and CMA-ES, each by asking for batches of designs in 0..1."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ._evaluate import Evaluator, error
from ._front import costs, dominated, front, hypervolume, undominated
from ._nsga2 import NSGA2, Population
from ._study import Study, Values
from ._table import Design

Listener = Callable[[dict[str, float], Sequence[Design]], object]
"""Hears of every batch: a line of progress, and the best designs so far."""

def note(evaluator: Evaluator, listener: Listener, designs: Sequence[Design], /, **values: float) -> None:
    """One line of progress."""
    counts = {"batch": evaluator.batch, "solved": evaluator.asked, "failed": evaluator.failures.total()}
    entry = {key: float(count) for key, count in counts.items()}
    entry |= {**values, **{kind: float(count) for kind, count in evaluator.failures.items()}}
    evaluator.progress.append(entry)
    listener(entry, designs)


def first(evaluator: Evaluator) -> Values:
    """(n, variables), the designs in 0..1 that a search begins with."""
    inside: Values = (evaluator.study.first - evaluator.low) / evaluator.span
    return np.clip(inside, 0.0, 1.0)


def nsga2(evaluator: Evaluator, listener: Listener) -> None:
    """Several objectives: NSGA-II."""
    study = evaluator.study
    given, begin = first(evaluator), None
    if len(given) > study.population:
        # All along the table: a front has one end at its top.
        given = given[np.linspace(0, len(given) - 1, study.population).round().astype(int)]
    if len(given):
        others = np.random.default_rng(study.seed).random((study.population - len(given), len(study.variables)))
        begin = np.vstack([given, others])
    search = NSGA2(study.population, len(study.variables), study.seed, begin)
    volumes: list[float] = []
    best: list[Design] = []
    for _ in range(study.generations):
        asked = search.ask()
        if not len(asked) or evaluator.is_spent():
            break
        designs = evaluator(asked)
        violation = np.array([design.violation for design in designs])
        search.tell(np.nan_to_num(costs(study, designs), nan=0.0, posinf=0.0, neginf=0.0), violation)
        # What was dominated stays so.
        best = front(study, best + evaluator.table.batches.get(evaluator.batch - 1, []))
        volumes.append(hypervolume(study, best))
        note(evaluator, listener, best, hypervolume=volumes[-1], population=_held(study, search.population))
        over = int(study.stop.get("over", 50))
        gain = study.stop.get("hypervolume_gain")
        if gain is not None and len(volumes) > over and volumes[-1] <= volumes[-1 - over] * (1 + gain):
            break


def _held(study: Study, population: Population) -> float:
    """The hypervolume of the designs that the method goes on with, without those that it has left behind."""
    if not study.reference:
        return float("nan")
    cost = population.cost[population.violation <= 0.0]
    return dominated(study, cost[undominated(cost)] if len(cost) else cost)


def ranks(value: Values, violation: Values) -> Values:
    """(n,), places in the order of merit: designs that meet all constraints by their value, then the others by their violation.

    Equal designs have equal places.
    """
    bad = (violation > 0.0) | ~np.isfinite(value)
    order = np.column_stack([bad, np.where(bad, violation, value)])
    places: Values = np.unique(order, axis=0, return_inverse=True)[1].reshape(-1).astype(np.float64)
    return places


def cma_es(evaluator: Evaluator, listener: Listener) -> None:
    """One objective, or the error of targets: CMA-ES of cma from the starting design."""
    import cma

    study = evaluator.study
    start = [(each.start - each.low) / (each.high - each.low) for each in study.variables]
    if len(study.first):
        start = first(evaluator)[0].tolist()
    options: dict[str, Any] = {"bounds": [0.0, 1.0], "seed": study.seed or 1, "verbose": -9, "tolx": 1e-12}
    options |= {"tolfun": 0.0, "tolfunhist": 0.0, "tolstagnation": 10**9, "maxiter": study.generations}
    if study.population:
        options["popsize"] = study.population
    search = cma.CMAEvolutionStrategy(start, 0.3, options)
    best: list[Design] = []
    least = float("inf")
    while not search.stop() and not evaluator.is_spent():
        asked = search.ask()
        designs = evaluator(np.array(asked))
        value = error(study, designs) if study.targets else costs(study, designs)[:, 0]
        violation = np.array([design.violation for design in designs])
        # The method knows no constraints, but of values it takes nothing except their order.
        search.tell(asked, ranks(value, violation).tolist())
        best = front(study, best + evaluator.table.batches.get(evaluator.batch - 1, []))
        least = min([least, *value[(violation <= 0.0) & np.isfinite(value)].tolist()])
        note(evaluator, listener, best, best=least)
        if least <= study.stop.get("error", -np.inf):
            break
