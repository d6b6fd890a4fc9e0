"""What can be moved: parameters of the file, and pressures that the file states as numbers."""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .. import _arguments, _core
from .._errors import NetworkError
from .._look.fields import ticks
from .._network import Network

# A slider has about so many places.
PLACES = 200


@dataclasses.dataclass(frozen=True)
class Handle:
    """A slider: a parameter of the network, its name for a reader, its limits, and its value in the file."""

    name: str
    label: str
    low: float
    high: float
    value: float
    # Whether the file has it under `[parameters]`; else it is a pressure of a step.
    named: bool = True

    @property
    def step(self) -> float:
        """A round part of the range."""
        rough = (self.high - self.low) / PLACES
        power = 10.0 ** math.floor(math.log10(rough)) if rough > 0 else 1.0
        return next(factor * power for factor in (1.0, 2.0, 5.0, 10.0) if factor * power >= 0.999 * rough)


def moving(network: Network, ranges: Mapping[str, tuple[float, float]]) -> tuple[Network, list[Handle]]:
    """The network with its stated pressures as parameters, and a handle for everything that can be moved."""
    network, pressures = with_pressures(network)
    tree = network.to_dict()
    free = [name for name, value in tree.get("parameters", {}).items() if not derived(value)]
    most = highest_pressure(tree)
    driven = {name for step in tree.get("steps", []) for name in plain_pressures(step)}
    found = []
    for name in free:
        value = network.parameters[name]
        low, high = ranges.get(name) or usual(value)
        if name in driven and name not in ranges and value >= 0:
            as_in_table = network.parameter_units[name] in ("", table_unit(tree))
            low, high = 0.0, max(most, value) if most and as_in_table else highest_valid(network, name, value, high)
        label = pressures.get(name) or ", ".join(filter(None, (name, network.parameter_units[name])))
        found.append(Handle(name, label, min(low, value), max(high, value), value, name not in pressures))
    return network, found


def limits(ranges: Mapping[str, tuple[float, float]]) -> dict[str, tuple[float, float]]:
    """Limits of sliders, each the least and the greatest value."""
    found = {}
    for name, pair in _arguments.table(ranges, "ranges").items():
        both = _arguments.numbers(pair, f"ranges['{name}']")
        if both.shape != (2,) or not np.isfinite(both).all() or both[0] >= both[1]:
            raise ValueError(f"ranges['{name}']: the least and the greatest value expected, not {_arguments.shown(pair)}")
        found[name] = (float(both[0]), float(both[1]))
    return found


def check_names(ranges: Mapping[str, tuple[float, float]], handles: Sequence[Handle]) -> None:
    """Refuses limits of what cannot be moved."""
    known = [handle.name for handle in handles]
    for name in ranges:
        if name not in known:
            where = [f"limits of a slider are given for '{name}'"]
            raise _core.unknown(f"there is no parameter '{name}' to move", name, known, "parameters", where)


def derived(value: object) -> bool:
    """Whether a parameter follows from others."""
    return isinstance(value, str) and value.lstrip().startswith("=")


def usual(value: float) -> tuple[float, float]:
    """Round limits from half to one and a half times a value."""
    if value == 0.0:
        return -1.0, 1.0
    marks = ticks(min(0.5 * value, 1.5 * value), max(0.5 * value, 1.5 * value), 11)
    return marks[0], marks[-1]


def plain_pressures(step: Mapping[str, Any]) -> list[str]:
    """Parameters that are a pressure of a step, as they are."""
    stated = step.get("pressure") or {}
    texts = [value for value in stated.values() if isinstance(value, str)] if isinstance(stated, Mapping) else []
    return [match[1] for text in texts if (match := re.fullmatch(r"\s*=\s*([A-Za-z_]\w*)\s*", text))]


def highest_pressure(tree: Mapping[str, Any]) -> float:
    """The last pressure that all muscles with a table have a row for; zero where none has."""
    tables = [muscle.get("table") for muscle in (tree.get("muscles") or {}).values() if isinstance(muscle, Mapping)]
    tops = []
    for table in tables:
        try:
            tops.append(max(float(row["pressure"]) for row in table or []))
        except (KeyError, TypeError, ValueError):
            continue
    return min(tops, default=0.0)


def highest_valid(network: Network, name: str, value: float, high: float) -> float:
    """The highest value up to a limit that the network is not refused for, to a hundredth of the range."""

    def valid(tried: float) -> bool:
        try:
            network.set(**{name: tried})
        except NetworkError:
            return False
        return True

    if valid(high):
        return high
    low, above = value, high
    while above - low > 0.01 * (high - value):
        middle = (low + above) / 2
        low, above = (middle, above) if valid(middle) else (low, middle)
    return low


def with_pressures(network: Network) -> tuple[Network, dict[str, str]]:
    """The network with a parameter for every pressure that its steps state as a number, and what each is called."""
    tree = network.to_dict()
    steps, unit = tree.get("steps", []), table_unit(tree)
    parameters: dict[str, float | str] = {}
    labels: dict[str, str] = {}
    for index, step in enumerate(steps):
        for who, value in (step.get("pressure") or {}).items():
            if derived(value):
                continue
            stated = re.fullmatch(r"\s*([-+.\deE]+)\s*(\S+)\s*", value) if isinstance(value, str) else None
            name = free_name(
                f"pressure_{who}" + (f"_{index + 1}" if len(steps) > 1 else ""), tree.get("parameters", {})
            )
            parameters[name] = value
            # A bare number is in the unit of the muscle.
            labels[name] = ", ".join(filter(None, (f"pressure {who}", stated[2] if stated else unit)))
            step["pressure"] = {**step["pressure"], who: f"= {name}"}
    return (network.edit(parameters=parameters, steps=steps), labels) if parameters else (network, {})


def table_unit(tree: Mapping[str, Any]) -> str:
    """The unit of pressure of all muscles of a file; empty where they have several."""
    units = pressure_units(tree)
    return units.pop() if len(units) == 1 else ""


def pressure_units(tree: Mapping[str, Any]) -> set[str]:
    """The units of pressure of the muscles of a file."""
    muscles = (tree.get("muscles") or {}).values()
    return {
        str(muscle["pressure_unit"]) for muscle in muscles if isinstance(muscle, Mapping) and "pressure_unit" in muscle
    }


def free_name(wish: str, taken: Mapping[str, object]) -> str:
    """A name of a parameter that there is not yet."""
    name = re.sub(r"\W", "_", wish)
    while name in taken:
        name += "_"
    return name
