"""Opens the pictures that `pennate solve --vtk` wrote, checks them, and draws them.

    validation/.venv/bin/python validation/view.py DIR_OR_PVD -o PICTURE.png

Every file is read by pyvista and by meshio, with warnings as errors. The picture shows the network without
load and, beside it, some of its states up to the last one as tubes of the true radius, coloured by the axial force.
"""

import argparse
import os
import pathlib
import sys
import warnings

# Without a display VTK tries X first and complains; this asks for off-screen rendering at once.
if not os.environ.get("DISPLAY"):
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

warnings.simplefilter("error")
import meshio  # noqa: E402
import numpy as np  # noqa: E402
import pyvista  # noqa: E402
import vtk  # noqa: E402

POINT_DATA = {
    "displacement": 3, "rotation": 3, "reaction_force": 3, "reaction_moment": 3, "load_force": 3,
    "load_moment": 3, "radius": 1,
    "frame_e1": 3, "frame_e2": 3, "frame_e3": 3,
}
CELL_DATA = [
    "axial_force", "shear_force_2", "shear_force_3", "torque", "bending_moment_2", "bending_moment_3",
    "strain_axial", "strain_induced", "curvature", "pressure", "member_id", "kind",
]
RIGID = 2


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("source", type=pathlib.Path, help="a .pvd file or the directory that holds one")
    parser.add_argument("-o", "--output", type=pathlib.Path, help="where the picture goes (.png)")
    arguments = parser.parse_args()

    complaints = listen_to_vtk()
    meshes = [open_both(path) for path in files_of(find_pvd(arguments.source))]
    if arguments.output:
        draw(meshes, arguments.output)
    if complaints:
        sys.exit("VTK complains:\n" + "\n".join(complaints))
    print(f"opened {len(meshes)} files, {sum(mesh.n_points for mesh in meshes)} points")


def listen_to_vtk():
    """VTK writes its warnings to a window of its own and goes on; here they are collected."""
    complaints = []
    window = vtk.vtkOutputWindow()
    for event in ("WarningEvent", "ErrorEvent"):
        def note(caller, event, text):
            complaints.append(text.strip())
        note.CallDataType = vtk.VTK_STRING
        window.AddObserver(event, note)
    vtk.vtkOutputWindow.SetInstance(window)
    return complaints


def find_pvd(source):
    if source.is_file():
        return source
    found = sorted(source.glob("*.pvd"))
    if len(found) != 1:
        sys.exit(f"{source}: one .pvd file expected, {len(found)} found")
    return found[0]


def files_of(pvd):
    reader = pyvista.get_reader(str(pvd))
    if not reader.datasets:
        sys.exit(f"{pvd}: no data sets")
    if any(later <= sooner for sooner, later in zip(reader.time_values, reader.time_values[1:])):
        sys.exit(f"{pvd}: times do not increase: {reader.time_values}")
    return [pvd.parent / data.path for data in reader.datasets]


def open_both(path):
    """Reads one file with both readers and compares what they found."""
    mesh, other = pyvista.read(str(path)), meshio.read(str(path))
    for name, components in POINT_DATA.items():
        shape = (mesh.n_points,) if components == 1 else (mesh.n_points, components)
        compare(path, name, mesh.point_data, other.point_data, shape)
    cells = {name: np.concatenate(parts) for name, parts in other.cell_data.items()}
    for name in CELL_DATA:
        compare(path, name, mesh.cell_data, cells, (mesh.n_cells,))
    if {block.type for block in other.cells} != {"line"}:
        sys.exit(f"{path}: cells other than lines")
    if not all(np.issubdtype(block.data.dtype, np.integer) for block in other.cells):
        sys.exit(f"{path}: meshio reads indices that are not integers")
    check_frames(path, mesh)
    return mesh


def compare(path, name, ours, theirs, shape):
    if name not in ours or name not in theirs:
        sys.exit(f"{path}: no array '{name}'")
    if ours[name].shape != shape or not np.array_equal(ours[name], theirs[name]):
        sys.exit(f"{path}: array '{name}' is read differently by pyvista and meshio")
    if not np.isfinite(ours[name]).all():
        sys.exit(f"{path}: array '{name}' holds numbers that are not finite")


def check_frames(path, mesh):
    frames = np.stack([mesh.point_data[f"frame_e{axis}"] for axis in (1, 2, 3)], axis=1)
    used = np.linalg.norm(frames, axis=(1, 2)) > 0
    product = frames[used] @ frames[used].transpose(0, 2, 1)
    if not np.allclose(product, np.eye(3), atol=1e-10):
        sys.exit(f"{path}: frames are not orthonormal")


def draw(meshes, output):
    """One view of the unloaded network and of up to three states, spread over the increments, the last one included."""
    unloaded, meshes = meshes[0], meshes[1:]
    count = min(len(meshes), 3)
    chosen = [len(meshes) * (place + 1) // count - 1 for place in range(count)]
    states = [(unloaded, "unloaded")]
    states += [(meshes[i].warp_by_vector("displacement"), f"increment {i + 1} of {len(meshes)}") for i in chosen]
    scene = pyvista.merge([state for state, _ in states], merge_points=False)
    limits = symmetric([meshes[i] for i in chosen])
    plotter = pyvista.Plotter(off_screen=True, shape=(1, len(states)), window_size=(640 * len(states), 480), border=False)
    for column, (state, title) in enumerate(states):
        plotter.subplot(0, column)
        plotter.add_text(title, font_size=10)
        for part, rigid in split(state):
            tubes = tube_of(part, rigid)
            if rigid or column == 0:
                plotter.add_mesh(tubes, color="dimgray" if rigid else "lightsteelblue", smooth_shading=True)
            else:
                plotter.add_mesh(tubes, scalars="axial_force", cmap="coolwarm", smooth_shading=True, clim=limits,
                                 show_scalar_bar=column == count,
                                 scalar_bar_args={"title": "axial force", "n_labels": 3})
        look_at(plotter, scene)
    plotter.screenshot(str(output))


def split(mesh):
    kinds = mesh.cell_data["kind"]
    for rigid in (False, True):
        chosen = np.flatnonzero((kinds == RIGID) == rigid)
        if chosen.size:
            yield mesh.extract_cells(chosen), rigid


def tube_of(mesh, rigid):
    """Tubes along the members with the radius that the file names; thin ones for rigid bodies."""
    lines = pyvista.PolyData(mesh.points, lines=mesh.cells)
    lines.cell_data["axial_force"] = mesh.cell_data["axial_force"]
    lines = lines.cell_data_to_point_data()
    lines.point_data["radius"] = mesh.point_data["radius"]
    lines = lines.strip(join=True)
    if rigid:
        return lines.tube(radius=0.3 * mesh.point_data["radius"].min(), n_sides=24)
    return lines.tube(scalars="radius", absolute=True, n_sides=24)


def symmetric(meshes):
    largest = max([1e-12, *(float(np.abs(mesh.cell_data["axial_force"]).max()) for mesh in meshes)])
    return [-largest, largest]


def look_at(plotter, scene):
    """Straight down on a plane network, at an angle on one in space; all views in the same frame."""
    extent = np.ptp(scene.points, axis=0)
    if extent[2] < 1e-9 * max(extent.max(), 1e-300):
        plotter.view_xy(bounds=scene.bounds)
    else:
        plotter.view_isometric(bounds=scene.bounds)


if __name__ == "__main__":
    main()
