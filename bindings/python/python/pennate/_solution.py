"""Solutions: arrays by step, and everything else that is known of the states."""

from __future__ import annotations

import functools
import json
import operator
import os
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
import numpy.typing as npt

from . import _core
from ._errors import Finding, SolveError

if TYPE_CHECKING:
    import pyvista

    from ._network import Network

Array = npt.NDArray[np.float64]


class Source(Protocol):
    """Where the parts of a solution come from: the solver, or a pickle."""

    def facts(self) -> dict[str, Any]: ...
    def displacement(self) -> Array: ...
    def rotation(self) -> Array: ...
    def reaction(self) -> Array: ...
    def end_forces(self) -> Array: ...
    def member_values(self) -> Array: ...
    def spring_forces(self) -> Array: ...
    def energy(self) -> Array: ...
    def probes(self) -> tuple[Array, Array]: ...
    def history(self) -> tuple[list[str], Array, list[tuple[str, str, Array]]]: ...
    def json(self) -> str: ...
    def report(self) -> str: ...
    def warnings(self) -> list[Finding]: ...
    def failures(self) -> list[Finding]: ...
    def fractions(self, step: int) -> Array | None: ...
    def drawing(self, step: int | None, increment: int) -> dict[str, Any] | None: ...


PARTS = (
    "facts",
    "displacement",
    "rotation",
    "reaction",
    "end_forces",
    "member_values",
    "spring_forces",
    "energy",
    "probes",
    "history",
    "json",
    "report",
    "warnings",
    "failures",
)


class Values(Mapping[str, Array]):
    """Arrays by the names of the probes, one entry a step; not a number where a step was not reached."""

    __slots__ = ("_columns", "_steps")

    def __init__(self, names: list[str], steps: tuple[str, ...], table: Array) -> None:
        self._columns = {name: table[:, column] for column, name in enumerate(names)}
        self._steps = steps

    def __getitem__(self, name: str) -> Any:
        if name in self._columns:
            return self._columns[name].copy()
        probe, at, step = (part.strip() for part in str(name).partition("@"))
        if at and probe in self._columns:
            return float(self._columns[probe][_place(step, self._steps, "step")])
        raise _unknown(probe if isinstance(name, str) else name, tuple(self._columns), "probe")

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return "{" + ", ".join(f"{name!r}: {values}" for name, values in self._columns.items()) + "}"

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._columns)


class History(Mapping[str, Array]):
    """What `history.csv` has: one entry a row, first the unloaded state, then every increment of every step.

    Columns are `fraction`, loads and pressures, and the probes; `steps` has the step of each row.
    """

    __slots__ = ("_columns", "steps", "units")
    steps: npt.NDArray[np.str_]
    """(rows,), name of the step of each row."""
    units: dict[str, str]
    """The unit of each column; empty where it has none."""

    def __init__(self, steps: list[str], fractions: Array, columns: list[tuple[str, str, Array]]) -> None:
        self.steps = np.array(steps, dtype=np.str_)
        self._columns = {"fraction": fractions, **{name: values for name, _, values in columns}}
        self.units = {"fraction": "", **{name: unit for name, unit, _ in columns}}

    def __getitem__(self, name: str) -> Array:
        if name not in self._columns:
            raise _unknown(name, tuple(self._columns), "column")
        return self._columns[name].copy()

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def of_step(self, step: str) -> dict[str, Array]:
        """The rows of one step, without the state that it begins with."""
        rows = self.steps == step
        # The unloaded state stands under the first step.
        rows[0] = False
        if not rows.any():
            raise _unknown(step, tuple(dict.fromkeys(self.steps.tolist())), "step")
        return {name: values[rows] for name, values in self._columns.items()}

    def __repr__(self) -> str:
        return f"<History: {len(self.steps)} rows of {', '.join(self._columns)}>"

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._columns)


class Solution:
    """A solved network: `solution["stroke"]` is a probe over the steps, `solution.error["stroke"]` its error.

    Arrays have the steps first; what a step did not reach is not a number. Vectors are in global axes, lengths, forces and
    moments in the units of the file.
    """

    network: Network
    """The network that was solved."""

    def __init__(self, source: Source, network: Network) -> None:
        self._source, self.network = source, network
        self._facts = source.facts()
        self._arrays: dict[str, Array] = {}

    # How it went.

    @property
    def title(self) -> str:
        """Title of the network."""
        return str(self._facts["title"])

    @property
    def status(self) -> str:
        """`"converged"`, or the status of the first step that is not: `"limit_point"`, `"bifurcation"`,
        `"not_converged"`, `"interrupted"`, `"not_reached"`."""
        return str(self._facts["status"])

    def raise_for_status(self) -> Solution:
        """Returns the solution where every step reached its end.

        Raises:
            SolveError: A step did not, with what the program says about it.
        """
        if self.status == "converged":
            return self
        failures = self.failures
        raise SolveError("\n\n".join(str(each) for each in failures) or self.status, failures, self)

    @property
    def stable(self) -> tuple[bool | None, ...]:
        """Whether the state at the end of each step is stable; `None` where that is not defined, or not known."""
        return tuple(self._facts["stable"])

    @property
    def fraction(self) -> Array:
        """(steps,), part of each step's ramp that was reached."""
        return np.array(self._facts["fractions"])

    @functools.cached_property
    def warnings(self) -> list[Finding]:
        """What is remarkable, about the file and about the run."""
        return list(self._source.warnings())

    @functools.cached_property
    def failures(self) -> list[Finding]:
        """Why steps failed, and whether the results have no error estimate."""
        return list(self._source.failures())

    def fractions(self, step: str | int) -> Array:
        """(increments,), part of the step's ramp at each of its increments."""
        found = self._source.fractions(_place(step, self.steps, "step"))
        return np.zeros(0) if found is None else found

    @property
    def asked(self) -> float:
        """The accuracy that was asked for."""
        return float(self._facts["accuracy"][0])

    @property
    def accuracy(self) -> float:
        """Estimated error of the mesh, relative to the largest values; not a number where there is no estimate."""
        estimated = self._facts["accuracy"][1]
        return float("nan") if estimated is None else float(estimated)

    # Names.

    @property
    def steps(self) -> tuple[str, ...]:
        """Names of the steps."""
        return tuple(self._facts["steps"])

    @property
    def nodes(self) -> tuple[str, ...]:
        """Names of the nodes, in the order of the arrays."""
        return tuple(self._facts["nodes"])

    @property
    def members(self) -> tuple[str, ...]:
        """Names of the members, in the order of the arrays."""
        return tuple(self._facts["members"])

    @property
    def probes(self) -> tuple[str, ...]:
        """Names of the probes."""
        return tuple(self._facts["probes"])

    # Numbers.

    def _array(self, name: str) -> Array:
        """One of the arrays of the source, which nobody else changes."""
        if name not in self._arrays:
            self._arrays[name] = getattr(self._source, name)()
        return self._arrays[name]

    @functools.cached_property
    def _probes(self) -> tuple[Values, Values]:
        values, errors = self._source.probes()
        return Values(self._facts["probes"], self.steps, values), Values(self._facts["probes"], self.steps, errors)

    def __getitem__(self, probe: str) -> Any:
        """A probe over the steps, (steps,), or with `probe@step` its value at the end of that step."""
        return self._probes[0][probe]

    def __contains__(self, probe: object) -> bool:
        return probe in self.probes

    @property
    def error(self) -> Values:
        """Estimated discretization errors of the probes, in their units."""
        return self._probes[1]

    @property
    def displacement(self) -> Array:
        """(steps, nodes, 3), length."""
        return self._array("displacement").copy()

    @property
    def rotation(self) -> Array:
        """(steps, nodes, 3), rotation vectors of norm at most π, radians."""
        return self._array("rotation").copy()

    @property
    def reaction(self) -> Array:
        """(steps, nodes, 6), force and moment of what holds the node on the network."""
        return self._array("reaction").copy()

    @property
    def end_forces(self) -> Array:
        """(steps, members, 2, 6), force and moment on the start and on the end of each member."""
        return self._array("end_forces").copy()

    @property
    def length(self) -> Array:
        """(steps, members), deformed length along the centre line."""
        return self._array("member_values")[:, :, 0].copy()

    @property
    def axial_force(self) -> Array:
        """(steps, members), at the middle of the member, tension positive."""
        return self._array("member_values")[:, :, 1].copy()

    @property
    def pressure(self) -> Array:
        """(steps, members), of muscles in their pressure unit; the actuation of what is actuated."""
        return self._array("member_values")[:, :, 2].copy()

    @property
    def spring_force(self) -> Array:
        """(steps, springs): of a spring along its line, tension positive; of one with components, the size of its force."""
        return self._array("spring_forces").copy()

    @property
    def energy(self) -> Array:
        """(steps,), strain energy."""
        return self._array("energy").copy()

    @functools.cached_property
    def history(self) -> History:
        """Probes, loads and pressures at every increment."""
        return History(*self._source.history())

    def step(self, name: str | int) -> Step:
        """The state at the end of a step, by its name or number."""
        return Step(self, _place(name, self.steps, "step"))

    def to_dict(self) -> dict[str, Any]:
        """What `results.json` holds."""
        found: dict[str, Any] = json.loads(self._source.json())
        return found

    # Pictures.

    @property
    def _drawable(self) -> bool:
        """Whether there are the shapes of all members, of which there may be none."""
        return bool(self._facts["shapes"]) or not self.members

    def drawing(self, step: str | int | None = None, increment: int = -1) -> dict[str, Any]:
        """Places, lines, and arrays of points and lines, as `.vtu` files have them.

        Args:
            step: Name or number; the last one that was reached by default; `"unloaded"` is the network as built.
            increment: Of that step.
        """
        if step == "unloaded":
            place, at = None, 0
        else:
            reached = [index for index, count in enumerate(self._facts["increments"]) if count]
            if step is None and not reached:
                raise ValueError("no step was reached: there is nothing to draw")
            place = reached[-1] if step is None else _place(step, self.steps, "step")
            count = self._facts["increments"][place]
            at = increment + count if increment < 0 else increment
            if not 0 <= at < count:
                raise ValueError(f"step '{self.steps[place]}' has {count} increments, not a number {increment}")
        if not self._drawable:
            raise ValueError("the shapes of the members were not kept: solve(shapes=True) keeps them")
        found = self._source.drawing(place, at)
        if found is None:
            raise ValueError("there is no such state to draw")
        return found

    def mesh(self, step: str | int | None = None, increment: int = -1, *, sides: int = 24) -> pyvista.PolyData:
        """A pyvista mesh: members as tubes with the radii of their sections, with all results of points and lines.

        Needs the extra `pennate[view]`.
        """
        from ._meshes import tubes

        return tubes(self.drawing(step, increment), sides)

    def plot(self, *steps: str | int, output: str | os.PathLike[str] | None = None, **options: Any) -> Any:
        """Draws the ends of some steps, all by default: into a file, or as a matplotlib figure.

        Needs the extra `pennate[view]`. See `pennate.pictures.plot` for the options.
        """
        from .pictures import plot

        return plot(self, *steps, output=output, **options)

    def animate(self, output: str | os.PathLike[str], **options: Any) -> None:
        """Draws the way through all steps as a `.gif` or `.mp4`.

        Needs the extra `pennate[view]`. See `pennate.pictures.animate` for the options.
        """
        from .pictures import animate

        animate(self, output, **options)

    def report(self, output: str | os.PathLike[str]) -> None:
        """Writes one page, `.html`, that needs nothing else: a picture that turns, results with errors, curves, messages."""
        from ._report import write

        write(self, output)

    # Python's own.

    def __repr__(self) -> str:
        steps = ", ".join(
            name if status == "converged" else f"{name} ({status.replace('_', ' ')} at {100 * part:.4g} %)"
            for name, status, part in zip(self.steps, self._facts["statuses"], self._facts["fractions"])
        )
        parts = [f"{self.status.replace('_', ' ')}", f"steps {steps}"]
        if self.probes:
            parts.append("probes " + " ".join(self.probes[:8]))
        if np.isfinite(self.accuracy):
            parts.append(f"error {self.accuracy:.1e}")
        return f"<Solution {self.title!r}: {', '.join(parts)}>"

    def __str__(self) -> str:
        return self._source.report()

    def __reduce__(self) -> tuple[Any, ...]:
        return Solution, (Stored(self), self.network)

    def _ipython_key_completions_(self) -> list[str]:
        return list(self.probes)

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        bundle: dict[str, Any] = {"text/plain": str(self)}
        if self._drawable and any(self._facts["increments"]):
            try:
                from .pictures import png
            except ImportError:
                return bundle
            bundle["image/png"] = png(self)
        return bundle


class Stored:
    """A solution as it is pickled: all its parts, and the drawings of all increments."""

    def __init__(self, solution: Solution) -> None:
        source = solution._source
        self.parts: dict[str, Any] = {part: getattr(source, part)() for part in PARTS}
        counts = solution._facts["increments"]
        self.all_fractions = [source.fractions(step) for step in range(len(counts))]
        self.drawings: dict[tuple[int | None, int], dict[str, Any] | None] = {}
        if solution._drawable:
            places = [(None, 0), *((step, each) for step, count in enumerate(counts) for each in range(count))]
            self.drawings = {place: source.drawing(*place) for place in places}

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__") or name not in PARTS:
            raise AttributeError(name)
        return lambda: self.parts[name]

    def fractions(self, step: int) -> Array | None:
        """As the solver gave them."""
        return self.all_fractions[step]

    def drawing(self, step: int | None, increment: int) -> dict[str, Any] | None:
        """As the solver gave it."""
        return self.drawings.get((step, increment))


def part(solution: Solution, name: str, *places: int) -> Array:
    """The part of an array of a solution at some places of its first axes."""
    found: Array = solution._array(name)[places]
    return found.copy()


class Step:
    """The state at the end of one step."""

    __slots__ = ("_solution", "index", "name")

    def __init__(self, solution: Solution, index: int) -> None:
        self._solution, self.index = solution, index
        self.name = solution.steps[index]

    @property
    def status(self) -> str:
        """As `Solution.status`, of this step."""
        return str(self._solution._facts["statuses"][self.index])

    @property
    def fraction(self) -> float:
        """Part of the step's ramp that was reached."""
        return float(self._solution._facts["fractions"][self.index])

    @property
    def stable(self) -> bool | None:
        """Whether the state is stable; `None` where that is not defined, or not known."""
        return self._solution.stable[self.index]

    @property
    def notes(self) -> tuple[str, ...]:
        """Remarks on the step that are no failure, as sentences."""
        return tuple(self.to_dict().get("notes", ()))

    @property
    def displacement(self) -> Array:
        """(nodes, 3), length."""
        return part(self._solution, "displacement", self.index)

    @property
    def rotation(self) -> Array:
        """(nodes, 3), radians."""
        return part(self._solution, "rotation", self.index)

    @property
    def reaction(self) -> Array:
        """(nodes, 6), force and moment."""
        return part(self._solution, "reaction", self.index)

    @property
    def energy(self) -> float:
        """Strain energy."""
        return float(self._solution._array("energy")[self.index])

    def __getitem__(self, probe: str) -> float:
        """A probe at the end of the step."""
        return float(self._solution[probe][self.index])

    def node(self, name: str) -> Node:
        """A node at the end of the step."""
        return Node(self, _place(name, self._solution.nodes, "node"))

    def member(self, name: str) -> Member:
        """A member at the end of the step."""
        return Member(self, _place(name, self._solution.members, "member"))

    def to_dict(self) -> dict[str, Any]:
        """What `results.json` holds of this step."""
        found: dict[str, Any] = self._solution.to_dict()["steps"][self.index]
        return found

    def __repr__(self) -> str:
        return f"<Step {self.name!r}: {self.status.replace('_', ' ')} at {100 * self.fraction:.4g} %>"

    def _ipython_key_completions_(self) -> list[str]:
        return list(self._solution.probes)


class Node:
    """A node at the end of a step."""

    __slots__ = ("_step", "index", "name")

    def __init__(self, step: Step, index: int) -> None:
        self._step, self.index = step, index
        self.name = step._solution.nodes[index]

    @property
    def displacement(self) -> Array:
        """(3,), length."""
        return part(self._step._solution, "displacement", self._step.index, self.index)

    @property
    def rotation(self) -> Array:
        """(3,), rotation vector, radians."""
        return part(self._step._solution, "rotation", self._step.index, self.index)

    @property
    def reaction(self) -> Array:
        """(6,), force and moment of what holds the node on the network."""
        return part(self._step._solution, "reaction", self._step.index, self.index)

    def __repr__(self) -> str:
        return f"<Node {self.name!r} after {self._step.name!r}: displacement {self.displacement}>"


class Member:
    """A member at the end of a step."""

    __slots__ = ("_step", "index", "name")

    def __init__(self, step: Step, index: int) -> None:
        self._step, self.index = step, index
        self.name = step._solution.members[index]

    @property
    def end_forces(self) -> Array:
        """(2, 6), force and moment on the start and on the end of the member, in global axes."""
        return part(self._step._solution, "end_forces", self._step.index, self.index)

    @property
    def length(self) -> float:
        """Deformed length along the centre line."""
        return float(self._step._solution._array("member_values")[self._step.index, self.index, 0])

    @property
    def axial_force(self) -> float:
        """At the middle of the member, tension positive."""
        return float(self._step._solution._array("member_values")[self._step.index, self.index, 1])

    @property
    def pressure(self) -> float:
        """Of a muscle, in its pressure unit; the actuation of what is actuated."""
        return float(self._step._solution._array("member_values")[self._step.index, self.index, 2])

    def __repr__(self) -> str:
        return f"<Member {self.name!r} after {self._step.name!r}: axial force {self.axial_force:.7g}>"


def _unknown(name: object, known: tuple[str, ...], what: str) -> KeyError:
    return UnknownName(f"there is no {what} {name!r}; there are {_listed(known)}")


def _listed(known: tuple[str, ...]) -> str:
    listed = ", ".join(repr(each) for each in known[:12]) + (f" and {len(known) - 12} more" if len(known) > 12 else "")
    return listed or "none"


class UnknownName(KeyError):
    """A name that there is not; the text says which there are."""

    def __str__(self) -> str:
        return str(self.args[0])


def _named(name: str, names: tuple[str, ...], what: str) -> int:
    """The place of a name."""
    if isinstance(name, str) and name in names:
        return names.index(name)
    raise _unknown(name, names, what)


def _place(name: str | int, names: tuple[str, ...], what: str) -> int:
    """The place of a name, or of a number, which may count from the end."""
    if isinstance(name, str):
        return _named(name, names, what)
    try:
        return range(len(names))[operator.index(name)]
    except IndexError:
        raise IndexError(f"there is no {what} number {name}; there are {len(names)}: {_listed(names)}") from None
    except TypeError:
        raise TypeError(f"{what}: a name or a number expected, not {name!r}; there are {_listed(names)}") from None

