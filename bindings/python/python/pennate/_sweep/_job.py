"""What workers do: designs in, answers out, with the network kept from one chunk to the next.

A chunk is sent as its numbers and the hash of its job. A worker that does not have that job says so, and is sent it once; it then
keeps what was read and compiled. Nothing here depends on where a worker runs.
"""

from __future__ import annotations

import dataclasses
import hashlib
import itertools
import os
import pickle
import socket
import threading
import time
from collections.abc import Callable
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _core
from .._errors import Error
from .._network import Network
from .._problem import Problem
from ._alone import Row, solved_alone

Array = npt.NDArray[np.float64]

# Designs that the lanes of a processor take side by side: what is solved in company keeps its company.
TOGETHER = 8
# A row that no worker could answer, though the network itself is fine.
FAILED = "failed"
# Kinds of reasons that say that the values make no network.
WRONG = ("refused", "mechanism", "other_topology", "not_finite")
# Jobs that a process keeps: those of runs that go on at a time.
KEPT = 8
# A worker that fails answers slower than one that works, in seconds, or it would get all that is to be done.
PAUSE = (0.0, 0.5, 1.0, 2.0, 4.0)


@dataclasses.dataclass(frozen=True)
class Job:
    """What all chunks of a run have in common."""

    network: Network
    parameters: tuple[str, ...]
    """Of the k columns of a chunk."""
    probes: tuple[str, ...]
    """The m answers, `probe@step` or `probe` at the end of the last step."""
    accuracy: float
    method: str
    """`"solve"`: each design on a mesh of its own; `"problem"`: on a common one; `"gradient"`: that with derivatives."""
    sample: tuple[tuple[float, ...], ...] = ()
    """Designs that the common mesh has to serve."""

    def problem(self, threads: int = 1) -> Problem:
        """The compiled network."""
        sample = np.array(self.sample, dtype=np.float64).reshape(len(self.sample), len(self.parameters))
        return Problem(self.network, self.parameters, self.probes, self.accuracy, sample, threads)

    def packed(self) -> tuple[str, bytes]:
        """What is sent, and its hash."""
        data = pickle.dumps((_core.__version__, self))
        return hashlib.sha256(data).hexdigest(), data


@dataclasses.dataclass(frozen=True)
class Answers:
    """What came of the designs of a chunk, in order."""

    values: Array
    """(n, m), not a number where there is none."""
    slopes: Array | None
    """(n, m, k), where derivatives were asked for."""
    status: list[str]
    """`"converged"`, or how a design ended."""
    kinds: dict[int, str]
    """The kind of the reason, of designs that have one from a problem."""
    stable: npt.NDArray[np.int8]
    """(n,), 1 stable, 0 unstable, -1 not known."""
    error: Array
    """(n,), estimated, relative to the largest value of its kind; not a number where it is not known."""
    reasons: dict[int, str]
    """Why a design has no answer, or not all of it."""
    worker: str
    seconds: float
    """That the worker took for the chunk."""


@dataclasses.dataclass(frozen=True)
class Missing:
    """A worker that does not have the job yet."""

    worker: str


@dataclasses.dataclass(frozen=True)
class Failure:
    """A worker that cannot do the job, and why."""

    worker: str
    reason: str


class Stopped(Exception):
    """Nobody waits for the answer any longer."""


Solver = Callable[[Array, Callable[[], bool]], Answers]

_solvers: dict[str, Solver] = {}
_lock = threading.Lock()
_failures = itertools.count()
# Runs in this process that nobody waits for any longer.
stopped: set[str] = set()


def name() -> str:
    """Of this worker, as messages have it."""
    return f"{socket.gethostname()}, process {os.getpid()}"


def answer(key: str, run: str, attempt: str, x: Array, packed: bytes | None) -> Answers | Missing | Failure:
    """Answers a chunk: (n, k) numbers.

    `attempt` makes each call another one for executors that keep the answers of equal calls.
    """
    solver = _solvers.get(key)
    if solver is None:
        if packed is None:
            return Missing(name())
        try:
            solver = _kept(key, packed)
        except Exception as error:
            time.sleep(PAUSE[min(next(_failures), len(PAUSE) - 1)])
            return Failure(name(), _told(error))
    return solver(x, lambda: run in stopped)


def _kept(key: str, packed: bytes) -> Solver:
    """What answers chunks of a job; one thread compiles, and the others of the process wait for it."""
    with _lock:
        if key not in _solvers:
            made = _made(packed)
            while len(_solvers) >= KEPT:
                _solvers.pop(next(iter(_solvers)))
            _solvers[key] = made
        return _solvers[key]


def _forked() -> None:
    """A child of a process has no thread that would let go of the lock."""
    global _lock
    _lock = threading.Lock()


if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_forked)


def _made(packed: bytes) -> Solver:
    version, job = pickle.loads(packed)
    if version != _core.__version__:
        raise RuntimeError(f"it has version {_core.__version__} of pennate, not {version}")
    return solver_of(job)


def _told(error: Exception) -> str:
    text = " ".join(str(error).split())
    return text if isinstance(error, Error | RuntimeError) else f"{type(error).__name__}: {text}"


def solver_of(job: Job) -> Solver:
    """What answers chunks of a job in this process."""
    if job.method == "solve":
        return _Alone(job)
    return _Together(job)


class _Alone:
    """Each design as `Network.solve` solves it."""

    def __init__(self, job: Job) -> None:
        self.job = job

    def __call__(self, x: Array, is_stopped: Callable[[], bool]) -> Answers:
        begin = time.perf_counter()
        job, rows = self.job, list[Row]()
        for row in x.tolist():
            if is_stopped():
                raise Stopped
            rows.append(
                solved_alone(job.network, job.parameters, row, job.probes, job.accuracy, lambda: not is_stopped())
            )
        if is_stopped():
            raise Stopped
        return Answers(
            np.array([row.values for row in rows]).reshape(len(x), len(self.job.probes)),
            None,
            [row.status for row in rows],
            {},
            _verdicts([row.stable for row in rows]),
            np.array([row.error for row in rows], dtype=np.float64),
            {place: row.reason for place, row in enumerate(rows) if row.reason},
            name(),
            time.perf_counter() - begin,
        )


class _Together:
    """Designs of one compiled network, eight side by side."""

    def __init__(self, job: Job) -> None:
        self.problem = job.problem()
        self.gradient = job.method == "gradient"

    def __call__(self, x: Array, is_stopped: Callable[[], bool]) -> Answers:
        begin = time.perf_counter()
        found = self._answered(x, lambda: not is_stopped())
        if is_stopped():
            raise Stopped
        kinds = {place: kind for place, (kind, _) in found.reasons.items()}
        status = ["converged"] * len(x)
        for place, kind in kinds.items():
            status[place] = "wrong_input" if kind in WRONG else kind
        return Answers(
            found.values,
            found.slopes,
            status,
            kinds,
            _verdicts(found.stable),
            np.full(len(x), np.nan),
            {place: text for place, (_, text) in found.reasons.items()},
            name(),
            time.perf_counter() - begin,
        )

    def _answered(self, x: Array, wanted: Callable[[], bool]) -> _Found:
        try:
            slopes: Array | None = None
            if self.gradient:
                y, slopes, why, stable = self.problem._call.gradient(x, wanted)
            else:
                y, why, stable = self.problem._call.evaluate(x, wanted)
            return _Found(y, slopes, stable, {place: (kind, text) for place, kind, text in why})
        except Exception as error:
            if len(x) > TOGETHER:
                return self._in_parts(x, TOGETHER, wanted)
            if len(x) > 1:
                return self._in_parts(x, 1, wanted)
            # One design that the program breaks at: the others have their answers.
            shape = (1, len(self.problem.probes))
            nothing = np.full((*shape, x.shape[1]), np.nan) if self.gradient else None
            return _Found(np.full(shape, np.nan), nothing, [None], {0: (FAILED, _told(error))})

    def _in_parts(self, x: Array, size: int, wanted: Callable[[], bool]) -> _Found:
        parts = [(begin, self._answered(x[begin : begin + size], wanted)) for begin in range(0, len(x), size)]
        slopes: Any = [part.slopes for _, part in parts]
        return _Found(
            np.concatenate([part.values for _, part in parts]),
            np.concatenate(slopes) if self.gradient else None,
            [verdict for _, part in parts for verdict in part.stable],
            {begin + place: why for begin, part in parts for place, why in part.reasons.items()},
        )


@dataclasses.dataclass(frozen=True)
class _Found:
    """What a problem says of some designs: values, slopes, verdicts, and the kind and the text of reasons."""

    values: Array
    slopes: Array | None
    stable: list[bool | None]
    reasons: dict[int, tuple[str, str]]


def _verdicts(stable: list[bool | None]) -> npt.NDArray[np.int8]:
    """1 stable, 0 unstable, -1 not known."""
    return np.array([-1 if each is None else int(each) for each in stable], dtype=np.int8)
