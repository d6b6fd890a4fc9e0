"""A sheet of paper: axes and texts at places in points, and the file that it becomes."""

from __future__ import annotations

import io
import pathlib
from typing import Any

import matplotlib
import numpy as np
import numpy.typing as npt
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.textpath import TextPath
from PIL import Image

POINTS = 72.0
MILLIMETRE = POINTS / 25.4
# Sizes of text, in points: that of titles, of names, and of the scale and the legend.
TITLE, TEXT, SMALL = 9.0, 8.0, 7.0
FONT = "DejaVu Sans"


def new_figure(width: float, height: float, colour: str, resolution: int) -> Figure:
    """An empty sheet of a size in points."""
    matplotlib.rcParams["font.family"] = FONT
    matplotlib.rcParams["mathtext.fontset"] = "dejavusans"
    figure = Figure(figsize=(width / POINTS, height / POINTS), dpi=resolution, facecolor=colour)
    FigureCanvasAgg(figure)
    return figure


def add_axes(figure: Figure, left: float, bottom: float, width: float, height: float) -> Axes:
    """Axes without lines at a place in points."""
    total = figure.get_size_inches() * POINTS
    axes = figure.add_axes((left / total[0], bottom / total[1], width / total[0], height / total[1]))
    axes.set_axis_off()
    return axes


def write(figure: Figure, x: float, y: float, text: str, **style: Any) -> float:
    """A text at a place in points; returns its width."""
    total = figure.get_size_inches() * POINTS
    drawn = figure.text(x / total[0], y / total[1], plain(text), **style)
    return float(drawn.get_window_extent().width * POINTS / figure.dpi)


def text_width(text: str, size: float, weight: str) -> float:
    """In points."""
    if not text:
        return 0.0
    path = TextPath((0, 0), plain(text), size=size, prop=FontProperties(family=FONT, weight=weight))
    return float(path.get_extents().x1)


def plain(text: str) -> str:
    """A text whose dollar signs are signs and not the limits of a formula."""
    return text.replace("$", r"\$")


def pixels_of(figure: Figure) -> npt.NDArray[np.uint8]:
    """Red, green, blue and opacity, 0 to 255, the first row uppermost."""
    canvas = figure.canvas
    assert isinstance(canvas, FigureCanvasAgg)
    canvas.draw()  # type: ignore[no-untyped-call]
    return np.asarray(canvas.buffer_rgba())  # type: ignore[no-untyped-call]


def save(figure: Figure, output: pathlib.Path | io.BytesIO, transparent: bool) -> None:
    """Writes the file, with the colour of the paper or without."""
    figure.patch.set_alpha(0.0 if transparent else 1.0)
    pixels = pixels_of(figure)
    # The last bit of a colour is seen by nobody and makes a third of the file.
    pixels = np.minimum(2 * np.round(pixels / 2.0), 255).astype(np.uint8)
    pixels[pixels == 254] = 255
    image = Image.fromarray(pixels if transparent else pixels[..., :3])
    image.save(output, format="png", optimize=True, dpi=(figure.dpi, figure.dpi))
