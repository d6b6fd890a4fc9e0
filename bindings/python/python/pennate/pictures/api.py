"""Pictures and films of solutions, in one call each."""

from __future__ import annotations

import dataclasses
import io
import os
import pathlib
from collections.abc import Sequence
from typing import TYPE_CHECKING

from .._network import Network
from .._solution import _place
from . import colours, figure, film, paper, results, states, view

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .._solution import Solution

# Pixels an inch of what a notebook shows, and its width in millimetres.
NOTEBOOK = 110
NARROW = 150.0


def options(
    run: results.Run,
    steps: Sequence[str | int] = (),
    *,
    field: str = "axial_force",
    dark: bool = False,
    transparent: bool = False,
    ghost: bool = True,
    names: str = "auto",
    width: float = 170.0,
    resolution: int = 200,
) -> states.Options:
    """What a picture shows, and how.

    Args:
        run: What is drawn.
        steps: Names or numbers of the steps whose ends are drawn; `"unloaded"` is the network as built.
        field: What the colours show: `axial_force`, `bending_moment_3`, `displacement`, …
        dark: For a dark background.
        transparent: Without a background.
        ghost: With the unloaded shape behind.
        names: Of nodes and members: `"auto"`, `"all"` or `"none"`.
        width: Greatest width on paper, mm.
        resolution: Pixels an inch.
    """
    if names not in ("auto", "all", "none"):
        raise results.PictureError(f"names: 'auto', 'all' or 'none' expected, not {names!r}")
    if not 0 < width < 5000:
        raise results.PictureError(f"width: more than 0 and less than 5000 mm expected, not {width:g}")
    if not 10 <= resolution <= 2000:
        raise results.PictureError(f"resolution: 10 to 2000 pixels an inch expected, not {resolution:g}")
    place = {name: index for index, name in enumerate(step.name for step in run.steps)}

    def chosen(step: str | int) -> int | None:
        if step == "unloaded" and step not in place:
            return None
        return run.step_named(step) if isinstance(step, str) else _place(step, tuple(place), "step")

    return states.Options(
        theme=colours.DARK if dark else colours.LIGHT,
        transparent=transparent,
        field=field,
        steps=tuple(chosen(step) for step in steps),
        width=width,
        resolution=resolution,
        ghost=ghost,
        names=names,
    )


def direction(run: results.Run, name: str | None) -> view.View:
    """A direction of view by its name, or the usual one."""
    return view.view_named(name or ("xy" if run.plane else "space"))


def plot(
    solution: Solution,
    *steps: str | int,
    output: str | os.PathLike[str] | None = None,
    view: str | None = None,
    **wishes: object,
) -> Figure | None:
    """Draws the ends of some steps, all by default.

    Args:
        solution: Solved with shapes, as it is by default.
        steps: Names or numbers; `"unloaded"` is the network as built.
        output: A `.png` file; a matplotlib figure is returned without one.
        view: `xy`, `xz`, `yz`, `space`, or azimuth and elevation in degrees, `"-60,20"`.
        wishes: See `options`.
    """
    if output is not None and pathlib.Path(output).suffix.lower() != ".png":
        raise results.PictureError(f"{os.fspath(output)}: a picture is a .png, and a film, by animate(), a .gif or .mp4")
    run = results.of(solution)
    wanted = options(run, steps, **wishes)  # type: ignore[arg-type]
    sheet = states.make_sheet(run, wanted, direction(run, view))
    if output is None:
        return figure.make(sheet, wanted)
    figure.draw(sheet, wanted, pathlib.Path(output))
    return None


def animate(
    solution: Solution,
    output: str | os.PathLike[str],
    *,
    view: str | None = None,
    frames: int = 24,
    seconds: float = 1.5,
    resolution: int = 90,
    width: float = 140.0,
    names: str = "none",
    **wishes: object,
) -> None:
    """Draws the way through all steps as a film.

    The network is solved once more with at least so many increments a step, so that every frame is an equilibrium. Steps that
    would end in another state then keep their own increments.

    Args:
        solution: Solved with shapes, as it is by default.
        output: A `.gif` or `.mp4` file.
        view: As in `plot`.
        frames: Of each step.
        seconds: That each step takes.
        resolution: Pixels an inch.
        width: On paper, mm.
        names: As in `options`.
        wishes: See `options`.
    """
    target = pathlib.Path(output)
    film.check(target)
    run = results.of(film.finer(solution, frames))
    wanted = options(run, (), resolution=resolution, width=width, names=names, **wishes)  # type: ignore[arg-type]
    film.draw(run, wanted, direction(run, view), target, seconds)


def png(drawn: Solution | Network) -> bytes:
    """The picture that a notebook shows: the ends of steps, or a network as it is built."""
    run = results.of_network(drawn) if isinstance(drawn, Network) else results.of(drawn)
    wanted = dataclasses.replace(options(run), resolution=NOTEBOOK, width=NARROW)
    made = figure.make(states.make_sheet(run, wanted, direction(run, None)), wanted)
    buffer = io.BytesIO()
    paper.save(made, buffer, wanted.transparent)
    return buffer.getvalue()
