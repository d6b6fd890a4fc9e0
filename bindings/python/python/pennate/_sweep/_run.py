"""Sweeps: one network for many values of its parameters, in one table."""

from __future__ import annotations

import concurrent.futures
import contextlib
import dataclasses
import os
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from .. import _arguments, _core
from .._errors import NetworkError, WorkerError
from .._network import Network
from . import Wanted, _dataset, _plan, _table
from ._job import TOGETHER, Job
from ._plan import Plan
from ._send import Chunk, Sender

if TYPE_CHECKING:
    import xarray

Array = npt.NDArray[np.float64]
METHODS = ("solve", "problem")
# Designs of a chunk: a worker is busy with them for some tenths of a second, beside which a scheduler's part is small.
CHUNK = 200


def run(
    network: Network, vary: Mapping[str, npt.ArrayLike], designs: Mapping[str, npt.ArrayLike] | None, wanted: Wanted
) -> xarray.Dataset:
    """A sweep."""
    _check(network, wanted)
    _dataset.library()
    if wanted.method not in METHODS:
        raise ValueError(f"method: {' or '.join(map(repr, METHODS))} expected, not {wanted.method!r}")
    plan = _plan.plan(network, vary, designs)
    made = _Sweep(network, plan, _probes(network, wanted.probes), _arguments.accuracy(wanted.accuracy), wanted.method)
    count = os.cpu_count() or 1 if wanted.threads is None else _arguments.count(wanted.threads, "threads")
    size = TOGETHER * -(-_size(wanted.chunk, plan, count if wanted.executor is None else None) // TOGETHER)
    table = None if wanted.output is None else made.table(Path(wanted.output))
    if table is not None:
        table.begin(wanted.overwrite)
    try:
        with _Threads(wanted.executor, count) as workers:
            sender = Sender(workers, made.job(), retries=wanted.retries, timeout=wanted.timeout)
            made.solve(sender, size, table, wanted.progress)
    except WorkerError as error:
        kept = "" if table is None else f"; what was answered is in {table.path}, and the same call goes on from there"
        raise WorkerError(f"{error}{kept}", made.dataset()) from error
    finally:
        if table is not None:
            table.end()
    return made.dataset()


def _check(network: Network, wanted: Wanted) -> None:
    """Refuses what is of the wrong kind before any work."""
    if not isinstance(network, Network):
        raise TypeError(f"a network expected, as pennate.load(path) reads one, not {_arguments.shown(network)}")
    if wanted.executor is not None:
        _arguments.executor(wanted.executor)
    _arguments.listener(wanted.progress)
    _arguments.whole(wanted.retries, "retries")
    if wanted.timeout is not None:
        _arguments.real(wanted.timeout, "timeout", "a number of seconds")


class _Sweep:
    """What is swept, and what is known of it."""

    def __init__(self, network: Network, plan: Plan, probes: tuple[str, ...], accuracy: float, method: str) -> None:
        self.network, self.plan, self.probes, self.accuracy, self.method = network, plan, probes, accuracy, method
        self.rows = _table.Rows(plan, len(probes))
        self.losses: list[str] = []
        self.errors: Array | None = None

    def table(self, directory: Path) -> _table.Table:
        head = _table.head(self.plan, self.network, self.probes)
        return _table.Table(directory, head, _table.manifest(self.network, self.accuracy, self.method), self.rows)

    def job(self) -> Job:
        """What workers do. A wrong name, or a network that is no problem, is found here, before anything is sent."""
        job = Job(self.network, self.plan.parameters, self.probes, self.accuracy, self.method)
        if self.method == "solve":
            return job
        sample = self.plan.sample()
        job = dataclasses.replace(
            job, network=_middle(self.network, job.parameters, sample), sample=tuple(map(tuple, sample.tolist()))
        )
        self.errors = job.problem().error
        return job

    def chunks(self, size: int) -> Iterator[Chunk]:
        """Designs that are not known yet; those that are solved side by side come with their neighbours."""
        for number, begin in enumerate(range(0, self.plan.count, size)):
            wanted = self.wanted(begin, size)
            if len(wanted):
                yield number, self.plan.rows(wanted)

    def wanted(self, begin: int, size: int) -> npt.NDArray[np.int64]:
        """Numbers of the designs of a chunk that are sent."""
        numbers = np.arange(begin, min(begin + size, self.plan.count))
        is_open = ~self.rows.known[numbers]
        if self.method == "problem" and is_open.any():
            # An answer's last digits come with its company.
            group = numbers // TOGETHER
            return numbers[np.isin(group, group[is_open])]
        return numbers[is_open]

    def solve(self, sender: Sender, size: int, table: _table.Table | None, progress: Callable[[int, int], object] | None) -> None:
        """Sends what is not known, and takes what comes back."""
        done = int(self.rows.known.sum())
        tell = progress or (lambda done, count: None)
        tell(done, self.plan.count)
        try:
            with contextlib.closing(sender.run(self.chunks(size))) as answers:
                for number, found in answers:
                    numbers = self.wanted(number * size, size)
                    new = numbers[~self.rows.known[numbers]]
                    self.rows.take(numbers, found)
                    done += len(new)
                    if table is not None:
                        table.add(new)
                    tell(done, self.plan.count)
        finally:
            self.losses = sender.losses

    def dataset(self) -> xarray.Dataset:
        found = _dataset.Made(self.accuracy, self.method, self.errors, self.losses)
        return _dataset.dataset(self.network, self.rows, self.probes, found)


class _Threads:
    """The executor that was given, or threads of this process."""

    def __init__(self, executor: concurrent.futures.Executor | None, count: int) -> None:
        self.given, self.count = executor, count

    def __enter__(self) -> concurrent.futures.Executor:
        self.own = None
        if self.given is not None:
            return self.given
        self.own = concurrent.futures.ThreadPoolExecutor(self.count, "pennate-sweep")
        return self.own

    def __exit__(self, *_: object) -> None:
        if self.own is not None:
            self.own.shutdown(wait=True, cancel_futures=True)


def _size(chunk: int | None, plan: Plan, threads: int | None) -> int:
    if chunk is not None:
        return _arguments.count(chunk, "chunk", None)
    # Threads of this process cost nothing to ask: each gets several chunks.
    return CHUNK if threads is None else max(1, min(CHUNK, plan.count // (4 * threads)))


def _probes(network: Network, probes: Sequence[str] | None) -> tuple[str, ...]:
    known, steps = list(network.probes), network.steps
    if probes is None:
        return tuple(known) if len(steps) == 1 else tuple(f"{probe}@{step}" for step in steps for probe in known)
    wanted = tuple("@".join(part.strip() for part in name.split("@", 1)) for name in _arguments.names(probes, "probes"))
    for place, name in enumerate(wanted):
        probe, at, step = name.partition("@")
        where = [f"'{name}' is number {place + 1} of the probes asked for"]
        if probe not in known:
            raise _core.unknown(f"there is no probe '{probe}'", probe, known, "probes", where)
        if at and step not in steps:
            raise _core.unknown(f"there is no step '{step}' for the probe '{probe}'", step, steps, "steps", where)
    if len(set(wanted)) < len(wanted):
        raise ValueError("probes: one of them is named twice")
    return wanted


def _middle(network: Network, parameters: Sequence[str], sample: Array) -> Network:
    """The network at the first of some designs that makes one: a problem is compiled there."""
    refused: NetworkError | None = None
    for row in sample.tolist():
        try:
            return network.set(**dict(zip(parameters, row)))
        except NetworkError as error:
            refused = refused or error
    assert refused is not None
    raise refused
