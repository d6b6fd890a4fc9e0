"""What is wrong, in words and as data."""

from __future__ import annotations

import dataclasses
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    import numpy.typing as npt
    import xarray

    from ._solution import Solution


@dataclasses.dataclass(frozen=True)
class Finding:
    """One thing that is wrong, or remarkable; `str` of it is what the program prints."""

    severity: str
    """`"error"` or `"warning"`."""
    message: str
    """What it is, in one sentence without a full stop."""
    file: str | None
    """Name of the file, where a place in one is to blame."""
    line: int | None
    """Counted from one."""
    column: int | None
    """In characters, counted from one."""
    name: str | None
    """What stands at that place."""
    label: str | None
    """A few words on that place."""
    notes: list[str]
    """Remarks, a sentence each."""
    help: str | None
    """What to do about it."""
    text: str
    """All of this as the program prints it."""

    def __str__(self) -> str:
        return self.text


@dataclasses.dataclass(frozen=True, eq=False)
class Motion:
    """A motion of an unloaded network that needs no force."""

    message: str
    """The motion in words."""
    node: str | None
    """The node that moves most, where it is a node."""
    member: str | None
    """The member that moves, where it is a member alone."""
    direction: npt.NDArray[np.float64]
    """(3,), unit vector of the motion, or unit axis of the turn, in global axes."""
    turns: bool
    """Whether it is a turn."""
    nodes: list[str]
    """All nodes that take part."""
    extent: str
    """`"local"`, `"part"` or `"whole"`: what moves as one rigid body."""

    def __str__(self) -> str:
        return self.message


class Error(Exception):
    """The base of all errors of this package."""


class NetworkError(Error, ValueError):
    """A network file, or a parameter set in it, is wrong."""

    errors: list[Finding]
    """Everything found, with its place."""

    def __init__(self, text: str, errors: list[Finding] | None = None) -> None:
        super().__init__(text, errors or [])
        self.errors = errors or []

    def __str__(self) -> str:
        return str(self.args[0])


class MechanismError(NetworkError):
    """A network can move without force."""

    motions: list[Motion]
    """All motions, in words and as arrays."""

    def __init__(self, text: str, errors: list[Finding] | None = None, motions: list[Motion] | None = None) -> None:
        super().__init__(text, errors)
        self.args = (text, errors or [], motions or [])
        self.motions = motions or []


class SolveError(Error, RuntimeError):
    """A step did not reach its end, or there is no answer to what was asked."""

    errors: list[Finding]
    """Why, as the program says it."""
    solution: Solution | None
    """What converged, where that is a solution."""

    def __init__(self, text: str, errors: list[Finding] | None = None, solution: Solution | None = None) -> None:
        super().__init__(text, errors or [], solution)
        self.errors = errors or []
        self.solution = solution

    def __str__(self) -> str:
        return str(self.args[0])


class WorkerError(Error, RuntimeError):
    """Workers of an executor gave no answer to some designs, though these were sent more than once."""

    table: xarray.Dataset | None
    """What was answered, where a sweep had a table."""

    def __init__(self, text: str, table: xarray.Dataset | None = None) -> None:
        super().__init__(text, table)
        self.table = table

    def __str__(self) -> str:
        return str(self.args[0])


class InternalError(Error, RuntimeError):
    """The program is wrong, not what it was given."""


class Interrupted(KeyboardInterrupt):
    """Ctrl-C in the middle of a solve: what had converged is in `solution`."""

    solution: Solution
    """Its status is `"interrupted"`."""

    def __init__(self, solution: Solution) -> None:
        super().__init__("interrupted; what converged is in the attribute 'solution'")
        self.solution = solution

    def __reduce__(self) -> tuple[Any, ...]:
        return Interrupted, (self.solution,)


