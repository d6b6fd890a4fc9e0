"""What a study asks for: what is varied, what is wanted, and how it is looked for."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import numpy.typing as npt

from .. import _network
from ._expression import Expression

Values = npt.NDArray[np.float64]


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
class Pick:
    """Which designs become network files."""

    ends: bool = True
    """The best of each objective."""
    knee: bool = True
    """The one nearest to the best of all objectives at once."""
    spread: int = 0
    """So many along the front."""
    best: int = 1
    """So many of one objective, or of targets."""


@dataclasses.dataclass(frozen=True, eq=False)
class Study:
    """A study that was read and checked."""

    path: Path
    text: str
    title: str
    network: _network.Network
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
    pick: Pick
    probes: tuple[str, ...]
    """Probes that expressions refer to."""
    derived: tuple[tuple[str, Expression], ...] = ()
    """Parameters that the network makes of others, in an order in which they can be evaluated."""
    tolerances: tuple[tuple[str, float], ...] = ()
    """Parameters that are not met exactly, and how far they may be off to either side."""
    reference: tuple[float, ...] = ()
    """What the hypervolume is counted from, one value an objective; empty where it is not known."""
    first: Values = dataclasses.field(default_factory=lambda: np.zeros((0, 0)))
    """(n, variables), designs that a search begins with."""

    @property
    def wanted(self) -> tuple[Named, ...]:
        """Objectives or targets, in the order of the columns of designs."""
        return (*self.objectives, *self.targets)


def in_file(network: _network.Network) -> dict[str, Values | float]:
    """The parameters of a network in the units of its file."""
    scales = network._scales
    return {name: value * scales[name] for name, value in network.parameters.items()}
