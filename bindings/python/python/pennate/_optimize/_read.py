"""Reading a study file: all that is wrong with it, each with its line and what would help."""

from __future__ import annotations

import csv
import os
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from .. import _arguments, _network
from .._errors import Finding, NetworkError
from ._expression import Expression
from ._reader import Reader, StudyError
from ._study import Constraint, Named, Objective, Pick, Study, Target, Values, Variable, in_file

FORMAT = "pennate-study/1"
# Part of a range that values of a table may be beyond it.
ROUNDED = 1e-12
METHODS = ("nsga2", "cma-es", "least-squares")


def read(
    path: str | os.PathLike[str],
    settings: Mapping[str, float] | None = None,
    seed: int | None = None,
    first: str | os.PathLike[str] | None = None,
) -> Study:
    """Reads and checks a study file.

    Args:
        path: The file.
        settings: Parameters of the network that take other values.
        seed: In place of that of the file.
        first: A table with a column for every variable, such as a `front.csv`: designs that the search begins with, in place
            of what the file names.

    Raises:
        StudyError: All that is wrong, each with its line and what would help.
        NetworkError: The network is wrong.
    """
    path = Path(path)
    try:
        text = path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        reader = Reader(path, "")
        reader.wrong(f"the study cannot be read: {error}", "give the path of a study file")
        reader.check()
        raise
    reader = Reader(path, text)
    try:
        tree = _parsed(text)
    except (ValueError, RecursionError) as error:
        line = re.search(r"line (\d+)", str(error))
        where = f"{path}:{line[1]}" if line else str(path)
        message = f"this is not TOML: {error}"
        help = "texts stand in quotes, lists in [ ], tables in { } on one line or under a [header]"
        shown = f"error: {message}\n --> {where}\nhelp: {help}"
        number = int(line[1]) if line else None
        raise StudyError(shown, [Finding("error", message, str(path), number, None, None, None, [], help, shown)]) from None
    if settings is not None:
        settings = {
            name: _arguments.real(value, f"settings['{name}']")
            for name, value in _arguments.table(settings, "settings").items()
        }
    return _checked(reader, tree, dict(settings or {}), seed, first)


def _parsed(text: str) -> dict[str, Any]:
    """What a text in TOML holds."""
    if sys.version_info >= (3, 11):
        import tomllib
    else:
        # The same library, before it came with Python: who reads no study needs neither.
        try:
            import tomli as tomllib
        except ImportError:
            raise ImportError("studies need tomli before Python 3.11: pip install 'pennate[study]'") from None
    return tomllib.loads(text)


def _checked(
    reader: Reader,
    tree: dict[str, Any],
    settings: dict[str, float],
    seed: int | None,
    first: str | os.PathLike[str] | None,
) -> Study:
    reader.unknown(tree, "")
    if tree.get("format") != FORMAT:
        reader.wrong(f"the format is {tree.get('format')!r}", f'write format = "{FORMAT}" at the top', "format")
    network = _set(reader, tree, _loaded(reader, tree), settings)
    parameters = set(network.parameters)
    after = {probe for probe in network.probes} | {f"{probe}@{step}" for probe in network.probes for step in network.steps}
    varied = set(tree["variables"]) if isinstance(tree.get("variables"), dict) else set()
    derived = _derived(reader, network, varied)
    changing = _changing(varied, derived, after)
    variables = _variables(reader, tree, network, changing)
    # The mesh is made for the starting design, and for others of its topology.
    try:
        network = network.set(**{each.name: each.start for each in variables}) if variables else network
    except NetworkError as error:
        what = error.errors[0].message if error.errors else str(error)
        reader.wrong(f"the starting design is no network: {what}", "let some variables start elsewhere: start = 60", "variables")
        reader.check()
    constraints = _constraints(reader, tree, parameters, after)
    objectives, targets = _wanted(reader, tree, parameters | after)
    tolerances = _tolerances(reader, tree, network, changing)
    if tolerances and targets:
        reader.wrong("tolerances go with objectives", "write [objectives], or leave [tolerances] out", "tolerances")
    search = reader.table(tree, "search")
    reader.unknown(search, "search", "search")
    method = _method(reader, search, objectives, targets)
    least = {"nsga2": 2, "cma-es": 2, "least-squares": 0}[method]
    usual = 100 if method == "nsga2" else 0
    population = usual if "population" not in search else reader.whole(search["population"], usual, least, "search", "population")
    accuracy = float(reader.number(tree.get("accuracy"), 1e-4, 1e-12, "accuracy"))
    if not accuracy < 1.0:
        reader.wrong(f"'accuracy' is {accuracy:g}", "write a number below 1, such as 1e-4", "accuracy")
    named: list[Named] = [*constraints, *objectives, *targets]
    used = {name for each in named for name in each.value.names}
    study = Study(
        path=reader.path,
        text=reader.text,
        title=reader.words(tree.get("title", ""), "title"),
        network=network,
        seed=reader.whole(tree.get("seed") if seed is None else seed, 1, 0, "seed"),
        accuracy=accuracy,
        variables=tuple(variables),
        constraints=tuple(constraints),
        objectives=tuple(objectives),
        targets=tuple(targets),
        method=method,
        population=population,
        generations=reader.whole(search.get("generations"), 200 if method == "nsga2" else 1000, 1, "search", "generations"),
        screen=reader.whole(search.get("screen"), 16, 1, "search", "screen"),
        starts=reader.whole(search.get("starts"), 3, 1, "search", "starts"),
        stop=_stop(reader, search),
        pick=_pick(reader, tree),
        probes=tuple(sorted(used & after - parameters)),
        derived=derived,
        tolerances=tolerances,
        reference=_reference(reader, search, objectives),
        first=_first(reader, search, variables, first),
    )
    reader.check()
    return study


def _loaded(reader: Reader, tree: dict[str, Any]) -> _network.Network:
    """The network; with the starting design where it is none with the values of its file."""
    written = tree.get("network")
    if isinstance(written, dict) and isinstance(written.get("scene"), str):
        values = {name: value for name, value in written.items() if name != "scene"}
        try:
            return _network.scene(written["scene"], **values)
        except (NetworkError, TypeError, ValueError) as error:
            reader.wrong(f"there is no such scene: {error}", f"known are {', '.join(_network.scenes())}", "network")
            reader.check()
    if not isinstance(written, str):
        help = 'write network = "inverter.toml", or network = { scene = "inverter" }'
        reader.wrong("the study names no network", help, "network")
        reader.check()
    path = reader.path.parent / str(written)
    if not path.is_file():
        reader.wrong(f"there is no network file {path}", "give its path from the folder of the study", "network")
        reader.check()
    try:
        return _network.load(path)
    except NetworkError:
        variables = tree.get("variables")
        given = variables.items() if isinstance(variables, dict) else ()
        starts = {name: data["start"] for name, data in given if isinstance(data, dict) and "start" in data}
        if not starts:
            raise
        return _network.load(path, **starts)


def _set(reader: Reader, tree: dict[str, Any], network: _network.Network, settings: dict[str, float]) -> _network.Network:
    """The network with what the study, and then the caller, sets."""
    known = network.parameters
    fixed: dict[str, Any] = {}
    for name, value in reader.table(tree, "parameters").items():
        if name not in known:
            reader.wrong(f"the network has no parameter '{name}'", reader.unlike(name, known, "its parameters"), "parameters", name)
            continue
        try:
            if isinstance(value, bool):
                raise TypeError("it is neither a number nor a text")
            network.set(**{name: value})
        except (NetworkError, TypeError, ValueError) as error:
            message = error.errors[0].message if isinstance(error, NetworkError) and error.errors else str(error)
            help = "write a number, or a text with its unit"
            reader.wrong(f"parameter '{name}' cannot be {value!r}: {message}", help, "parameters", name)
            continue
        fixed[name] = value
    for name, number in settings.items():
        if name in reader.table(tree, "variables"):
            reader.wrong(f"'{name}' is looked for, and cannot be set", "take it out of [variables], or do not set it", "variables", name)
        elif name not in known:
            reader.wrong(f"the network has no parameter '{name}' to set", reader.unlike(name, known, "its parameters"))
        elif not np.isfinite(number):
            reader.wrong(f"parameter '{name}' cannot be set to {number:g}", "give a finite number")
        else:
            fixed[name] = number
    reader.check()
    return network.set(**fixed) if fixed else network


def _changing(varied: set[str], derived: Sequence[tuple[str, Expression]], after: set[str]) -> dict[str, str]:
    """What has another value in each design, by its name, and how messages say that."""
    found = {probe: "is a probe" for probe in after}
    found |= {name: "is a variable" for name in varied}
    for name, value in derived:
        for other in sorted(value.names & set(found)):
            found[name] = f"follows '{other}'"
    return found


def _variables(reader: Reader, tree: dict[str, Any], network: _network.Network, changing: dict[str, str]) -> list[Variable]:
    parameters = network.parameters
    given = reader.table(tree, "variables")
    if not given:
        reader.wrong("the study has no variables", "write [variables] with L1 = { from = 45, to = 180 }", "variables")
    found = []
    for name, data in given.items():
        keys = ("variables", name)
        if name not in parameters:
            help = reader.unlike(name, parameters, "its parameters")
            reader.wrong(f"the network has no parameter '{name}' to vary", help, *keys)
            continue
        if not isinstance(data, dict) or "from" not in data or "to" not in data:
            reader.wrong(f"variable '{name}' has no range", f"write {name} = {{ from = 0, to = 1 }}", *keys)
            continue
        reader.unknown(data, "variables", *keys)
        known = set(parameters) - set(changing)
        data = {key: _measured(network, name, value) for key, value in data.items()}
        ends = [reader.expression(data[key], known, *keys, key, others=changing) for key in ("from", "to")]
        if None in ends:
            continue
        low, high = (_in_unit(network, name, data[key], each) for key, each in zip(("from", "to"), ends) if each is not None)
        if not (low < high and np.isfinite(high - low)):
            reader.wrong(f"variable '{name}' goes from {low:g} to {high:g}", "let it go from less to more", *keys)
            continue
        start = reader.number(data.get("start"), (low + high) / 2, low, *keys, "start")
        if start > high:
            reader.wrong(f"variable '{name}' starts at {start:g}, beyond {high:g}", "start within its range", *keys, "start")
        found.append(Variable(name, low, high, start))
    return found


def _measured(network: _network.Network, name: str, given: Any) -> Any:
    """The value of a parameter that is given with its unit; anything else as it is."""
    if not isinstance(given, str) or given.strip().startswith("="):
        return given
    try:
        return network.set(**{name: given}).parameters[name]
    except (NetworkError, ValueError):
        return given


def _in_unit(network: _network.Network, name: str, given: Any, value: Expression) -> float:
    """A number for a parameter in its unit: a plain one is, and an expression is in the units of the file."""
    found = float(value(in_file(network)))
    return found / network._scales[name] if isinstance(given, str) else found


def _constraints(reader: Reader, tree: dict[str, Any], parameters: set[str], after: set[str]) -> list[Constraint]:
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
        if least > most:
            reader.wrong(f"constraint '{name}' is at least {least:g} and at most {most:g}", "nothing is both", *keys)
        limits = [abs(limit) for limit in (least, most) if abs(limit) != float("inf")]
        scale = reader.number(data.get("scale"), max([*limits, 0.0]) or 1.0, 1e-300, *keys, "scale")
        if value is not None:
            found.append(Constraint(name, value, least, most, scale, before=not value.names & (after - parameters)))
    return found


def _wanted(reader: Reader, tree: dict[str, Any], names: set[str]) -> tuple[list[Objective], list[Target]]:
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
    elif targets and not sum(each.weight for each in targets) > 0.0:
        reader.wrong("no target has a weight", "write weight = 1, or leave it out", "targets")
    return objectives, targets


def _derived(reader: Reader, network: _network.Network, varied: set[str]) -> tuple[tuple[str, Expression], ...]:
    """Parameters that the network makes of others, and that nobody sets or varies: they follow what is varied."""
    written = network.to_dict().get("parameters", {})
    others = ((name, text) for name, text in written.items() if name not in varied)
    open_names = {name: text for name, text in others if isinstance(text, str) and text.strip().startswith("=")}
    found: list[tuple[str, Expression]] = []
    while open_names:
        before = len(open_names)
        for name, text in list(open_names.items()):
            try:
                value = Expression(text)
            except ValueError as error:
                reader.wrong(f"the network makes '{name}' by what a study cannot evaluate: {error}", "write its value")
                open_names.pop(name)
                continue
            if not value.names & set(open_names):
                found.append((name, value))
                open_names.pop(name)
        if len(open_names) == before:
            break
    return tuple(found)


def _tolerances(
    reader: Reader, tree: dict[str, Any], network: _network.Network, changing: dict[str, str]
) -> tuple[tuple[str, float], ...]:
    """How far parameters may be off, in their units."""
    found = []
    for name, given in reader.table(tree, "tolerances").items():
        keys = ("tolerances", name)
        if name not in network.parameters:
            help = reader.unlike(name, network.parameters, "its parameters")
            reader.wrong(f"the network has no parameter '{name}' that could be off", help, *keys)
            continue
        value = reader.expression(given, set(network.parameters) - set(changing), *keys, others=changing)
        if value is None:
            continue
        size = _in_unit(network, name, given, value)
        if not (size > 0.0 and np.isfinite(size)):
            reader.wrong(f"tolerance '{name}' is {size:g}", "write how far it may be off to either side, such as 0.5", *keys)
        found.append((name, size))
    return tuple(found)


def _method(reader: Reader, search: dict[str, Any], objectives: list[Objective], targets: list[Target]) -> str:
    usual = "least-squares" if targets else "cma-es" if len(objectives) == 1 else "nsga2"
    method = search.get("method", usual)
    keys = ("search", "method")
    if method not in METHODS:
        reader.wrong(f"there is no method {method!r}", f"known are {', '.join(METHODS)}", *keys)
    elif method == "least-squares" and not targets:
        reader.wrong("least squares need targets", "write [targets], or another method", *keys)
    elif method == "nsga2" and targets:
        reader.wrong("nsga2 needs objectives", 'write [objectives], or method = "cma-es"', *keys)
    elif method == "cma-es" and len(objectives) > 1:
        reader.wrong("cma-es looks for one objective", 'leave one, or write method = "nsga2"', *keys)
    else:
        return str(method)
    return usual


def _stop(reader: Reader, search: dict[str, Any]) -> dict[str, float]:
    stop = search.get("stop", {})
    if not isinstance(stop, dict):
        reader.wrong("'stop' is no table", "write stop = { evaluations = 5000 }", "search", "stop")
        return {}
    reader.unknown(stop, "stop", "search", "stop")
    return {key: reader.number(value, 0.0, 0.0, "search", "stop") for key, value in stop.items()}


def _pick(reader: Reader, tree: dict[str, Any]) -> Pick:
    given = reader.table(tree, "pick")
    reader.unknown(given, "pick", "pick")
    return Pick(
        ends=reader.flag(given.get("ends"), True, "pick", "ends"),
        knee=reader.flag(given.get("knee"), True, "pick", "knee"),
        spread=reader.whole(given.get("spread"), 0, 0, "pick", "spread"),
        best=reader.whole(given.get("best"), 1, 1, "pick", "best"),
    )


def _reference(reader: Reader, search: dict[str, Any], objectives: list[Objective]) -> tuple[float, ...]:
    """What the hypervolume is counted from: zero for what is made greatest, unless the study says otherwise."""
    given = search.get("reference", {})
    if not isinstance(given, dict):
        reader.wrong("'reference' is no table", "write reference = { stroke = 0, force = 0 }", "search", "reference")
        return ()
    for name in given:
        if name not in [each.name for each in objectives]:
            reader.wrong(f"there is no objective '{name}'", "name objectives of the study", "search", "reference")
    values = []
    for each in objectives:
        if each.name in given:
            values.append(float(reader.number(given[each.name], 0.0, float("-inf"), "search", "reference")))
        elif each.sign > 0:
            return ()
        else:
            values.append(0.0)
    return tuple(values) if len(values) > 1 else ()


def _first(
    reader: Reader, search: dict[str, Any], variables: list[Variable], given: str | os.PathLike[str] | None
) -> Values:
    """Designs of a table with a column for every variable, each within its range."""
    written, names = search.get("first"), [each.name for each in variables]
    if given is None and written is None:
        return np.zeros((0, len(names)))
    path = Path(given) if given is not None else reader.path.parent / str(written)
    keys = () if given is not None else ("search", "first")
    try:
        with path.open(encoding="utf-8", newline="") as file:
            rows = list(csv.DictReader(file))
        designs = np.array([[float(row[name]) for name in names] for row in rows]).reshape(len(rows), len(names))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        reader.wrong(f"the designs to begin with cannot be read: {error}", "give the path of a table such as front.csv", *keys)
    except (KeyError, ValueError, TypeError) as error:
        help = f"it needs numbers in the columns {', '.join(names)}"
        reader.wrong(f"{path} is no table of designs of this study: {error}", help, *keys)
    else:
        for each, column in zip(variables, designs.T):
            # A value at the end of a range may have been rounded beyond it.
            room = ROUNDED * (each.high - each.low)
            for row in np.flatnonzero(~((column >= each.low - room) & (column <= each.high + room)))[:1]:
                what = f"row {row + 1} of {path} has {column[row]:g} for '{each.name}', which goes from {each.low:g} to {each.high:g}"
                reader.wrong(what, "take it out of the table, or let the range hold it", *keys)
        return designs
    return np.zeros((0, len(names)))
