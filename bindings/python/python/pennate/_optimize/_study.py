"""The study file: what is varied, what is wanted, and how it is looked for."""

from __future__ import annotations

import dataclasses
import difflib
import os
import re
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from .. import _network
from .._errors import Finding, NetworkError
from ._expression import Expression

if sys.version_info >= (3, 11):
    import tomllib
else:  # the same library, before it came with Python
    import tomli as tomllib

FORMAT = "pennate-study/1"
METHODS = ("nsga2", "cma-es", "least-squares")
KEYS: dict[str, tuple[str, ...]] = {
    "": (
        "format title network seed accuracy variables parameters constraints objectives targets search pick".split()  # type: ignore[dict-item]
    ),
    "variables": ("from", "to", "start"),
    "constraints": ("value", "least", "most", "scale"),
    "objectives": ("maximize", "minimize"),
    "targets": ("value", "is", "weight"),
    "search": ("method", "population", "generations", "screen", "starts", "stop"),
    "stop": ("hypervolume_gain", "over", "evaluations", "error"),
    "pick": ("ends", "knee", "spread", "best"),
}


class StudyError(NetworkError):
    """A study file is wrong; `errors` says what, where, and what would help."""


@dataclasses.dataclass(frozen=True)
class Variable:
    """A parameter of the network that is looked for, between two values."""

    name: str
    low: float
    high: float
    start: float


@dataclasses.dataclass(frozen=True)
class Named:
    """An expression that the study gives a name."""

    name: str
    value: Expression


@dataclasses.dataclass(frozen=True)
class Constraint(Named):
    """Limits of an expression; `before` says that it needs no solution."""

    least: float
    most: float
    scale: float
    before: bool


@dataclasses.dataclass(frozen=True)
class Objective(Named):
    """An expression that is made least, or greatest where `sign` is -1."""

    sign: float


@dataclasses.dataclass(frozen=True)
class Target(Named):
    """What an expression is to be."""

    wanted: float
    weight: float


@dataclasses.dataclass(frozen=True)
class Study:
    """A study that was read and checked."""

    path: Path
    text: str
    title: str
    network: _network.Network
    network_path: Path
    fixed: dict[str, float]
    seed: int
    accuracy: float
    variables: tuple[Variable, ...]
    constraints: tuple[Constraint, ...]
    objectives: tuple[Objective, ...]
    targets: tuple[Target, ...]
    method: str
    population: int
    generations: int
    screen: int
    starts: int
    stop: dict[str, float]
    pick: dict[str, Any]
    probes: tuple[str, ...]

    @property
    def wanted(self) -> tuple[Named, ...]:
        """Objectives or targets, in the order of the columns of designs."""
        return (*self.objectives, *self.targets)


class _Reader:
    """The tree of a study with the places of its keys."""

    def __init__(self, path: Path, text: str) -> None:
        self.path, self.text = path, text
        self.findings: list[Finding] = []

    def wrong(self, message: str, help: str, *keys: str) -> None:
        """Notes what is wrong at a key."""
        line = self._line(keys)
        text = f"error: {message}\n --> {self.path}{f':{line}' if line else ''}\nhelp: {help}"
        name = keys[-1] if keys else None
        finding = Finding("error", message, str(self.path), line, 1 if line else None, name, None, [], help, text)
        self.findings.append(finding)

    def _line(self, keys: tuple[str, ...]) -> int | None:
        """Where a key stands: under the header of its table, or else anywhere."""
        if not keys:
            return None
        lines = self.text.splitlines()
        table, found = "", None
        for number, line in enumerate(lines, 1):
            if header := re.match(r"\s*\[+\s*([^\]]+?)\s*\]+", line):
                table = header[1].strip("\"'")
                if keys in ((table,), tuple(table.split("."))):
                    return number
                continue
            key = re.match(r"\s*[\"']?([^\"'=\s]+)[\"']?\s*=", line)
            # A key in a table on one line is found at the line of the table.
            if key and (table, key[1]) in ((".".join(keys[:-1]), keys[-1]), (keys[0], keys[1] if len(keys) > 1 else "")):
                return number
            if key and not table and key[1] == keys[0]:
                found = number
        return found

    def check(self) -> None:
        """Raises all that was noted."""
        if self.findings:
            raise StudyError("\n\n".join(finding.text for finding in self.findings), self.findings)

    def unknown(self, given: Mapping[str, Any], kind: str, *keys: str) -> None:
        """Keys that nobody knows."""
        for key in given:
            if key not in KEYS[kind]:
                near = difflib.get_close_matches(key, KEYS[kind], 1)
                help = f"did you mean '{near[0]}'?" if near else f"known keys are {', '.join(KEYS[kind])}"
                self.wrong(f"there is no key '{key}' here", help, *keys, key)

    def table(self, tree: Mapping[str, Any], key: str) -> dict[str, Any]:
        given = tree.get(key, {})
        if isinstance(given, dict):
            return given
        self.wrong(f"'{key}' is no table", f"write a header [{key}]", key)
        return {}

    def expression(self, given: Any, names: set[str], *keys: str) -> Expression | None:
        if isinstance(given, bool) or not isinstance(given, (int, float, str)):
            self.wrong(f"'{keys[-1]}' is no expression", 'write for example "= u@free"', *keys)
            return None
        try:
            found = Expression(given)
        except ValueError as error:
            self.wrong(str(error), 'write for example "= max(u@free, 0)"', *keys)
            return None
        for name in sorted(found.names - names):
            near = difflib.get_close_matches(name, sorted(names), 1)
            known = ", ".join(sorted(names)[:12])
            help = f"did you mean '{near[0]}'?" if near else f"known are {known}"
            self.wrong(f"'{found.text}' refers to '{name}', which is neither a parameter nor a probe", help, *keys)
            return None
        return found

    def number(self, given: Any, default: float, least: float, *keys: str) -> float:
        """A number that is not less than something."""
        if given is None:
            return default
        if isinstance(given, bool) or not isinstance(given, (int, float)) or not given >= least:
            self.wrong(f"'{keys[-1]}' is {given!r}", f"write a number from {least:g} on", *keys)
            return default
        return given


def read(path: str | os.PathLike[str], settings: Mapping[str, float] | None = None, seed: int | None = None) -> Study:
    """Reads and checks a study file.

    Raises:
        StudyError: All that is wrong, each with its line and what would help.
        NetworkError: The network is wrong.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reader = _Reader(path, "")
        reader.wrong(f"the study cannot be read: {error}", "give the path of a study file")
        reader.check()
        raise
    reader = _Reader(path, text)
    try:
        tree = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        line = re.search(r"line (\d+)", str(error))
        where = f"{path}:{line[1]}" if line else str(path)
        message = f"this is not TOML: {error}"
        help = "texts stand in quotes, lists in [ ], tables in { } on one line or under a [header]"
        shown = f"error: {message}\n --> {where}\nhelp: {help}"
        number = int(line[1]) if line else None
        raise StudyError(shown, [Finding("error", message, str(path), number, None, None, None, [], help, shown)]) from None
    return _checked(reader, tree, dict(settings or {}), seed)


def _checked(reader: _Reader, tree: dict[str, Any], settings: dict[str, float], seed: int | None) -> Study:
    reader.unknown(tree, "")
    if tree.get("format") != FORMAT:
        reader.wrong(f"the format is {tree.get('format')!r}", f'write format = "{FORMAT}" at the top', "format")
    written = tree.get("network")
    if not isinstance(written, str):
        reader.wrong("the study names no network", 'write network = "inverter.toml"', "network")
        reader.check()
    network_path = reader.path.parent / str(written)
    if not network_path.is_file():
        reader.wrong(f"there is no network file {network_path}", "give its path from the folder of the study", "network")
        reader.check()
    network = _loaded(network_path, tree)
    fixed = _fixed(reader, tree, network, settings)
    network = network.set(**fixed) if fixed else network
    parameters = set(network.parameters)
    after = {probe for probe in network.probes} | {f"{probe}@{step}" for probe in network.probes for step in network.steps}
    variables = _variables(reader, tree, network)
    # The mesh is made for the starting design.
    network = network.set(**{each.name: each.start for each in variables}) if variables else network
    constraints = _constraints(reader, tree, parameters, after)
    objectives, targets = _wanted(reader, tree, parameters | after)
    search = reader.table(tree, "search")
    reader.unknown(search, "search", "search")
    stop = search.get("stop", {})
    if not isinstance(stop, dict):
        reader.wrong("'stop' is no table", "write stop = { evaluations = 5000 }", "search", "stop")
        stop = {}
    reader.unknown(stop, "stop", "search", "stop")
    stop = {key: reader.number(value, 0.0, 0.0, "search", "stop") for key, value in stop.items()}
    usual = "least-squares" if targets else "cma-es" if len(objectives) == 1 else "nsga2"
    method = search.get("method", usual)
    if method not in METHODS:
        reader.wrong(f"there is no method {method!r}", f"known are {', '.join(METHODS)}", "search", "method")
    elif method == "least-squares" and not targets:
        reader.wrong("least squares need targets", "write [targets], or another method", "search", "method")
    elif method == "nsga2" and targets:
        reader.wrong("nsga2 needs objectives", 'write [objectives], or method = "cma-es"', "search", "method")
    elif method == "cma-es" and len(objectives) > 1:
        reader.wrong("cma-es looks for one objective", 'leave one, or write method = "nsga2"', "search", "method")
    whole = {
        key: int(reader.number(search.get(key), default, least, "search", key))
        for key, default, least in (
            ("population", 0 if method != "nsga2" else 100, 2 if "population" in search else 0),
            ("generations", 200 if method == "nsga2" else 1000, 1),
            ("screen", 64, 1),
            ("starts", 3, 1),
        )
    }
    pick = reader.table(tree, "pick")
    reader.unknown(pick, "pick", "pick")
    given_seed = int(reader.number(tree.get("seed"), 1, 0, "seed")) if seed is None else seed
    accuracy = float(reader.number(tree.get("accuracy"), 1e-4, 1e-12, "accuracy"))
    reader.check()
    named: list[Named] = [*constraints, *objectives, *targets]
    used = {name for each in named for name in each.value.names}
    return Study(
        path=reader.path,
        text=reader.text,
        title=str(tree.get("title", "")),
        network=network,
        network_path=network_path,
        fixed=fixed,
        seed=given_seed,
        accuracy=accuracy,
        variables=tuple(variables),
        constraints=tuple(constraints),
        objectives=tuple(objectives),
        targets=tuple(targets),
        method=str(method),
        stop=stop,
        pick=pick,
        probes=tuple(sorted(used & after - parameters)),
        **whole,
    )


def _loaded(path: Path, tree: dict[str, Any]) -> _network.Network:
    """The network; with the starting design where it is none with the values of its file."""
    try:
        return _network.load(path)
    except NetworkError:
        variables = tree.get("variables")
        given = variables.items() if isinstance(variables, dict) else ()
        starts = {name: data["start"] for name, data in given if isinstance(data, dict) and "start" in data}
        if not starts:
            raise
        return _network.load(path, **starts)


def _fixed(reader: _Reader, tree: dict[str, Any], network: _network.Network, settings: dict[str, float]) -> dict[str, float]:
    fixed = {}
    for name, value in reader.table(tree, "parameters").items():
        if name not in network.parameters:
            near = difflib.get_close_matches(name, network.parameters, 1)
            help = f"did you mean '{near[0]}'?" if near else f"its parameters are {', '.join(network.parameters)}"
            reader.wrong(f"the network has no parameter '{name}'", help, "parameters", name)
        else:
            fixed[name] = value
    for name, value in settings.items():
        if name in network.parameters:
            fixed[name] = value
        else:
            reader.wrong(f"the network has no parameter '{name}' to set", f"its parameters are {', '.join(network.parameters)}")
    return fixed


def _variables(reader: _Reader, tree: dict[str, Any], network: _network.Network) -> list[Variable]:
    parameters = network.parameters
    given = reader.table(tree, "variables")
    if not given:
        reader.wrong("the study has no variables", "write [variables] with L1 = { from = 45, to = 180 }", "variables")
    found = []
    for name, data in given.items():
        keys = ("variables", name)
        if name not in parameters:
            near = difflib.get_close_matches(name, parameters, 1)
            help = f"did you mean '{near[0]}'?" if near else f"its parameters are {', '.join(parameters)}"
            reader.wrong(f"the network has no parameter '{name}' to vary", help, *keys)
            continue
        if not isinstance(data, dict) or "from" not in data or "to" not in data:
            reader.wrong(f"variable '{name}' has no range", f"write {name} = {{ from = 0, to = 1 }}", *keys)
            continue
        reader.unknown(data, "variables", *keys)
        known = set(parameters) - set(given)
        ends = [reader.expression(data[key], known, *keys, key) for key in ("from", "to")]
        if None in ends:
            continue
        low, high = (float(each(parameters)) for each in ends if each is not None)
        if not low < high:
            reader.wrong(f"variable '{name}' goes from {low:g} to {high:g}", "let it go from less to more", *keys)
            continue
        start = reader.number(data.get("start"), (low + high) / 2, low, *keys, "start")
        if start > high:
            reader.wrong(f"variable '{name}' starts at {start:g}, beyond {high:g}", "start within its range", *keys, "start")
        found.append(Variable(name, low, high, start))
    return found


def _constraints(reader: _Reader, tree: dict[str, Any], parameters: set[str], after: set[str]) -> list[Constraint]:
    found = []
    for name, data in reader.table(tree, "constraints").items():
        keys = ("constraints", name)
        if not isinstance(data, dict) or "value" not in data or not {"least", "most"} & set(data):
            help = f'write {name} = {{ value = "= …", most = 0 }}'
            reader.wrong(f"constraint '{name}' needs a value, and least or most", help, *keys)
            continue
        reader.unknown(data, "constraints", *keys)
        value = reader.expression(data["value"], parameters | after, *keys, "value")
        least = reader.number(data.get("least"), float("-inf"), float("-inf"), *keys, "least")
        most = reader.number(data.get("most"), float("inf"), float("-inf"), *keys, "most")
        limits = [abs(limit) for limit in (least, most) if abs(limit) != float("inf")]
        scale = reader.number(data.get("scale"), max([*limits, 0.0]) or 1.0, 1e-300, *keys, "scale")
        if value is not None:
            found.append(Constraint(name, value, least, most, scale, before=not value.names & (after - parameters)))
    return found


def _wanted(reader: _Reader, tree: dict[str, Any], names: set[str]) -> tuple[list[Objective], list[Target]]:
    objectives, targets = [], []
    for name, data in reader.table(tree, "objectives").items():
        keys = ("objectives", name)
        if not isinstance(data, dict) or len(set(data) & {"maximize", "minimize"}) != 1:
            reader.wrong(f"objective '{name}' says not what to do", f'write {name} = {{ maximize = "= u" }}', *keys)
            continue
        reader.unknown(data, "objectives", *keys)
        key = "maximize" if "maximize" in data else "minimize"
        value = reader.expression(data[key], names, *keys, key)
        if value is not None:
            objectives.append(Objective(name, value, -1.0 if key == "maximize" else 1.0))
    for name, data in reader.table(tree, "targets").items():
        keys = ("targets", name)
        if not isinstance(data, dict) or not {"value", "is"} <= set(data):
            reader.wrong(f"target '{name}' needs a value and what it is to be", f'write {name} = {{ value = "= a", is = 0 }}', *keys)
            continue
        reader.unknown(data, "targets", *keys)
        value = reader.expression(data["value"], names, *keys, "value")
        wanted = reader.number(data["is"], 0.0, float("-inf"), *keys, "is")
        weight = reader.number(data.get("weight"), 1.0, 0.0, *keys, "weight")
        if value is not None:
            targets.append(Target(name, value, wanted, weight))
    given = bool(tree.get("objectives")) + bool(tree.get("targets"))
    if given != 1:
        what = "neither objectives nor targets" if given == 0 else "both objectives and targets"
        reader.wrong(f"the study has {what}", "write either [objectives] or [targets]", "objectives")
    return objectives, targets


