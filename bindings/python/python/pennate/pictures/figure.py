"""Puts the states of a network side by side on one sheet, with one scale and one legend."""

from __future__ import annotations

import pathlib

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from . import render, surfaces, symbols
from .colours import Theme
from .legend import draw_foot
from .naming import GHOST, names_of
from .paper import MILLIMETRE, POINTS, TEXT, TITLE, add_axes, new_figure, save, text_width, write
from .scene import Scene
from .states import FOOT, GUTTER, HEAD, MARGIN, Options, Panel, Sheet, lay_out
from .view import Frame

# A note that finds no room beside its title stands below it, by so many points.
SECOND_LINE = 11.0
# Scale and legend need this width, in millimetres.
LEAST = 105.0
# More supports than this are drawn smaller.
MANY = 8


def draw(sheet: Sheet, options: Options, output: pathlib.Path) -> None:
    """Draws a sheet into a file."""
    save(make(sheet, options), output, options.transparent)


def make(sheet: Sheet, options: Options) -> Figure:
    """Draws a sheet."""
    layout = lay_out(sheet.frame, len(sheet.panels), options)
    # Names may use what the scale and the legend need more of in width than the networks.
    gutters = GUTTER * (layout.columns - 1)
    least = (LEAST * MILLIMETRE - gutters) / layout.columns
    beside = max(MARGIN, (least - float(sheet.frame.size[0]) * layout.scale) / 2) / layout.scale
    margin = MARGIN / layout.scale
    frame = sheet.frame.grown(beside, beside, margin, margin)
    tile = frame.size * layout.scale
    head = HEAD if all(fits(panel, tile[0]) for panel in sheet.panels) else HEAD + SECOND_LINE
    width = layout.columns * tile[0] + gutters
    height = layout.rows * (tile[1] + head) + FOOT
    figure = new_figure(width, height, options.theme.paper, options.resolution)
    boxes = []
    for index, panel in enumerate(sheet.panels):
        row, column = divmod(index, layout.columns)
        left = column * (tile[0] + GUTTER)
        bottom = height - (row + 1) * (tile[1] + head)
        axes = add_axes(figure, left, bottom, tile[0], tile[1])
        draw_title(figure, panel, left, bottom + tile[1] + 3.0, head, options.theme)
        boxes.append((axes, panel, draw_panel(axes, sheet, panel, frame, layout.scale, options)))
    names_of(figure, sheet, boxes, layout.scale, options)
    draw_foot(figure, sheet, layout.scale, options)
    return figure


def fits(panel: Panel, width: float) -> bool:
    """Whether the title and the note of a panel fit into one line."""
    title = text_width(panel.title, TITLE, "bold")
    return 4.0 + title + (6.0 + text_width(panel.note, TEXT, "normal") if panel.note else 0.0) <= width


def draw_title(figure: Figure, panel: Panel, left: float, bottom: float, head: float, theme: Theme) -> None:
    """The name of a step and what is to be known of it, beside it or below."""
    above = bottom if head == HEAD else bottom + SECOND_LINE
    width = write(figure, left + 4.0, above, panel.title, size=TITLE, weight="bold", color=theme.ink, va="bottom")
    beside = left + 4.0 + (width + 6.0 if head == HEAD else 0.0)
    write(figure, beside, bottom, panel.note, size=TEXT, color=theme.faint, va="bottom")


def draw_panel(axes: Axes, sheet: Sheet, panel: Panel, frame: Frame, scale: float, options: Options) -> render.Taken:
    """The network, and its symbols."""
    taken = paint(axes, sheet, panel, frame, scale, options)
    many = sum(joint.held > 0 for joint in panel.scene.joints) > MANY
    pen = symbols.Pen(axes, sheet.view, options.theme, 1.0 / scale, 0.7 if many else 1.0)
    if sheet.run.plane:
        symbols.draw_supports(pen, panel.scene)
    return taken


def paint(axes: Axes, sheet: Sheet, panel: Panel, frame: Frame, scale: float, options: Options) -> render.Taken:
    """The network itself, over the unloaded one."""
    theme, plane = options.theme, sheet.run.plane
    edge = (theme.edge, theme.edge_opacity)
    pixels = scale * options.resolution / POINTS
    surface = surfaces.network(panel.scene, sheet.colouring, theme, plane)
    taken = render.render(surface, sheet.view, frame, pixels, edge, edge_jump(panel.scene))
    extent = (frame.low[0], frame.high[0], frame.low[1], frame.high[1])
    if options.ghost and panel.state.step is not None:
        axes.imshow(
            ghost_of(sheet, frame, pixels, options),
            extent=extent,
            interpolation="none",
            zorder=1,
            aspect="auto",
            gid=GHOST,
        )
    axes.imshow(taken.image, extent=extent, interpolation="none", zorder=3, aspect="auto")
    axes.set_xlim(extent[0], extent[1])
    axes.set_ylim(extent[2], extent[3])
    return taken


def ghost_of(sheet: Sheet, frame: Frame, pixels: float, options: Options) -> render.Image:
    """The picture of the unloaded network, drawn once for each frame."""
    theme = options.theme
    key = (*frame.low, *frame.size, pixels)
    if key not in sheet.ghosts:
        ghost = surfaces.ghost(sheet.unloaded, theme, sheet.run.plane)
        edge = (theme.edge, theme.edge_opacity)
        taken = render.render(ghost, sheet.view, frame, pixels, edge, edge_jump(sheet.unloaded))
        sheet.ghosts[key] = render.faded(taken.image, theme.ghost_opacity)
    found: render.Image = sheet.ghosts[key]
    return found


def edge_jump(scene: Scene) -> float:
    """How far behind something must lie to be parted from it by a line."""
    radii = [piece.radii for rod in scene.rods for piece in rod.pieces]
    others = [body.radius for body in scene.bodies] + [joint.radius for joint in scene.joints if joint.alone]
    return 0.8 * float(np.median(np.concatenate(radii) if radii else others))
