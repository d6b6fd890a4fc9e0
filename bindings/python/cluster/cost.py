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
import threading
import time
from collections.abc import Callable
from typing import Any

import distributed
import numpy as np
from workers import FEWER, STAGES, local

import pennate
from pennate._sweep import _job, _plan, _table

CHUNK = 200
# Tasks without work that a scheduler is given, and what figures are taken to.
TASKS, DESIGNS, CORES = 2000, 10**7, 1000
# What is asked for: two workers over one, and a worker with chunks over the same work in one process.
SPEEDUP, OVERHEAD = 1.8, 0.05
# Where others use more of the processors, times by the clock say little.
BUSY = 0.1
missed: list[str] = []


def main() -> int:
    """All figures, and the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--figures", action="store_true", help="bytes, tasks, and what follows alone")
    parser.add_argument("--turns", type=int, default=5, help="in how many parts times are taken; medians count")
    parser.add_argument("--patience", type=float, default=60, help="seconds to wait for a moment when others are quiet")
    parser.add_argument("--stages", type=int, default=10_000, help="how many are solved for it, up to 10,000")
    arguments = parser.parse_args()
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    if not arguments.figures:
        scale(arguments.turns, arguments.patience, arguments.stages)
    cost()
    return int(bool(missed))


def ticks() -> tuple[float, float]:
    """Processor time that the machine has used, and that it could have used, in seconds."""
    line = pathlib.Path("/proc/stat").read_text(encoding="ascii").split("\n")[0]
    fields = [float(each) / os.sysconf("SC_CLK_TCK") for each in line.split()[1:9]]
    return sum(fields) - fields[3] - fields[4], sum(fields)


class Timed:
    """How long something took, its processor time, and what part of the processors others used meanwhile."""

    idle = 0.0
    """Processor time that this process needs in each second for clusters that do nothing."""

    def __init__(self, client: distributed.Client | None = None) -> None:
        self.client = client

    def now(self) -> tuple[float, float, float, float, float]:
        """Processor time of this process, of its workers, of what these do beside solving, and of the machine."""
        workers = self.client.run(time.process_time).values() if self.client else []
        others = self.client.run(beside).values() if self.client else []
        return time.process_time(), sum(workers), sum(others), *ticks()

    def __enter__(self) -> Timed:
        self.before = self.now()
        self.begin = time.perf_counter()
        return self

    def __exit__(self, *_: object) -> None:
        self.seconds = time.perf_counter() - self.begin
        self.here, self.there, self.beside, used, could = (after - before for after, before in zip(self.now(), self.before))
        self.others = max(used - self.here - self.there, 0.0) / max(could, 1e-9)
        self.here -= Timed.idle * self.seconds

    def __str__(self) -> str:
        parts = f"{self.here:.2f} s here"
        if self.client:
            parts += f", {self.there:.2f} s in workers, {self.beside:.2f} s of that beside solving"
        return f"{self.seconds:.2f} s (processors {parts}; others {100 * self.others:.0f} %)"


def watch() -> None:
    """Lets a worker count the processor time of its thread that solves, while it does."""
    from pennate._sweep import _job

    make, spent = _job.solver_of, vars(_job).setdefault("spent", [0.0])

    def solver_of(job: _job.Job) -> _job.Solver:
        solver = make(job)

        def timed(x: Any, is_stopped: Callable[[], bool]) -> _job.Answers:
            begin = time.thread_time()
            try:
                return solver(x, is_stopped)
            finally:
                spent[0] += time.thread_time() - begin

        return timed

    vars(_job)["solver_of"] = solver_of


def beside() -> float:
    """Processor time of a worker's threads that is not for solving, in seconds; networks are solved on threads of their own."""
    from pennate._sweep import _job

    clocks = [time.pthread_getcpuclockid(thread.ident) for thread in threading.enumerate() if thread.ident]
    return sum(time.clock_gettime(clock) for clock in clocks) - float(vars(_job)["spent"][0])


def quiet(most: float, patience: float) -> None:
    """Waits for a moment at which others use little of the processors."""
    end = time.monotonic() + patience
    while time.monotonic() < end:
        with Timed() as second:
            time.sleep(1.0)
        if second.others < most:
            return


def scale(turns: int, patience: float, count: int) -> None:
    """Some stages by one process, by one worker, by two: part by part in turns, since a machine's pace changes within minutes."""
    network = pennate.scene("stage")
    job = _job.Job(network, tuple(STAGES), tuple(f"{p}@{s}" for s in network.steps for p in network.probes), 1e-6, "solve")
    solver = _job.solver_of(job)
    lengths = STAGES["L"][: count // len(STAGES["beta"])]

    def alone(axes: dict[str, Any]) -> None:
        rows = np.stack(np.meshgrid(*axes.values(), indexing="ij"), axis=-1).reshape(-1, len(axes))
        for place in range(0, len(rows), CHUNK):
            solver(rows[place : place + CHUNK], lambda: False)

    def swept(client: distributed.Client) -> Callable[[dict[str, Any]], object]:
        return lambda axes: pennate.sweep(network, axes, executor=client.get_executor(), chunk=CHUNK)

    with local(1) as one, local(2) as two:
        ways: dict[str, tuple[distributed.Client | None, Callable[[dict[str, Any]], object]]]
        ways = {"one process": (None, alone), "one worker": (one, swept(one)), "two workers": (two, swept(two))}
        found: list[dict[str, Timed]] = []
        for each in (one, two):
            each.run(watch)
        # What is done once is no part of a chunk: workers load the solver, and are sent the network.
        for _, work in ways.values():
            work({"beta": STAGES["beta"], "L": STAGES["L"][:4]})
        # Two clusters that do nothing are no part of what a sweep costs, and cost more the slower the machine is.
        with Timed() as still:
            time.sleep(10.0)
        Timed.idle = still.here / still.seconds
        for part in np.array_split(lengths, turns):
            axes = {"beta": STAGES["beta"], "L": part}
            turn: dict[str, Timed] = {}
            for name, (client, work) in ways.items():
                quiet(BUSY, patience)
                with Timed(client) as turn[name]:
                    work(axes)
            found.append(turn)
            print(f"{100 * len(part)} stages:", *(f"    {name} {timed}" for name, timed in turn.items()), sep="\n", flush=True)
    judge(found)


def judge(turns: list[dict[str, Timed]]) -> None:
    """What the ratios within each turn say: their medians."""

    def ratios(over: Callable[[dict[str, Timed]], float], under: Callable[[dict[str, Timed]], float]) -> list[float]:
        return sorted(over(turn) / under(turn) for turn in turns)

    def clock(name: str) -> Callable[[dict[str, Timed]], float]:
        return lambda turn: turn[name].seconds

    for name in ("one process", "one worker", "two workers"):
        seconds, others = sum(turn[name].seconds for turn in turns), max(turn[name].others for turn in turns)
        print(f"{name}: {seconds:.1f} s in all; others used at most {100 * others:.0f} %")
    # What workers and this process do beside solving: a machine's pace changes by more than that from one minute to the next.
    for name in ("one worker", "two workers"):
        here, there, beside = (sum(getattr(turn[name], part) for turn in turns) for part in ("here", "there", "beside"))
        overhead = (here + beside) / (there - beside)
        figure(f"chunks of {CHUNK}, {name}: % beside solving", 100 * overhead, 100 * OVERHEAD, overhead <= OVERHEAD)
    # A worker alone sets the pace, with this process beside it; two workers share two processors with this process.
    bound = statistics.median(ratios(lambda turn: 2 * turn["one worker"].there, lambda turn: turn["two workers"].there))
    figure("two workers over one, by the processor time of each", bound, SPEEDUP, bound >= SPEEDUP)
    speedups = ratios(clock("one worker"), clock("two workers"))
    speedup = statistics.median(speedups)
    print(f"two over one in each turn: {', '.join(f'{each:.2f}' for each in speedups)}")
    others = statistics.median(max(turn["one worker"].others, turn["two workers"].others) for turn in turns)
    if others < BUSY:
        figure("two workers over one, by the clock", speedup, SPEEDUP, speedup >= SPEEDUP)
    else:
        print(f"two workers over one, by the clock: {speedup:.2f}, which says little as others used {100 * others:.0f} %")


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
    design = least(solver, rows)
    with local(2) as client:
        executor = client.get_executor(pure=False)

        def tasks() -> None:
            concurrent.futures.wait([executor.submit(nothing, number) for number in range(TASKS)])

        tasks()
        before = traffic()
        # Processor time, since others may use the machine: this process is scheduler and client at once.
        rate = TASKS / spent(tasks)
        task = (traffic() - before) / TASKS
    sent = statistics.median(known.sent) / CHUNK
    back = statistics.median(len(each) for each in known.answers.values()) / CHUNK
    methods()
    print(f"numbers: {sent:.0f} bytes a design to a worker, {back:.0f} back; {len(job.packed()[1])} once to each worker")
    print(f"a task of dask with nothing in it: {task:.0f} bytes over the network")
    print(f"scheduler and client together: {rate:.0f} tasks a second of a processor")
    print(f"sweep, with its table: {1e6 * keeping / count:.1f} us a design, of which it keeps {kept(job)} bytes")
    # What a worker gets and gives goes by way of the scheduler.
    arithmetic(design, 2 * (sent + back), task, rate, keeping / count)


def methods() -> None:
    """What a design takes on a mesh of its own, and on a common one."""
    for name, vary in (("dyad", {"chi": np.linspace(15, 40, CHUNK)}), ("stage", {"beta": np.linspace(22, 32, CHUNK)})):
        network = pennate.scene(name)
        ways = (_job.Job(network, tuple(vary), tuple(network.probes), 1e-6, method) for method in ("solve", "problem"))
        solvers = [_job.solver_of(job) for job in ways]
        rows = next(iter(vary.values()))[:, None]
        alone, together = (least(solver, rows) for solver in solvers)
        each = f"{1e3 * alone:.3f} ms of a processor, {1e3 * together:.3f} ms by method='problem'"
        print(f"a {name}: {each}, {alone / together:.1f} times")


def least(solver: _job.Solver, rows: Any) -> float:
    """Processor time of a design of a chunk, the least of several."""
    return min(spent(lambda: solver(rows, lambda: False)) for _ in range(5)) / len(rows)


def kept(job: _job.Job) -> int:
    """Bytes of the arrays of a sweep, for a design."""
    count = 1000
    rows = _table.Rows(_plan.Plan(("n",), [np.arange(float(count))], None), len(job.probes))
    table = _table.Table(pathlib.Path(), [], {}, rows)
    arrays = [each for of in (rows, table) for each in vars(of).values() if isinstance(each, np.ndarray)]
    return sum(each.nbytes for each in arrays) // count


def spent(work: Callable[[], object]) -> float:
    """Processor time of some work, in seconds."""
    begin = time.process_time()
    work()
    return time.process_time() - begin


def arithmetic(design: float, numbers: float, task: float, rate: float, keeping: float) -> None:
    """What many designs on many cores would take by these figures."""
    print(f"\n{DESIGNS:,} designs on {CORES:,} cores:")
    print(f"  to solve them {DESIGNS * design / CORES:.0f} s, to keep the table {DESIGNS * keeping:.0f} s of one core")
    print(f"  one scheduler keeps all cores busy with chunks of at least {CORES / (design * rate):.0f} designs")
    print("  chunk  tasks  scheduler   network  a chunk  altogether")
    for chunk in (200, 500, 1000, 2000, 5000):
        scheduling, wire = DESIGNS / chunk / rate, DESIGNS * (numbers + task / chunk) / 1e9
        # Whoever is slowest sets the pace, and the last chunk ends after the others.
        longest = max(DESIGNS * design / CORES, scheduling, DESIGNS * keeping) + chunk * design
        print(f"  {chunk:5d} {DESIGNS // chunk:6d} {scheduling:8.0f} s {wire:6.1f} GB {chunk * design:6.1f} s {longest:9.0f} s")


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
