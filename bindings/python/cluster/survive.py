#!/usr/bin/env python3
"""Sweeps on real workers of dask.distributed while these are killed, stopped or wrong: the table stays that of one process.

    PYTHON bindings/python/cluster/survive.py

Needs pennate[cluster]. Ends with status 1 where a table is not that of one process, byte for byte.
"""

from __future__ import annotations

import logging
import os
import pathlib
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Callable
from typing import Any

import distributed
from workers import FEWER, Apart, local, pids

import pennate

# As many designs as a chunk has.
CHUNK = {"beta": FEWER["beta"][:8], "L": FEWER["L"][:5]}


def main() -> int:
    """Each mishap in turn, and the exit status."""
    logging.getLogger("distributed").setLevel(logging.CRITICAL)
    # Who ends this ends the workers with it.
    signal.signal(signal.SIGTERM, lambda *_: sys.exit(143))
    network = pennate.scene("stage")
    with tempfile.TemporaryDirectory() as folder:
        pennate.sweep(network, FEWER, output=folder, threads=1)
        table = pathlib.Path(folder, "sweep.csv").read_bytes()
    missed = 0
    for name, mishap in MISHAPS.items():
        with tempfile.TemporaryDirectory() as folder:
            begin = time.perf_counter()
            told = mishap(network, pathlib.Path(folder))
            same = pathlib.Path(folder, "sweep.csv").read_bytes() == table
            missed += not same
            rows = len(table.splitlines()) - 1
            print(f"{name}: {rows} rows {'the same bytes' if same else 'MISSED'}, {time.perf_counter() - begin:.1f} s")
            print(*(f"    {each}" for each in told), sep="\n", flush=True)
    return int(missed > 0)


def run(network: pennate.Network, client: distributed.Client, folder: pathlib.Path, **options: Any) -> list[str]:
    """The sweep, and what was lost."""
    table = pennate.sweep(network, FEWER, executor=client.get_executor(), output=folder, chunk=40, **options)
    return list(table.attrs["losses"]) or ["nothing was lost that dask did not send again by itself"]


def halfway(act: Callable[[], object]) -> Callable[[int, int], None]:
    """Does something once, when a third of the designs is known."""
    done: list[int] = []

    def heard(known: int, count: int) -> None:
        if known >= count / 3 and not done:
            done.append(known)
            act()

    return heard


def killed_worker(network: pennate.Network, folder: pathlib.Path) -> list[str]:
    with local(2) as client:
        victim = pids(client)[0]
        return run(network, client, folder, progress=halfway(lambda: os.kill(victim, signal.SIGKILL)))


def twice(network: pennate.Network, folder: pathlib.Path) -> list[str]:
    with local(2) as client:
        both = pids(client)
        begin = time.perf_counter()
        pennate.sweep(network, CHUNK, executor=client.get_executor(), chunk=40)
        # Longer than workers take that work, whatever else the machine has to do.
        patience = max(1.0, 5 * (time.perf_counter() - begin))

        def stop() -> None:
            for pid in both:
                os.kill(pid, signal.SIGSTOP)
            threading.Timer(3 * patience, lambda: [os.kill(pid, signal.SIGCONT) for pid in both]).start()

        heard = Heard()
        lost = run(network, client, folder, progress=halfway(stop), timeout=patience, retries=20)
    assert heard.count, "no answer came twice"
    return [f"{heard.count} answers came twice", *lost]


class Heard(logging.Handler):
    """Counts the answers that are left, as they were there already."""

    def __init__(self) -> None:
        super().__init__(logging.DEBUG)
        self.count = 0
        logger = logging.getLogger("pennate")
        logger.setLevel(logging.DEBUG)
        logger.addHandler(self)

    def emit(self, record: logging.LogRecord) -> None:
        self.count += "come already" in record.getMessage()


def killed_scheduler(network: pennate.Network, folder: pathlib.Path) -> list[str]:
    with Apart() as apart:
        scheduler = apart.scheduler()
        for _ in range(2):
            apart.worker()

        def anew() -> None:
            scheduler.kill()
            scheduler.wait()
            apart.scheduler()
            for _ in range(2):
                apart.worker()

        with distributed.Client(apart.address, timeout=60) as client:
            return run(network, client, folder, progress=halfway(anew))


# What a worker runs before it takes work.
OTHER_VERSION = "import pennate\npennate._core.__version__ = '0.0.9'\n"


def bad_worker(network: pennate.Network, folder: pathlib.Path) -> list[str]:
    with Apart() as apart, tempfile.NamedTemporaryFile("w", suffix=".py") as preload:
        preload.write(OTHER_VERSION)
        preload.flush()
        apart.scheduler()
        apart.worker()
        apart.worker("--preload", preload.name)
        with distributed.Client(apart.address, timeout=60) as client:
            client.wait_for_workers(2, timeout=60)
            return run(network, client, folder)


def stopped(network: pennate.Network, folder: pathlib.Path) -> list[str]:
    def stop(known: int, count: int) -> None:
        if known >= count / 2:
            raise KeyboardInterrupt

    with local(2) as client:
        try:
            run(network, client, folder, progress=stop)
        except KeyboardInterrupt:
            pass
        rows = len(pathlib.Path(folder, "sweep.csv").read_bytes().splitlines()) - 1
        seen: list[int] = []
        lost = run(network, client, folder, progress=lambda known, _: seen.append(known))
    return [f"{rows} rows were there, and the second call began with {seen[0]}", *lost]


MISHAPS: dict[str, Callable[[pennate.Network, pathlib.Path], list[str]]] = {
    "a worker killed by SIGKILL in the middle": killed_worker,
    "the scheduler killed in the middle, and started anew with new workers": killed_scheduler,
    "chunks answered twice, by workers that had stopped and went on": twice,
    "a worker with another version, on which the network fails": bad_worker,
    "this process stopped in the middle, and the same call again": stopped,
}

if __name__ == "__main__":
    sys.exit(main())
