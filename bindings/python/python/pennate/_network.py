"""Networks: read, changed and asked."""

from __future__ import annotations

import json
import logging
import os
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from . import _arguments, _core
from ._errors import Finding, Interrupted
from ._flow import Flow
from ._solution import Solution, UnknownName
from ._spectra import Buckling, Modes

if TYPE_CHECKING:
    from ._problem import Problem
    from ._view import Session

log = logging.getLogger("pennate")

# Behind the name of a network that was edited.
EDITED = " (edited)"

Value = float | str
"""A parameter: a number in its unit, or a text such as `"40 deg"` or `"= 2 * L"`, as it may stand in the file."""
Progress = Callable[[int, int, float], object]
"""Called with the step, the number of steps and the fraction of its ramp; the solve stops where it returns `False`."""


class Network:
    """A network of muscles and members: a value, which nothing changes.

    `Network(dict)` takes what a network file holds, as dictionaries and lists; see also `load`, `loads` and `scene`.

    Raises:
        NetworkError: everything that is wrong, with its place.
    """

    __slots__ = ("_facts", "_read")
    _read: _core.Network
    _facts: dict[str, Any]

    def __init__(self, network: Mapping[str, Any], /, *, directory: str | os.PathLike[str] = "", **parameters: Value):
        text = _written(network)
        self._take(_core.Network(text, "network.json", os.fspath(directory), _settings(parameters), []))

    @classmethod
    def _of(cls, core: _core.Network) -> Network:
        network = cls.__new__(cls)
        network._take(core)
        return network

    def _take(self, core: _core.Network) -> None:
        self._read = core
        self._facts = core.facts()
        for warning in self.warnings:
            log.warning("%s", warning)

    # What it is.

    @property
    def title(self) -> str:
        """As the file has it; may be empty."""
        return str(self._facts["title"])

    @property
    def dimension(self) -> str:
        """`"plane"` or `"space"`."""
        return str(self._facts["dimension"])

    @property
    def units(self) -> str:
        """Unit system of the file, `"mm-N-MPa"` or `"m-N-Pa"`."""
        return str(self._facts["units"])

    @property
    def pressure_unit(self) -> str:
        """Unit of the pressures in pictures: that of the first muscle of the network; empty where there are none."""
        return str(self._facts["pressure_unit"])

    @property
    def nodes(self) -> tuple[str, ...]:
        """Names of the nodes, in the order of the file, which is that of all arrays."""
        return tuple(self._facts["nodes"])

    @property
    def members(self) -> tuple[str, ...]:
        """Names of the members, muscles included, in the order of the file."""
        return tuple(self._facts["members"])

    @property
    def muscles(self) -> tuple[str, ...]:
        """Names of the members that are muscles."""
        return tuple(self._facts["muscles"])

    @property
    def springs(self) -> tuple[str, ...]:
        """Names of the springs."""
        return tuple(self._facts["springs"])

    @property
    def bodies(self) -> tuple[str, ...]:
        """Names of the rigid bodies."""
        return tuple(self._facts["bodies"])

    @property
    def steps(self) -> tuple[str, ...]:
        """Names of the steps; `prestress` alone where the file has none."""
        return tuple(self._facts["steps"])

    @property
    def probes(self) -> dict[str, str]:
        """Names of the probes, and their units."""
        return dict(zip(self._facts["probes"], self._facts["probe_units"]))

    @property
    def parameters(self) -> dict[str, float]:
        """Values of the parameters, each in its unit; see `parameter_units`."""
        return dict(self._facts["parameters"])

    @property
    def parameter_units(self) -> dict[str, str]:
        """Units of the parameters, empty where the file writes a number without one.

        Such a number is in the units of the file, an angle in degrees, and a pressure in the unit of the muscle that it reaches.
        """
        units = {name: unit for name, unit, _ in self._facts["parameter_units"]}
        return {name: units.get(name, "") for name in self.parameters}

    @property
    def _scales(self) -> dict[str, float]:
        """What one of the unit of each parameter is in the units of the file, of an angle in degrees."""
        scales = {name: scale for name, _, scale in self._facts["parameter_units"]}
        return {name: scales.get(name, 1.0) for name in self.parameters}

    @property
    def positions(self) -> npt.NDArray[np.float64]:
        """(nodes, 3), unloaded places, length."""
        return np.array(self._facts["positions"])

    @property
    def ends(self) -> dict[str, tuple[str, str]]:
        """Names of the nodes at the start and the end of each member."""
        return {member: (ends[0], ends[1]) for member, ends in zip(self.members, self._facts["ends"])}

    @property
    def lengths(self) -> npt.NDArray[np.float64]:
        """(members,), unloaded length along the centre line."""
        return np.array(self._facts["lengths"])

    @property
    def warnings(self) -> list[Finding]:
        """What is remarkable about the file."""
        return list(self._facts["warnings"])

    @property
    def text(self) -> str:
        """The text of the file, without the parameters that were set."""
        return self._read.parts()[0]

    @property
    def name(self) -> str:
        """Name of the file, as it stands in messages."""
        return self._read.parts()[1]

    def _sources(self) -> list[tuple[str, str]]:
        """Names and texts of what was read: of the network first, then of the files that it refers to.

        The muscles that come with the program are not among them: its version tells what they are.
        """
        text, name, _, _, files = self._read.parts()
        return [(name, text), *((os.fspath(path), content) for path, content in files)]

    def to_dict(self) -> dict[str, Any]:
        """What the file holds, as dictionaries and lists; parameters that were set have their new values."""
        tree: dict[str, Any] = self._read.tree()
        for name, text in self._read.parts()[3]:
            value: Value = text if text.lstrip().startswith("=") else self._stated(name, self._number(name, text))
            tree.setdefault("parameters", {})[name] = value
        return tree

    def _number(self, name: str, text: str) -> float:
        """What a text that is no expression sets a parameter to, in its unit."""
        number = _number(text)
        return self.parameters[name] if isinstance(number, str) else number

    def _stated(self, name: str, value: Value) -> Value:
        """A parameter as it may stand in a file: a number with its unit, if it has one."""
        unit = self.parameter_units.get(name, "")
        return f"{value!r} {unit}" if unit and not isinstance(value, str) else value

    # Other networks.

    def set(self, /, **parameters: Value) -> Network:
        """The same network with other values of some parameters."""
        return Network._of(self._read.with_settings(self._set(parameters)))

    def _set(self, parameters: Mapping[str, Value]) -> list[tuple[str, str]]:
        """What is set, with other values of some parameters: numbers are in the units that these have here."""
        settings = dict(self._read.parts()[3])
        for name, text in _settings(parameters):
            # A parameter that the file writes without a unit has one where a text with a unit was set.
            if isinstance(_number(settings.get(name, "0")), str):
                text = str(self._stated(name, _number(text)))
            settings[name] = text
        return list(settings.items())

    def edit(self, changes: Mapping[str, Any] | None = None, /, **tables: Any) -> Network:
        """A new network, with some of what the file holds replaced.

        Tables are merged, key by key; `None` takes a key away; lists and values are replaced whole. Steps may be named:
        `steps={"inflate": {"pressure": {"all": 20}}}`.
        """
        if changes is not None:
            tables = {**_arguments.table(changes, "changes"), **tables}
        tree = _merged(self.to_dict(), tables)
        _, name, directory, _, files = self._read.parts()
        name = name if name.endswith(EDITED) else name + EDITED
        return Network._of(_core.Network(_written(tree), name, directory, [], files))

    # Answers.

    def solve(
        self,
        *,
        accuracy: float = 1e-6,
        threads: int = 1,
        shapes: bool = True,
        progress: Progress | None = None,
    ) -> Solution:
        """Solves the network.

        Args:
            accuracy: Discretization error asked for, relative to the largest value of its kind.
            threads: Results are the same with any number.
            shapes: Keep the shapes of members, for pictures.
            progress: Hears of every accepted increment.

        Returns:
            The solution. A step that fails is part of it: see `Solution.status` and `Solution.raise_for_status`.

        Raises:
            MechanismError: The network can move without force.
            Interrupted: Ctrl-C; what converged is in its attribute `solution`.
        """
        core, raised = self._read.solve(_arguments.accuracy(accuracy), _arguments.count(threads, "threads"), shapes, _arguments.listener(progress))
        solution = Solution(core, self)
        for finding in (*solution.warnings[len(self.warnings) :], *solution.failures):
            log.log(logging.WARNING if finding.severity == "warning" else logging.ERROR, "%s", finding)
        if raised is None:
            return solution
        if type(raised) is KeyboardInterrupt:
            raise Interrupted(solution) from None
        raise raised

    def check(self) -> Check:
        """Everything short of solving.

        Raises:
            MechanismError: The network can move without force.
        """
        return Check(*self._read.check())

    def problem(
        self,
        parameters: Sequence[str] | None = None,
        probes: Sequence[str] | None = None,
        *,
        accuracy: float = 1e-6,
        sample: npt.ArrayLike | None = None,
        threads: int | None = None,
    ) -> Problem:
        """Compiles the network for "these numbers in, those numbers out".

        Args:
            parameters: Names under `[parameters]`; all by default.
            probes: Names of probes, at the end of the last step, or `probe@step`; all by default.
            accuracy: What the mesh is made for, at the values of the file.
            sample: (n, k), designs that the mesh is to serve as well, in the units of the parameters; those without an answer
                do not count, and neither does that of the file as long as one of these has one.
            threads: One for each core by default; answers are the same with any number.

        Raises:
            NetworkError: A name that there is not, or a parameter that changes a count or the topology.
        """
        from ._problem import Problem

        names = tuple(self.parameters) if parameters is None else _arguments.names(parameters, "parameters")
        wanted = tuple(self.probes) if probes is None else _arguments.names(probes, "probes")
        rows = _sample(() if sample is None else sample, names)
        count = os.cpu_count() or 1 if threads is None else _arguments.count(threads, "threads")
        return Problem(self, names, wanted, _arguments.accuracy(accuracy), rows, count)

    def modes(
        self,
        count: int = 6,
        *,
        step: str | None = None,
        accuracy: float = 1e-6,
        threads: int = 1,
        progress: Progress | None = None,
    ) -> Modes:
        """Natural frequencies and modes about the end of a step, the last one unless named."""
        answer = self._read.spectrum(
            "modes", _arguments.name_or_none(step, "step"), None, _arguments.count(count, "count"), _arguments.accuracy(accuracy), _arguments.count(threads, "threads"), _arguments.listener(progress)
        )
        return Modes(*answer)

    def buckle(
        self,
        count: int = 6,
        *,
        step: str | None = None,
        along: str | None = None,
        accuracy: float = 1e-6,
        threads: int = 1,
        progress: Progress | None = None,
    ) -> Buckling:
        """Critical factors and modes of linear buckling.

        The factor multiplies the ramp of a step, the last one unless `along` names another; with `step` it multiplies all
        loads, pressures and prescribed motions that are present at the end of that step.
        """
        if step is not None and along is not None:
            raise ValueError("either 'step' or 'along', not both")
        answer = self._read.spectrum(
            "buckling", _arguments.name_or_none(step, "step"), _arguments.name_or_none(along, "along"), _arguments.count(count, "count"), _arguments.accuracy(accuracy), _arguments.count(threads, "threads"), _arguments.listener(progress)
        )
        return Buckling(*answer)

    def view(
        self,
        *,
        ranges: Mapping[str, tuple[float, float]] | None = None,
        accuracy: float = 1e-6,
        port: int = 8080,
        bind: str = "127.0.0.1",
        hosts: Sequence[str] = (),
    ) -> Session:
        """Shows the network as a page with sliders, in a notebook or at the `address` of what is returned.

        Needs the extra `pennate[view]`. `stop()` of what is returned ends the page.

        Args:
            ranges: Limits of sliders, by the names of parameters; from half to one and a half times the value by default.
            accuracy: Discretization error asked for.
            port: The next one that is free is taken.
            bind: The network address to listen at; this machine alone by default.
            hosts: Other names of this machine that browsers may use.
        """
        from ._view import Session

        return Session(self, ranges=ranges, accuracy=accuracy, port=port, bind=bind, hosts=hosts)

    def flow(self, *, threads: int = 1, progress: Progress | None = None) -> Flow:
        """The load flow, where the file has `[load_flow]`: which members transmit what the input puts in, and what muscles
        in their place do.

        Raises:
            NetworkError: There is no `[load_flow]`, or what it names does not fit.
            MechanismError: The mechanism can move without force.
        """
        text, report, picture, steps = self._read.flow(_arguments.count(threads, "threads"), _arguments.listener(progress))
        _, _, directory, _, files = self._read.parts()
        networks = [Network._of(_core.Network(step, name, directory, [], files)) for name, step in steps]
        return Flow(self, text, report, picture, networks)

    # Python's own.

    def __repr__(self) -> str:
        others = len(self.members) - len(self.muscles)
        counts = (
            (len(self.nodes), "node", "nodes"),
            (len(self.muscles), "muscle", "muscles"),
            (others, "member", "members"),
            (len(self.bodies), "rigid body", "rigid bodies"),
            (len(self.springs), "spring", "springs"),
        )
        parts = [f"{count} {one if count == 1 else many}" for count, one, many in counts if count]
        parts.append(self.dimension if self.dimension == "plane" else "spatial")
        if values := self.parameters:
            parts.append("parameters " + _short([f"{name}={value:.6g}" for name, value in values.items()]))
        return f"<Network {self.title or self.name!r}: {', '.join(parts)}>"

    def _repr_mimebundle_(self, **_: Any) -> dict[str, Any]:
        bundle: dict[str, Any] = {"text/plain": repr(self)}
        try:
            from .pictures import png
        except ImportError:
            return bundle
        bundle["image/png"] = png(self)
        return bundle

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Network) and self._read.parts() == other._read.parts()

    def __hash__(self) -> int:
        text, name, directory, settings, _ = self._read.parts()
        return hash((text, name, directory, tuple(settings)))

    def __reduce__(self) -> tuple[Any, ...]:
        return _restored, self._read.parts()


class Check:
    """What `Network.check` found: nothing that would keep the network from being solved."""

    __slots__ = ("summary", "warnings")
    summary: str
    """The network in a line."""
    warnings: list[Finding]
    """What is remarkable about it."""

    def __init__(self, summary: str, warnings: list[Finding]) -> None:
        self.summary, self.warnings = summary, warnings

    def __repr__(self) -> str:
        return f"<Check: {self.summary}; {len(self.warnings)} warnings>"

    def __str__(self) -> str:
        return "\n\n".join([*(str(warning) for warning in self.warnings), self.summary])


def load(path: str | os.PathLike[str], /, **parameters: Value) -> Network:
    """Reads a network file, TOML or JSON, with some of its parameters set.

    Raises:
        NetworkError: everything that is wrong, with its place.
    """
    return Network._of(_core.Network.open(os.fsdecode(path), _settings(parameters)))


def loads(
    text: str, /, *, name: str = "<text>", directory: str | os.PathLike[str] = "", **parameters: Value
) -> Network:
    """Reads a network from the text of a file.

    `name` stands in messages; files that the network refers to are looked for in `directory`. A parameter that is called
    `name` or `directory` is set by `loads(…).set(name=…)`.
    """
    _arguments.text(text, "text")
    return Network._of(_core.Network(text, name, os.fspath(directory), _settings(parameters), []))


def scene(scene: str, /, **parameters: Value) -> Network:
    """A network of the dissertation, by its name; see `scenes`."""
    text = _core.scene(_arguments.text(scene, "scene"), _settings(parameters))
    return Network._of(_core.Network(text, f"{scene}.toml", "", [], []))


def scenes() -> dict[str, dict[str, str]]:
    """The scenes: names, and what may be set in each with its default."""
    return {
        name: {parameter: f"{default}: {what}" for parameter, default, what in parameters}
        for name, _, _, parameters in _core.scenes()
    }


def schema() -> dict[str, Any]:
    """The JSON Schema of the network file."""
    found: dict[str, Any] = json.loads(_core.schema())
    return found


def _restored(*parts: Any) -> Network:
    text, name, directory, settings, files = parts
    return Network._of(_core.Network(text, name, directory, settings, files))


def _settings(parameters: Mapping[str, Value]) -> list[tuple[str, str]]:
    """Values as the program takes them."""
    return [(name, _setting(name, value)) for name, value in parameters.items()]


def _setting(name: str, value: object) -> str:
    if isinstance(value, str):
        return value
    if isinstance(value, int | np.integer) and not isinstance(value, bool):
        # Counts of scenes are whole.
        return str(int(value))
    number = _arguments.real(value, f"parameter '{name}'", "a number or a text")
    if not np.isfinite(number):
        raise ValueError(f"parameter '{name}': a finite number expected, not {number}")
    return repr(number)


def _number(text: str) -> Value:
    try:
        return float(text)
    except ValueError:
        return text


def _sample(given: npt.ArrayLike, parameters: tuple[str, ...]) -> npt.NDArray[np.float64]:
    """(n, k), designs that a mesh has to serve."""
    rows = _arguments.numbers(given, "sample", parameters)
    if rows.shape == (0,):
        return np.zeros((0, len(parameters)))
    rows = np.atleast_2d(rows)
    if rows.ndim != 2 or rows.shape[1] != len(parameters):
        raise ValueError(f"sample has the shape {np.shape(given)}, but there are {len(parameters)} parameters")
    return _arguments.finite(rows, "sample", parameters)


def _short(parts: Sequence[str], most: int = 6) -> str:
    more = len(parts) - most
    return " ".join(parts[:most]) + (f" and {more} more" if more > 0 else "")


def _merged(old: Any, new: Any) -> Any:
    """`old` with what `new` says; tables key by key."""
    if isinstance(old, list) and isinstance(new, Mapping):
        # Steps, and whatever else is a list of named tables.
        places = {entry.get("name"): place for place, entry in enumerate(old) if isinstance(entry, Mapping)}
        merged = list(old)
        for name, changes in new.items():
            if name not in places:
                known = ", ".join(repr(each) for each in places if each) or "none with a name"
                raise UnknownName(f"there is no {name!r} to edit; there are {known}")
            merged[places[name]] = _merged(merged[places[name]], changes)
        return [entry for entry in merged if entry is not None]
    if not (isinstance(old, Mapping) and isinstance(new, Mapping)):
        return new
    table = dict(old)
    for key, value in new.items():
        if value is None:
            table.pop(key, None)
        else:
            table[key] = _merged(table.get(key), value)
    return table


def _not_finite(value: Any, place: str = "") -> str | None:
    """Where a network has a number that is none, as `nodes.A[0]`."""
    if isinstance(value, Mapping):
        entries = [(f"{place}.{key}" if place else str(key), entry) for key, entry in value.items()]
    elif isinstance(value, list | tuple | np.ndarray) and np.ndim(value) != 0:
        entries = [(f"{place}[{index}]", entry) for index, entry in enumerate(value)]
    else:
        return place if isinstance(value, float | np.floating) and not np.isfinite(value) else None
    return next((found for where, entry in entries if (found := _not_finite(entry, where)) is not None), None)


def _written(network: Mapping[str, Any]) -> str:
    """A network as JSON, a line for each of its things, so that messages have a line to show."""

    def plain(value: Any) -> Any:
        if isinstance(value, np.generic | np.ndarray):
            return value.tolist()
        if isinstance(value, os.PathLike):
            return os.fspath(value)
        raise TypeError(f"a network holds numbers, texts, lists and tables, not {_arguments.shown(value)}")

    def line(value: Any) -> str:
        try:
            return json.dumps(value, ensure_ascii=False, default=plain, allow_nan=False)
        except ValueError as error:
            place = _not_finite(network)
            if place is None:
                raise
            raise ValueError(f"{place}: a finite number expected, not nan or infinity") from error

    def block(value: Any, depth: int) -> str:
        pad = "  " * depth
        if isinstance(value, Mapping) and value and depth < 3:
            entries = (f"{pad}  {line(str(key))}: {block(entry, depth + 1)}" for key, entry in value.items())
            return "{\n" + ",\n".join(entries) + f"\n{pad}}}"
        if isinstance(value, list | tuple) and depth == 1 and any(isinstance(entry, Mapping) for entry in value):
            return "[\n" + ",\n".join(f"{pad}  {line(entry)}" for entry in value) + f"\n{pad}]"
        return line(value)

    if not isinstance(network, Mapping):
        raise TypeError(f"a dictionary expected, as a network file holds it, not {type(network).__name__}")
    return block({"format": "pennate/1", **network}, 0) + "\n"
