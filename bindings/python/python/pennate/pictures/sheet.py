"""Many networks on one sheet, each in its own scale, with one legend relative to the largest value of each."""

from __future__ import annotations

import dataclasses
import math
import pathlib

import numpy as np
from matplotlib.figure import Figure

from .._look.fields import Field, Scale, with_unit
from . import colours, figure, legend, states, symbols
from .colours import Theme
from .paper import add_axes, new_figure, save, write
from .results import Run
from .view import View

# Sizes in points: a tile, the space around the network in it, its title above and its scale below.
COLUMNS, WIDE, HIGH, MARGIN, HEAD, FOOT = 4, 128.0, 92.0, 11.0, 21.0, 18.0
# Symbols are smaller than in a picture of one network.
SYMBOLS = 0.6


@dataclasses.dataclass(frozen=True)
class Tile:
    """One network: its title and what stands below, its results, which step, and from where."""

    title: str
    note: str
    run: Run
    options: states.Options
    view: View


def draw(tiles: list[Tile], theme: Theme, transparent: bool, output: pathlib.Path) -> None:
    """Draws all tiles into a file."""
    rows = math.ceil(len(tiles) / COLUMNS)
    pitch = HIGH + HEAD + FOOT
    width, height = COLUMNS * WIDE, rows * pitch + states.FOOT
    page = new_figure(width, height, theme.paper, tiles[0].options.resolution)
    for index, tile in enumerate(tiles):
        row, column = divmod(index, COLUMNS)
        draw_tile(page, tile, column * WIDE, height - (row + 1) * pitch + FOOT)
    relative = Field("relative", "axial force over the largest in each network", "", "force", True)
    legend.draw_bar(page, Scale(relative, -1.0, 1.0, (-1.0, -0.5, 0.0, 0.5, 1.0)), width - 8.0, 190.0, theme)
    legend.draw_ghost_key(page, 8.0, theme)
    save(page, output, transparent)


def draw_tile(page: Figure, tile: Tile, left: float, bottom: float) -> None:
    """One network with its title and its scale."""
    options, theme = tile.options, tile.options.theme
    usable = np.array([WIDE, HIGH]) - 2 * MARGIN
    sheet = states.make_sheet(tile.run, options, tile.view, usable)
    panel = sheet.panels[0]
    found = np.abs(colours.values(sheet.colouring.field, panel.shape))
    # A network whose forces are rounding alone has none.
    none = sheet.colouring.uniform and sheet.colouring.low == 0.0
    largest = 0.0 if none else float(np.nanmax(found))
    # Where all is zero, any range shows it as zero.
    sheet = dataclasses.replace(sheet, colouring=Scale(sheet.colouring.field, -(largest or 1.0), largest or 1.0))
    scale = float((usable / sheet.frame.size).min())
    spare = (np.array([WIDE, HIGH]) / scale - sheet.frame.size) / 2
    frame = sheet.frame.grown(spare[0], spare[0], spare[1], spare[1])
    axes = add_axes(page, left, bottom, WIDE, HIGH)
    figure.paint(axes, sheet, panel, frame, scale, options)
    pen = symbols.Pen(axes, tile.view, theme, 1.0 / scale, SYMBOLS)
    if tile.run.plane:
        symbols.draw_supports(pen, panel.scene)
    symbols.draw_loads(pen, panel.scene, tile.run, states.largest_force([panel]), symbols.Noise())
    top = bottom + HIGH + HEAD
    write(page, left + 6.0, top - 2.0, tile.title, size=6.5, weight="bold", color=theme.ink, va="top")
    force = f"up to {with_unit(largest, tile.run.force_unit)}" if largest else "no force"
    notes = [note for note in (tile.note, panel.note, force) if note]
    write(page, left + 6.0, top - 11.5, ", ".join(notes), size=6.0, color=theme.faint, va="top")
    legend.draw_scale(page, tile.run.length_unit, scale, left + 8.0, bottom - 8.0, 34.0, theme)
