"""Draws the gallery of the scenes: each as built and as deformed, coloured by the force along its members.

    validation/.venv/bin/python validation/gallery.py PENNATE -o docs/scenes.png

PENNATE is the program, such as target/release/pennate. It writes every scene, solves it, and writes its shapes; what
is drawn is the end of the step named here, or of the first one. The scenes that fail are named, and the exit status is 1.
"""

import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

import view  # before pyvista: it asks for off-screen rendering
import pyvista

# Scene, settings, step that is drawn.
SCENES = [
    ("dyad", ["pressure=20", "chi=26"], "inflate"),
    ("conventional", ["n=2", "m=2", "pressure=20"], "inflate"),
    ("inverted", ["n=3", "m=2", "pressure=20"], "inflate"),
    ("stage", ["beta=32"], "one_high"),
    ("sleeve_stroke", [], "inflate"),
    ("sleeve_compression", [], "inflate"),
    ("spiral", ["cells=1"], "inflate"),
    ("spiral", ["cells=12"], "inflate"),
    ("finger", [], "inflate"),
    ("wheel", ["press=0"], "inflate"),
    ("compliant_gripper", [], "inflate"),
    ("motor", [], "inflate"),
    ("inverter", [], "inflate"),
    ("wire_gripper", [], "inflate"),
    ("morphing", [], "inflate"),
    ("ring_gripper", [], "inflate"),
]
COLUMNS = 4
TILE = (380, 330)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pennate", type=pathlib.Path, help="the program")
    parser.add_argument("-o", "--output", type=pathlib.Path, required=True, help="where the picture goes (.png)")
    arguments = parser.parse_args()

    complaints = view.listen_to_vtk()
    rows = -(-len(SCENES) // COLUMNS)
    size = (TILE[0] * COLUMNS, TILE[1] * rows)
    plotter = pyvista.Plotter(off_screen=True, shape=(rows, COLUMNS), window_size=size, border=False)
    failed = []
    for index, (scene, settings, step) in enumerate(SCENES):
        plotter.subplot(index // COLUMNS, index % COLUMNS)
        title = " ".join([scene, *settings])
        try:
            unloaded, deformed = shapes(arguments.pennate, scene, settings, step)
        except subprocess.CalledProcessError as error:
            failed.append(f"{title}: {error.stderr.strip()}")
            continue
        draw(plotter, unloaded, deformed, title, "N" + " " * index)
    plotter.screenshot(str(arguments.output))
    if complaints or failed:
        sys.exit("\n".join([*failed, *complaints]))


def shapes(pennate, scene, settings, step):
    """The network without load, and at the end of a step."""
    settings = [word for setting in settings for word in ("--set", setting)]
    text = run(pennate, "scene", scene, *settings)
    with tempfile.TemporaryDirectory() as folder:
        network = pathlib.Path(folder, "scene.toml")
        network.write_text(text)
        run(pennate, "solve", network, "-o", folder, "--vtk")
        files = view.files_of(view.find_pvd(pathlib.Path(folder)))
        steps = json.loads(pathlib.Path(folder, "results.json").read_text())["steps"]
        names = [each["name"] for each in steps]
        last = sum(each["increments"] for each in steps[: names.index(step) + 1])
        # The first file is the unloaded network where there is one more than increments.
        offset = len(files) - sum(each["increments"] for each in steps)
        deformed = view.open_both(files[last + offset - 1])
        return deformed.copy(), deformed.warp_by_vector("displacement")


def run(pennate, *arguments):
    command = [str(pennate), *(str(argument) for argument in arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=True).stdout


def draw(plotter, unloaded, deformed, title, bar_title):
    """One tile; bars of equal title would be one bar in all tiles."""
    limits = view.symmetric([deformed])
    plotter.add_text(title, font_size=8)
    for part, rigid in view.split(unloaded):
        if not rigid:
            plotter.add_mesh(view.tube_of(part, rigid), color="lightgray", opacity=0.35, smooth_shading=True)
    for part, rigid in view.split(deformed):
        tubes = view.tube_of(part, rigid)
        if rigid:
            plotter.add_mesh(tubes, color="dimgray", smooth_shading=True)
        else:
            bar = {"title": bar_title, "n_labels": 3, "title_font_size": 12, "label_font_size": 12, "height": 0.06,
                   "position_y": 0.02, "fmt": "%.3g"}
            plotter.add_mesh(tubes, scalars="axial_force", cmap="coolwarm", smooth_shading=True, clim=limits,
                             scalar_bar_args=bar)
    view.look_at(plotter, pyvista.merge([unloaded, deformed], merge_points=False))


if __name__ == "__main__":
    main()
