"""What stands below the states: the scale, what the pale shape is, and the legend of the colours."""

from __future__ import annotations

import math

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle

from .._look.fields import Scale, number, with_unit
from .colours import Theme
from .paper import POINTS, SMALL, add_axes, write
from .states import Options, Sheet


def draw_foot(figure: Figure, sheet: Sheet, scale: float, options: Options) -> None:
    """The scale on the left, what the pale shape is, and the legend on the right."""
    theme = options.theme
    width = float(figure.get_size_inches()[0]) * POINTS
    left = draw_scale(figure, sheet.run.length_unit, scale, 8.0, 10.0, min(0.2 * width, 70.0), theme)
    if options.ghost and any(panel.state.step is not None for panel in sheet.panels):
        left = draw_ghost_key(figure, left + 14.0, theme)
    if not sheet.run.steps or not sheet.run.members:
        # What nobody solved has no forces, and they are not zero either; nor has a network without members.
        return
    if sheet.colouring.uniform:
        write(figure, width - 8.0, 15.0, sheet.colouring.words(), size=SMALL, color=theme.ink, va="center", ha="right")
    else:
        draw_bar(figure, sheet.colouring, width - 8.0, min(150.0, width - left - 24.0), theme)


def draw_ghost_key(figure: Figure, left: float, theme: Theme) -> float:
    """What the pale shape is; returns where its name ends."""
    axes = add_axes(figure, left, 12.0, 12.0, 6.0)
    axes.add_patch(
        Rectangle((0, 0), 1, 1, facecolor=theme.ghost, alpha=theme.ghost_opacity, lw=0.6, edgecolor=theme.ink)
    )
    return left + 16.0 + write(figure, left + 16.0, 15.0, "unloaded", size=SMALL, color=theme.ink, va="center")


def draw_scale(
    figure: Figure, unit_name: str, scale: float, left: float, bottom: float, room: float, theme: Theme
) -> float:
    """A bar of a round length, at most as long as there is room; returns where it ends. All in points."""
    wanted = room / scale
    power = 10.0 ** math.floor(math.log10(wanted))
    length = max(step for step in (1, 2, 5) if step * power <= wanted) * power
    axes = add_axes(figure, left, bottom, length * scale, 5.0)
    axes.set_xlim(0, 1)
    axes.set_ylim(0, 1)
    axes.plot([0, 0, 1, 1], [1, 0.2, 0.2, 1], color=theme.ink, lw=1.2, clip_on=False, solid_joinstyle="miter")
    end = left + length * scale + 4.0
    return end + write(
        figure, end, bottom + 1.0, with_unit(length, unit_name), size=SMALL, color=theme.ink, va="bottom"
    )


def draw_bar(figure: Figure, colouring: Scale, right: float, length: float, theme: Theme) -> None:
    """The legend: a bar of colours with a few round numbers, and what they are."""
    axes = add_axes(figure, right - length, 12.0, length, 5.5)
    axes.set_axis_on()
    axes.imshow(
        colouring.colours(np.linspace(colouring.low, colouring.high, 512))[None],
        aspect="auto",
        extent=(colouring.low, colouring.high, 0, 1),
    )
    axes.set_yticks([])
    marks = colouring.marks
    axes.set_xticks(marks, [number(mark) for mark in marks])
    axes.tick_params(axis="x", labelsize=SMALL, colors=theme.ink, length=2.0, width=0.6, pad=1.5)
    for spine in axes.spines.values():
        spine.set_linewidth(0.6)
        spine.set_color(theme.ink)
    write(figure, right - length, 19.5, colouring.words(), size=SMALL, color=theme.ink, va="bottom")
