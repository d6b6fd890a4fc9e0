"""Checks the pictures that `pennate solve -o DIR --vtk` wrote, and draws them.

validation/view.sh DIR_OR_PVD                    reads every file with pyvista and meshio, and compares
validation/view.sh DIR_OR_PVD -o PICTURE.png     and draws the ends of the steps
"""

from __future__ import annotations

import argparse
import dataclasses
import pathlib
import sys

from . import check, colours, figure, results, states, view


def main() -> None:
    """The command line."""
    arguments = parser().parse_args()
    complaints = check.listen_to_vtk()
    try:
        files = results.list_files(results.find_pvd(arguments.source))
        points = sum(check.open_both(file) for file in files)
        if arguments.output:
            run = results.read(arguments.source)
            direction = view.view_named(arguments.view or ("xy" if run.plane else "space"))
            options = options_of(arguments, run)
            figure.draw(states.make_sheet(run, options, direction), options, arguments.output)
    except results.PictureError as error:
        sys.exit(f"error: {error}")
    if complaints:
        sys.exit("VTK complains:\n" + "\n".join(complaints))
    print(f"opened {len(files)} files, {points} points")


def parser() -> argparse.ArgumentParser:
    """What the command line understands."""
    found = argparse.ArgumentParser(prog="view.sh", description=(__doc__ or "").splitlines()[0])
    add = found.add_argument
    add("source", type=pathlib.Path, help="a .pvd file or the directory that holds one")
    add("-o", "--output", type=pathlib.Path, help="where the picture goes (.png)")
    add("--field", default="axial_force", help="what the colours show: axial_force, bending_moment_3, displacement, …")
    add("--steps", help="steps to draw, separated by commas; 'unloaded' is the network as built")
    add("--view", help="xy, xz, yz, space, or azimuth and elevation in degrees, '--view=-60,20'")
    add("--names", choices=("auto", "all", "none"), default="auto", help="names of nodes and members")
    add("--no-ghost", action="store_true", help="without the unloaded shape behind")
    add("--dark", action="store_true", help="for a dark background")
    add("--transparent", action="store_true", help="without a background")
    add("--width", type=float, default=170.0, help="greatest width on paper, mm")
    add("--resolution", type=int, default=200, help="pixels per inch")
    return found


def options_of(arguments: argparse.Namespace, run: results.Run) -> states.Options:
    """What was asked for."""
    options = states.Options(
        theme=colours.DARK if arguments.dark else colours.LIGHT,
        transparent=arguments.transparent,
        field=arguments.field,
        width=arguments.width,
        resolution=arguments.resolution,
        ghost=not arguments.no_ghost,
        names=arguments.names,
    )
    if arguments.steps:
        names = [name.strip() for name in arguments.steps.split(",")]
        steps = tuple(None if name == "unloaded" else run.step_named(name) for name in names)
        options = dataclasses.replace(options, steps=steps)
    return options


if __name__ == "__main__":
    main()
