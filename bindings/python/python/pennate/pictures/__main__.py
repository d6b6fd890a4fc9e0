"""`pennate plot`: from a network file, or a folder of results, to a picture."""

from __future__ import annotations

import argparse
import pathlib
import sys
from collections.abc import Sequence
from typing import Any

from .. import _commands

EXAMPLES = """examples:
  pennate plot dyad.toml -o dyad.png
  pennate plot dyad.toml --set beta=30 --steps inflate --field curvature -o bent.png
  pennate plot dyad.toml -o dyad.gif
  pennate solve dyad.toml -o out --vtk; pennate plot out -o dyad.png
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line; returns the exit status."""
    parsed = parser().parse_args(arguments)
    try:
        from . import PictureError
    except ImportError as error:
        return _commands.missing(error, "draws")
    from .._errors import Error

    try:
        return draw(parsed)
    except (PictureError, Error, OSError, ValueError) as error:
        return _commands.wrong(error)


def draw(parsed: argparse.Namespace) -> int:
    """Solves or reads, and draws."""
    from . import PictureError, api, figure, film, results, states

    wishes: dict[str, Any] = {
        "field": parsed.field,
        "dark": parsed.dark,
        "transparent": parsed.transparent,
        "ghost": not parsed.no_ghost,
    }
    _commands.check_output(parsed)
    steps = [name.strip() for name in parsed.steps.split(",")] if parsed.steps else []
    given = {name: getattr(parsed, name) for name in ("names", "width", "resolution")}
    wishes |= {name: value for name, value in given.items() if value is not None}
    moving = parsed.output.suffix.lower() in (".gif", ".mp4")
    if not moving and parsed.output.suffix.lower() != ".png":
        raise PictureError(f"{parsed.output}: a .png, or a film as .gif or .mp4")
    if moving and steps:
        raise PictureError(f"steps: a film goes through all of them; a .png shows the ends of {parsed.steps}")
    solution = None
    if parsed.source.suffix.lower() in (".toml", ".json") and not parsed.source.is_dir():
        solution = _commands.solution(parsed)
        if moving:
            api.animate(solution, parsed.output, view=parsed.view, **wishes)
        else:
            api.plot(solution, *steps, output=parsed.output, view=parsed.view, **wishes)
        return _commands.status(solution)
    if parsed.settings:
        raise PictureError("parameters are set in a network file, and these are results")
    run = results.read(parsed.source)
    direction = api.direction(run, parsed.view)
    options = api.options(run, steps, **(film.LOOKS | wishes if moving else wishes))
    if moving:
        film.draw(run, options, direction, parsed.output, 1.5)
    else:
        figure.draw(states.make_sheet(run, options, direction), options, parsed.output)
    return 0


def parser() -> argparse.ArgumentParser:
    """What the command line understands."""
    description = (__doc__ or "").split(": ", 1)[1]
    source = "a network file, or a folder of results with its .pvd file"
    found = _commands.parser("plot", description, EXAMPLES, source)
    add = found.add_argument
    add("-o", "--output", type=pathlib.Path, required=True, help="the picture: .png, or a film as .gif or .mp4")
    add("--field", default="axial_force", help="what the colours show: axial_force, bending_moment_3, displacement, …")
    add("--steps", help="steps to draw, separated by commas, not of a film; 'unloaded' is the network as built")
    add("--view", help="xy, xz, yz, space, or azimuth and elevation in degrees, '--view=-60,20'")
    add("--names", choices=("auto", "all", "none"), help="names of nodes and members")
    add("--no-ghost", action="store_true", help="without the unloaded shape behind")
    add("--dark", action="store_true", help="for a dark background")
    add("--transparent", action="store_true", help="without a background")
    add("--width", type=float, help="greatest width on paper, mm; 170, of a film 140")
    add("--resolution", type=int, help="pixels an inch; 200, of a film 90")
    return found


if __name__ == "__main__":
    sys.exit(main())
