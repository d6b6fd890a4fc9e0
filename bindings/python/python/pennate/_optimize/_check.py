"""The best designs solved once more, each on a mesh of its own: a search has one mesh for all, made for a few of them."""

from __future__ import annotations

import concurrent.futures
import os
import threading
from collections import Counter
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from .._sweep._alone import Row, solved_alone
from ._evaluate import Evaluator
from ._study import Study, Values
from ._table import Design

# Designs that are checked at most: of more, so many evenly along the front, both ends among them.
MOST = 1000
# Accuracy of the check, as a part of that of the search, and the least there is.
FINER, LEAST = 1e-2, 1e-8


class Checked(NamedTuple):
    """What a design is on a mesh of its own."""

    status: str
    """`"converged"`, or how it ended, as `Solution.status`."""
    stable: bool | None
    """Whether the ends of all steps are stable; `None` where nobody can say."""
    wanted: tuple[float, ...]
    """Objectives or targets, as `Design.wanted`."""
    reason: str
    """Why it ended, if not well."""

    @property
    def holds(self) -> bool:
        """Whether there is an equilibrium that is not unstable."""
        return self.status == "converged" and self.stable is not False


def accuracy(study: Study) -> float:
    """That of the check."""
    return min(study.accuracy, max(FINER * study.accuracy, LEAST))


def check(evaluator: Evaluator, best: Sequence[Design]) -> list[Checked | None]:
    """Solves designs as `Network.solve` does; `None` for those that are not looked at where there are too many."""
    study = evaluator.study
    places = np.unique(np.linspace(0, len(best) - 1, min(len(best), MOST)).round().astype(int))
    names = [each.name for each in study.variables]
    stopped = threading.Event()

    def solved(place: int) -> Row:
        return solved_alone(study.network, names, best[place].x, study.probes, accuracy(study), lambda: not stopped.is_set())

    pool = concurrent.futures.ThreadPoolExecutor(evaluator.threads or os.cpu_count() or 1, "pennate-check")
    try:
        rows = list(pool.map(solved, places.tolist()))
    finally:
        # Who presses Ctrl-C does not wait for those that are being solved.
        stopped.set()
        pool.shutdown(wait=True, cancel_futures=True)
    found: list[Checked | None] = [None] * len(best)
    for place, row in zip(places.tolist(), rows):
        found[place] = _checked(evaluator, best[place], row)
    return found


def _checked(evaluator: Evaluator, design: Design, row: Row) -> Checked:
    study = evaluator.study
    x, probes = np.array([design.x]), np.array([row.values]).reshape(1, len(study.probes))
    values = [float(evaluator.value(each.value, x, probes)[0]) for each in study.wanted]
    if design.spread:
        values = [value + spread * each.sign for value, spread, each in zip(values, design.spread, study.objectives)]
    return Checked(row.status, row.stable, tuple(values), row.reason)


def off(study: Study, designs: Sequence[Design], best: Sequence[Design], checked: Sequence[Checked | None]) -> Values:
    """(best,), the largest difference of an objective or a target to that of the check, relative to the largest value that it has
    among designs that meet all constraints; not a number where nothing was checked, or does not hold.
    """
    largest = np.array([np.abs(design.wanted) for design in designs if design.violation == 0.0]).max(0, initial=0.0)
    found = np.full(len(best), np.nan)
    for place, (design, other) in enumerate(zip(best, checked)):
        if other is not None and other.holds:
            difference = np.abs(np.subtract(design.wanted, other.wanted))
            relative = difference / np.where(largest > 0.0, largest, 1.0)
            found[place] = np.max(np.where(np.isnan(relative), np.inf, relative))
    return found


def ends(checked: Sequence[Checked | None]) -> Counter[str]:
    """How those designs ended that do not hold."""
    words = (("unstable" if each.status == "converged" else each.status) for each in checked if each and not each.holds)
    return Counter(words)
