"""Opens the `.vtu` files of a folder with pyvista and with meshio, and compares what the two read.

    validation/.venv/bin/python validation/check_vtu.py DIR_OR_PVD
"""

from __future__ import annotations

import pathlib
import sys
import warnings
from typing import Any

from pennate.pictures import PictureError, results

import meshio
import numpy as np
import pyvista
import vtk

POINT_DATA = {
    "displacement": 3,
    "rotation": 3,
    "reaction_force": 3,
    "reaction_moment": 3,
    "load_force": 3,
    "load_moment": 3,
    "radius": 1,
    "frame_e1": 3,
    "frame_e2": 3,
    "frame_e3": 3,
    "held": 1,
    "held_x": 3,
    "held_y": 3,
    "released": 1,
}
CELL_DATA = {
    "axial_force": 1,
    "shear_force_2": 1,
    "shear_force_3": 1,
    "torque": 1,
    "bending_moment_2": 1,
    "bending_moment_3": 1,
    "strain_axial": 1,
    "strain_induced": 1,
    "curvature": 1,
    "pressure": 1,
    "load_distributed": 3,
    "member_id": 1,
    "kind": 1,
}


def listen_to_vtk() -> list[str]:
    """VTK writes its warnings to a window of its own and goes on; here they are collected."""
    complaints: list[str] = []
    window = vtk.vtkOutputWindow()
    for event in ("WarningEvent", "ErrorEvent"):

        def note(caller: Any, event: str, text: str) -> None:
            complaints.append(text.strip())

        note.CallDataType = vtk.VTK_STRING  # type: ignore[attr-defined]
        window.AddObserver(event, note)
    vtk.vtkOutputWindow.SetInstance(window)
    return complaints


def open_both(path: pathlib.Path) -> int:
    """Reads one file with both readers, warnings as errors, and compares what they found; returns its points."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        mesh, other = pyvista.read(str(path)), meshio.read(str(path))
    cells = {name: np.concatenate(parts) for name, parts in other.cell_data.items()}
    for name, components in POINT_DATA.items():
        compare(path, name, mesh.point_data, other.point_data, mesh.n_points, components)
    for name, components in CELL_DATA.items():
        compare(path, name, mesh.cell_data, cells, mesh.n_cells, components)
    if {block.type for block in other.cells} != {"line"}:
        raise PictureError(f"{path}: cells other than lines")
    if not all(np.issubdtype(block.data.dtype, np.integer) for block in other.cells):
        raise PictureError(f"{path}: meshio reads indices that are not integers")
    check_frames(path, mesh)
    return int(mesh.n_points)


def compare(path: pathlib.Path, name: str, ours: Any, theirs: Any, count: int, components: int) -> None:
    """One array, as both readers have it."""
    shape = (count,) if components == 1 else (count, components)
    if name not in ours or name not in theirs:
        raise PictureError(f"{path}: no array '{name}'")
    if ours[name].shape != shape or not np.array_equal(ours[name], theirs[name]):
        raise PictureError(f"{path}: array '{name}' is read differently by pyvista and meshio")
    if not np.isfinite(ours[name]).all():
        raise PictureError(f"{path}: array '{name}' holds numbers that are not finite")


def check_frames(path: pathlib.Path, mesh: Any) -> None:
    """The axes of the sections are orthonormal wherever there are any."""
    frames = np.stack([mesh.point_data[f"frame_e{axis}"] for axis in (1, 2, 3)], axis=1)
    used = np.linalg.norm(frames, axis=(1, 2)) > 0
    product = frames[used] @ frames[used].transpose(0, 2, 1)
    if not np.allclose(product, np.eye(3), atol=1e-10):
        raise PictureError(f"{path}: frames are not orthonormal")


def main() -> None:
    """The command line."""
    if len(sys.argv) != 2:
        sys.exit((__doc__ or "").strip())
    complaints = listen_to_vtk()
    try:
        files = results.list_files(results.find_pvd(pathlib.Path(sys.argv[1])))
        points = sum(open_both(file) for file in files)
    except PictureError as error:
        sys.exit(f"error: {error}")
    if complaints:
        sys.exit("VTK complains:\n" + "\n".join(complaints))
    print(f"opened {len(files)} files, {points} points")


if __name__ == "__main__":
    main()
