"""NSGA-II and CMA-ES, each by asking for batches of designs in 0..1."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ._evaluate import Evaluator, error
from ._front import costs, dominated, front, hypervolume, undominated
from ._study import Study, Values
from ._table import Design

Listener = Callable[[dict[str, float], Sequence[Design]], object]
"""Hears of every batch: a line of progress, and the best designs so far."""

# Objective of a design that violates a constraint, in a method that knows no constraints: worse than what is feasible.
INFEASIBLE = 1e6


def note(evaluator: Evaluator, listener: Listener, designs: Sequence[Design], /, **values: float) -> None:
    """One line of progress."""
    counts = {"batch": evaluator.batch, "solved": evaluator.asked, "failed": evaluator.failed}
    entry = {**{key: float(count) for key, count in counts.items()}, **values}
    evaluator.progress.append(entry)
    listener(entry, designs)


def first(evaluator: Evaluator) -> Values:
    """(n, variables), the designs in 0..1 that a search begins with."""
    inside: Values = (evaluator.study.first - evaluator.low) / evaluator.span
    return np.clip(inside, 0.0, 1.0)


def nsga2(evaluator: Evaluator, listener: Listener) -> None:
    """Several objectives: NSGA-II of pymoo, with constraints as it knows them."""
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.evaluator import Evaluator as Judge
    from pymoo.core.problem import Problem
    from pymoo.problems.static import StaticProblem

    study = evaluator.study
    space = Problem(n_var=len(study.variables), n_obj=len(study.objectives), n_ieq_constr=1, xl=0.0, xu=1.0)
    options: dict[str, Any] = {"pop_size": study.population}
    given = first(evaluator)
    if len(given) > study.population:
        # All along the table: a front has one end at its top.
        given = given[np.linspace(0, len(given) - 1, study.population).round().astype(int)]
    if len(given):
        others = np.random.default_rng(study.seed).random((study.population - len(given), len(study.variables)))
        options["sampling"] = np.vstack([given, others])
    search = NSGA2(**options)
    search.setup(space, termination=("n_gen", study.generations), seed=study.seed, verbose=False)
    volumes: list[float] = []
    best: list[Design] = []
    while search.has_next() and not evaluator.is_spent():
        asked: Any = search.ask()
        designs = evaluator(np.asarray(asked.get("X"), dtype=np.float64))
        violation = np.array([[design.violation] for design in designs])
        cost = np.nan_to_num(costs(study, designs), nan=0.0, posinf=0.0, neginf=0.0)
        Judge().eval(StaticProblem(space, F=cost, G=violation), asked)
        search.tell(infills=asked)
        # What was dominated stays so.
        best = front(study, best + evaluator.table.batches.get(evaluator.batch - 1, []))
        volumes.append(hypervolume(study, best))
        note(evaluator, listener, best, hypervolume=volumes[-1], population=_population(study, search.pop))
        over = int(study.stop.get("over", 50))
        gain = study.stop.get("hypervolume_gain")
        if gain is not None and len(volumes) > over and volumes[-1] <= volumes[-1 - over] * (1 + gain):
            break


def _population(study: Study, population: Any) -> float:
    """The hypervolume of the designs that the method goes on with, without those that it has left behind."""
    if not study.reference:
        return float("nan")
    cost = np.array([each.F for each in population if each.feas], dtype=np.float64).reshape(-1, len(study.objectives))
    return dominated(study, cost[undominated(cost)] if len(cost) else cost)


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
        bad = (violation > 0.0) | ~np.isfinite(value)
        search.tell(asked, np.where(bad, INFEASIBLE * (1.0 + violation), value).tolist())
        best = front(study, best + evaluator.table.batches.get(evaluator.batch - 1, []))
        least = min([least, *value[~bad].tolist()])
        note(evaluator, listener, best, best=least)
        if least <= study.stop.get("error", -np.inf):
            break
