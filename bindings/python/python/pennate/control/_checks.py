"""What is given from outside, checked: errors say what is wrong, where, and what would help."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _arguments
from ._arms import Arm, Array


def rows(what: str, given: npt.ArrayLike, width: int) -> Array:
    """(n, width), finite numbers; one row alone may be given as it is."""
    try:
        found = np.atleast_2d(_arguments.numbers(given, what))
    except (TypeError, ValueError):
        raise ValueError(f"{what}: numbers expected, not {given!r}") from None
    if found.ndim != 2 or found.shape[1] != width:
        raise ValueError(f"{what} has the shape {np.shape(given)}: ({width},) or (n, {width}) expected")
    bad = np.flatnonzero(~np.isfinite(found).all(axis=1))
    if len(bad):
        where = f"{what} {bad[0]}" if len(found) > 1 else what
        raise ValueError(f"{where} is ({_listed(found[bad[0]])}): finite numbers expected")
    return found


def within(what: str, given: npt.ArrayLike, arm: Arm) -> Array:
    """(n, k) inputs of an arm, within their limits but for rounding."""
    found = rows(what, given, len(arm.names))
    slack = 1e-9 * (arm.upper - arm.lower)
    beyond = (found < arm.lower - slack) | (found > arm.upper + slack)
    if beyond.any():
        row, place = np.argwhere(beyond)[0]
        limits = f"{arm.lower[place]:g} to {arm.upper[place]:g}"
        raise ValueError(f"{what}: {arm.names[place]} = {found[row, place]:g} is beyond its limits, {limits}")
    return found


def starts(given: npt.ArrayLike, arm: Arm, count: int, what: str = "start") -> Array:
    """(count, k) inputs to begin with, within their limits: one row for each target, or one for all."""
    found = within(what, given, arm)
    if len(found) not in (1, count):
        raise ValueError(f"{what}: one row, or {count}, one for each target, expected, not {len(found)}")
    return np.broadcast_to(found, (count, found.shape[1]))


def length(what: str, given: Any) -> float:
    """A length that is no less than 0."""
    found = _arguments.real(given, what, "a length")
    if not 0.0 <= found < np.inf:
        raise ValueError(f"{what}: a length, 0 or more, expected, not {found:g}")
    return found


def largest(given: npt.ArrayLike | None, arm: Arm) -> Array:
    """(k,), the changes of inputs that a move does not exceed; infinite where nothing limits them."""
    count = len(arm.names)
    if given is None:
        return np.full(count, np.inf)
    found = _arguments.numbers(given, "largest", arm.names)
    if found.shape != (count,):
        raise ValueError(f"largest has the shape {found.shape}: ({count},) expected, for {', '.join(arm.names)}")
    if not (found > 0).all():
        place = int(np.flatnonzero(~(found > 0))[0])
        raise ValueError(f"largest: changes above 0 expected, not {found[place]:g} for {arm.names[place]}")
    return found


def strides(actions: npt.ArrayLike, count: int, arms: int) -> npt.NDArray[np.intp]:
    """(arms,), numbers of discrete actions."""
    given = np.asarray(actions)
    if given.shape != (arms,):
        raise ValueError(f"actions have the shape {given.shape}: ({arms},) expected, a number for each arm")
    numeric = given.dtype.kind in "iufb"
    if not numeric or not np.isin(given, np.arange(count)).all():
        bad = [each for each in given.tolist() if not numeric or each not in range(count)]
        raise ValueError(f"there is no action {bad[0]!r}: whole numbers from 0 to {count - 1} expected")
    return given.astype(np.intp)


def changes(actions: npt.ArrayLike, names: tuple[str, ...], arms: int) -> Array:
    """(arms, k), continuous actions, those beyond -1 and 1 taken to these."""
    try:
        given = np.asarray(actions, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueError(f"actions: numbers from -1 to 1 for {', '.join(names)} expected, not {actions!r}") from None
    if given.shape != (arms, len(names)):
        raise ValueError(
            f"actions have the shape {given.shape}: ({arms}, {len(names)}) expected, numbers from -1 to 1 for {', '.join(names)}"
        )
    if not np.isfinite(given).all():
        row, place = np.argwhere(~np.isfinite(given))[0]
        raise ValueError(f"the action for {names[place]} is {given[row, place]}: a number from -1 to 1 expected")
    found: Array = np.clip(given, -1.0, 1.0)
    return found


def load(given: Any) -> float:
    """A load at the tip, g."""
    try:
        found = float(given)
    except (TypeError, ValueError):
        found = np.nan
    if not (np.isfinite(found) and found >= 0):
        raise ValueError(f"load: a number of grams, 0 or more, expected, not {given!r}")
    return found


def _listed(row: Array) -> str:
    return ", ".join(f"{value:g}" for value in row)
