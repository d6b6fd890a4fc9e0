"""Random pairs of a start and a target: Table 8, the same with three inputs, and the fewest moves of the lattice (Fig. 35)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .. import br2
from .._arms import Array
from .._reach import reach
from . import drawn, half, lattice, percent, table, whole

LOADS = (0, 6, 9, 12, 18)
# Table 8, and a prototype of these trials: damped Gauss-Newton with the Jacobian of the unloaded arm, and a DQN.
REPORTED = {0: 97.30, 6: 97.19, 9: 95.88, 12: 95.92, 18: 94.60}
PROTOTYPE = {0: 99.82, 6: 99.86, 9: 99.84, 12: 99.84, 18: 99.84}
PROTOTYPE_DQN = {0: 95.41, 6: 95.45, 9: 95.55, 12: 95.46, 18: 94.34}
# Of the prototype's DDPG, shares within 1.5 cm.
PROTOTYPE_DDPG = {0: 99.0, 3: 99.1, 6: 99.1, 9: 99.1}


def pairs(load: float, count: int, seed: int) -> tuple[Array, Array]:
    """Starts (count, 2) and targets (count, 3) on the lattice of the arm with a load."""
    arm, rng = half(load), np.random.default_rng(seed)
    starts, goals = (rng.integers(0, br2.LEVELS, (count, 2)) / (np.array(br2.LEVELS) - 1) for _ in range(2))
    within = arm.upper - arm.lower
    return arm.lower + starts * within, arm.tip(arm.lower + goals * within)


def table8(count: int, seed: int) -> str:
    """Gauss-Newton stops at 1 cm, as the policy of the text does; the arm is measured, derivatives are those without load."""
    rows = []
    for load in LOADS:
        begin, to = pairs(load, count, seed)
        plain, cured, known, fine = (
            reach(half(load), to, start=begin, model=model, tolerance=tolerance, restarts=restarts)
            for model, restarts, tolerance in (
                (half(0), 0, 10.0),
                (half(0), 8, 10.0),
                (half(load), 0, 10.0),
                (half(0), 8, 1.0),
            )
        )
        shares = [percent(found.error <= 15.0) for found in (plain, cured, known)]
        far, fine_share = percent(plain.error > 30.0), percent(fine.error <= 1.0)
        figures = [
            f"{REPORTED[load]:.2f}",
            f"{PROTOTYPE_DQN[load]:.2f}",
            f"{PROTOTYPE[load]:.2f}",
            *shares,
            far,
            fine_share,
        ]
        rows.append(
            [f"{load} g", *figures, f"{plain.moves.mean():.2f}", f"{plain.moves.max()}", f"{cured.moves.max()}"]
        )
    head = [
        "load",
        "reported, DQN",
        "prototype, DQN",
        "prototype, measured",
        "measured",
        "measured, restarts",
        "modelled",
    ]
    head += ["measured, beyond 3 cm", "0.1 cm, restarts", "moves", "most", "most, restarts"]
    return table(f"Table 8: share of {count} pairs within 1.5 cm, %", head, rows)


def three_inputs(count: int, seed: int) -> str:
    """Random pairs of the swivelling arm, at most 15 moves to within 1.5 cm; changes no greater than those of the policy."""
    rows = []
    for load, prototype in PROTOTYPE_DDPG.items():
        arm, rng = whole(load), np.random.default_rng(seed)
        starts, targets = drawn(arm, rng, count), arm.tip(drawn(arm, rng, count))
        found = [
            reach(arm, targets, start=starts, model=whole(0), tolerance=15.0, largest=br2.LARGEST, restarts=restarts)
            for restarts in (0, 8)
        ]
        shares = [percent(each.error <= 15.0) for each in found]
        errors = [f"{each.error.mean() / 10:.2f}" for each in found]
        rows.append(
            [f"{load} g", f"{prototype:.1f}", *shares, *errors, *(f"{each.moves.mean():.2f}" for each in found)]
        )
    head = [
        "load",
        "prototype, DDPG",
        "measured",
        "with restarts",
        "error, cm",
        "with restarts",
        "moves",
        "with restarts",
    ]
    return table(f"Three inputs: share of {count} pairs within 1.5 cm, %", head, rows)


def fewest_moves(count: int, seed: int) -> str:
    """Between random pairs of the lattice to within 1 cm, breadth first: what no policy with these strides can better."""
    tips, rng = lattice(half(0)), np.random.default_rng(seed)
    starts, goals = rng.integers(0, br2.LEVELS, (count, 2)), rng.integers(0, br2.LEVELS, (count, 2))
    rows = []
    for name, strides, prototype in (("all strides", (1, 2, 4), "6.2, 17"), ("the smallest alone", (1,), "22.1, 65")):
        goal = [np.linalg.norm(tips - tips[tuple(place)], axis=2) <= 10.0 for place in goals]
        moves = [int(shortest(there, strides)[tuple(place)]) for there, place in zip(goal, starts)]
        rows.append([name, prototype, f"{np.mean(moves):.1f}, {max(moves)}"])
    return table(
        f"Fig. 35: fewest moves of the lattice, mean and most of {count} pairs", ["", "prototype", "here"], rows
    )


def shortest(goal: npt.NDArray[np.bool_], strides: tuple[int, ...]) -> npt.NDArray[np.int64]:
    """How many strides lead from each point of a lattice to the nearest one of a goal."""
    found = np.where(goal, 0, -1)
    reached, moves = goal, 0
    while not reached.all():
        moves += 1
        grown = reached.copy()
        for stride in strides:
            grown[stride:] |= reached[:-stride]
            grown[:-stride] |= reached[stride:]
            grown[:, stride:] |= reached[:, :-stride]
            grown[:, :-stride] |= reached[:, stride:]
        found[grown & ~reached] = moves
        reached = grown
    return found
