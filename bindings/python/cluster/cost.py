#!/usr/bin/env python3
"""What sweeps on dask.distributed cost: two workers over one, chunks beside one process, bytes, tasks; and what follows for many.

    PYTHON bindings/python/cluster/cost.py              on two cores that are free
    PYTHON bindings/python/cluster/cost.py --figures    without the times of one worker and two

Needs pennate[cluster]. Ends with status 1 where a figure that is asked for is missed.
"""

from __future__ import annotations

import argparse
import concurrent.futures
import logging
import os
import pathlib
import pickle
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from typing import Any

import distributed
import numpy as np
from workers import FEWER, STAGES, local

import pennate
from pennate._sweep import _job

CHUNK = 200
# What is asked for: two workers over one, and a worker with chunks over the same work in one process.
SPEEDUP, OVERHEAD = 1.8, 0.05
missed: list[str] = []


def main() -> int:
    """All figures, and the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--figures", action="store_true", help="bytes, tasks, and what follows alone")
    parser.add_argument("--repeat", type=int, default=3, help="how often times are taken; the best ones count")
    parser.add_argument("--patience", type=float, default=60, help="seconds to wait for a moment when others are quiet")
    arguments = parser.parse_args()
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    if not arguments.figures:
        scale(arguments.repeat, arguments.patience)
    cost()
    return int(bool(missed))


def ticks() -> tuple[float, float]:
    """Processor time that the machine has used, and that it could have used, in seconds."""
    line = pathlib.Path("/proc/stat").read_text(encoding="ascii").split("\n")[0]
    fields = [float(each) / os.sysconf("SC_CLK_TCK") for each in line.split()[1:9]]
    return sum(fields) - fields[3] - fields[4], sum(fields)


class Timed:
    """How long something took, its processor time, and what part of the processors others used meanwhile."""

    def __init__(self, client: distributed.Client | None = None) -> None:
        self.client = client

    def own(self) -> float:
        """Processor time of this process and of its workers."""
        workers = self.client.run(time.process_time).values() if self.client else []
        return time.process_time() + sum(workers)

    def __enter__(self) -> Timed:
        self.before = self.own(), *ticks()
        self.begin = time.perf_counter()
        return self

    def __exit__(self, *_: object) -> None:
        self.seconds = time.perf_counter() - self.begin
        self.work, used, could = (after - before for after, before in zip((self.own(), *ticks()), self.before))
        self.others = max(used - self.work, 0.0) / max(could, 1e-9)

    def __str__(self) -> str:
        return f"{self.seconds:.2f} s ({self.work:.2f} s of processors, others {100 * self.others:.0f} %)"


def quiet(most: float, patience: float) -> None:
    """Waits for a moment at which others use little of the processors."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        with Timed() as second:
            time.sleep(1.0)
        if second.others < most:
            return


def scale(repeat: int, patience: float) -> None:
    """10,000 stages by one process, by one worker, by two."""
    network = pennate.scene("stage")
    job = _job.Job(network, tuple(STAGES), tuple(f"{p}@{s}" for s in network.steps for p in network.probes), 1e-6, "solve")
    solver = _job.solver_of(job)
    rows = np.stack(np.meshgrid(*STAGES.values(), indexing="ij"), axis=-1).reshape(-1, len(STAGES))

    def alone() -> None:
        for place in range(0, len(rows), CHUNK):
            solver(rows[place : place + CHUNK], lambda: False)

    def swept(client: distributed.Client) -> Callable[[], object]:
        return lambda: pennate.sweep(network, STAGES, executor=client.get_executor(), chunk=CHUNK)

    with local(1) as one, local(2) as two:
        ways: dict[str, tuple[distributed.Client | None, Callable[[], object]]]
        ways = {"one process": (None, alone), "one worker": (one, swept(one)), "two workers": (two, swept(two))}
        rounds: list[dict[str, Timed]] = []
        for _ in range(repeat):
            found: dict[str, Timed] = {}
            for name, (client, work) in ways.items():
                quiet(0.05, patience)
                with Timed(client) as found[name]:
                    work()
            rounds.append(found)
            print(f"{len(rows)} stages:", ", ".join(f"{name} {each}" for name, each in found.items()), flush=True)
    # Others only make it longer.
    best = {name: min((found[name] for found in rounds), key=lambda each: each.seconds) for name in ways}
    work = {name: min(found[name].work for found in rounds) for name in ways}
    print("best of all:", ", ".join(f"{name} {each}" for name, each in best.items()))
    overhead = work["one worker"] / work["one process"] - 1
    figure(f"overhead of chunks of {CHUNK}, % of processor time", 100 * overhead, 100 * OVERHEAD, overhead <= OVERHEAD)
    speedup = best["one worker"].seconds / best["two workers"].seconds
    figure("two workers over one", speedup, SPEEDUP, speedup >= SPEEDUP)


def figure(what: str, found: float, asked: float, holds: bool) -> None:
    print(f"{what:50} {found:8.3g}   asked for {asked:g}{'' if holds else '   MISSED'}", flush=True)
    if not holds:
        missed.append(f"{what}: MISSED, {found:.3g} where {asked:g} is asked for")


class Known(concurrent.futures.Executor):
    """Gives answers that are known already: what is left is the work of who asks."""

    def __init__(self) -> None:
        self.answers: dict[bytes, bytes] = {}
        self.sent: list[int] = []

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Any:
        key = args[3].tobytes()
        if key not in self.answers:
            self.answers[key] = pickle.dumps(fn(*args))
        self.sent.append(len(pickle.dumps(args)))
        future: concurrent.futures.Future[Any] = concurrent.futures.Future()
        future.set_result(pickle.loads(self.answers[key]))
        return future


def nothing(x: int) -> int:
    """A task that takes no time."""
    return x


def traffic() -> int:
    """Bytes that went over the loopback device."""
    lines = pathlib.Path("/proc/net/dev").read_text(encoding="ascii").splitlines()
    return next(int(line.split(":")[1].split()[0]) for line in lines if line.strip().startswith("lo:"))


def cost() -> None:
    """Bytes a design, tasks a second, the work of who asks; and what follows for many."""
    if os.environ.get("PENNATE_APART") is None and own_network():
        return
    network = pennate.scene("stage")
    known = Known()
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(2):
            begin = time.process_time()
            pennate.sweep(network, FEWER, executor=known, output=folder, overwrite=True, chunk=CHUNK)
            keeping = time.process_time() - begin
            for file in pathlib.Path(folder).iterdir():
                file.unlink()
    count = int(np.prod([len(axis) for axis in FEWER.values()]))
    job = _job.Job(network, tuple(FEWER), tuple(f"{p}@{s}" for s in network.steps for p in network.probes), 1e-6, "solve")
    solver, rows = _job.solver_of(job), np.tile([27.0, 130.0], (CHUNK, 1))
    design = min(spent(lambda: solver(rows, lambda: False)) for _ in range(5)) / CHUNK
    with local(2) as client:
        client.gather(client.map(nothing, range(100), pure=False))
        begin = time.perf_counter()
        client.gather(client.map(nothing, range(100, 3100), pure=False))
        rate = 3000 / (time.perf_counter() - begin)
        before = traffic()
        pennate.sweep(network, STAGES, executor=client.get_executor(), chunk=CHUNK)
        wire = (traffic() - before) / len(STAGES["beta"]) / len(STAGES["L"])
    sent = statistics.median(known.sent) / CHUNK
    back = statistics.median(len(each) for each in known.answers.values()) / CHUNK
    print(f"a stage: {1e3 * design:.2f} ms of a worker's processor")
    print(f"numbers: {sent:.0f} bytes a design to a worker, {back:.0f} back; {len(job.packed()[1])} once to each worker")
    print(f"over the network with all that dask adds, by way of its scheduler: {wire:.0f} bytes a design in chunks of {CHUNK}")
    print(f"scheduler: {rate:.0f} tasks a second; who asks, with its table: {1e6 * keeping / count:.1f} us a design")
    arithmetic(design, wire, rate, keeping / count)


def spent(work: Callable[[], object]) -> float:
    """Processor time of some work, in seconds."""
    begin = time.process_time()
    work()
    return time.process_time() - begin


def arithmetic(design: float, wire: float, rate: float, keeping: float, designs: int = 10**7, cores: int = 1000) -> None:
    """What many designs on many cores would take by these figures."""
    print(f"\n{designs:,} designs on {cores:,} cores:")
    print(f"  to solve them {designs * design / cores:.0f} s; over the network {designs * wire / 1e9:.1f} GB")
    print(f"  to keep the table, one core {designs * keeping:.0f} s")
    print(f"  one scheduler keeps all cores busy with chunks of at least {cores / (design * rate):.0f} designs")
    print("  chunk  tasks  scheduler  a chunk  altogether")
    for chunk in (200, 500, 1000, 2000, 5000):
        scheduling = designs / chunk / rate
        # Whoever is slowest sets the pace, and the last chunk ends after the others.
        longest = max(designs * design / cores, scheduling, designs * keeping) + chunk * design
        print(f"  {chunk:5d} {designs // chunk:6d} {scheduling:8.0f} s {chunk * design:6.1f} s {longest:9.0f} s")


def own_network() -> bool:
    """Does it again where nothing else is on the loopback device, if that can be had: Linux, and root."""
    command = ["unshare", "--net", "sh", "-c", 'ip link set lo up && exec "$@"', "sh", sys.executable, __file__, "--figures"]
    try:
        done = subprocess.run(["unshare", "--net", "ip", "link", "set", "lo", "up"], capture_output=True, check=False).returncode
    except OSError:
        done = 1
    if done:
        print("bytes of other programs on the loopback device are counted too")
        return False
    if subprocess.run(command, env={**os.environ, "PENNATE_APART": "1"}, check=False).returncode:
        missed.append("cost: MISSED")
    return True


if __name__ == "__main__":
    sys.exit(main())
