"""Names of nodes, members and loads: which there are, and where they stand."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.patheffects import withStroke

from . import render, symbols
from .colours import Theme
from .labels import Mask, Wish, place_all
from .paper import POINTS, TEXT, pixels_of, plain
from .results import Run, Step
from .scene import unit
from .states import Options, Panel, Sheet, largest_force

# What marks the image of the unloaded shape, on which names may stand.
GHOST = "ghost"
# Names are drawn of networks of no more nodes and members than these: of more they would be a thicket.
NAMED_NODES, NAMED_MEMBERS = 12, 10
# Where along a member its name may stand, the best place first.
NAME_PLACES = (0.5, 0.4, 0.6, 0.3, 0.7, 0.2, 0.8)


STYLES: dict[str, dict[str, Any]] = {
    "node": {"size": TEXT, "weight": "bold"},
    "member": {"size": TEXT, "style": "italic"},
    "load": {"size": TEXT, "weight": "bold"},
}


def names_of(
    figure: Figure, sheet: Sheet, boxes: list[tuple[Axes, Panel, render.Taken]], scale: float, options: Options
) -> None:
    """Loads with their values in all panels, names of nodes and members in the first."""
    run, largest = sheet.run, largest_force(sheet.panels)
    wishes: list[tuple[Axes, list[tuple[symbols.Note, str, bool]]]] = []
    for place, (axes, panel, taken) in enumerate(boxes):
        pen = symbols.Pen(axes, sheet.view, options.theme, 1.0 / scale)
        step = run.steps[panel.state.step] if panel.state.step is not None else None
        loads = symbols.draw_loads(pen, panel.scene, run, largest, noise_of(run, step))
        texts = [(note, "load", True) for note in loads]
        if place == 0:
            texts += [(note, style, False) for note, style in names(sheet, panel, taken, options)]
        wishes.append((axes, texts))
    # What is drawn so far is where no name may stand; on the unloaded shape it may, rather than far away.
    with_ghost = inked(figure, options.theme)
    for axes, _ in wishes:
        for image in axes.images:
            image.set_visible(image.get_gid() != GHOST)
    covered = inked(figure, options.theme)
    for axes, texts in wishes:
        for image in axes.images:
            image.set_visible(True)
        set_texts(figure, axes, texts, covered, with_ghost, options.theme)


def noise_of(run: Run, step: Step | None) -> symbols.Noise:
    """What is rounding and mesh alone at the end of a step."""
    if step is None:
        return symbols.Noise()
    known = {kind: digits for kind, digits in step.digits.items() if digits is not None}
    found = {
        kind: step.largest[kind] * max(10.0 ** -known[kind], run.mesh_error)
        for kind in ("force", "moment")
        if kind in known
    }
    return symbols.Noise(**found)


def inked(figure: Figure, theme: Theme) -> Mask:
    """Where something is drawn; the first row is the lowest."""
    canvas = pixels_of(figure)[::-1, :, :3].astype(int)
    paper = (255 * np.array(to_rgb(theme.paper))).round().astype(int)
    # A change of colour that no eye sees does not count.
    return np.asarray(np.abs(canvas - paper).max(axis=2) > 6)


def names(sheet: Sheet, panel: Panel, taken: render.Taken, options: Options) -> list[tuple[symbols.Note, str]]:
    """Names of the nodes and members that are seen, with where they would stand best."""
    if options.names == "none":
        return []
    every = options.names == "all"
    found = []
    flat = sheet.view.flat
    if every or len(panel.scene.joints) <= NAMED_NODES:
        for joint in (joint for joint in panel.scene.joints if taken.sees(joint.place, joint.radius)):
            away = -unit(flat(joint.inward()))
            found.append((symbols.Note(joint.name, flat(joint.place), joint.radius, away), "node"))
    if every or len(panel.scene.rods) <= NAMED_MEMBERS:
        for rod in panel.scene.rods:
            radius = max(float(piece.radii.max()) for piece in rod.pieces)
            places = rod.places
            at = next(
                (
                    int(part * (len(places) - 1))
                    for part in NAME_PLACES
                    if taken.sees(places[int(part * (len(places) - 1))], radius)
                ),
                None,
            )
            if at is None:
                continue
            line = flat(places)
            normal = symbols.turned(unit(line[min(at + 1, len(line) - 1)] - line[max(at - 1, 0)]))
            normal = normal if normal[1] >= 0 else -normal
            found.append((symbols.Note(rod.name, line[at], radius, normal), "member"))
    return found


def set_texts(
    figure: Figure,
    axes: Axes,
    texts: list[tuple[symbols.Note, str, bool]],
    covered: Mask,
    with_ghost: Mask,
    theme: Theme,
) -> None:
    """Puts the texts of one panel where they cover nothing."""
    box = axes.get_window_extent()
    low = np.array([math.ceil(box.x0), math.ceil(box.y0)])
    high = np.array([math.floor(box.x1), math.floor(box.y1)])
    inner = (slice(low[1], high[1]), slice(low[0], high[0]))
    points = figure.dpi / POINTS
    unit_pixels = box.width / (axes.get_xlim()[1] - axes.get_xlim()[0])
    ink = {"node": theme.ink, "member": theme.faint, "load": theme.load}
    wishes = []
    for note, style, needed in texts:
        trial = figure.text(0, 0, plain(note.text), **STYLES[style])
        extent = trial.get_window_extent()
        trial.remove()
        wishes.append(
            Wish(
                note.text,
                style,
                axes.transData.transform(note.anchor) - low,
                note.radius * unit_pixels,
                np.array([extent.width, extent.height]),
                note.towards,
                needed,
            )
        )
    inverse = figure.transFigure.inverted()
    for place in place_all(wishes, covered[inner], with_ghost[inner], points):
        at = inverse.transform(place.centre + low)
        if place.leader:
            line = inverse.transform(np.array(place.line) + low)
            figure.add_artist(Line2D(line[:, 0], line[:, 1], lw=0.6, color=ink[place.wish.style]))
        halo = [withStroke(linewidth=1.8, foreground=theme.paper, alpha=0.85)]
        figure.text(
            at[0],
            at[1],
            plain(place.wish.text),
            ha="center",
            va="center",
            color=ink[place.wish.style],
            path_effects=halo,
            **STYLES[place.wish.style],
        )
