"""Many designs: parameters in, probes out, with derivatives, and equilibria that are kept and followed."""

from __future__ import annotations

import math
import threading
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, overload

import numpy as np
import numpy.typing as npt

from . import _arguments, _core
from ._errors import SolveError
from ._solution import _named

if TYPE_CHECKING:
    import concurrent.futures

    from ._network import Network

Array = npt.NDArray[np.float64]
# Live states of one problem, at most: a larger number is a slip, and would end the interpreter for want of memory.
MOST_LIVE = 1_000_000


class Reason(str):
    """Why a design has no answer, or not all of it, in a sentence; `kind` is a word for programs.

    Kinds are `not_finite`, `refused`, `other_topology`, `mechanism`, `limit_point`, `bifurcation`, `not_converged`,
    `unbalanced` (values of a state in which a moment is taken by nothing), `singular`, `no_derivative`, `inexact`
    (derivatives that are less exact than others), `lost` and `interrupted`.
    """

    __slots__ = ("kind",)
    kind: str

    def __new__(cls, text: str, kind: str) -> Reason:
        reason = super().__new__(cls, text)
        reason.kind = kind
        return reason

    def __reduce__(self) -> tuple[Any, ...]:
        return Reason, (str(self), self.kind)


class Problem:
    """A network compiled for some of its parameters and probes: `y = problem(x)`.

    `x` is (n, k) or, for one design, (k,), each value in the unit of its parameter, as `network.set` takes it; `y` is (n, m) or
    (m,), in the units of the probes. Reading, checking and meshing happened once. Answers depend neither on the other designs of a call, nor on
    their order, nor on the number of threads. A problem may be called by several Python threads at once.
    """

    __slots__ = ("_call", "_facts", "_last", "_made")

    def __init__(
        self,
        network: Network,
        parameters: Sequence[str],
        probes: Sequence[str],
        accuracy: float,
        sample: Array,
        threads: int,
    ) -> None:
        self._made = (network, tuple(parameters), tuple(probes), accuracy, sample, threads)
        core = network._read.problem(list(parameters), list(probes), accuracy, sample.ravel().tolist(), threads)
        self._call = core
        self._facts = core.facts()
        self._last = threading.local()

    @property
    def network(self) -> Network:
        """The network that was compiled."""
        return self._made[0]

    @property
    def parameters(self) -> tuple[str, ...]:
        """Names of the k parameters, in the order of a row of `x`."""
        return tuple(self._facts[0])

    @property
    def probes(self) -> tuple[str, ...]:
        """Names of the m probes, in the order of a row of `y`."""
        return tuple(self._facts[1])

    @property
    def middle(self) -> Array:
        """(k,), the values of the parameters in the file, each in its unit."""
        return np.array(self._facts[2])

    @property
    def error(self) -> Array:
        """(m,), estimated discretization error of the probes: the largest of the designs that the mesh was made for."""
        return np.array(self._facts[3])

    @property
    def accuracy(self) -> float:
        """The relative accuracy that the mesh was made for."""
        return self._made[3]

    def __call__(self, x: npt.ArrayLike) -> Array:
        """The probes of some designs.

        Args:
            x: (n, k) or (k,), values of the parameters; labels that are their names tell the axis of k.

        Returns:
            (n, m) or (m,); not a number where there is no answer, and `reasons` says why.
        """
        y, *self._last.answer = self._call.evaluate(_arguments.numbers(x, "x", self._facts[0]))
        return y

    def gradient(self, x: npt.ArrayLike) -> tuple[Array, Array]:
        """The probes of some designs, and their derivatives by all parameters.

        Args:
            x: (n, k) or (k,), values of the parameters; labels that are their names tell the axis of k.

        Returns:
            `y`, (n, m) or (m,), and `j`, (n, m, k) or (m, k); not a number where there is no answer, or no derivative.
        """
        y, j, *self._last.answer = self._call.gradient(_arguments.numbers(x, "x", self._facts[0]))
        return y, j

    @property
    def reasons(self) -> list[Reason | None]:
        """One entry a design of the last call that this thread made: why it has no answer, or `None`."""
        why, stable = getattr(self._last, "answer", ([], []))
        found: list[Reason | None] = [None] * len(stable)
        for index, kind, text in why:
            found[index] = Reason(text, kind)
        return found

    def on(
        self,
        executor: concurrent.futures.Executor,
        *,
        chunk: int | None = None,
        retries: int = 3,
        timeout: float | None = None,
    ) -> Problem:
        """The same problem, whose designs the workers of an executor solve: the same answers, bit for bit.

        Args:
            executor: Any of `concurrent.futures`, such as `dask.distributed.Client.get_executor()`. Each worker gets the
                network once, and compiles it.
            chunk: Designs that are sent at a time, rounded up to a multiple of eight; a part of each call by default.
            retries: So many times a chunk is sent again whose worker was lost.
            timeout: Seconds without any answer after which all chunks that are out are sent again.

        Calls raise `WorkerError` where nobody answers. Live states, and single designs, stay in this process.
        """
        from ._sweep._spread import Spread

        return Spread(self, executor, chunk, retries, timeout)

    @property
    def stable(self) -> list[bool | None]:
        """One entry a design of the last call that this thread made: whether the ends of all steps that got somewhere are stable.

        `None` where that is not defined, or not known. Plane networks are judged out of their plane as well, unless the file
        says `dimension = "plane"`.
        """
        return list(getattr(self._last, "answer", ([], []))[1])

    @overload
    def live(self, count: None = None) -> Live: ...

    @overload
    def live(self, count: int) -> Lives: ...

    def live(self, count: int | None = None) -> Live | Lives:
        """An equilibrium at the values of the file, to be followed from there; with a number, so many side by side.

        Raises:
            SolveError: There is no equilibrium there.
        """
        if count is None:
            return Live(self)
        return Lives(self, _arguments.count(count, "count", MOST_LIVE))

    def __repr__(self) -> str:
        title = self.network.title or self.network.name
        return f"<Problem {title!r}: {' '.join(self.parameters)} -> {' '.join(self.probes)}>"

    def __reduce__(self) -> tuple[Any, ...]:
        return Problem, self._made


class Live:
    """An equilibrium that is kept, and followed as parameters change.

        live.set(pressure=12.5)
        live.solve()
        live["holding"], live.stable

    It stays on its branch: what a step of the file holds where it was (`hold`, `displace_by`) is held where it was at the values of the
    file, whatever the parameters are set to, where `problem(x)` would hold it where the steps lead at `x`. Calls of several threads
    take turns.
    """

    __slots__ = ("_core", "_wanted", "problem")
    problem: Problem

    def __init__(self, problem: Problem) -> None:
        self.problem = problem
        self._core = problem._call.live()
        self._wanted = self._core.now()[1].tolist()

    def set(self, /, **parameters: float) -> Live:
        """Sets parameters to values that the next `solve` goes to.

        Raises:
            ValueError: A value is no finite number; nothing is set.
        """
        places = [_named(name, self.problem.parameters, "parameter") for name in parameters]
        values = [_arguments.real(value, f"parameter '{name}'") for name, value in parameters.items()]
        for name, value in zip(parameters, values):
            if not math.isfinite(value):
                raise ValueError(f"parameter '{name}': a finite number expected, not {value}")
        for place, value in zip(places, values):
            self._wanted[place] = value
        return self

    def solve(self) -> Live:
        """Goes to the values that were set.

        Raises:
            SolveError: The way does not lead there. The last state is kept, and so is what was set.
            KeyboardInterrupt: Ctrl-C was pressed on the way. The last state that was reached is kept, and `present` says whose it
                is; probes of earlier steps that were not followed there are NaN until the next `solve`.
        """
        why, raised = self._core.go(self._wanted)
        if raised is not None:
            raise raised
        if why is not None:
            raise SolveError(why[2])
        return self

    @property
    def values(self) -> Array:
        """(m,), the probes in the present state."""
        return self._core.now()[0].copy()

    @property
    def present(self) -> dict[str, float]:
        """The parameters that the present state belongs to."""
        return dict(zip(self.problem.parameters, self._core.now()[1].tolist()))

    @property
    def stable(self) -> bool | None:
        """Whether the present state is stable; `None` where that is not defined, or not known.

        Under loads that have no potential (those that turn with their node, moments in space) it is a matter of small vibrations
        where masses are known, as `solve` has it: these are looked at when this is asked for, once a state. Where rounding hides a
        verdict `solve` has `None`, which is not looked at here.
        """
        _, _, known, stable = self._core.now()
        return stable if known else self._core.stable()

    def __reduce__(self) -> tuple[Any, ...]:
        raise TypeError("a live state can neither be copied nor pickled: make another one of its problem, and set that")

    def __getitem__(self, probe: str) -> float:
        return float(self._core.now()[0][_named(probe, self.problem.probes, "probe")])

    def __contains__(self, probe: object) -> bool:
        return probe in self.problem.probes

    def __repr__(self) -> str:
        now = " ".join(f"{name}={value:.6g}" for name, value in self.present.items())
        values = " ".join(f"{name}={value:.6g}" for name, value in zip(self.problem.probes, self.values))
        return f"<Live {now}: {values}, {judged(self.stable)}>"

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.problem.probes)


class Lives:
    """Equilibria that are kept and followed side by side; everything is an array over them.

    Each of them is what a `Live` is. Calls of several threads take turns.
    """

    __slots__ = ("_core", "_wanted", "problem")
    problem: Problem

    def __init__(self, problem: Problem, count: int) -> None:
        self.problem = problem
        self._core = problem._call.live_all(count)
        self._wanted = np.tile(problem.middle, (count, 1))

    def __len__(self) -> int:
        return len(self._wanted)

    def set(self, /, **parameters: npt.ArrayLike) -> Lives:
        """Sets parameters, each by a number or by (n,) numbers, to values that the next `solve` goes to."""
        wanted = self._wanted.copy()
        for name, values in parameters.items():
            place = _named(name, self.problem.parameters, "parameter")
            column = _arguments.numbers(values, f"parameter '{name}'")
            if column.shape not in ((), (1,), (len(self),)):
                raise ValueError(
                    f"parameter '{name}' has the shape {column.shape}, but there are {len(self)} states: "
                    f"a number or ({len(self)},) expected"
                )
            wanted[:, place] = column
        self._wanted = wanted
        return self

    def solve(self) -> Lives:
        """Goes to the values that were set; where the way does not lead there, the last state is kept, and `reasons` says why.

        Raises:
            KeyboardInterrupt: Ctrl-C was pressed on the way. Each state is kept as far as it came, and `reasons` says of which
                it was not all the way; probes of earlier steps that were not followed there are NaN until the next `solve`.
        """
        raised = self._core.go(self._wanted)
        if raised is not None:
            raise raised
        return self

    @property
    def values(self) -> Array:
        """(n, m), the probes in the present states."""
        return self._core.now()[0].copy()

    @property
    def present(self) -> dict[str, Array]:
        """The parameters that the present states belong to, (n,) each: those that were set, but for states that did not get there."""
        rows = self._core.now()[3]
        return {name: rows[:, place].copy() for place, name in enumerate(self.problem.parameters)}

    @property
    def stable(self) -> list[bool | None]:
        """Whether each state is stable; `None` where that is not defined, or not known. See `Live.stable`."""
        known = self._core.now()[1]
        return self._core.stable() if known is None else list(known)

    @property
    def reasons(self) -> list[Reason | None]:
        """Why states did not get where the last `solve` was to go."""
        found: list[Reason | None] = [None] * len(self)
        for index, kind, text in self._core.now()[2]:
            found[index] = Reason(text, kind)
        return found

    def __reduce__(self) -> tuple[Any, ...]:
        raise TypeError("live states can neither be copied nor pickled: make others of their problem, and set those")

    def __getitem__(self, probe: str) -> Array:
        """(n,), a probe in all states."""
        found: Array = self._core.now()[0][:, _named(probe, self.problem.probes, "probe")]
        return found.copy()

    def __contains__(self, probe: object) -> bool:
        return probe in self.problem.probes

    def __repr__(self) -> str:
        return f"<Lives: {len(self)} states of {self.problem!r}>"

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.problem.probes)


def judged(stable: bool | None) -> str:
    """The verdict in words."""
    return {True: "stable", False: "unstable", None: "stability not known"}[stable]
