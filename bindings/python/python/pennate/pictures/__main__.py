"""`pennate plot`: from a network file, or a folder of results, to a picture."""

from __future__ import annotations

import argparse
import pathlib
import sys
from collections.abc import Sequence
from typing import Any

from .._settings import setting

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
        print(f"error: {error}\nhelp: pip install 'pennate[view]' installs what draws", file=sys.stderr)
        return 1
    from .._errors import Error

    try:
        return draw(parsed)
    except (PictureError, Error, OSError) as error:
        text = str(error)
        print(text if text.startswith("error") else f"error: {text}", file=sys.stderr)
        return 2


def draw(parsed: argparse.Namespace) -> int:
    """Solves or reads, and draws."""
    from . import PictureError, api, figure, film, results, states

    wishes: dict[str, Any] = {
        "field": parsed.field,
        "dark": parsed.dark,
        "transparent": parsed.transparent,
        "ghost": not parsed.no_ghost,
    }
    steps = [name.strip() for name in parsed.steps.split(",")] if parsed.steps else []
    wishes |= {name: getattr(parsed, name) for name in ("names", "width", "resolution") if getattr(parsed, name)}
    moving = parsed.output.suffix.lower() in (".gif", ".mp4")
    if not moving and parsed.output.suffix.lower() != ".png":
        raise PictureError(f"{parsed.output}: a .png, or a film as .gif or .mp4")
    solution = None
    if parsed.source.suffix.lower() in (".toml", ".json") and not parsed.source.is_dir():
        solution = solve(parsed)
        if moving:
            api.animate(solution, parsed.output, view=parsed.view, **wishes)
        else:
            api.plot(solution, *steps, output=parsed.output, view=parsed.view, **wishes)
        return 0 if solution.status == "converged" else 1
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


def solve(parsed: argparse.Namespace) -> Any:
    """The solution of a network file; what is remarkable is printed."""
    from .. import load

    network = load(parsed.source).set(**dict(parsed.settings))
    solution = network.solve(accuracy=parsed.accuracy)
    for finding in (*solution.warnings, *solution.failures):
        print(finding, file=sys.stderr)
    return solution


def parser() -> argparse.ArgumentParser:
    """What the command line understands."""
    found = argparse.ArgumentParser(
        prog="pennate plot",
        description=(__doc__ or "").split(": ", 1)[1],
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = found.add_argument
    add("source", type=pathlib.Path, help="a network file, or a folder of results with its .pvd file")
    add("-o", "--output", type=pathlib.Path, required=True, help="the picture: .png, or a film as .gif or .mp4")
    add("--set", dest="settings", type=setting, action="append", default=[], metavar="NAME=VALUE", help="a parameter")
    add("--accuracy", type=float, default=1e-6, help="discretization error asked for")
    add("--field", default="axial_force", help="what the colours show: axial_force, bending_moment_3, displacement, …")
    add("--steps", help="steps to draw, separated by commas; 'unloaded' is the network as built")
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
