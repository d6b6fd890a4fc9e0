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


def test_a_listener_stops_even_a_quick_solve_each_time(dyad: pennate.Network) -> None:
    for no in (False, np.False_, 0):
        for _ in range(50):
            calls: list[float] = []
            solution = dyad.solve(progress=lambda *news: bool(calls.append(news[2])) or no)
            assert solution.status == "interrupted" and solution.fraction[-1] == 0.0 and len(calls) == 1


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


class Finger:
    """Presses Ctrl-C after some seconds, or as soon as an event is set, and tells how long ago that was."""

    def __init__(self, after: float | threading.Event) -> None:
        self.at = float("inf")
        self.after = after
        self.thread = threading.Thread(target=self._press)
        self.thread.start()

    def _press(self) -> None:
        if isinstance(self.after, threading.Event):
            self.after.wait(60.0)
        else:
            time.sleep(self.after)
        self.at = time.perf_counter()
        os.kill(os.getpid(), signal.SIGINT)

    def ago(self) -> float:
        self.thread.join()
        return time.perf_counter() - self.at


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_stops_states_side_by_side_and_keeps_what_was_done() -> None:
    problem = pennate.scene("stage").problem(["beta"], ["stroke"], threads=1)
    lives = problem.live(4000)
    assert isinstance(lives, pennate.Lives)
    before = lives.values.copy()
    wanted = problem.middle[0] * np.linspace(0.97, 1.03, len(lives))
    finger = Finger(0.1)
    with pytest.raises(KeyboardInterrupt):
        lives.set(beta=wanted).solve()
    assert finger.ago() < 1.0
    done = np.array([reason is None for reason in lives.reasons])
    assert done.any() and not done.all()
    assert {reason.kind for reason in lives.reasons if reason is not None} == {"interrupted"}
    assert lives.stable == [True] * len(lives)
    np.testing.assert_allclose(lives.values[done], problem(wanted[done][:, None]), rtol=1e-8)
    # Two at most were on their way.
    assert (lives.values[~done] != before[~done]).any(axis=1).sum() <= 2
    few = problem.live(3)
    assert isinstance(few, pennate.Lives) and few.set(beta=wanted[:3]).solve().reasons == [None] * 3


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_stops_a_live_state_and_keeps_what_it_came_to() -> None:
    problem = pennate.scene("spiral", cells=12).problem(["H"], ["tilt"])
    live = problem.live()
    assert isinstance(live, pennate.Live)
    start = live.present["H"]
    finger = Finger(0.3)
    with pytest.raises(KeyboardInterrupt):
        for times in range(1000):
            live.set(H=start * (1.4 if times % 2 == 0 else 1.0)).solve()
    assert finger.ago() < 1.0
    assert live.stable is True
    np.testing.assert_allclose(live.values, problem([live.present["H"]]), rtol=1e-7)
    live.set(H=start).solve()
    np.testing.assert_allclose(live.values, problem([start]), rtol=1e-7)


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_stops_derivatives() -> None:
    problem = pennate.scene("stage").problem(["beta", "L"], ["stroke"], threads=1)
    designs = problem.middle * np.linspace(0.99, 1.01, 20000)[:, None]
    # What one design takes says little of many.
    problem(designs[0])
    finger = Finger(0.3)
    with pytest.raises(KeyboardInterrupt):
        problem.gradient(designs)
    assert finger.ago() < 1.0


@pytest.mark.usefixtures("interruptible")
def test_calls_on_states_side_by_side_take_turns(dyad: pennate.Network) -> None:
    problem = dyad.problem(["beta"], ["holding"], threads=2)
    for lives in (problem.live(64), problem.live()):

        def solve(lives: pennate.Lives | pennate.Live = lives) -> None:
            for beta in np.linspace(20.0, 24.0, 40):
                lives.set(beta=float(beta)).solve()

        threads = [threading.Thread(target=solve, daemon=True) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join(120.0)
            assert not thread.is_alive()
        lives.set(beta=24.0).solve()
        np.testing.assert_allclose(np.ravel(lives["holding"])[0], problem([24.0])[0], rtol=1e-8)


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_is_heard_while_a_call_waits_for_its_turn() -> None:
    problem = pennate.scene("stage").problem(["beta"], ["stroke"], threads=1)
    lives = problem.live(1000)
    assert isinstance(lives, pennate.Lives)
    works, waits, heard = (threading.Event() for _ in range(3))

    def work() -> None:
        times = 0
        while not heard.is_set():
            times += 1
            lives.set(beta=problem.middle[0] * (1.03 if times % 2 else 1.0)).solve()
            works.set()

    # One of them always works, and others come before this thread.
    others = [threading.Thread(target=work) for _ in range(4)]
    for other in others:
        other.start()
    finger = Finger(waits)
    assert works.wait(60.0)
    with pytest.raises(KeyboardInterrupt):
        waits.set()
        while True:
            lives.solve()
    late = finger.ago()
    heard.set()
    for other in others:
        other.join()
    assert late < 0.5
    assert lives.set(beta=problem.middle[0]).solve().reasons == [None] * len(lives)


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_is_heard_at_once_however_many_designs_are_left() -> None:
    problem = pennate.scene("stage").problem(["beta", "L"], ["stroke"], threads=1)
    designs = problem.middle * np.linspace(0.99, 1.01, 1000000)[:, None]
    for call in (problem, problem.gradient):
        finger = Finger(0.2)
        with pytest.raises(KeyboardInterrupt):
            call(designs)
        assert finger.ago() < 0.4


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_is_heard_where_designs_take_longer_than_those_before() -> None:
    # Those that snap take twenty times as long as those that do not.
    network = pennate.loads("""
        format = "pennate/1"
        parameters = { F = 1 }
        nodes = { A = [-100, 0], B = [100, 0], C = [0, 10] }
        materials.steel = { youngs_modulus = 200000, poissons_ratio = 0.3 }
        sections.strip = { rectangle = { width = 10, height = 1 } }
        members.left = { nodes = ["A", "C"], section = "strip", material = "steel" }
        members.right = { nodes = ["B", "C"], section = "strip", material = "steel" }
        supports = { A = "clamped", B = "clamped" }
        dimension = "plane"
        steps = [{ name = "press", method = "jump", force = { C = [0, "= -F"] } }]
        probes.down = { node = "C", displacement = "uy" }
    """)
    problem = network.problem(["F"], ["down"], threads=1)
    for _ in range(2):
        begin = time.perf_counter()
        problem(np.ones((50, 1)))
        each = (time.perf_counter() - begin) / 50
    designs = np.full((int(0.035 / each), 1), 1000.0)
    finger = Finger(0.15)
    with pytest.raises(KeyboardInterrupt):
        problem(designs)
        problem(np.repeat(designs, 20, axis=0))
    assert finger.ago() < 0.4
    # They are answered, too.
    assert np.isfinite(problem(designs)).all()


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_stops_a_sample_that_a_mesh_is_made_for() -> None:
    network = pennate.scene("stage")
    middle = network.problem(["beta"], ["stroke"]).middle[0]
    finger = Finger(0.2)
    with pytest.raises(KeyboardInterrupt):
        network.problem(["beta"], ["stroke"], sample=middle * np.linspace(0.9, 1.1, 3000)[:, None])
    assert finger.ago() < 0.4


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
    # Python has had a reader of TOML since 3.11 alone.
    check = "import sys; sys.modules['tomllib'] = sys.modules['tomli'] = None; import pennate"
    subprocess.run([sys.executable, "-W", "error", "-c", check], check=True)
