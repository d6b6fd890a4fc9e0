"""Pictures of the tests of chapter 4, by matplotlib: `pennate[view]`. Lengths are in cm."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from .. import br2
from .._arms import Arm, Array
from .._bench import bench
from .._judge import setting
from .._policy import follow
from .._reach import reach
from . import CM, drawn, half, whole
from .edges import FARTHEST, OUTSIDE, crossings
from .paths import TABLE_12, WAYPOINTS, curve, extremal_shares, fresh
from .ways import kept, policy_along, reach_along, servo_along

# Of one hue each: what is asked for, the policy, Gauss-Newton, feedback.
ASKED, POLICY, MODEL, BACK = "#37474f", "#c62828", "#1565c0", "#2e7d32"
MIDDLE: Array = np.array([br2.BENDING / 2, 0.0, 0.0])


def trace(name: str, arm: Arm, start: Array, target: Array, tolerance: float | None = None) -> tuple[Array, Array]:
    """Where a kept policy takes one arm: (moves + 1, k) inputs and (moves + 1, 3) tips, mm."""
    _, actions, rules = setting(kept(name).kind)
    inputs, rules = [start], rules if tolerance is None else replace(rules, tolerance=tolerance)
    for moves in range(1, rules.steps + 1):
        found = follow(kept(name), arm, start[None], target[None], actions=actions, rules=replace(rules, steps=moves))
        if found.moves[0] < moves:
            break
        inputs.append(found.inputs[0])
    states = np.array(inputs)
    return states, arm.tip(states)


def waypoints(file: Path, seed: int) -> str:
    """Fig. 34."""
    figure, axes = _axes(2, 2, (9, 7))
    arm = half(0)
    cloud = arm.tip(drawn(arm, np.random.default_rng(seed), 4000)) / CM
    for row, (name, shares) in zip(axes, extremal_shares().items()):
        targets, inputs, tips = arm.tip(np.array(shares) * arm.upper), MIDDLE[:2], []
        for target in targets:
            states, way = trace("dqn", arm, inputs, target)
            inputs = states[-1]
            tips.append(way)
        way = np.concatenate(tips) / CM
        for axis, (first, second, label) in zip(row, ((0, 2, "z"), (0, 1, "y"))):
            axis.plot(cloud[:, first], cloud[:, second], ".", color="#cfd8dc", markersize=1.5)
            axis.plot(way[:, first], way[:, second], "-", color=POLICY, linewidth=1, label="DQN")
            axis.plot(*(targets[:, [first, second]] / CM).T, "o", color=ASKED, markersize=5, label="waypoints")
            _named(axis, "x, cm", f"{label}, cm", f"{name}, {'side' if label == 'z' else 'top'}")
    axes[0][0].legend(loc="lower left")
    return _save(figure, file, "Five extremal waypoints and a lateral sweep, and the way of DQN")


def strides(file: Path, seed: int) -> str:
    """Fig. 35."""
    figure, (left, right) = _axes(1, 2, (9, 3.6))
    arm, rng = half(0), np.random.default_rng(seed)
    starts, ends = drawn(arm, rng, 150), drawn(arm, rng, 150)
    errors, sizes, moves = [], [], []
    for start, target in zip(starts, arm.tip(ends)):
        states, tips = trace("dqn", arm, start, target)
        away = np.linalg.norm(tips - target, axis=1) / CM
        errors += away[:-1].tolist()
        sizes += np.abs(np.diff(states, axis=0) / arm.upper * (np.array(br2.LEVELS) - 1)).max(axis=1).tolist()
        moves += list(range(len(away) - 1))
        left.plot(away, color=POLICY, alpha=0.15, linewidth=0.8)
    edges = np.array([0.0, 2, 4, 6, 9, 12, 16, 40])
    places = np.digitize(errors, edges)
    mean = [np.mean(np.array(sizes)[places == place]) for place in range(1, len(edges)) if (places == place).any()]
    middles = [np.mean(np.array(errors)[places == place]) for place in range(1, len(edges)) if (places == place).any()]
    right.plot(middles, mean, "o-", color=POLICY)
    right.set_ylim(0, 4.2)
    left.axhline(1.0, color=ASKED, linewidth=0.8)
    _named(left, "move", "error, cm", "150 pairs")
    _named(right, "distance of the target, cm", "mean stride, levels", "strides of 1, 2 and 4 levels")
    return _save(figure, file, "Error along the moves of DQN, and its strides far from the target and near it")


def workspaces(file: Path, seed: int) -> str:
    """Figs. 33 and 36, with the waypoints of Table 9."""
    figure, axes = _axes(1, 2, (9, 3.8))
    inputs = drawn(half(0), np.random.default_rng(seed), 4000)
    points = half(0).tip(np.array(WAYPOINTS)) / CM
    for axis, (second, label) in zip(axes, ((2, "z"), (1, "y"))):
        for load, colour in ((0, "#90a4ae"), (12, "#ffab91")):
            tips = half(load).tip(inputs) / CM
            axis.plot(tips[:, 0], tips[:, second], ".", color=colour, markersize=1.5, label=f"{load} g")
        axis.plot(points[:, 0], points[:, second], "o", color=ASKED, markersize=5, label="waypoints")
        _named(axis, "x, cm", f"{label}, cm", "side" if label == "z" else "top")
    axes[0].legend(loc="upper left", fontsize=8, markerscale=2)
    return _save(figure, file, "Half the workspace without load and with 12 g, and the four waypoints")


def curves(file: Path, seed: int) -> str:
    """Figs. 38 and 39."""
    figure, axes = _axes(2, 3, (10, 7))
    for row, load in zip(axes, (0, 9)):
        for axis, name in zip(row, TABLE_12):
            points, arm = curve(name, 60), whole(load)
            axis.plot(
                points[:, 1] / CM, points[:, 2] / CM, "-", color=ASKED, linewidth=3, alpha=0.35, label="asked for"
            )
            for found, colour, label in (
                (policy_along(arm, points, MIDDLE, 7.5), POLICY, "DDPG, to 0.75 cm"),
                (reach_along(arm, points, MIDDLE, 1.0), MODEL, "Gauss–Newton, to 0.1 cm"),
            ):
                tips = arm.tip(found.inputs) / CM
                axis.plot(tips[:, 1], tips[:, 2], ".-", color=colour, linewidth=0.6, markersize=3, label=label)
            axis.set_aspect("equal", adjustable="datalim")
            _named(axis, "y, cm", "z, cm", f"{name}, {load} g")
    axes[0][0].legend(loc="best", fontsize=7)
    return _save(figure, file, "Curves as asked for and as they were followed, seen along x, without load and with 9 g")


def beyond(file: Path, seed: int) -> str:
    """Fig. 40."""
    figure, (axis,) = _axes(1, 1, (5.5, 4))
    arm, rng = whole(0), np.random.default_rng(seed)
    tips = arm.tip(drawn(arm, rng, 400))
    by = rng.uniform(0.0, FARTHEST, len(tips))
    targets = tips * (1 + by / np.linalg.norm(tips, axis=1))[:, None]
    closest = reach(arm, targets, tolerance=0.01, moves=60, restarts=32).error
    chosen = np.flatnonzero(closest > OUTSIDE)[:200]
    _, actions, rules = setting("continuous")
    policy = follow(kept("ddpg"), arm, drawn(arm, rng, len(chosen)), targets[chosen], actions=actions, rules=rules)
    axis.plot(
        by[chosen] / CM, (policy.closest - closest[chosen]) / CM, ".", color=POLICY, label="DDPG, closest of the run"
    )
    axis.plot([0, 8], [0, 8], "-", color=ASKED, linewidth=0.8, label="as large as the perturbation")
    axis.legend(loc="upper left", fontsize=8)
    _named(axis, "perturbation, cm", "error beyond the closest reachable point, cm", "")
    return _save(figure, file, "200 targets out of reach: error over perturbation")


def gap(file: Path, seed: int) -> str:
    """Fig. 41."""
    figure, (axis,) = _axes(1, 1, (5.5, 5.5))
    arm = whole(0)
    cloud = arm.tip(drawn(arm, np.random.default_rng(seed), 6000)) / CM
    axis.plot(cloud[:, 0], cloud[:, 1], ".", color="#cfd8dc", markersize=1.5)
    starts, targets = crossings(3, seed)
    for start, target, colour in zip(starts, targets, (POLICY, MODEL, BACK)):
        states, ends = trace("ddpg", arm, start, target)
        # Inputs go straight from one to the next, and the tip with them.
        between = np.concatenate([np.linspace(a, b, 15) for a, b in zip(states, states[1:])])
        way = arm.tip(between) / CM
        axis.plot(way[:, 0], way[:, 1], "-", color=colour, linewidth=1.2)
        axis.plot(ends[:, 0] / CM, ends[:, 1] / CM, "o", color=colour, markersize=4)
        axis.plot(target[0] / CM, target[1] / CM, "x", color=colour, markersize=9, markeredgewidth=2)
    axis.set_aspect("equal")
    _named(axis, "x, cm", "y, cm", "")
    return _save(
        figure,
        file,
        "Three ways of DDPG from one side of the gap behind the arm to the other, from above; × are targets",
    )


def loops(file: Path, seed: int) -> str:
    """Fig. 43."""
    figure, axes = _axes(1, 3, (10, 3.8))
    for axis, name in zip(axes, TABLE_12):
        points, arm = curve(name, 30), bench(0)
        planned = reach_along(whole(0), points, MIDDLE, 1.0).inputs
        axis.plot(points[:, 1] / CM, points[:, 2] / CM, "-", color=ASKED, linewidth=3, alpha=0.35, label="asked for")
        opened = fresh(arm).tip(planned) / CM
        axis.plot(opened[:, 1], opened[:, 2], ".-", color="#ef6c00", linewidth=0.6, markersize=3, label="open loop")
        for run, colour, label, tolerance in (
            (policy_along, POLICY, "DDPG", 15.0),
            (servo_along, BACK, "feedback", 3.0),
        ):
            way = run(fresh(bench(0)), points, MIDDLE, tolerance).tips / CM
            axis.plot(way[:, 1], way[:, 2], ".-", color=colour, linewidth=0.6, markersize=3, label=label)
        axis.set_aspect("equal", adjustable="datalim")
        _named(axis, "y, cm", "z, cm", name)
    axes[0].legend(loc="best", fontsize=7)
    return _save(figure, file, "The bench arm, seen along x: inputs of the model played to it, and closed loops")


def _axes(rows: int, columns: int, size: tuple[float, float]) -> tuple[Any, Any]:
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(rows, columns, figsize=size, squeeze=False, layout="constrained")
    return figure, axes if rows > 1 else axes[0]


def _named(axis: Any, x: str, y: str, title: str) -> None:
    axis.set_xlabel(x)
    axis.set_ylabel(y)
    axis.set_title(title, fontsize=10)


def _save(figure: Any, file: Path, caption: str) -> str:
    from matplotlib import pyplot

    figure.savefig(file, dpi=110)
    pyplot.close(figure)
    return caption
