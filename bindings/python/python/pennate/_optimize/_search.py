"""NSGA-II, CMA-ES and least squares, each by asking for batches of designs in 0..1."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from ._study import Study
from ._table import Design

if TYPE_CHECKING:
    from ._run import Evaluator

Values = npt.NDArray[np.float64]
Listener = Callable[[dict[str, float]], object]

# Objective of a design that violates a constraint, in a method that knows no constraints: worse than what is feasible.
INFEASIBLE = 1e6


def costs(study: Study, designs: list[Design]) -> Values:
    """(n, objectives), what is made least."""
    signs = np.array([each.sign for each in study.objectives])
    found: Values = np.array([design.wanted[: len(signs)] for design in designs]).reshape(len(designs), len(signs)) * signs
    return found


def front(study: Study, designs: list[Design]) -> list[Design]:
    """Feasible designs that no other one is better than, by the first objective; of one objective or of targets the best one."""
    from ._run import error

    feasible = [design for design in designs if design.violation == 0.0]
    if not feasible:
        return []
    if study.targets:
        return [min(feasible, key=lambda design: (error(study, design), design.number))]
    cost = costs(study, feasible)
    if cost.shape[1] == 1:
        return [feasible[int(np.argsort(cost[:, 0], kind="stable")[0])]]
    kept: list[int] = []
    # In the order of all objectives, a design is only dominated by those before it; of equal ones the first stays.
    for k in np.lexsort((np.arange(len(cost)), *cost.T[::-1])):
        if not (cost[kept] <= cost[k]).all(1).any():
            kept.append(int(k))
    return [feasible[k] for k in kept]


def hypervolume(study: Study, designs: list[Design]) -> float:
    """Of two objectives that are made greatest: the area between the front and zero; else not a number."""
    if len(study.objectives) != 2 or any(each.sign > 0 for each in study.objectives):
        return float("nan")
    best = front(study, designs)
    points = -costs(study, best)
    points = points[(points > 0).all(1)]
    points = points[np.argsort(-points[:, 0], kind="stable")]
    area, height = 0.0, 0.0
    for u, f in points:
        if f > height:
            area += u * (f - height)
            height = f
    return float(area)


def note(evaluator: Evaluator, listener: Listener, **values: float) -> None:
    """One line of progress."""
    solved = [design for design in evaluator.table.order if design.batch < evaluator.batch]
    failed = sum(design.status != "solved" for design in solved)
    entry = {"batch": float(evaluator.batch), "solved": float(len(solved)), "failed": float(failed), **values}
    evaluator.progress.append(entry)
    listener(entry)


def nsga2(evaluator: Evaluator, listener: Listener) -> None:
    """Several objectives: NSGA-II of pymoo, with constraints as it knows them."""
    from pymoo.algorithms.moo.nsga2 import NSGA2
    from pymoo.core.evaluator import Evaluator as Judge
    from pymoo.core.problem import Problem
    from pymoo.problems.static import StaticProblem

    study = evaluator.study
    space = Problem(n_var=len(study.variables), n_obj=len(study.objectives), n_ieq_constr=1, xl=0.0, xu=1.0)
    search = NSGA2(pop_size=study.population)
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
        best = front(study, best + [design for design in evaluator.table.order if design.batch == evaluator.batch - 1])
        volumes.append(hypervolume(study, best))
        note(evaluator, listener, hypervolume=volumes[-1])
        over = int(study.stop.get("over", 50))
        gain = study.stop.get("hypervolume_gain")
        if gain is not None and len(volumes) > over and volumes[-1] <= volumes[-1 - over] * (1 + gain):
            break


def cma_es(evaluator: Evaluator, listener: Listener) -> None:
    """One objective, or the error of targets: CMA-ES of cma from the starting design."""
    import cma

    from ._run import error

    study = evaluator.study
    start = [(each.start - each.low) / (each.high - each.low) for each in study.variables]
    options: dict[str, Any] = {"bounds": [0.0, 1.0], "seed": study.seed or 1, "verbose": -9, "tolx": 1e-12}
    options |= {"tolfun": 0.0, "tolfunhist": 0.0, "tolstagnation": 10**9, "maxiter": study.generations}
    if study.population:
        options["popsize"] = study.population
    search = cma.CMAEvolutionStrategy(start, 0.3, options)
    least = float("inf")
    while not search.stop() and not evaluator.is_spent():
        asked = search.ask()
        designs = evaluator(np.array(asked))
        cost = []
        for k, design in enumerate(designs):
            value = error(study, design) if study.targets else float(costs(study, [design])[0, 0])
            if design.violation > 0.0 or not np.isfinite(value):
                cost.append(INFEASIBLE * (1.0 + design.violation))
            else:
                cost.append(value)
                least = min(least, value)
        search.tell(asked, cost)
        note(evaluator, listener, best=least)
        if least <= study.stop.get("error", -np.inf):
            break


def least_squares(evaluator: Evaluator, listener: Listener) -> None:
    """Targets: damped Gauss-Newton steps by differences, from the starting design and the best of random ones."""
    from ._run import error

    study = evaluator.study
    start = np.array([(each.start - each.low) / (each.high - each.low) for each in study.variables])
    random = np.random.default_rng(study.seed)
    feasible = [start] if evaluator.violation(evaluator.values(start[None]), before=True)[0] == 0.0 else []
    for _ in range(1000 * study.screen):
        if len(feasible) >= study.screen:
            break
        point = random.random(len(start))
        if evaluator.violation(evaluator.values(point[None]), before=True)[0] == 0.0:
            feasible.append(point)
    if not feasible:
        return
    screened = evaluator(np.array(feasible))
    errors = [error(study, design) for design in screened]
    note(evaluator, listener, best=min(errors))
    best = min(errors)
    for k in np.argsort(errors, kind="stable")[: study.starts]:
        if np.isfinite(errors[k]):
            best = min(best, _gauss_newton(evaluator, listener, feasible[k], best))
        if best <= study.stop.get("error", 0.0) or evaluator.is_spent():
            break


# Differences are taken over this part of a range, as the error of a solution asks for.
DIFFERENCE = 1e-4
DAMPING = (1e-4, 1e-2, 1.0, 1e2, 1e4)


def _gauss_newton(evaluator: Evaluator, listener: Listener, x: Values, best: float) -> float:
    """Follows one start; the least error of a feasible design."""
    study = evaluator.study
    weights = np.sqrt([each.weight for each in study.targets])
    wanted = np.array([each.wanted for each in study.targets])

    def residuals(points: Values) -> Values:
        designs = evaluator(points, anyway=True)
        values = np.array([design.wanted[len(study.objectives) :] for design in designs])
        beyond = np.array([[design.violation] for design in designs])
        # Beyond a constraint the error grows by the size of the targets for each of its scales.
        return np.column_stack([(values - wanted) * weights, beyond * 10.0 * (1.0 + np.abs(wanted).max())])

    from ._run import error

    present = residuals(x[None])[0]
    if not np.isfinite(present).all():
        return best
    for _ in range(study.generations):
        if evaluator.is_spent():
            break
        signs = np.where(x + DIFFERENCE > 1.0, -1.0, 1.0)
        shifted = x + np.diag(DIFFERENCE * signs)
        slopes = (residuals(shifted) - present).T / (DIFFERENCE * signs)
        slopes[~np.isfinite(slopes)] = 0.0
        normal, right = slopes.T @ slopes, slopes.T @ present
        size = max(float(np.trace(normal)) / len(x), 1e-300)
        trials = np.array([np.clip(x - np.linalg.solve(normal + d * size * np.eye(len(x)), right), 0, 1) for d in DAMPING])
        found = residuals(trials)
        sums = np.where(np.isfinite(found).all(1), (found**2).sum(1), np.inf)
        k = int(np.argmin(sums))
        solved = [d for d in evaluator.table.order if d.batch < evaluator.batch and d.violation == 0.0]
        best = min([best, *(error(study, d) for d in solved[-len(x) - len(DAMPING) :])])
        note(evaluator, listener, best=best)
        if best <= study.stop.get("error", 0.0) or not sums[k] < 0.999 * (present**2).sum():
            break
        x, present = trials[k], found[k]
    return best


METHODS: dict[str, Callable[[Evaluator, Listener], None]] = {
    "nsga2": nsga2,
    "cma-es": cma_es,
    "least-squares": least_squares,
}
