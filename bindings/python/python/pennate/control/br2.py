"""The BR2 arm: its limits, its strides, and its models for a load at the tip.

Pressures are in kPa, angles in degrees, lengths in mm, loads in g. What is given by the dissertation (chapter 4), inferred
from its numbers or assumed stands in the book, on the page on control.
"""

from __future__ import annotations

from dataclasses import fields, replace
from functools import lru_cache
from typing import Any

import numpy as np
import pennate

from . import _checks
from ._arms import Bounds, Solved, Swivelled
from ._leaning import Leaning
from ._table import Table
from ._task import Changes, Levels, Rules

# Given in section 4.3: 25 and 28 psi.
BENDING, ROTATING = 172.36, 193.05
# Half the workspace, with one rotating actuator; all of it, where a negative pressure is that of the other one.
HALF: Bounds = {"Pb": (0.0, BENDING), "Pr": (0.0, ROTATING)}
BOTH: Bounds = {"Pb": (0.0, BENDING), "Pr": (-ROTATING, ROTATING)}
# Inferred from the pressures of Table 9: steps of 0.5 psi and of 1 psi.
LEVELS = (51, 29)
# Given: an action goes by so many levels, up or down.
STRIDES = (1, 2, 4)
# From this load on, g, the arm buckles near full bending pressure; up to 16 g no state was found unstable.
BUCKLING = 16.0
# Further points of tables of such arms, kPa: the tip goes by the root of the distance from the bending pressure at which they
# buckle, around which the first ones lie.
BENDING_POINTS = tuple(np.arange(-7.5, 7.5, 0.5).tolist())
ROTATING_POINTS = (0.1, 0.2, 0.5, 1.0, 2.0, 3.5, 5.0)
# Given in section 4.4: the greatest changes of a continuous action, kPa, kPa and degrees. 31.2 kPa lies on no grid of psi.
LARGEST = (31.2, 96.5, 60.0)
# Given in Fig. 41; half the range of a rotating pressure and of the swivel alike is the greatest change.
SWIVEL = 60.0
# No tip is farther from the base.
LENGTH = 310.0
# Given: the rewards, the tolerance of 15 mm with continuous actions, what counts as success. Inferred: 10 mm in training with
# discrete ones ("limits (0.01 m)"), errors in cm, 15 moves. Assumed: 40 moves, which the way through the whole range needs.
DISCRETE = Rules(tolerance=10.0, steps=40, success=15.0, rounding=10.0)
CONTINUOUS = Rules(tolerance=15.0, steps=15, success=15.0, fine=None, late=True)


def solved(load: float = 0.0, *, both: bool = False, swivel: bool = False) -> Solved | Swivelled:
    """The arm, solved for each state; where it buckles it leans to the side of its rotating actuator."""
    made = _single(_checks.load(load), both)
    return Swivelled(made, least=-SWIVEL, greatest=SWIVEL) if swivel else made


def table(load: float = 0.0, *, both: bool = False, swivel: bool = False) -> Table | Swivelled:
    """The arm, by a table of solved states: the lattice of `LEVELS`, with both rotating actuators twice. Tables are kept."""
    made = _tabulated(_checks.load(load), both)
    return Swivelled(made, least=-SWIVEL, greatest=SWIVEL) if swivel else made


def _single(load: float, both: bool) -> Solved:
    network, inputs = pennate.scene("br2", load=load), BOTH if both else HALF
    return Leaning(network, inputs) if load > BUCKLING else Solved(network, inputs)


@lru_cache(maxsize=32)
def _tabulated(load: float, both: bool) -> Table:
    bending, rotating = LEVELS
    # The slope of the tip jumps where one rotating actuator takes over from the other, or the tip itself does.
    counts, kinks = ((bending, 2 * rotating - 1), ((), (0.0,))) if both else (LEVELS, ((), ()))
    extra: tuple[tuple[float, ...], ...] = ((), ())
    if load > BUCKLING:
        signs = (-1, 1) if both else (1,)
        around = tuple(point for by in BENDING_POINTS if 0.0 < (point := _buckles(load) + by) < BENDING)
        extra = (around, tuple(sign * value for sign in signs for value in ROTATING_POINTS))
    return Table(_single(load, both), counts, kinks, extra)


@lru_cache(maxsize=32)
def _buckles(load: float) -> float:
    """The bending pressure at which the arm falls to its side, kPa: where hardly any more of it moves the tip most."""
    bending = np.arange(0.0, BENDING, 1.0)
    sideways = _single(load, False).tip(np.stack([bending, 0.0 * bending], axis=1))[:, 1]
    steepest = int(np.abs(np.diff(sideways)).argmax())
    return float(bending[steepest] + bending[steepest + 1]) / 2


def environment(
    actions: str, *, load: float = 0.0, source: str = "live", **changes: float | bool | None
) -> dict[str, Any]:
    """The arguments of `Env` and `VectorEnv` for the two decision processes of chapter 4.

    Args:
        actions: `"discrete"`, two inputs by twelve strides; or `"continuous"`, three inputs.
        load: At the tip, in g.
        source: `"live"` solves at each move, `"table"` solves once for a lattice and interpolates.
        changes: Of the rules, such as `unit=1.0`, which counts errors in mm.
    """
    if actions not in ("discrete", "continuous"):
        raise ValueError(f"actions: 'discrete' or 'continuous' expected, not {actions!r}")
    if source not in ("live", "table"):
        raise ValueError(f"source: 'live' or 'table' expected, not {source!r}")
    known = [field.name for field in fields(Rules)]
    unknown = set(changes) - set(known)
    if unknown:
        raise ValueError(f"there is no setting '{min(unknown)}'; there are load, source, {', '.join(known)}")
    discrete = actions == "discrete"
    rules = replace(DISCRETE if discrete else CONTINUOUS, **changes)  # type: ignore[arg-type]
    made = (solved if source == "live" else table)(load, both=not discrete, swivel=not discrete)
    return {
        "network": made,
        "actions": Levels(LEVELS) if discrete else Changes(LARGEST),
        "rules": rules,
        "length": LENGTH,
    }
