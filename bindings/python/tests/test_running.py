"""Solves may be watched, stopped, and run side by side."""

from __future__ import annotations

import concurrent.futures
import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Iterator

import numpy as np
import pytest

import pennate

# Takes some seconds, in many increments.
LONG = """
import os, signal, sys, threading, time
import pennate
network = pennate.scene("spiral", cells=12)
tree = network.to_dict()
network = network.edit(steps=[{**step, "increments": 300} for step in tree["steps"]])
"""


def many_increments() -> pennate.Network:
    network = pennate.scene("spiral", cells=6)
    return network.edit(steps=[{**step, "increments": 400} for step in network.to_dict()["steps"]])


def test_progress_is_told(dyad: pennate.Network) -> None:
    told: list[tuple[int, int, float]] = []
    dyad.edit(steps={"inflate": {"increments": 4}}).solve(progress=lambda *news: told.append(news))
    assert {steps for _, steps, _ in told} == {2} and {step for step, _, _ in told} == {0, 1}
    assert all(0.0 < fraction <= 1.0 for _, _, fraction in told)


def test_a_listener_stops_a_solve_and_keeps_what_converged() -> None:
    solution = many_increments().solve(progress=lambda step, steps, fraction: fraction < 0.1)
    assert solution.status == "interrupted" and solution.fraction[0] >= 0.1
    assert np.isfinite(solution.displacement[0]).all()


def test_an_exception_of_a_listener_stops_a_solve() -> None:
    def listen(*_: object) -> None:
        raise RuntimeError("enough")

    begin = time.perf_counter()
    with pytest.raises(RuntimeError, match="enough"):
        many_increments().solve(progress=listen)
    assert time.perf_counter() - begin < 10.0


@pytest.fixture
def interruptible() -> Iterator[None]:
    """Ctrl-C means what it means in a terminal: a shell starts what runs in its background with this signal ignored."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_stops_a_solve_and_keeps_what_converged() -> None:
    network = many_increments()
    heard = threading.Event()

    def press() -> None:
        heard.wait(30.0)
        os.kill(os.getpid(), signal.SIGINT)

    finger = threading.Thread(target=press)
    finger.start()
    with pytest.raises(KeyboardInterrupt) as caught:
        network.solve(progress=lambda *_: heard.set())
    finger.join()
    assert isinstance(caught.value, pennate.Interrupted)
    assert caught.value.solution.status == "interrupted"
    assert np.isfinite(caught.value.solution.displacement[0]).all()


def test_other_threads_run_while_rust_works() -> None:
    network = many_increments()
    done = threading.Event()
    solver = threading.Thread(target=lambda: (network.solve(shapes=False), done.set()))
    solver.start()
    count = 0
    while not done.is_set():
        count += 1
        time.sleep(0.001)
    solver.join()
    # Ticks of a millisecond while the solve took its time.
    assert count > 20


def test_solves_of_many_threads_agree(dyad: pennate.Network, solution: pennate.Solution) -> None:
    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        for stroke in pool.map(lambda _: dyad.solve()["stroke"], range(16)):
            np.testing.assert_array_equal(stroke, solution["stroke"])


def test_the_import_is_silent_and_takes_numpy_alone() -> None:
    check = "import sys, pennate; print([name for name in ('pyvista', 'matplotlib', 'xarray', 'dask') if name in sys.modules])"
    done = subprocess.run([sys.executable, "-W", "error", "-c", check], capture_output=True, text=True, check=True)
    assert (done.stdout, done.stderr) == ("[]\n", "")
