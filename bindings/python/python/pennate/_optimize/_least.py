"""Least squares: designs that meet targets, by the derivatives of a problem.

Gauss–Newton in a box of trust: with residuals r, their slopes J, margins c of the constraints and their slopes A, all at the
present design, the step d makes least

    |J d + r|² + |A d + c − s|² + μ |d|²        s ≥ 0,  |dₖ| ≤ Δ,  0 ≤ xₖ + dₖ ≤ 1

which is a least-squares problem with bounds for d and s (Nocedal and Wright, Numerical Optimization, 2nd ed., 10.3 and 18.5).
What J leaves open, where there are more variables than targets, goes the shortest way.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ._evaluate import Evaluator, error
from ._front import front
from ._search import Listener, first, note
from ._study import Values
from ._table import Design

# Designs that are drawn for one that meets what needs no solution, at most.
DRAWS = 10_000
# Constraints are aimed at by this part of their scale more than asked for: steps end beside what they aim at.
INSIDE = 1e-3
# A constraint that is violated by its scale counts as so many times the largest target.
STEEP = 10.0
# Root of μ, as a part of the largest slope: below it a direction changes nothing that could be aimed at.
SHORT = 1e-3
# The box of trust, as a part of the ranges: at first, and when nothing is left to try.
BOX, LEAST = 0.2, 1e-5
# Parts of what a step promised: below the first it is refused, below the second the box shrinks, above the third it grows.
HELD = (1e-3, 0.25, 0.75)
# A start that gains less than this part of its error by so many steps in a row is given up.
GAIN, PATIENCE = 0.05, 4


class Reached(Exception):
    """The error asked for, or the number of designs or minutes, is reached."""


class Point(NamedTuple):
    """A design in 0..1 with its residuals and margins, and their slopes."""

    x: Values
    residuals: Values
    """(targets,)"""
    slopes: Values
    """(targets, variables)"""
    margins: Values
    """(limits,), over their scales; negative where violated."""
    rises: Values
    """(limits, variables)"""

    @property
    def merit(self) -> float:
        """What is made least."""
        return float((self.residuals**2).sum() + (np.minimum(self.margins, 0.0) ** 2).sum())


def least_squares(evaluator: Evaluator, listener: Listener) -> None:
    """Targets: from the starting design and the best of random ones."""
    study = evaluator.study
    starts = _feasible(evaluator)
    if not len(starts):
        return
    screened = evaluator(starts)
    errors = error(study, screened)
    search = _Search(evaluator, listener, front(study, screened))
    try:
        search.note()
        for k in np.argsort(errors, kind="stable")[: study.starts]:
            if np.isfinite(errors[k]):
                search.follow(starts[k])
    except Reached:
        pass


def _feasible(evaluator: Evaluator) -> Values:
    """Starting designs in 0..1 that violate nothing that needs no solution: those given, then random ones."""
    study = evaluator.study
    start = np.array([[(each.start - each.low) / (each.high - each.low) for each in study.variables]])
    given = np.vstack([first(evaluator), start])[: study.screen]
    kept = [point for point in given if evaluator.violation(evaluator.values(point[None]), before=True)[0] == 0.0]
    random = np.random.default_rng(study.seed)
    for _ in range(DRAWS * study.screen):
        if len(kept) >= study.screen:
            break
        point = random.random(len(study.variables))
        if evaluator.violation(evaluator.values(point[None]), before=True)[0] == 0.0:
            kept.append(point)
    return np.array(kept)


class _Search:
    """What the starts of a search have in common."""

    def __init__(self, evaluator: Evaluator, listener: Listener, best: list[Design]) -> None:
        self.evaluator, self.listener, self.best = evaluator, listener, best
        self.study = evaluator.study
        self.steep = STEEP * (1.0 + max(abs(each.wanted) for each in self.study.targets))

    def note(self) -> None:
        """One line of progress; the end where the error asked for, or the number of designs, is reached."""
        least = float(error(self.study, self.best)[0]) if self.best else float("inf")
        note(self.evaluator, self.listener, self.best, best=least)
        if least <= self.study.stop.get("error", 0.0) or self.evaluator.is_spent():
            raise Reached

    def follow(self, start: Values) -> None:
        """Goes from a start as far as it leads."""
        point = self.ask(start)
        if point is None:
            return
        box, idle = BOX, 0
        for _ in range(self.study.generations):
            step, promised = _step(point, box)
            trial = self.ask(np.clip(point.x + step, 0.0, 1.0))
            gained = point.merit - trial.merit if trial is not None else -np.inf
            held = gained / promised if promised > 0.0 else -np.inf
            if held < HELD[1]:
                box = 0.3 * min(box, float(np.abs(step).max()))
            elif held > HELD[2]:
                box = min(2.0 * box, 1.0)
            idle = 0 if gained > GAIN * point.merit else idle + 1
            if trial is not None and held > HELD[0]:
                point = trial
            if box < LEAST or idle >= PATIENCE:
                return

    def ask(self, x: Values) -> Point | None:
        """A design with its slopes; nothing where it has none."""
        design = self.evaluator(x, anyway=True, slopes=True)[0]
        self.best = front(self.study, [*self.best, design])
        self.note()
        point = self._of(x, design) if design.status == "solved" else None
        return point if point is not None and all(np.isfinite(part).all() for part in point[1:]) else None

    def _of(self, x: Values, design: Design) -> Point:
        evaluator, study = self.evaluator, self.study
        at, probes, width = np.array([design.x]), np.array([design.probes]), len(x)
        rates = np.array(design.slopes).reshape(1, len(study.probes), width)
        residuals, slopes, margins, rises = [], [], [], []
        for target in study.targets:
            weight = target.weight**0.5
            residuals.append(weight * (evaluator.value(target.value, at, probes)[0] - target.wanted))
            slopes.append(weight * evaluator.slopes(target.value, at, probes, rates)[0])
        for each in study.constraints:
            value = evaluator.value(each.value, at, probes)[0]
            rise = evaluator.slopes(each.value, at, probes, rates)[0]
            for limit, sign in ((each.least, 1.0), (each.most, -1.0)):
                if np.isfinite(limit):
                    margins.append(self.steep * (sign * (value - limit) / each.scale - INSIDE))
                    rises.append(self.steep * sign * rise / each.scale)
        return Point(x, np.array(residuals), np.array(slopes), np.array(margins), np.array(rises).reshape(-1, width))


def _step(point: Point, box: float) -> tuple[Values, float]:
    """The step within a box of trust, and how much of the merit it promises to take away."""
    from scipy.optimize import lsq_linear

    width, limits = len(point.x), len(point.margins)
    short = SHORT * float(np.linalg.norm(point.slopes, 2))
    rows = np.block(
        [
            [point.slopes, np.zeros((len(point.residuals), limits))],
            [point.rises, -np.eye(limits)],
            [short * np.eye(width), np.zeros((width, limits))],
        ]
    )
    right = np.concatenate([-point.residuals, -point.margins, np.zeros(width)])
    low = np.concatenate([np.maximum(-point.x, -box), np.zeros(limits)])
    high = np.concatenate([np.minimum(1.0 - point.x, box), np.full(limits, np.inf)])
    # At a bound there is still room to the other side, and a variable needs some.
    found = lsq_linear(rows, right, (low, np.maximum(high, low + 1e-12)), method="bvls").x
    step: Values = found[:width]
    left = point.slopes @ step + point.residuals
    beyond = np.minimum(point.rises @ step + point.margins, 0.0)
    return step, point.merit - float((left**2).sum() + (beyond**2).sum())
