"""The tests of a policy: random pairs, curves, targets beyond the gap, and pairs of Table 8."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np

from .. import br2
from .._arms import Array
from .._judge import setting_of
from .._policy import Policy, follow, visit
from .._task import Changes
from . import drawn, half, percent, spread, table, whole
from .edges import crossings
from .pairs import LOADS, PROTOTYPE_DDPG, PROTOTYPE_DQN, REPORTED, pairs
from .paths import TABLE_11, curve


def score(policy: Policy, share: float, seed: int) -> str:
    """All tables of a policy; `share` of the cases."""
    if policy.kind == "discrete":
        return _table8(policy, round(10_000 * share), seed)
    parts = [_three_inputs(policy, round(5_000 * share), seed), _curves(policy, round(60 * share))]
    return "\n\n".join([*parts, _gap(policy, round(300 * share), seed)])


def _table8(policy: Policy, count: int, seed: int) -> str:
    """Trained without load, tried with loads, as a policy goes and as it would with levels that it may visit again."""
    rows = []
    for load in LOADS:
        starts, targets = pairs(load, count, seed)
        figures = []
        arm, actions, rules = setting_of(policy, load)
        for again in (False, True):
            found = follow(policy, arm, starts, targets, actions=actions, rules=rules, again=again)
            figures += [percent(found.errors <= 15.0), percent(found.errors > 30.0), f"{found.moves.mean():.1f}"]
        rows.append([f"{load} g", f"{REPORTED[load]:.2f}", f"{PROTOTYPE_DQN[load]:.2f}", *figures])
    head = ["load", "reported", "prototype", "here", "beyond 3 cm", "moves"]
    head += ["levels visited again", "beyond 3 cm", "moves"]
    return table(f"Table 8: share of {count} pairs within 1.5 cm, %", head, rows)


def live(policy: Policy, share: float, seed: int) -> str:
    """The pairs of Table 8 by solves at each move, and by tables."""
    rows, count = [], round(10_000 * share)
    for load in LOADS:
        starts, targets = pairs(load, count, seed)
        cells, inputs = [], []
        _, actions, rules = setting_of(policy)
        for arm in (half(load), br2.solved(load)):
            begin, used = time.perf_counter(), time.process_time()
            found = follow(policy, arm, starts, targets, actions=actions, rules=rules)
            inputs.append(found.inputs)
            cells += [percent(found.errors <= 15.0), f"{time.process_time() - used:.1f}"]
            cells.append(f"{time.perf_counter() - begin:.1f}")
        same = (np.abs(inputs[0] - inputs[1]).max(axis=1) < 1e-6).astype(bool)
        rows.append([f"{load} g", *cells, percent(same)])
    head = ["load", "by table", "s of processor time", "s", "live", "s of processor time", "s", "same end, %"]
    return table(f"Table 8 live and by table: share of {count} pairs within 1.5 cm, %", head, rows)


def _three_inputs(policy: Policy, count: int, seed: int) -> str:
    rows = []
    for load, prototype in PROTOTYPE_DDPG.items():
        arm, rng = whole(load), np.random.default_rng(seed)
        starts, targets = drawn(arm, rng, count), arm.tip(drawn(arm, rng, count))
        found = follow(policy, arm, starts, targets, actions=Changes(br2.LARGEST), rules=br2.CONTINUOUS)
        figures = [percent(found.errors <= 15.0), f"{found.errors.mean() / 10:.2f}", f"{found.moves.mean():.2f}"]
        rows.append([f"{load} g", f"{prototype:.1f}", *figures])
    head = ["load", "prototype", "here", "error, cm", "moves"]
    return table(f"Three inputs: share of {count} pairs within 1.5 cm, %", head, rows)


def _curves(policy: Policy, count: int) -> str:
    rows, fine = [], replace(br2.CONTINUOUS, tolerance=7.5)
    start: Array = np.array([br2.BENDING / 2, 0.0, 0.0])
    for name, reported in TABLE_11.items():
        for place, load in enumerate((0, 3, 6, 9)):
            many = visit(policy, whole(load), start, list(curve(name, count)), br2.CONTINUOUS, Changes(br2.LARGEST))
            few = visit(policy, whole(load), start, list(curve(name, max(2, count // 4))), fine, Changes(br2.LARGEST))
            moves = [f"{each.moves.mean():.1f}" for each in (many, few)]
            errors = [spread(each.errors) for each in (many, few)]
            rows.append([f"{name}, {load} g", reported[place] or "–", *errors, *moves])
    head = ["curve, load", "reported", f"{count} waypoints to 1.5 cm", "a quarter of them to 0.75 cm", "moves", "moves"]
    return table("Table 11: error along the waypoints, cm", head, rows)


def _gap(policy: Policy, count: int, seed: int) -> str:
    starts, targets = crossings(count, seed)
    found = follow(policy, whole(0), starts, targets, actions=Changes(br2.LARGEST), rules=br2.CONTINUOUS)
    rows = [["prototype", "100", "4.3"], ["here", percent(found.errors <= 15.0), f"{found.moves.mean():.1f}"]]
    return table(f"Fig. 41: {count} targets beyond the gap, share within 1.5 cm, %", ["", "share", "moves"], rows)
