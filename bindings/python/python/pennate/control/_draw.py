"""Pictures of an arm and its target."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Literal, cast

import numpy as np
import numpy.typing as npt

from ._arms import Arm, Array

if TYPE_CHECKING:
    from pennate import Network, Solution

Picture = npt.NDArray[np.uint8]

# Pixels along a side of each of the two views, and half the width of a line in them.
SIDE, HALF = 480, 3.0
# Least radius of a tube, as a share of the size of what is drawn.
THINNEST = 0.012
# On white: the network, and its target.
DARK, RED = np.array([55.0, 71.0, 79.0]), np.array([198.0, 40.0, 40.0])


def picture(arm: Arm, inputs: Array, target: Array, painter: str) -> Picture:
    """(480, 960, 3), the network of an arm, solved at (k,) inputs, and its target, from the side and from above."""
    if painter not in ("numpy", "pyvista"):
        raise ValueError(f"painter: 'numpy' or 'pyvista' expected, not {painter!r}")
    network = cast("Network | None", getattr(arm, "network", None))
    if network is None:
        raise ValueError(f"{type(arm).__name__} has no `network` to be drawn")
    solution = network.set(**dict(zip(arm.names, inputs.tolist()))).solve(shapes=True)
    return _tubes(solution, target) if painter == "pyvista" else _lines(solution.drawing(), target)


def _lines(drawing: dict[str, Any], target: Array) -> Picture:
    """Lines of a drawing in two views, x to the right; z is up in the left one and y in the right one."""
    places: Array = drawing["points"] + drawing["point_data"]["displacement"]
    # What has no displacement is drawn as well, so that the frame stands still.
    every = np.concatenate([places, drawing["points"], target[None]])
    reach = float(np.abs(every - places[0]).max()) or 1.0
    views = []
    for up in (2, 1):
        spot = SIDE * (
            0.5 + 0.45 * (np.stack([places[:, 0], -places[:, up]], axis=1) - [places[0, 0], -places[0, up]]) / reach
        )
        goal = SIDE * (0.5 + 0.45 * np.array([target[0] - places[0, 0], places[0, up] - target[up]]) / reach)
        view = np.full((SIDE, SIDE, 3), 255.0)
        for first, second in np.asarray(drawing["lines"]):
            _stroke(view, spot[first], spot[second], HALF, DARK)
        _stroke(view, goal, goal, 3 * HALF, RED)
        views.append(view)
    return np.concatenate(views, axis=1).round().astype(np.uint8)


def _stroke(view: Array, first: Array, second: Array, half: float, colour: Array) -> None:
    """Draws a line with round ends: pixels are covered as far as they are nearer to it than half its width."""
    margin = half + 1.0
    low = np.clip(np.floor(np.minimum(first, second) - margin).astype(int), 0, SIDE)
    high = np.clip(np.ceil(np.maximum(first, second) + margin).astype(int), 0, SIDE)
    x, y = np.meshgrid(np.arange(low[0], high[0]), np.arange(low[1], high[1]))
    along = second - first
    share = ((x - first[0]) * along[0] + (y - first[1]) * along[1]) / max(float(along @ along), 1e-12)
    share = np.clip(share, 0.0, 1.0)
    away = np.hypot(x - first[0] - share * along[0], y - first[1] - share * along[1])
    cover = np.clip(half + 0.5 - away, 0.0, 1.0)[:, :, None]
    part = view[low[1] : high[1], low[0] : high[0]]
    part += cover * (colour - part)


def _tubes(solution: Solution, target: Array) -> Picture:
    """Tubes with the sections of the members, by pyvista off the screen; thin ones are drawn as thick as can be seen."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, shape=(1, 2), window_size=[2 * SIDE, SIDE], border=False)
    drawing = solution.drawing()
    data, lines = drawing["point_data"], np.asarray(drawing["lines"])
    places: Array = drawing["points"] + data["displacement"]
    size = float(np.ptp(np.concatenate([places, drawing["points"], target[None]]), axis=0).max())
    # A section that is given by its stiffness may have no radius to show.
    radius = np.maximum(np.nan_to_num(data["radius"]), THINNEST * size)
    mesh = pyvista.PolyData(places, lines=np.hstack([np.full((len(lines), 1), 2), lines]))
    mesh.point_data["radius"] = radius
    tubes = mesh.tube(scalars="radius", absolute=True)
    looks: tuple[Literal["xz", "xy"], ...] = ("xz", "xy")
    for place, look in enumerate(looks):
        plotter.subplot(0, place)
        plotter.add_mesh(tubes, color="slategray", show_scalar_bar=False)
        plotter.add_mesh(pyvista.Sphere(radius=2 * THINNEST * size, center=target), color="firebrick")
        plotter.camera_position = look
    shot = np.asarray(plotter.screenshot(return_img=True), dtype=np.uint8)
    plotter.close()
    return shot
