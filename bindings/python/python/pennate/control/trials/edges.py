"""Targets beyond the workspace (Fig. 40), and beyond the gap behind the arm (Fig. 41)."""

from __future__ import annotations

import numpy as np

from .. import br2
from .._arms import Array
from .._reach import reach
from . import drawn, percent, spread, table, whole

# Fig. 40: an even share of 8 cm makes 4 +- 2.3 cm, as reported; what is kept is outside by more than 0.5 cm.
FARTHEST, OUTSIDE = 80.0, 5.0


def beyond(count: int, seed: int) -> str:
    """Reachable tips moved away from the base along the ray from it; the arm is that of the model."""
    arm, rng = whole(0), np.random.default_rng(seed)
    tips = arm.tip(drawn(arm, rng, 3 * count))
    by = rng.uniform(0.0, FARTHEST, len(tips))
    targets = tips * (1 + by / np.linalg.norm(tips, axis=1))[:, None]
    closest = reach(arm, targets, tolerance=0.01, moves=60, restarts=32).error
    kept = np.flatnonzero(closest > OUTSIDE)[:count]
    targets, by, closest = targets[kept], by[kept], closest[kept]
    starts = drawn(arm, rng, len(kept))
    rows = []
    for name, restarts in (("Gauss-Newton", 0), ("with restarts", 8)):
        found = reach(arm, targets, start=starts, tolerance=0.1, restarts=restarts)
        over = found.error - closest
        rows.append([name, spread(over), percent(over < by), percent(found.error < by), f"{found.moves.mean():.1f}"])
    rows.append(["reported, DDPG", "2.6 ± 2.7", "76", "76", "–"])
    rows.append(["prototype, DDPG, closest of the run", "1.10 ± 1.17", "97", "13", "–"])
    rows.append(["prototype, Gauss-Newton", "0.74", "–", "83", "–"])
    head = ["", "error beyond the closest reachable point, cm", "this below the perturbation, %"]
    head += ["error to the target below it, %", "moves"]
    moved = f"moved by {spread(by)} cm, closest reachable points {spread(closest)} cm away"
    return table(f"Fig. 40: {len(kept)} targets outside the workspace, {moved}", head, rows)


def gap(count: int, seed: int) -> str:
    """From one side of the closed gap behind the arm to the other: the base has to turn all the way back."""
    starts, targets = crossings(count, seed)
    azimuth = np.degrees(np.arctan2(targets[:, 1], targets[:, 0]))
    rows = []
    for name, restarts in (("Gauss-Newton", 0), ("with restarts", 8)):
        found = reach(whole(0), targets, start=starts, tolerance=10.0, largest=br2.LARGEST, restarts=restarts)
        rows.append([name, percent(found.error <= 15.0), f"{found.moves.mean():.1f}", f"{found.moves.max()}"])
    rows.append(["prototype, DDPG", "100", "4.3", "–"])
    rows.append(["prototype, Gauss-Newton", "78", "–", "–"])
    where = f"at azimuths from {azimuth.min():.0f} to {azimuth.max():.0f} degrees"
    return table(f"Fig. 41: {count} targets {where}, share within 1.5 cm, %", ["", "share", "moves", "most"], rows)


def crossings(count: int, seed: int) -> tuple[Array, Array]:
    """Starts (count, 3) on one side of the gap and targets (count, 3) on the other."""
    arm, rng = whole(0), np.random.default_rng(seed)
    # A positive rotating pressure turns the tip to negative azimuths, as does a negative swivel.
    first, second = (rng.uniform([0.3, -1.0, 0.8], [1.0, -0.5, 1.0], (count, 3)) for _ in range(2))
    return first * arm.upper, arm.tip(second * [1.0, -1.0, -1.0] * arm.upper)
