"""Workers of dask.distributed for the checks beside: in processes of their own."""

from __future__ import annotations

import contextlib
import logging
import os
import socket
import subprocess
import sys
import tempfile
from collections.abc import Iterator

import dask
import distributed
import numpy as np

# Angles and lengths of tip-tilt stages.
STAGES = {"beta": np.linspace(22, 32, 100), "L": np.linspace(110, 150, 100)}
FEWER = {"beta": np.linspace(22, 32, 50), "L": np.linspace(110, 150, 40)}


@contextlib.contextmanager
def local(workers: int) -> Iterator[distributed.Client]:
    """A cluster of processes with one thread each, as docs/cluster.md has it: without dask's profiler."""
    dask.config.set({"distributed.worker.profile.enabled": False})
    cluster = distributed.LocalCluster(
        n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=":0", silence_logs=logging.CRITICAL
    )
    with cluster, distributed.Client(cluster) as client:
        yield client


def pids(client: distributed.Client) -> list[int]:
    """Of the workers."""
    return sorted(client.run(os.getpid).values())


class Apart:
    """A scheduler and its workers as programs of their own."""

    def __init__(self) -> None:
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        self.address = f"tcp://127.0.0.1:{self.port}"
        self.running: list[subprocess.Popen[bytes]] = []
        self.folder = tempfile.TemporaryDirectory()

    def start(self, *arguments: str) -> subprocess.Popen[bytes]:
        command = [sys.executable, "-m", "dask", *arguments, "--no-dashboard"]
        quiet = subprocess.DEVNULL
        self.running.append(subprocess.Popen(command, stdout=quiet, stderr=quiet, cwd=self.folder.name))
        return self.running[-1]

    def scheduler(self) -> subprocess.Popen[bytes]:
        return self.start("scheduler", "--host", "127.0.0.1", "--port", str(self.port))

    def worker(self, *arguments: str) -> subprocess.Popen[bytes]:
        return self.start("worker", self.address, "--nthreads", "1", "--death-timeout", "60", *arguments)

    def __enter__(self) -> Apart:
        return self

    def __exit__(self, *_: object) -> None:
        for process in self.running:
            process.terminate()
        for process in self.running:
            process.wait()
        self.folder.cleanup()
