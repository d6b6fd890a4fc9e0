"""Solving a batch of designs here, or on the workers of an executor; answers are the same bytes."""

from __future__ import annotations

import concurrent.futures
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._errors import WorkerError
from .._problem import Problem, Reason

Values = npt.NDArray[np.float64]


class Answers(NamedTuple):
    """What became of some designs."""

    values: Values
    """(n, probes)"""
    slopes: Values | None
    """(n, probes, parameters), where asked for."""
    reasons: list[Reason | None]
    """Why a design has no answer."""
    stable: list[bool | None]


class Solver:
    """Solves batches of designs."""

    def __init__(self, problem: Problem, executor: concurrent.futures.Executor | None) -> None:
        self.problem = problem if executor is None else problem.on(executor)

    def __call__(self, x: Values, slopes: bool) -> Answers:
        try:
            y, j = self.problem.gradient(x) if slopes else (self.problem(x), None)
        except WorkerError as error:
            help = "the same command with the same directory goes on where this one ended"
            raise WorkerError(f"error: the workers are lost: {error}\nhelp: {help}") from error
        return Answers(y, j, self.problem.reasons, self.problem.stable)
