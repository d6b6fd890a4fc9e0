"""Chunks of designs to workers, and answers back, on any executor of `concurrent.futures`.

Every chunk is answered once, whatever happens to workers: a chunk that is lost is sent again, an answer that arrives twice is
taken once, and what nobody can answer is told at the end.
"""

from __future__ import annotations

import collections
import concurrent.futures
import dataclasses
import itertools
import logging
import queue
import time
import uuid
from collections.abc import Generator, Iterable, Iterator

import numpy as np
import numpy.typing as npt

from .. import _arguments
from .._errors import WorkerError
from . import _job
from ._job import Answers, Failure, Job, Missing

log = logging.getLogger("pennate")

Array = npt.NDArray[np.float64]
Chunk = tuple[int, Array]
"""A number, and (n, k) designs."""
Heard = Answers | Missing | Failure

# Chunks that are out at a time: few at first, which carry the job, and one more with every answer. Or all that go to a worker
# before it has the job would come back for it.
FIRST, AHEAD = 8, 4096
# How often a chunk is tried that reaches workers which say that they cannot do it.
MOST_TRIES = 20
# Seconds before a chunk is sent again: twice as long each time.
WAIT, LONGEST_WAIT = 0.05, 5.0
# How often a person who stops the run is looked for, in seconds.
TICK = 0.5
# Kinds of losses that are told.
TOLD = 20


@dataclasses.dataclass
class _Open:
    """A chunk without an answer."""

    x: Array
    tries: int = 0
    """Losses and failures."""
    first_try: int = 0
    """How many chunks were answered before the first of them."""
    last: str = ""
    """What was said of the last of them."""


class Sender:
    """Sends the chunks of a job to the workers of an executor.

    Args:
        executor: Any of `concurrent.futures`; it is not shut down.
        job: What is done with each chunk.
        retries: A chunk that was lost is sent again so many times.
        timeout: Seconds without any answer after which all that is out counts as lost; `None` waits for ever.
    """

    def __init__(
        self, executor: concurrent.futures.Executor, job: Job, *, retries: int = 3, timeout: float | None = None
    ) -> None:
        self.executor, self.retries = executor, _arguments.whole(retries, "retries")
        self.timeout = None if timeout is None else _arguments.real(timeout, "timeout", "a number of seconds")
        self.key, self.packed = job.packed()
        self._losses: collections.Counter[str] = collections.Counter()
        self.sent = self.answered = 0
        """Chunks so far, of all runs."""
        self._attempts = itertools.count()

    def run(self, chunks: Iterable[Chunk]) -> Generator[tuple[int, Answers], None, None]:
        """The answers of all chunks, as they come, each once.

        Raises:
            WorkerError: Chunks without an answer, told when all others have theirs.
        """
        run = uuid.uuid4().hex
        state = _Run(self, run, iter(chunks))
        try:
            yield from state.answers()
        finally:
            if state.out:
                # In this process chunks that have begun hear of it; others finish in vain.
                _job.stopped.add(run)
                state.cancel()

    def submit(self, run: str, x: Array, with_job: bool) -> concurrent.futures.Future[Heard]:
        """Sends a chunk."""
        packed = self.packed if with_job else None
        return self.executor.submit(_job.answer, self.key, run, f"{run}-{next(self._attempts)}", x, packed)

    @property
    def losses(self) -> list[str]:
        """What happened to chunks that had to be sent again, a sentence for all with the same fate."""
        fates = self._losses.most_common(TOLD)
        told = [f"{count} chunk{' was' if count == 1 else 's were'} sent again: {what}" for what, count in fates]
        return told + ["and others"] * (len(self._losses) > TOLD)

    def lost(self, number: int, what: str) -> None:
        """Notes a loss; one of many with the same fate is no news."""
        self._losses[what] += 1
        level = logging.WARNING if self._losses[what] == 1 else logging.DEBUG
        log.log(level, "chunk %d was sent again: %s", number + 1, what)


class _Run:
    """One pass over the chunks."""

    def __init__(self, sender: Sender, run: str, source: Iterator[Chunk]) -> None:
        self.sender, self.run, self.source = sender, run, source
        self.open: dict[int, _Open] = {}
        self.out: dict[concurrent.futures.Future[Heard], int] = {}
        self.later: list[tuple[float, int]] = []
        self.given_up: dict[int, _Open] = {}
        self.arrived: queue.SimpleQueue[concurrent.futures.Future[Heard]] = queue.SimpleQueue()
        self.answered = 0
        self.heard = time.monotonic()

    def answers(self) -> Iterator[tuple[int, Answers]]:
        while True:
            self._fill()
            if not self.open:
                break
            future = self._next()
            if future is None:
                continue
            number = self.out.pop(future, None)
            # Of two answers of a chunk the first is taken; one that counted as lost may still come.
            if number is None or number not in self.open:
                log.debug("an answer that had come already is left")
                continue
            found = self._taken(future, number)
            if found is not None:
                del self.open[number]
                self.answered += 1
                self.sender.answered += 1
                self.heard = time.monotonic()
                yield number, found
        if self.given_up:
            raise WorkerError(self._told())

    def _fill(self) -> None:
        """Sends what is due, and new chunks while there is room."""
        now = time.monotonic()
        due = [number for at, number in self.later if at <= now]
        self.later = [(at, number) for at, number in self.later if at > now]
        for number in due:
            if number in self.open:
                self._send(number, False)
        while len(self.open) < min(FIRST + self.sender.answered, AHEAD):
            chunk = next(self.source, None)
            if chunk is None:
                break
            number, x = chunk
            self.open[number] = _Open(x)
            self._send(number, self.sender.sent < FIRST)

    def _send(self, number: int, with_job: bool) -> None:
        try:
            future = self.sender.submit(self.run, self.open[number].x, with_job)
        except Exception as error:
            # A pool of processes that lost one takes nothing any more; a scheduler may come back.
            if isinstance(error, concurrent.futures.BrokenExecutor) or "shutdown" in str(error):
                raise WorkerError(f"the executor takes no more work: {_said(error)}") from error
            self._failed(number, _said(error))
            return
        self.sender.sent += 1
        self.out[future] = number
        future.add_done_callback(self.arrived.put)

    def _next(self) -> concurrent.futures.Future[Heard] | None:
        """The next one that is done; nothing where something else is to be done before."""
        now = time.monotonic()
        wait = min([TICK, *(max(at - now, 0.0) for at, _ in self.later)])
        try:
            return self.arrived.get(timeout=wait)
        except queue.Empty:
            timeout = self.sender.timeout
            if timeout is not None and self.out and time.monotonic() - self.heard > timeout:
                self.heard = time.monotonic()
                # They stay where they are: whichever answer comes first is taken.
                for number in dict.fromkeys(self.out.values()):
                    if number in self.open:
                        self._failed(number, f"no worker had answered anything for {timeout:g} s")
            return None

    def _taken(self, future: concurrent.futures.Future[Heard], number: int) -> Answers | None:
        """The answer; nothing where the chunk has to be sent again."""
        try:
            found = future.result()
        except (Exception, concurrent.futures.CancelledError) as error:
            self._failed(number, _said(error))
            return None
        if isinstance(found, Missing):
            self._send(number, True)
            return None
        if isinstance(found, Failure):
            # While others answer chunks, it is this worker that fails, and not the chunk.
            others = self.answered > self.open[number].first_try + self.sender.retries
            self._failed(number, f"worker {found.worker}: {found.reason}", MOST_TRIES if others else None)
            return None
        return found

    def _failed(self, number: int, what: str, tries: int | None = None) -> None:
        """Counts a loss, and puts the chunk off, or gives it up."""
        chunk = self.open[number]
        if chunk.tries == 0:
            chunk.first_try = self.answered
        chunk.tries += 1
        chunk.last = what
        if chunk.tries > (self.sender.retries if tries is None else tries):
            self.given_up[number] = self.open.pop(number)
            log.error("chunk %d is given up after %d tries: %s", number + 1, chunk.tries, what)
            if not self.answered:
                raise WorkerError(self._told())
            return
        self.sender.lost(number, what)
        wait = min(WAIT * 2.0 ** (chunk.tries - 1), LONGEST_WAIT)
        self.later.append((time.monotonic() + wait, number))

    def _told(self) -> str:
        designs = sum(len(chunk.x) for chunk in self.given_up.values())
        last = list(dict.fromkeys(chunk.last for chunk in self.given_up.values()))
        tries = max(chunk.tries for chunk in self.given_up.values())
        return f"{designs} designs have no answer, though they were sent {tries} times: {'; '.join(last[:3])}"

    def cancel(self) -> None:
        """Takes back what has not begun."""
        for future in self.out:
            future.cancel()


def _said(error: BaseException) -> str:
    text = " ".join(str(error).split())
    name = type(error).__name__
    if isinstance(error, concurrent.futures.CancelledError):
        return "it was cancelled, as its worker or the scheduler went away"
    return f"{name}: {text}" if text else name
