"""Running a study: designs in, answers out, by one of three methods."""

from __future__ import annotations

import concurrent.futures
import contextlib
import dataclasses
import os
import tempfile
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .. import _arguments
from . import _least, _search, _write
from ._check import Checked, check
from ._evaluate import Evaluator, Spent
from ._front import front
from ._lock import locked
from ._progress import Picture
from ._read import read
from ._study import Study, Values
from ._table import Design, Table, check_owner

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
    """All that this search asked for and that were solved, in order."""
    best: list[Design]
    """The front of several objectives, by the first of them; else the best design alone; empty where none is feasible."""
    solved: int
    """Designs that this run solved: the others stood in `designs.csv` already."""
    progress: list[dict[str, float]]
    """One entry a batch."""
    directory: Path
    picks: list[dict[str, Any]] = dataclasses.field(default_factory=list)
    """What `picks.json` holds."""
    checked: list[Checked | None] = dataclasses.field(default_factory=list)
    """What each of the best designs is on a mesh of its own; `None` for some where there are very many."""


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
        first: A table with a column for every variable, such as a `front.csv`: designs that the search begins with.
        threads: One for each core by default, or one for each worker of an executor; the files are the same with any number.
        executor: Solves the designs elsewhere: any `concurrent.futures.Executor`, of processes, dask or MPI. The files are
            the same.
        budget: Designs to solve at most, those of earlier runs among them: a batch that would go beyond is not begun.
        progress: Called after each batch.
        draw: Keep a picture current, where matplotlib is there.

    Raises:
        StudyError: The study is wrong, the directory belongs to another one, or another search is at work there.
        NetworkError: The network is wrong.
        KeyboardInterrupt: Ctrl-C; whole batches are kept, and written as if the search had ended there.
    """
    if executor is not None:
        _arguments.executor(executor)
    if threads is not None:
        _arguments.count(threads, "threads")
    budget = _arguments.real(budget, "budget", "a number of designs")
    if not budget >= 1:
        raise ValueError(f"budget: a number of designs, one or more, expected, not {budget:g}")
    _arguments.listener(progress)
    found = study if isinstance(study, Study) else read(study, settings, seed, first)
    directory = Path(output)
    check_owner(directory)
    with locked(directory):
        evaluator = Evaluator(found, Table(found, directory), threads, budget, executor)
        return _searched(evaluator, directory, Picture(found, directory, evaluator, draw), progress)


def _searched(
    evaluator: Evaluator, directory: Path, picture: Picture, progress: Callable[[dict[str, float]], object] | None
) -> Outcome:
    """Runs the search of an evaluator, and writes what it found."""
    found = evaluator.study

    def listen(entry: dict[str, float], best: Sequence[Design]) -> None:
        picture(best)
        if progress is not None:
            progress(entry)

    try:
        with contextlib.suppress(Spent):
            METHODS[found.method](evaluator, listen)
    finally:
        # Also where it was interrupted.
        designs = evaluator.designs
        best = front(found, designs)
        outcome = Outcome(found, designs, best, evaluator.solved, evaluator.progress, directory)
        picture(best, _write.picks(found, designs, best), at_once=True)
        # The front stands there before it is checked: that takes its time, and may be interrupted.
        outcome = dataclasses.replace(outcome, picks=_write.write(outcome))
        outcome = dataclasses.replace(outcome, checked=check(evaluator, best))
        _write.write_best(outcome)
    return outcome


def evaluate(study: Study, x: Values, threads: int | None = None) -> list[Design]:
    """Some designs of a study, (n, variables) in their units, in order: solved as a search would, and written nowhere."""
    with tempfile.TemporaryDirectory() as folder:
        evaluator = Evaluator(study, Table(study, Path(folder)), threads)
        return evaluator((np.asarray(x, dtype=np.float64) - evaluator.low) / evaluator.span)
