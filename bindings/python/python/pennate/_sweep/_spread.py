"""A problem whose designs are solved by the workers of an executor."""

from __future__ import annotations

import concurrent.futures
from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .. import _arguments
from .._problem import Problem
from ._job import TOGETHER, Job
from ._send import Chunk, Sender

if TYPE_CHECKING:
    from ._job import Answers

Array = npt.NDArray[np.float64]

# Designs of a chunk at most, and into how many chunks a call is cut: enough for a few workers each to get several.
CHUNK, PARTS = 200, 32


class Spread(Problem):
    """A problem on an executor: the same answers, bit for bit. See `Problem.on`."""

    __slots__ = ("_chunk", "_senders", "executor")

    def __init__(
        self,
        problem: Problem,
        executor: concurrent.futures.Executor,
        chunk: int | None = None,
        retries: int = 3,
        timeout: float | None = None,
    ) -> None:
        network, parameters, probes, accuracy, sample, _ = self._made = problem._made
        self._call, self._facts, self._last = problem._call, problem._facts, problem._last
        self.executor = _arguments.executor(executor)
        rows = tuple(map(tuple, sample.tolist()))
        self._chunk = None if chunk is None else _arguments.count(chunk, "chunk", None)
        self._senders = {
            method: Sender(executor, Job(network, parameters, probes, accuracy, method, rows), retries=retries, timeout=timeout)
            for method in ("problem", "gradient")
        }

    def __call__(self, x: npt.ArrayLike) -> Array:
        rows = _arguments.numbers(x, "x", self.parameters)
        if self._is_small(rows):
            return super().__call__(rows)
        return np.concatenate([part.values for part in self._asked("problem", rows)])

    def gradient(self, x: npt.ArrayLike) -> tuple[Array, Array]:
        rows = _arguments.numbers(x, "x", self.parameters)
        if self._is_small(rows):
            return super().gradient(rows)
        parts = self._asked("gradient", rows)
        slopes: Any = [part.slopes for part in parts]
        return np.concatenate([part.values for part in parts]), np.concatenate(slopes)

    def _is_small(self, rows: Array) -> bool:
        """What is one design, or none, or of the wrong shape, is not worth the way."""
        return rows.ndim != 2 or rows.shape[1] != len(self.parameters) or len(rows) < 2

    def _asked(self, method: str, rows: Array) -> list[Answers]:
        wanted = self._chunk if self._chunk is not None else min(CHUNK, len(rows) // PARTS)
        # Designs that are solved side by side stay together.
        size = TOGETHER * max(1, -(-wanted // TOGETHER))

        def chunks() -> Iterator[Chunk]:
            for number, begin in enumerate(range(0, len(rows), size)):
                yield number, rows[begin : begin + size]

        found = dict(self._senders[method].run(chunks()))
        parts = [found[number] for number in range(len(found))]
        reasons = (
            (number * size + place, part.kinds[place], reason)
            for number, part in enumerate(parts)
            for place, reason in part.reasons.items()
        )
        verdicts = np.concatenate([part.stable for part in parts]).tolist()
        stable = [None if verdict < 0 else bool(verdict) for verdict in verdicts]
        self._last.answer = [list(reasons), stable]
        return parts

    def __repr__(self) -> str:
        return f"{super().__repr__()[:-1]}, on {type(self.executor).__name__}>"

    def __reduce__(self) -> tuple[Any, ...]:
        # Whoever unpickles it is somewhere else, and has an executor of its own or none.
        return Problem, self._made
