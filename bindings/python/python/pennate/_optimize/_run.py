"""Running a study: designs in, answers out, by one of three methods."""

from __future__ import annotations

import concurrent.futures
import dataclasses
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from . import _least, _search, _write
from ._evaluate import Evaluator
from ._front import front
from ._progress import Picture
from ._read import read
from ._study import Study, Values
from ._table import Design, Table

METHODS: dict[str, Callable[[Evaluator, _search.Listener], None]] = {
    "nsga2": _search.nsga2,
    "cma-es": _search.cma_es,
    "least-squares": _least.least_squares,
}


@dataclasses.dataclass(frozen=True)
class Outcome:
    """What a study found."""

    study: Study
    designs: list[Design]
    """All that were solved, in order."""
    best: list[Design]
    """The front of several objectives, by the first of them; else the best design alone; empty where none is feasible."""
    solved: int
    """Designs that this run solved: the others stood in `designs.csv` already."""
    progress: list[dict[str, float]]
    """One entry a batch."""
    directory: Path


class Evaluator:
    """Answers for designs in 0..1, each solved once; a batch that an interrupt cut is solved again as a whole.

    Answers of designs that are solved side by side may differ in rounding from those solved in other company, so that a
    batch keeps its company.
    """

    def __init__(
        self, study: Study, table: Table, threads: int | None, budget: float, executor: concurrent.futures.Executor | None = None
    ) -> None:
        self.study, self.table, self.budget = study, table, budget
        self.low = np.array([each.low for each in study.variables])
        self.span = np.array([each.high - each.low for each in study.variables])
        names = [each.name for each in study.variables]
        probes = list(study.probes) or None
        problem = study.network.problem(names, probes, accuracy=study.accuracy, threads=threads)
        self.problem = problem if executor is None else problem.on(executor)
        self.batch = 0
        self.solved = 0
        self.asked = 0
        self.progress: list[dict[str, float]] = []

    def values(self, scaled: Values) -> Values:
        """Designs in their units."""
        found: Values = self.low + np.clip(scaled, 0.0, 1.0) * self.span
        return found

    def violation(self, x: Values, before: bool, probes: Values | None = None) -> Values:
        """The sum of what constraints are violated by, each over its scale."""
        known = self._known(x, probes)
        total = np.zeros(len(x))
        for each in self.study.constraints:
            if each.before == before:
                value = np.broadcast_to(each.value(known), (len(x),))
                beyond = np.maximum(np.maximum(each.least - value, value - each.most), 0.0) / each.scale
                total += np.where(np.isnan(beyond), UNSOLVED, beyond)
        return total

    def _known(self, x: Values, probes: Values | None) -> dict[str, Values | float]:
        known: dict[str, Values | float] = dict(self.study.network.parameters)
        known.update({each.name: x[:, k] for k, each in enumerate(self.study.variables)})
        if probes is not None:
            known.update({name: probes[:, k] for k, name in enumerate(self.study.probes)})
        return known

    def __call__(self, scaled: Values, anyway: bool = False) -> list[Design]:
        """Designs of a batch in the order asked for; those that violate what needs no solution are not solved, unless `anyway`."""
        x = self.values(np.atleast_2d(scaled))
        before = self.violation(x, before=True)
        rows = [tuple(row.tolist()) for row in x]
        batch, self.batch = self.batch, self.batch + 1
        wanted: dict[tuple[float, ...], int] = {}
        for index, row in enumerate(rows):
            stored = self.table.known.get(row)
            if (anyway or before[index] == 0.0) and row not in wanted and (stored is None or stored.batch >= batch):
                wanted[row] = index
        stored_rows = [design.x for design in self.table.order if design.batch == batch]
        if stored_rows != list(wanted):
            if any(design.batch >= batch for design in self.table.order):
                self.table.drop_from(batch)
            if wanted:
                self.table.add(self._solve(batch, x[list(wanted.values())], before[list(wanted.values())]))
        self.asked += len(wanted)
        answers = []
        for index, row in enumerate(rows):
            found = self.table.known.get(row)
            if found is None:
                nothing = (float("nan"),) * len(self.study.wanted)
                found = Design(0, batch, row, "geometry", (), nothing, 1.0 + float(before[index]), "violates a constraint")
            answers.append(found)
        return answers

    def _solve(self, batch: int, x: Values, before: Values) -> list[Design]:
        y = self.problem(x)
        reasons = self.problem.reasons
        self.solved += len(x)
        after = self.violation(x, False, y) + before
        wanted = self._wanted(x, y)
        designs = []
        for k, row in enumerate(x):
            reason = reasons[k]
            bad = reason is not None or not np.isfinite(wanted[k]).all()
            status = reason.kind if reason is not None else "no_value" if bad else "solved"
            violation = UNSOLVED if bad else float(after[k])
            number = len(self.table.order) + k + 1
            text = str(reason) if reason is not None else ""
            found = tuple(wanted[k].tolist())
            designs.append(Design(number, batch, tuple(row.tolist()), status, tuple(y[k].tolist()), found, violation, text))
        return designs

    def _wanted(self, x: Values, y: Values) -> Values:
        """Objectives and targets, a column each."""
        known = self._known(x, y)
        return np.column_stack([np.broadcast_to(each.value(known), (len(x),)) for each in self.study.wanted])

    def is_spent(self) -> bool:
        """Whether no more designs are to be solved."""
        return self.asked >= min(self.budget, self.study.stop.get("evaluations", np.inf))


def error(study: Study, design: Design) -> float:
    """The root mean square of what a design misses its targets by; infinite where it has no answer."""
    values = np.array(design.wanted[len(study.objectives) :])
    wanted = np.array([each.wanted for each in study.targets])
    weights = np.array([each.weight for each in study.targets])
    found = float(np.sqrt((weights * (values - wanted) ** 2).sum() / weights.sum()))
    return found if np.isfinite(found) else float("inf")



def optimize(
    study: Study | str | os.PathLike[str],
    output: str | os.PathLike[str],
    *,
    settings: Mapping[str, float] | None = None,
    seed: int | None = None,
    first: str | os.PathLike[str] | None = None,
    threads: int | None = None,
    executor: concurrent.futures.Executor | None = None,
    budget: float = float("inf"),
    progress: Callable[[dict[str, float]], object] | None = None,
    draw: bool = True,
) -> Outcome:
    """Looks for designs, and writes them into a directory; goes on where an earlier run of the study ended.

    Args:
        study: A study that was read, or the path of its file.
        output: The directory.
        settings: Parameters of the network that take other values, before the variables.
        seed: In place of that of the study.
        threads: One for each core by default; the files are the same with any number.
        executor: Whose workers solve the designs, as in `sweep`; the files are the same with any.

        first: A table with a column for every variable, such as a `front.csv`: designs that the search begins with.
        threads: One for each core by default, or one for each worker of an executor; the files are the same with any number.
        executor: Solves the designs elsewhere: any `concurrent.futures.Executor`, of processes, dask or MPI. The files are
            the same.
        budget: Designs to solve at most, those of earlier runs among them.
        progress: Called after each batch.
        draw: Keep a picture current, where matplotlib is there.

    Raises:
        StudyError: The study is wrong, or the directory belongs to another one.
        NetworkError: The network is wrong.
        WorkerError: Designs that no worker of the executor answered; the same call goes on.

        KeyboardInterrupt: Ctrl-C; whole batches are kept, and written as if the search had ended there.
    """
    found = study if isinstance(study, Study) else read(study, settings, seed, first)
    directory = Path(output)
    table = Table(found, directory)
    evaluator = Evaluator(found, table, threads, budget, executor)
    _search.METHODS[found.method](evaluator, progress or (lambda _: None))
    # Rows of a later batch are those of a longer search.
    best = _search.front(found, [design for design in table.order if design.batch < evaluator.batch])
    outcome = Outcome(found, table.order, best, evaluator.solved, evaluator.progress, directory)
    _write.write(outcome)

    picture = Picture(found, directory, evaluator)

    picture = Picture(found, directory, evaluator, draw)

    def listen(entry: dict[str, float], best: Sequence[Design]) -> None:
        picture(best)
        if progress is not None:
            progress(entry)

    try:
        METHODS[found.method](evaluator, listen)
    finally:
        # Also where it was interrupted. Rows of a later batch are those of a longer search.
        best = front(found, [design for design in table.order if design.batch < evaluator.batch])
        outcome = Outcome(found, table.order, best, evaluator.solved, evaluator.progress, directory)
        picture(best, _write.picks(found, outcome.designs, best), at_once=True)
        _write.write(outcome)
    return outcome


def evaluate(study: Study, x: Values, threads: int | None = None) -> list[Design]:
    """Some designs of a study, (n, variables) in their units, in order: solved as a search would, and written nowhere."""
    with tempfile.TemporaryDirectory() as folder:
        evaluator = Evaluator(study, Table(study, Path(folder)), threads)
        return evaluator((np.asarray(x, dtype=np.float64) - evaluator.low) / evaluator.span)
