"""Waypoints: those of Fig. 34 and of Tables 9 to 12."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from .. import br2
from .._arms import Arm, Array
from .._bench import Bench, bench
from .._reach import reach
from . import CM, half, spread, table, whole

# Table 9: pressures of the waypoints, kPa, and with them the distance between a waypoint and the nearest tip that is reported
# with loads (Table 10), cm; only what is farther than 1 cm is reported.
WAYPOINTS = ((48.26, 55.15), (151.68, 0.0), (158.58, 103.42), (124.1, 124.1))
CLOSEST = {(1, 9): "1.65", (1, 12): "2.18", (2, 9): "1.31", (2, 12): "1.65"}
PROTOTYPE_CLOSEST = {
    6: (0.04, 0.81, 0.66, 0.12),
    9: (0.06, 1.50, 1.09, 0.17),
    12: (0.09, 2.20, 1.52, 0.24),
}
# Mean errors: Table 11 (0, 3, 6, 9 g) and Table 12 (open loop; closed at 0 and 9 g), cm.
TABLE_11 = {
    "line": ("0.83 ± 0.30", "0.82 ± 0.22", "0.79 ± 0.34", "0.76 ± 0.42"),
    "circle": ("0.71 ± 0.21", "0.82 ± 0.22", "1.23 ± 0.72", "1.84 ± 2.34"),
    "Viviani": ("0.93 ± 0.57", "1.34 ± 1.04", "1.40 ± 0.95", "1.37 ± 0.89"),
    "Viviani, pressed": ("", "", "", ""),
}
TABLE_12 = {
    "line": ("3.45 ± 1.02", "1.01 ± 0.49", "1.10 ± 0.58"),
    "circle": ("5.77 ± 2.08", "1.21 ± 0.61", "1.13 ± 0.51"),
    "Viviani, pressed": ("4.81 ± 2.23", "1.32 ± 0.97", "1.91 ± 1.47"),
}
PROTOTYPE_12 = {
    "line": ("3.58 ± 0.39", "0.46 ± 0.21", "0.39 ± 0.14"),
    "circle": ("3.50 ± 0.88", "0.20 ± 0.07", "0.21 ± 0.03"),
    "Viviani, pressed": ("3.56 ± 0.85", "0.33 ± 0.18", "0.31 ± 0.10"),
}


def curve(name: str, count: int) -> Array:
    """(count, 3), waypoints in mm. The text prints no coordinates: the curves are assumed, within the shell of tips."""
    share = np.linspace(0.0, 1.0, count)[:, None]
    if name == "line":
        found: Array = CM * np.array([17.0, -6.5, -22.0]) + CM * share * np.array([0.0, 13.0, 0.0])
        return found
    centre, e2, e3 = np.array([17.5, 0.0, -22.0]), np.array([0.0, 1.0, 0.0]), np.array([0.595, 0.0, 0.804])
    if name == "circle":
        angle = 2 * np.pi * share
        found = CM * (centre + 4 * np.cos(angle) * e2 + 4 * np.sin(angle) * e3)
        return found
    normal, radius = np.cross(e2, e3), 2.0
    # Viviani's curve stands out of the shell; pressed onto it, it can nearly be reached.
    out = 0.3 if name.endswith("pressed") else 1.0
    angle = 4 * np.pi * share - 2 * np.pi
    rise = out * radius * (np.cos(angle) - 1) * normal + radius * np.sin(angle) * e3
    found = CM * (centre + 0.5 * normal + rise + 2 * radius * np.sin(angle / 2) * e2)
    return found


def extremal_shares() -> dict[str, list[tuple[float, float]]]:
    """Waypoints of Fig. 34, as shares of the greatest pressures."""
    return {
        "extremal": [(1, 0), (1, 1), (0, 1), (0.5, 1), (0, 0)],
        "lateral sweep": [(0.8, part) for part in (0, 0.25, 0.5, 0.75, 1)],
    }


def extremes() -> str:
    """Fig. 34: corners of the half workspace, and a lateral sweep, measured to 0.1 cm. The pressures are assumed."""
    arm = half(0)
    rows = []
    for name, share in extremal_shares().items():
        found = list(_along(arm, arm.tip(np.array(share) * arm.upper), arm, 1.0))
        worst, moves = max(error for error, _, _ in found) / CM, sum(moves for _, moves, _ in found)
        rows.append([name, "≤ 1.0 each", f"{worst:.2f}", f"{moves}"])
    return table(
        "Fig. 34: five waypoints twice, greatest error, cm",
        ["waypoints", "asked for", "measured", "moves in all"],
        rows,
    )


def loaded_waypoints() -> str:
    """Tables 9 and 10: the nearest tip of the loaded arm to waypoints that are given by pressures of the unloaded one."""
    targets, rows = half(0).tip(np.array(WAYPOINTS)), []
    for load in (0, 6, 9, 12):
        found = reach(half(load), targets, tolerance=0.01, moves=40)
        for place, error in enumerate(found.error / CM):
            reported = CLOSEST.get((place, load), "≤ 1")
            prototype = f"{PROTOTYPE_CLOSEST[load][place]:.2f}" if load else "0.00"
            pressures = ", ".join(f"{value:.1f}" for value in found.inputs[place])
            verdict = "yes" if error <= 1.0 else "no"
            rows.append([f"{place + 1}, {load} g", reported, prototype, f"{error:.2f}", verdict, pressures])
    head = ["waypoint, load", "reported", "prototype", "here", "within 1 cm", "Pb, Pr, kPa"]
    return table("Tables 9 and 10: distance of the closest reachable point, cm", head, rows)


def curves(count: int) -> str:
    """Table 11: each waypoint from where the last one ended, measured, with derivatives of the unloaded arm."""
    rows = []
    for name, reported in TABLE_11.items():
        for place, load in enumerate((0, 3, 6, 9)):
            arm, points = whole(load), curve(name, count)
            coarse = list(_along(arm, points, whole(0), 15.0))
            fine = list(_along(arm, points, whole(0), 1.0))
            closest = reach(arm, points, tolerance=0.01, moves=40).error
            figures = [spread(np.array([error for error, _, _ in found])) for found in (coarse, fine)]
            moves = [f"{np.mean([moves for _, moves, _ in found]):.1f}" for found in (coarse, fine)]
            rows.append([f"{name}, {load} g", reported[place] or "–", *figures, spread(closest), *moves])
    head = [
        "curve, load",
        "reported, DDPG",
        "to 1.5 cm",
        "to 0.1 cm",
        "closest reachable",
        "moves to 1.5 cm",
        "to 0.1 cm",
    ]
    return table(f"Table 11: error along {count} waypoints, measured, cm", head, rows)


def bench_arm(count: int) -> str:
    """Table 12 on the bench arm: inputs found on the model alone, and Gauss-Newton on what is measured, to 0.3 cm."""
    rows = []
    for name, reported in TABLE_12.items():
        points, figures = curve(name, count), []
        planned = np.array([inputs for _, _, inputs in _along(whole(0), points, whole(0), 1.0)])
        for worse in (1.0, 1.5):
            figures.append(spread(np.linalg.norm(fresh(bench(0, worse)).tip(planned) - points, axis=1)))
            for load in (0, 9):
                found = list(_along(fresh(bench(load, worse)), points, whole(0), 3.0))
                figures.append(spread(np.array([error for error, _, _ in found])))
        rows.append(
            [name, *(part for each in zip(reported, PROTOTYPE_12[name], figures) for part in each), *figures[3:]]
        )
    kinds = ("open", "closed, 0 g", "closed, 9 g")
    head = ["curve", *(f"{kind}, {who}" for kind in kinds for who in ("reported", "prototype", "here"))]
    head += [f"worse arm, {kind}" for kind in kinds]
    return table(f"Table 12: error along {count} waypoints on the bench arm, cm", head, rows)


def fresh(arm: Bench) -> Bench:
    """At half the bending pressure, whence its way to the first waypoint begins."""
    arm.tip(np.array([[br2.BENDING / 2, 0.0, 0.0]]))
    return arm


def _along(arm: Arm, points: Array, model: Arm, tolerance: float) -> Iterator[tuple[float, int, Array]]:
    """Error, moves and inputs at each waypoint, from where the last one ended; at first from half of the first input."""
    inputs = np.zeros(len(arm.names))
    inputs[0] = arm.upper[0] / 2
    for point in points:
        found = reach(arm, point, start=inputs, model=model, tolerance=tolerance)
        inputs = found.inputs
        yield float(found.error), int(found.moves), inputs
