"""The eight tests of chapter 4, each as a section of one page: reported, policy, Gauss-Newton, both together."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from .. import br2
from .._arms import Array
from .._bench import bench
from .._judge import setting
from .._policy import follow
from .._reach import reach
from . import CM, drawn, half, lattice, percent, spread, table, whole
from .edges import FARTHEST, OUTSIDE, crossings
from .pairs import LOADS, PROTOTYPE_DDPG, PROTOTYPE_DQN, REPORTED, pairs, shortest
from .paths import CLOSEST, PROTOTYPE_12, TABLE_11, TABLE_12, WAYPOINTS, curve, extremal_shares, fresh
from .ways import HEAD, kept, policy_along, reach_along, servo_along, ways

# Where curves begin: half the bending pressure.
MIDDLE: Array = np.array([br2.BENDING / 2, 0.0, 0.0])


def table8(share: float, seed: int) -> str:
    """T1: random pairs of the lattice, under loads."""
    rows, count = [], round(10_000 * share)
    for load in LOADS:
        starts, targets = pairs(load, count, seed)
        rows.append([f"{load} g", "reported", f"{REPORTED[load]:.2f}", *["–"] * 6])
        rows.append([f"{load} g", "prototype, DQN", f"{PROTOTYPE_DQN[load]:.2f}", *["–"] * 6])
        for name, found in ways("dqn", half(load), half(0), starts, targets, 10.0, None):
            rows.append([f"{load} g", name, *found.row()])
    return table(f"Table 8: {count} random pairs a load, to 1 cm", ["load", "by", *HEAD], rows)


def three(share: float, seed: int) -> str:
    """T1b: random pairs of the swivelling arm."""
    rows, count = [], round(5_000 * share)
    for load, prototype in PROTOTYPE_DDPG.items():
        arm, rng = whole(load), np.random.default_rng(seed)
        starts, targets = drawn(arm, rng, count), arm.tip(drawn(arm, rng, count))
        rows.append([f"{load} g", "prototype, DDPG", f"{prototype:.1f}", *["–"] * 6])
        for name, found in ways("ddpg", arm, whole(0), starts, targets, 15.0, br2.LARGEST):
            rows.append([f"{load} g", name, *found.row()])
    return table(f"Three inputs: {count} random pairs a load, to 1.5 cm", ["load", "by", *HEAD], rows)


def fig34(share: float, seed: int) -> str:
    """T2: waypoints at the edge of the workspace, and a lateral sweep."""
    arm, rows = half(0), []
    for name, shares in extremal_shares().items():
        targets = arm.tip(np.array(shares) * arm.upper)
        errors: dict[str, list[float]] = {"DQN": [], "with restarts": [], "hybrid": []}
        moves = dict.fromkeys(errors, 0.0)
        inputs = dict.fromkeys(errors, np.array([[br2.BENDING / 2, 0.0]]))
        for target in targets[:, None]:
            for way in errors:
                found = dict(ways("dqn", arm, arm, inputs[way], target, 10.0, None))[way]
                errors[way].append(found.errors[0] / CM)
                moves[way] += found.moves[0]
                inputs[way] = found.inputs
        for way, each in errors.items():
            rows.append([name, way, "≤ 1.0", *(f"{error:.2f}" for error in each), f"{moves[way]:.0f}"])
    head = ["waypoints", "by", "asked for", *(f"{place}" for place in range(1, 6)), "moves in all"]
    return table("Fig. 34: errors at five waypoints, cm", head, rows)


def fig35(share: float, seed: int) -> str:
    """T3: fewest moves of the lattice, and those of the policy; strides far from the target and near it."""
    tips, rng, count = lattice(half(0)), np.random.default_rng(seed), round(300 * share)
    starts, goals = (rng.integers(0, br2.LEVELS, (count, 2)) for _ in range(2))
    targets, begin = tips[tuple(goals.T)], starts / (np.array(br2.LEVELS) - 1) * half(0).upper
    rows = []
    for name, strides, prototype in (("all strides", br2.STRIDES, "6.2"), ("the smallest alone", (1,), "22.1")):
        there = [np.linalg.norm(tips - target, axis=2) <= 10.0 for target in targets]
        best = np.array([shortest(goal, strides)[tuple(place)] for goal, place in zip(there, starts)])
        _, actions, rules = setting("discrete", strides=strides)
        policy = kept("dqn" if strides == br2.STRIDES else "fine")
        found = follow(policy, half(0), begin, targets, actions=actions, rules=replace(rules, steps=160))
        ended, away = found.errors <= 10.0, best > 0
        ratio = found.moves[ended].sum() / best[ended].sum()
        middle = np.median(found.moves[ended & away] / best[ended & away])
        figures = [f"{best.mean():.1f}", f"{found.moves.mean():.1f}", percent(ended), f"{ratio:.2f}", f"{middle:.2f}"]
        rows.append([name, prototype, *figures])
    head = ["", "fewest, prototype", "fewest", "DQN", "there in 160, %", "ratio, of those", "its median"]
    return table(f"Fig. 35: moves of the lattice to 1 cm, mean of {count} pairs", head, rows)


def table9(share: float, seed: int) -> str:
    """T4: waypoints that loads put out of reach."""
    targets, rows = half(0).tip(np.array(WAYPOINTS)), []
    starts = np.tile([br2.BENDING / 2, br2.ROTATING / 2], (len(targets), 1))
    _, actions, rules = setting("discrete")
    for load in (0, 6, 9, 12):
        closest = reach(half(load), targets, tolerance=0.01, moves=40).error / CM
        policy = follow(kept("dqn"), half(load), starts, targets, actions=actions, rules=rules)
        found = dict(ways("dqn", half(load), half(0), starts, targets, 10.0, None))
        for place in range(len(targets)):
            cells = [CLOSEST.get((place, load), "≤ 1"), f"{closest[place]:.2f}", "yes" if closest[place] <= 1 else "no"]
            cells += [f"{policy.closest[place] / CM:.2f}", f"{policy.errors[place] / CM:.2f}"]
            cells += [f"{found[way].errors[place] / CM:.2f}" for way in ("with restarts", "hybrid")]
            rows.append([f"{place + 1}, {load} g", *cells])
    head = ["waypoint, load", "reported", "closest reachable", "within 1 cm", "DQN, closest of the run", "DQN, last"]
    return table("Tables 9 and 10: errors, cm", [*head, "with restarts", "hybrid"], rows)


def table11(share: float, seed: int) -> str:
    """T5: curves, waypoint by waypoint."""
    rows, count = [], round(60 * share)
    for name, reported in TABLE_11.items():
        points, few = curve(name, count), curve(name, max(2, count // 4))
        for place, load in enumerate((0, 3, 6, 9)):
            arm = whole(load)
            closest = reach(arm, points, tolerance=0.01, moves=40).error
            found = (
                policy_along(arm, points, MIDDLE),
                policy_along(arm, few, MIDDLE, 7.5),
                reach_along(arm, points, MIDDLE, 1.0),
                reach_along(arm, points, MIDDLE, 1.0, both=True),
            )
            cells = [cell for each in found for cell in (spread(each.errors), f"{each.moves.mean():.1f}")]
            rows.append([f"{name}, {load} g", reported[place] or "–", spread(closest), *cells])
    head = [
        "curve, load",
        "reported",
        "closest reachable",
        "DDPG to 1.5 cm",
        "moves",
        f"{count // 4} points to 0.75 cm",
    ]
    head += ["moves", "with restarts, to 0.1 cm", "moves", "hybrid, to 0.1 cm", "moves"]
    return table(f"Table 11: errors at {count} waypoints, cm", head, rows)


def fig40(share: float, seed: int) -> str:
    """T6: reachable tips moved outwards along the ray from the base."""
    arm, rng, count = whole(0), np.random.default_rng(seed), round(200 * share)
    tips = arm.tip(drawn(arm, rng, 3 * count))
    by = rng.uniform(0.0, FARTHEST, len(tips))
    targets = tips * (1 + by / np.linalg.norm(tips, axis=1))[:, None]
    closest = reach(arm, targets, tolerance=0.01, moves=60, restarts=32).error
    chosen = np.flatnonzero(closest > OUTSIDE)[:count]
    targets, by, closest = targets[chosen], by[chosen], closest[chosen]
    starts = drawn(arm, rng, len(chosen))
    _, actions, rules = setting("continuous")
    policy = follow(kept("ddpg"), arm, starts, targets, actions=actions, rules=rules)
    found = dict(ways("ddpg", arm, arm, starts, targets, 1.0, None))
    each = {"DDPG, closest of the run": policy.closest, "DDPG, last": policy.errors}
    each |= {name: found[name].errors for name in ("Gauss–Newton", "with restarts", "hybrid")}
    moves = {name: f"{result.moves.mean():.1f}" for name, result in found.items()}
    rows = [["reported, DDPG", "2.6 ± 2.7", "76", "76", "–"]]
    rows.append(["prototype, DDPG, closest of the run", "1.10 ± 1.17", "97", "13", "–"])
    for name, errors in each.items():
        over = errors - closest
        rows.append([name, spread(over), percent(over < by), percent(errors < by), moves.get(name, "15.0")])
    head = ["", "beyond the closest reachable point, cm", "this below the perturbation, %"]
    what = f"moved by {spread(by)} cm, closest reachable points {spread(closest)} cm away"
    return table(
        f"Fig. 40: {len(by)} targets out of reach, {what}", [*head, "error to the target below it, %", "moves"], rows
    )


def fig41(share: float, seed: int) -> str:
    """T7: from one side of the gap behind the arm to the other."""
    count = round(300 * share)
    starts, targets = crossings(count, seed)
    rows = [["prototype, DDPG", "100", "–", "–", "4.3", *["–"] * 3], ["prototype, Gauss–Newton", "78", *["–"] * 6]]
    rows += [
        [name, *found.row()] for name, found in ways("ddpg", whole(0), whole(0), starts, targets, 15.0, br2.LARGEST)
    ]
    return table(f"Fig. 41: {count} targets beyond the gap, to 1.5 cm", ["by", *HEAD], rows)


def table12(share: float, seed: int) -> str:
    """T8: the bench arm, open and closed loop, and a worse one."""
    rows, count = [], round(30 * share)
    for name, reported in TABLE_12.items():
        points = curve(name, count)
        planned = reach_along(whole(0), points, MIDDLE, 1.0).inputs
        for worse, kind in ((1.0, ""), (1.5, ", worse arm")):
            away = np.linalg.norm(fresh(bench(0, worse)).tip(planned) - points, axis=1)
            known = [reported[0], PROTOTYPE_12[name][0]] if worse == 1.0 else ["–", "–"]
            rows.append([f"{name}, open{kind}", *known, spread(away), *["–"] * 6])
            for place, load in ((1, 0), (2, 9)):
                found = (
                    policy_along(fresh(bench(load, worse)), points, MIDDLE),
                    reach_along(fresh(bench(load, worse)), points, MIDDLE, 3.0),
                    servo_along(fresh(bench(load, worse)), points, MIDDLE, 3.0),
                )
                cells = [cell for each in found for cell in (spread(each.errors), f"{each.moves.mean():.1f}")]
                known = [reported[place], PROTOTYPE_12[name][place]] if worse == 1.0 else ["–", "–"]
                rows.append([f"{name}, {load} g{kind}", *known, "–", *cells])
    head = ["curve, load", "reported", "prototype, Jacobian", "open loop", "DDPG to 1.5 cm", "moves"]
    head += ["with restarts, to 0.3 cm", "moves", "feedback, to 0.3 cm", "moves"]
    return table(f"Table 12: errors at {count} waypoints on the bench arm, cm", head, rows)
