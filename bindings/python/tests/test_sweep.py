"""Sweeps: one table, whoever solves it, and whatever happens on the way."""

from __future__ import annotations

import concurrent.futures
import multiprocessing
import os
import pickle
import signal
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pennate
from pennate import _core

xarray = pytest.importorskip("xarray")

BETA, PRESSURE = range(16, 40, 2), [12, 15, 22, 1000]
COUNT = 48


class Executor(concurrent.futures.Executor):
    """Does everything at once, in this process; `before` may take a call's place, by its number."""

    def __init__(self, before: Callable[[int], Any] = lambda number: None) -> None:
        self.before, self.calls, self.arguments = before, 0, list[tuple[Any, ...]]()

    def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Any:
        number, self.calls = self.calls, self.calls + 1
        self.arguments.append(args)
        future: concurrent.futures.Future[Any] = concurrent.futures.Future()
        try:
            instead = self.before(number)
            future.set_result(fn(*args, **kwargs) if instead is None else instead)
        except Exception as error:
            future.set_exception(error)
        return future


def raising(error: Exception, *numbers: int) -> Callable[[int], None]:
    """What fails at some calls."""

    def before(number: int) -> None:
        if number in numbers:
            raise error

    return before


def processes(count: int) -> concurrent.futures.ProcessPoolExecutor:
    """A pool of new processes: forks of one that has threads may wait for ever."""
    return concurrent.futures.ProcessPoolExecutor(count, mp_context=multiprocessing.get_context("spawn"))


@pytest.fixture(scope="module")
def table(dyad: pennate.Network) -> Any:
    return pennate.sweep(dyad, beta=BETA, pressure=PRESSURE)


@pytest.fixture(scope="module")
def whole(dyad: pennate.Network, tmp_path_factory: pytest.TempPathFactory) -> bytes:
    """The file of the same sweep."""
    folder = tmp_path_factory.mktemp("whole")
    pennate.sweep(dyad, beta=BETA, pressure=PRESSURE, output=folder)
    return (folder / "sweep.csv").read_bytes()


def test_a_table_holds_what_solves_say(dyad: pennate.Network, table: Any) -> None:
    assert dict(table.sizes) == {"beta": 12, "pressure": 4}
    assert table["stroke@inflate"].dims == ("beta", "pressure") and table["stroke@inflate"].units == "mm"
    solution = dyad.set(beta=22, pressure=15).solve()
    one = table.sel(beta=22, pressure=15)
    assert float(one["stroke@inflate"]) == solution["stroke@inflate"]
    assert float(one["holding@push back"]) == solution["holding@push back"]
    assert float(one.error) == pytest.approx(solution.accuracy, rel=0.05) and int(one.stable) == 1
    beyond = table.sel(beta=22, pressure=1000)
    assert beyond.status == "wrong_input" and "beyond the table" in str(beyond.reason.values) and int(beyond.stable) == -1
    assert np.isnan(float(beyond["stroke@inflate"])) and np.isnan(float(beyond.error))
    assert table.attrs["network"] == dyad.text and table.attrs["units"] == "mm-N-MPa"
    assert table.attrs["pennate"] == pennate.__version__ and table.attrs["losses"] == []


def test_a_failed_step_has_its_reason_and_what_came_before(snap: pennate.Network) -> None:
    gentle = snap.edit(parameters={"F": 1}, steps={"press": {"force": {"C": [0, "= -F"]}}})
    found = pennate.sweep(gentle, F=[1, 1000])
    assert found.status.values.tolist() == ["bifurcation", "bifurcation"]
    assert "'more' ends at" in found.reason.values[0] and "'press' ends at" in found.reason.values[1]
    assert np.isfinite(found["down@press"].values).tolist() == [True, False]
    assert np.isnan(found["down@more"].values).all()


def test_a_state_that_is_unstable_is_told(strut: pennate.Network) -> None:
    found = pennate.sweep(strut.edit(parameters={"F": 40}, steps=[{"name": "press", "force": {"B": ["= -F", 0]}}]), F=[1, 40])
    solution = strut.solve()
    assert found.stable.values.tolist() == [1, int(bool(solution.stable[0]))]


@pytest.mark.parametrize("chunk", [None, 1, 16, 200])
def test_executors_and_chunks_do_not_matter(dyad: pennate.Network, table: Any, chunk: int | None) -> None:
    for executor in (None, Executor(), concurrent.futures.ThreadPoolExecutor(3)):
        found = pennate.sweep(dyad, beta=BETA, pressure=PRESSURE, executor=executor, chunk=chunk)
        xarray.testing.assert_identical(found, table)
    assert isinstance(executor, concurrent.futures.ThreadPoolExecutor)
    executor.shutdown()


def test_processes_give_the_same(dyad: pennate.Network, table: Any) -> None:
    with processes(2) as executor:
        found = pennate.sweep(dyad, beta=BETA, pressure=PRESSURE, executor=executor, chunk=8)
    xarray.testing.assert_identical(found, table)


def test_a_common_mesh_gives_the_same_to_its_error(dyad: pennate.Network, table: Any) -> None:
    runs = [
        pennate.sweep(dyad, beta=BETA, pressure=PRESSURE, method="problem", executor=Executor(), chunk=chunk)
        for chunk in (8, 200)
    ]
    xarray.testing.assert_identical(*runs)
    for probe in ("stroke@inflate", "holding@push back"):
        error = runs[0][probe].attrs["error"]
        # Muscles that are pushed back are straight: any mesh holds them exactly, but for rounding.
        assert error < 1e-12 if probe == "holding@push back" else 0 < error < 1e-3
        scale = float(abs(table[probe]).max())
        np.testing.assert_allclose(runs[0][probe], table[probe], atol=2 * error + 2e-6 * scale)
    assert runs[0].stable.equals(table.stable) and runs[0].status.equals(table.status)


def test_workers_keep_a_network_and_ask_for_it_if_they_lack_it(dyad: pennate.Network) -> None:
    from pennate._sweep import _job

    def forget(number: int) -> None:
        if number in (15, 18):
            _job._solvers.clear()

    executor = Executor(forget)
    found = pennate.sweep(dyad, beta=np.linspace(16, 30, 160), executor=executor, chunk=8)
    carries = [arguments[4] is not None for arguments in executor.arguments]
    # The first ones have it with them, and those that come back for it.
    again = len(carries) - 20
    assert carries[:8] == [True] * 8 and 2 <= again <= 8 and sum(carries) == 8 + again
    assert found.attrs["losses"] == [] and (found.stable == 1).all()


@pytest.mark.parametrize("method", ["solve", "problem"])
def test_a_run_that_was_stopped_goes_on_byte_for_byte(dyad: pennate.Network, whole: bytes, tmp_path: Path, method: str) -> None:
    file = tmp_path / "sweep.csv"

    def run(executor: Executor | None = None) -> Any:
        return pennate.sweep(dyad, beta=BETA, pressure=PRESSURE, output=tmp_path, method=method, executor=executor, chunk=16)

    run()
    complete = file.read_bytes()
    assert complete == whole or method == "problem"
    head, *rows = complete.splitlines(keepends=True)
    for part in (0.0, 0.3, 0.6, 0.999, 1.0):
        file.write_bytes(complete[: len(head) + int(part * (len(complete) - len(head)))])
        executor = Executor()
        run(executor)
        assert file.read_bytes() == complete
        assert executor.calls == {0.0: 3, 0.3: 3, 0.6: 2, 0.999: 1, 1.0: 0}[part]
    # What was begun in another order, as workers answer, ends in that of the designs.
    file.write_bytes(head + b"".join(rows[::-3]))
    run()
    assert file.read_bytes() == complete


def test_an_interrupt_keeps_what_was_answered(dyad: pennate.Network, whole: bytes, tmp_path: Path) -> None:
    def stop(done: int, count: int) -> None:
        assert count == COUNT
        if done >= 16:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        pennate.sweep(dyad, beta=BETA, pressure=PRESSURE, output=tmp_path, executor=Executor(), chunk=8, progress=stop)
    file = tmp_path / "sweep.csv"
    assert file.read_bytes() == b"".join(whole.splitlines(keepends=True)[:17])
    executor = Executor()
    pennate.sweep(dyad, beta=BETA, pressure=PRESSURE, output=tmp_path, executor=executor, chunk=8)
    assert file.read_bytes() == whole and executor.calls == 4


@pytest.mark.parametrize("method", ["solve", "problem"])
def test_ctrl_c_does_not_wait_for_designs_under_way(method: str) -> None:
    network = pennate.scene("spiral", cells=12)
    tree = network.to_dict()
    # One design takes some seconds.
    slow = network.edit(steps=[{**step, "increments": 3000} for step in tree["steps"]])
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    pressed: list[float] = []

    def press() -> None:
        pressed.append(time.perf_counter())
        os.kill(os.getpid(), signal.SIGINT)

    finger = threading.Timer(0.5, press)
    try:
        finger.start()
        with pytest.raises(KeyboardInterrupt):
            pennate.sweep(slow, H=slow.parameters["H"] * np.linspace(0.98, 1.02, 4), threads=2, method=method)
        late = time.perf_counter() - pressed[0]
    finally:
        finger.join()
        signal.signal(signal.SIGINT, before)
    assert late < 0.5


def test_more_values_solve_only_what_is_missing(dyad: pennate.Network, whole: bytes, tmp_path: Path) -> None:
    pennate.sweep(dyad, beta=[16, 20], pressure=PRESSURE, output=tmp_path)
    executor = Executor()
    pennate.sweep(dyad, beta=BETA, pressure=PRESSURE, output=tmp_path, executor=executor, chunk=8)
    assert sum(len(arguments[3]) for arguments in executor.arguments) == COUNT - 8
    assert (tmp_path / "sweep.csv").read_bytes() == whole
    with pytest.raises(FileExistsError, match="40 rows that this sweep does not ask for"):
        pennate.sweep(dyad, beta=[16, 20], pressure=PRESSURE, output=tmp_path)
    with pytest.raises(FileExistsError, match="its network or what was set in it"):
        pennate.sweep(dyad.set(L=140), beta=BETA, pressure=PRESSURE, output=tmp_path)
    with pytest.raises(FileExistsError, match="its accuracy"):
        pennate.sweep(dyad, beta=BETA, pressure=PRESSURE, output=tmp_path, accuracy=1e-5)
    assert (tmp_path / "sweep.csv").read_bytes() == whole
    table = pennate.sweep(dyad, beta=[16, 20], pressure=[15, 16], output=tmp_path, overwrite=True)
    assert len((tmp_path / "sweep.csv").read_bytes().splitlines()) == 5 and (table.reason == "").all()


def test_two_runs_in_one_directory_both_end_in_a_whole_table(dyad: pennate.Network, whole: bytes, tmp_path: Path) -> None:
    def another(done: int, _: int) -> None:
        if done == 16:
            pennate.sweep(dyad, beta=BETA, pressure=PRESSURE, output=tmp_path)

    pennate.sweep(dyad, beta=BETA, pressure=PRESSURE, output=tmp_path, executor=Executor(), chunk=8, progress=another)
    assert (tmp_path / "sweep.csv").read_bytes() == whole


def test_the_program_and_the_package_go_on_with_each_other(
    dyad: pennate.Network, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, whole: bytes
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("dyad.toml").write_text(dyad.text, encoding="utf-8")
    network = pennate.load("dyad.toml")
    sweep = ["sweep", "dyad.toml", "--vary", "pressure=12,15,22,1000", "-o", "out"]
    _core.main([*sweep, "--vary", "beta=16:38:2"])
    written = Path("out/sweep.csv").read_bytes()
    executor = Executor()
    found = pennate.sweep(network, pressure=PRESSURE, beta=BETA, output="out", executor=executor)
    assert executor.calls == 0 and Path("out/sweep.csv").read_bytes() == written
    # Row by row what the package says, but for the last digits of numbers.
    mine = pennate.sweep(network, pressure=PRESSURE, beta=BETA)
    for name in ("status", "stable", "reason"):
        assert mine[name].equals(found[name])
    for name in ("stroke@inflate", "holding@push back"):
        np.testing.assert_allclose(mine[name], found[name], rtol=1e-9, atol=1e-9)
    _core.main([*sweep, "--vary", "beta=16:40:2"])
    assert len(Path("out/sweep.csv").read_bytes().splitlines()) == 1 + 4 * 13


def test_a_list_of_designs_has_numbers(dyad: pennate.Network, tmp_path: Path) -> None:
    values = {"beta": [22.0, 22.0, 30.5], "pressure": np.array([15, 15, 20])}
    found = pennate.sweep(dyad, designs=values, probes=["stroke@inflate"], output=tmp_path)
    assert found.sizes == {"design": 3} and found.design.values.tolist() == [1, 2, 3]
    assert found.beta.values.tolist() == [22.0, 22.0, 30.5]
    lines = (tmp_path / "sweep.csv").read_text().splitlines()
    assert lines[0] == "design,beta,pressure,status,stable,stroke@inflate (mm),error,reason"
    assert lines[3].startswith("3,30.5,20,converged,yes,")
    executor = Executor()
    pennate.sweep(dyad, designs=values, probes=["stroke@inflate"], output=tmp_path, executor=executor)
    assert executor.calls == 0


def test_designs_may_be_a_table_with_columns(dyad: pennate.Network) -> None:
    class Frame:
        """As those of pandas."""

        columns = ("beta", "pressure")

        def items(self) -> Any:
            return zip(self.columns, ([22.0, 30.5], np.array([15, 20])))

        def __bool__(self) -> bool:
            raise ValueError("the truth value is ambiguous")

    found = pennate.sweep(dyad, designs=Frame())  # type: ignore[arg-type]
    xarray.testing.assert_identical(found, pennate.sweep(dyad, designs=dict(Frame().items())))
    with pytest.raises(TypeError, match="designs: a dictionary expected, not"):
        pennate.sweep(dyad, designs=[22.0])  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="vary: a dictionary expected, not"):
        pennate.sweep(dyad, [22.0])  # type: ignore[arg-type]


def test_a_chunk_that_was_lost_is_sent_again(dyad: pennate.Network, table: Any) -> None:
    executor = Executor(raising(OSError("the worker was killed"), 2, 3))
    found = pennate.sweep(dyad, beta=BETA, pressure=PRESSURE, executor=executor, chunk=8)
    assert executor.calls == 8
    assert found.attrs["losses"] == ["2 chunks were sent again: OSError: the worker was killed"]
    xarray.testing.assert_equal(found, table)


def test_what_nobody_answers_is_told_when_the_rest_is_done(dyad: pennate.Network, whole: bytes, tmp_path: Path) -> None:
    class Bad(Executor):
        """Loses whoever works on the third chunk."""

        def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Any:
            if args[3][0].tolist() == [24.0, 12.0]:
                self.before = raising(OSError("out of memory"), self.calls)
            return super().submit(fn, *args, **kwargs)

    with pytest.raises(
        pennate.WorkerError, match=r"8 designs have no answer, .* out of memory; what was answered is in"
    ) as raised:
        pennate.sweep(dyad, beta=BETA, pressure=PRESSURE, executor=Bad(), chunk=8, retries=2, output=tmp_path)
    rest = raised.value.table
    assert rest is not None and int((rest.status == "").sum()) == 8
    assert len((tmp_path / "sweep.csv").read_bytes().splitlines()) == 41
    pennate.sweep(dyad, beta=BETA, pressure=PRESSURE, output=tmp_path)
    assert (tmp_path / "sweep.csv").read_bytes() == whole


def test_an_executor_without_workers_is_told_at_once(dyad: pennate.Network) -> None:
    executor = Executor(raising(ModuleNotFoundError("No module named 'pennate'"), *range(1000)))
    with pytest.raises(pennate.WorkerError, match="sent 2 times: ModuleNotFoundError: No module named 'pennate'"):
        pennate.sweep(dyad, beta=range(10, 60), executor=executor, chunk=8, retries=1)
    assert executor.calls < 20


def die(*_: Any) -> None:
    """A worker's end."""
    os._exit(1)


def test_a_pool_that_lost_a_process_is_told_and_the_table_kept(dyad: pennate.Network, tmp_path: Path) -> None:
    with processes(1) as executor:
        executor.submit(die)
        with pytest.raises(pennate.WorkerError, match="BrokenProcessPool"):
            pennate.sweep(dyad, beta=BETA, executor=executor, output=tmp_path)
    assert len(pennate.sweep(dyad, beta=BETA, output=tmp_path).beta) == 12


def test_an_answer_that_arrives_twice_is_taken_once(dyad: pennate.Network, table: Any) -> None:
    class Slow(concurrent.futures.ThreadPoolExecutor):
        """The first chunks are answered long after they were given up for lost."""

        calls = 0

        def submit(self, fn: Any, /, *args: Any, **kwargs: Any) -> Any:
            def late(*args: Any) -> Any:
                found = fn(*args)
                late_by.wait(1.5)
                return found

            self.calls += 1
            return super().submit(late if self.calls <= 6 else fn, *args, **kwargs)

    late_by = threading.Event()
    seen: list[int] = []
    with Slow(12) as executor:
        found = pennate.sweep(
            dyad,
            beta=BETA,
            pressure=PRESSURE,
            executor=executor,
            chunk=8,
            timeout=0.5,
            progress=lambda done, _: seen.append(done),
        )
    assert executor.calls > 6 and seen == list(range(0, COUNT + 1, 8))
    assert "no worker had answered anything for 0.5 s" in found.attrs["losses"][0]
    xarray.testing.assert_equal(found, table)


def test_a_worker_on_which_the_network_fails_is_named_and_others_do_the_work(dyad: pennate.Network, table: Any) -> None:
    from pennate._sweep._job import Failure

    def before(number: int) -> Failure | None:
        return Failure("node7, process 12", "there is no room for the network") if number % 2 else None

    executor = Executor(before)
    found = pennate.sweep(dyad, beta=BETA, pressure=PRESSURE, executor=executor, chunk=8)
    (loss,) = found.attrs["losses"]
    assert loss.endswith("sent again: worker node7, process 12: there is no room for the network")
    xarray.testing.assert_equal(found, table)
    with pytest.raises(pennate.WorkerError, match="node7, process 12: there is no room"):
        pennate.sweep(dyad, beta=BETA, executor=Executor(lambda _: Failure("node7, process 12", "there is no room")))


def test_another_version_on_a_worker_is_said(dyad: pennate.Network, monkeypatch: pytest.MonkeyPatch) -> None:
    from pennate._sweep import _job

    job = _job.Job(dyad, ("beta",), ("holding",), 1e-6, "solve")
    key, packed = job.packed()
    assert isinstance(_job.answer(key + "0", "run", "1", np.array([[22.0]]), None), _job.Missing)
    monkeypatch.setattr(_job._core, "__version__", "0.0.9")
    found = _job.answer(key + "0", "run", "1", np.array([[22.0]]), packed)
    assert isinstance(found, _job.Failure)
    assert found.reason == f"it has version 0.0.9 of pennate, not {pennate.__version__}"


@pytest.mark.parametrize(
    ("values", "error", "message"),
    [
        ({}, ValueError, "nothing to vary"),
        ({"bet": [1]}, pennate.NetworkError, r"(?s)no parameter 'bet' to vary.*did you mean 'beta'\?"),
        ({"designs": {"bet": [1]}}, pennate.NetworkError, "'bet' is among the columns of designs="),
        ({"beta": []}, ValueError, "'beta': one or more numbers in a row expected"),
        ({"beta": [[1, 2]]}, ValueError, r"in a row expected, not an array of the shape \(1, 2\)"),
        ({"beta": [1, 2, np.nan]}, ValueError, "'beta': finite numbers expected, not nan at index 2"),
        ({"beta": [1, 2j]}, TypeError, "'beta': numbers expected, not"),
        ({"beta": ["20 deg"]}, TypeError, "'beta': numbers expected, not '20 deg' at index 0"),
        ({"beta": [1, 1]}, ValueError, "'beta' has a value twice"),
        ({"beta": ["ten"]}, TypeError, "'beta': numbers expected"),
        ({"beta": [20], "method": "guess"}, ValueError, "'solve' or 'problem' expected"),
        ({"beta": [20], "chunk": 0}, ValueError, "chunk: a whole number"),
        ({"beta": [20], "chunk": "8"}, TypeError, "chunk: a whole number, one or more, expected, not '8'"),
        ({"beta": [20], "retries": "3"}, TypeError, "retries: a whole number"),
        ({"beta": [20], "timeout": "3"}, TypeError, "timeout: a number of seconds"),
        ({"beta": [20], "threads": "2"}, TypeError, "threads: a whole number, from 1 to 1000, expected, not '2'"),
        ({"beta": [20], "progress": 3}, TypeError, "progress: something that can be called"),
        ({"beta": [20], "probes": ["strike"]}, pennate.NetworkError, "(?s)no probe 'strike'.*'stroke', 'holding'"),
        ({"beta": [20], "probes": ["stroke@deflate"]}, pennate.NetworkError, "no step 'deflate'"),
        ({"beta": [20], "designs": {"L": [1]}}, ValueError, "either values to combine or designs="),
        ({"designs": {"L": [1], "beta": [1, 2]}}, ValueError, "of 'L' 1, 'beta' 2"),
    ],
)
def test_slips_are_refused(dyad: pennate.Network, values: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        pennate.sweep(dyad, **values)


def test_parameters_that_are_called_as_the_table_is_are_refused_at_once(dyad: pennate.Network) -> None:
    for name in ("status", "stable", "error", "reason"):
        with pytest.raises(ValueError, match=f"a parameter called '{name}' cannot be varied"):
            pennate.sweep(pennate.loads(dyad.text.replace("beta", name)), {name: [20]})
    called = pennate.loads(dyad.text.replace("beta", "design"))
    assert pennate.sweep(called, design=[20, 30]).design.values.tolist() == [20.0, 30.0]
    with pytest.raises(ValueError, match="a parameter called 'design' cannot be varied"):
        pennate.sweep(called, designs={"design": [20, 30]})


def test_a_name_that_there_is_not_is_data_too(dyad: pennate.Network) -> None:
    for probes, name, note, help in (
        (["stroke", "strok@inflate"], "strok", "'strok@inflate' is number 2 of the probes asked for", "mean 'stroke'?"),
        (["stroke@inflat"], "inflat", "'stroke@inflat' is number 1 of the probes asked for", "mean 'inflate'?"),
    ):
        with pytest.raises(pennate.NetworkError) as caught:
            pennate.sweep(dyad, beta=[20], probes=probes)
        (error,) = caught.value.errors
        assert error.name == name and error.notes == [note] and help in (error.help or "")
        assert str(caught.value) == str(error) and str(error).startswith("error: there is no ")
    with pytest.raises(pennate.NetworkError) as caught:
        pennate.sweep(dyad, bet=[20])
    assert [(error.name, error.notes) for error in caught.value.errors] == [("bet", ["'bet' is among the values to combine"])]


@pytest.mark.parametrize("wrong", [3, "threads", object()])
def test_what_takes_no_work_is_refused_before_any(dyad: pennate.Network, tmp_path: Path, wrong: Any) -> None:
    from pennate.control import Solved

    wanted = r"executor: something with submit\(\)"
    with pytest.raises(TypeError, match=wanted):
        pennate.sweep(dyad, beta=[20], executor=wrong, output=tmp_path / "table")
    with pytest.raises(TypeError, match=wanted):
        pennate.optimize("nowhere.toml", tmp_path / "table", executor=wrong)
    for given, message in (
        ({"threads": "2"}, "threads: a whole number"),
        ({"budget": "9"}, "budget: a number of designs"),
        ({"progress": 3}, "progress: something that can be called"),
    ):
        with pytest.raises(TypeError, match=message):
            pennate.optimize("nowhere.toml", tmp_path / "table", **given)
    with pytest.raises(TypeError, match=wanted):
        dyad.problem(["beta"], ["stroke"]).on(wrong)
    with pytest.raises(TypeError, match=wanted):
        Solved(dyad, {"nothing": (0, 1)}, executor=wrong)
    with pytest.raises(TypeError, match="a network expected, as pennate.load"):
        pennate.sweep("dyad.toml", beta=[20])  # type: ignore[arg-type]
    assert not (tmp_path / "table").exists()


def test_a_problem_on_an_executor_gives_the_same_bits(dyad: pennate.Network) -> None:
    problem = dyad.problem(["beta", "pressure"], ["stroke@inflate", "holding"])
    x = np.stack([np.linspace(15, 30, 75), np.linspace(15, 26, 75)], axis=1)
    y, (same, slopes) = problem(x), problem.gradient(x)
    with processes(2) as pool:
        for executor, chunk in ((Executor(), None), (Executor(raising(OSError("lost"), 1)), 16), (pool, 24)):
            spread = problem.on(executor, chunk=chunk)
            np.testing.assert_array_equal(spread(x), y)
            reasons, verdicts = spread.reasons, spread.stable
            found = spread.gradient(x)
            assert spread.stable == verdicts
            np.testing.assert_array_equal(found[0], same)
            np.testing.assert_array_equal(found[1], slopes)
    problem(x)
    assert verdicts == problem.stable and True in verdicts and None in verdicts
    assert reasons == problem.reasons and isinstance(reasons[-1], pennate.Reason) and reasons[-1].kind == "refused"
    assert repr(spread).endswith("holding, on ProcessPoolExecutor>")
    np.testing.assert_allclose(spread(x[3]), y[3], rtol=1e-11)
    again = pickle.loads(pickle.dumps(spread))
    assert type(again) is pennate.Problem and again.probes == spread.probes
    with pytest.raises(ValueError, match="2 parameters"):
        spread(np.zeros((3, 3)))


def test_a_network_goes_once_to_a_worker_that_is_called_many_times(dyad: pennate.Network) -> None:
    executor = Executor()
    spread = dyad.problem(["beta"], ["holding"]).on(executor)
    for _ in range(6):
        spread(np.linspace(20, 30, 64)[:, None])
    carries = [arguments[4] is not None for arguments in executor.arguments]
    assert len(carries) == 48 and carries[:8] == [True] * 8 and sum(carries) == 8


def test_an_arm_on_an_executor_is_the_same(dyad: pennate.Network) -> None:
    from pennate.control import Solved

    network = dyad.edit(probes={"x": {"node": "J", "position": "x"}, "y": {"node": "J", "position": "y"}, "z": "= 0 * stroke"})
    executor = Executor()
    arms = [Solved(network, {"pressure": (10, 25)}, executor=each) for each in (None, executor)]
    inputs = np.linspace(11, 24, 20)[:, None]
    np.testing.assert_array_equal(arms[0].tip(inputs), arms[1].tip(inputs))
    assert executor.calls == 3


def test_designs_that_are_labelled_along_another_axis_are_turned(dyad: pennate.Network) -> None:
    pandas = pytest.importorskip("pandas")
    names = ["beta", "pressure"]
    problem = dyad.problem(names, ["stroke@inflate"], accuracy=1e-4)
    # As many designs as parameters: the shape does not tell.
    x = np.array([[22.0, 18.0], [30.0, 20.0]])
    y = problem(x)
    labels = {"parameter": names, "design": ["first", "second"]}
    for given in (
        xarray.DataArray(x, dims=("design", "parameter"), coords=labels),
        xarray.DataArray(x.T, dims=("parameter", "design"), coords=labels),
        xarray.DataArray(x.T, dims=("parameter", "design"), coords={"parameter": names}),
        pandas.DataFrame(x, columns=names),
        pandas.DataFrame(x, columns=names, index=names),
        pandas.DataFrame(x.T, index=names),
        pandas.DataFrame(x.T, index=names, columns=["first", "second"]),
    ):
        np.testing.assert_array_equal(problem(given), y)
        np.testing.assert_array_equal(problem.gradient(given)[0], problem.gradient(x)[0])
        mesh = dyad.problem(names, ["stroke@inflate"], accuracy=1e-4, sample=given)
        np.testing.assert_array_equal(mesh.error, dyad.problem(names, ["stroke@inflate"], accuracy=1e-4, sample=x).error)
    one = pandas.Series(x[0], index=names)
    np.testing.assert_array_equal(problem(one), problem(x[0]))


def test_labels_that_do_not_tell_which_axis_is_meant_are_refused(dyad: pennate.Network) -> None:
    pandas = pytest.importorskip("pandas")
    problem = dyad.problem(["beta", "pressure"], ["stroke@inflate"], accuracy=1e-4)
    x = np.full((2, 2), 20.0)
    for given, message in (
        (pandas.DataFrame(x, index=["pressure", "beta"]), "columns pressure, beta, but beta, pressure are expected, in this order"),
        (pandas.DataFrame(np.full((3, 2), 20.0), index=["beta", "pressure", "L"]), "rows beta, pressure, L, but"),
        (xarray.DataArray(x, dims=("p", "d"), coords={"p": ["beta", "L"]}), "rows beta, L, but beta, pressure are expected"),
        (pandas.DataFrame(x, columns=["a", "b"]), "columns a, b, but"),
    ):
        with pytest.raises(ValueError, match=message):
            problem(given)
