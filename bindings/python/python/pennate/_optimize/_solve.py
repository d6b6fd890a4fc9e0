"""Solving a batch of designs here, or on the workers of an executor; answers are the same bytes."""

from __future__ import annotations

import concurrent.futures
import functools
import pickle
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from .._errors import Error
from .._problem import Problem

Values = npt.NDArray[np.float64]

# Designs of a task: whole groups of those that are solved side by side, eight at a time, so that each has its company.
TASK = 16


class Answers(NamedTuple):
    """What became of some designs."""

    values: Values
    """(n, probes)"""
    slopes: Values | None
    """(n, probes, parameters), where asked for."""
    reasons: list[tuple[str, str] | None]
    """Kind and words of why a design has no answer."""
    stable: list[bool | None]


def solve(problem: Problem, x: Values, slopes: bool) -> Answers:
    """The answers of designs in this process."""
    if slopes:
        y, j = problem.gradient(x)
    else:
        y, j = problem(x), None
    reasons = [None if reason is None else (reason.kind, str(reason)) for reason in problem.reasons]
    return Answers(y, j, reasons, problem.stable)


class Solver:
    """Solves batches of designs."""

    def __init__(self, problem: Problem, executor: concurrent.futures.Executor | None) -> None:
        self.problem, self.executor = problem, executor
        # A worker compiles the network once.
        self.token = pickle.dumps(problem) if executor is not None else b""

    def __call__(self, x: Values, slopes: bool) -> Answers:
        if self.executor is None:
            return solve(self.problem, x, slopes)
        parts = [x[k : k + TASK] for k in range(0, len(x), TASK)]
        futures = []
        try:
            futures = [self.executor.submit(_task, self.token, part, slopes) for part in parts]
            found = [future.result() for future in futures]
        except concurrent.futures.BrokenExecutor as error:
            help = "the same command with the same directory goes on where this one ended"
            raise Error(f"error: the workers are lost: {error}\nhelp: {help}") from error
        finally:
            for future in futures:
                future.cancel()
        rates = np.concatenate([each.slopes for each in found if each.slopes is not None]) if slopes else None
        reasons = [reason for each in found for reason in each.reasons]
        stable = [verdict for each in found for verdict in each.stable]
        return Answers(np.concatenate([each.values for each in found]), rates, reasons, stable)


@functools.lru_cache(maxsize=4)
def _compiled(token: bytes) -> Problem:
    problem: Problem = pickle.loads(token)
    return problem


def _task(token: bytes, x: Values, slopes: bool) -> Answers:
    """What a worker does."""
    return solve(_compiled(token), x, slopes)
