"""pyvista meshes of states."""

from __future__ import annotations

from typing import Any

import numpy as np
import pyvista


def tubes(drawing: dict[str, Any], sides: int) -> pyvista.PolyData:
    """Tubes of a drawing: members in their deformed places with the radii of their sections.

    Arrays of lines (`axial_force`, `bending_moment_3`, …) are arrays of cells, those of points arrays of points.
    """
    if sides < 3:
        raise ValueError(f"sides: a tube has at least 3, not {sides}")
    points, lines = drawing["points"], drawing["lines"]
    lines = lines[drawing["cell_data"]["member_id"] >= 0]
    data = drawing["point_data"]
    places = points + data["displacement"]
    turns = np.linspace(0.0, 2.0 * np.pi, sides, endpoint=False)
    second, third, radius = data["frame_e2"], data["frame_e3"], data["radius"]
    around = second[:, None] * np.cos(turns)[:, None] + third[:, None] * np.sin(turns)[:, None]
    rings = places[:, None] + radius[:, None, None] * around
    side, other = np.arange(sides), (np.arange(sides) + 1) % sides
    start, end = lines[:, :1] * sides, lines[:, 1:] * sides
    faces = np.stack([start + side, start + other, end + other, end + side], axis=2).reshape(-1, 4)
    faces = np.hstack([np.full((len(faces), 1), 4), faces])
    # Nodes have a place of their own and no tube.
    used = np.unique(lines)
    place = np.full(len(points), -1)
    place[used] = np.arange(len(used))
    faces[:, 1:] = place[faces[:, 1:] // sides] * sides + faces[:, 1:] % sides
    if not len(used):
        return pyvista.PolyData()
    mesh = pyvista.PolyData(rings[used].reshape(-1, 3), faces=faces.ravel())
    mesh.point_data["Normals"] = around[used].reshape(-1, 3)
    for name, values in data.items():
        mesh.point_data[name] = np.repeat(values[used], sides, axis=0)
    members = drawing["cell_data"]["member_id"] >= 0
    for name, values in drawing["cell_data"].items():
        mesh.cell_data[name] = np.repeat(values[members], sides, axis=0)
    mesh.set_active_scalars("axial_force", preference="cell")
    return mesh
