"""The page: its parts in order, in one HTML file."""

from __future__ import annotations

import html
import importlib.resources
import json
import pathlib
from typing import TYPE_CHECKING, Any

import numpy as np

from .._core import __version__
from .._look import fields, shapes
from .._look.fields import number, with_unit
from .._look.finer import finer
from . import _curves, _picture, _tables

if TYPE_CHECKING:
    from .._solution import Solution

# Increments of a step, at least, between which the picture moves and of which curves are made.
FRAMES = 12
# Nothing but what stands in the page itself is loaded.
POLICY = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data:"


def page(solution: Solution) -> str:
    """The report of a solution, which must have its shapes."""
    network, content = solution.network, solution.to_dict()
    length, force, _ = _picture.units(solution)
    # The results are those of the solution; the way between them is that of one with more increments.
    way = finer(solution, FRAMES, solution.asked)
    picture = _picture.data(way)
    name = pathlib.PurePath(network.name).name
    title = solution.title or name
    parts = [
        f"<h1>{html.escape(title)}</h1>",
        f'<p class="about">{html.escape(name)} · {html.escape(_size(content))} · units {html.escape(network.units)}</p>',
        _tables.verdicts(solution, content),
        _view(way, picture),
        "<h2>Results</h2>",
        _tables.probes(solution),
        f'<p class="about">{_accuracy(solution)}</p>',
        _parameters(solution),
        "<h2>Along the way</h2>",
        _curves_of(way),
        "<h2>What the run said</h2>",
        _tables.said(solution),
        "<h2>All numbers</h2>",
        f"<p>At the end of step ‘{html.escape(solution.steps[_tables.last(solution)])}’:</p>",
        f"<details><summary>Nodes</summary>{_tables.nodes(solution, length, force)}</details>",
        f"<details><summary>Members</summary>{_tables.members(solution, length, force)}</details>",
        f"<details><summary>The network file</summary><pre>{html.escape(network.text)}</pre></details>",
        f"<footer>pennate {__version__}. This page is complete in itself: it loads nothing, and its picture needs no library.</footer>",
    ]
    return _whole(title, "\n".join(parts), picture)


def _whole(title: str, body: str, picture: dict[str, Any]) -> str:
    style, script = (_file(name) for name in ("page.css", "page.js"))
    # A text that ends the element would end it in the middle of the data too.
    packed = json.dumps(picture, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    return f"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<meta http-equiv="Content-Security-Policy" content="{POLICY}">
<title>{html.escape(title)}</title>
<style>
{style}</style>
</head>
<body>
{body}
<script type="application/json" id="data">{packed}</script>
<script>
{script}</script>
</body>
</html>
"""


def _file(name: str) -> str:
    return importlib.resources.files(__package__).joinpath(name).read_text(encoding="utf-8")


def _size(content: dict[str, Any]) -> str:
    mesh = content["mesh"]
    kind = "plane" if content["dimension"] == "plane" else "spatial"
    return f"{kind} network, {mesh['elements']} elements, {mesh['unknowns']} unknowns"


def _accuracy(solution: Solution) -> str:
    if np.isfinite(solution.accuracy):
        return (
            f"Behind ± stands the estimated error of the mesh; the largest is {number(solution.accuracy, 2)} of the largest "
            f"values, where {number(solution.asked, 2)} was asked for."
        )
    return "There is no estimate of the error of the mesh for this run."


def _parameters(solution: Solution) -> str:
    found = solution.network.parameters
    if not found:
        return ""
    units = solution.network.parameter_units
    rows = [[html.escape(name), with_unit(value, units[name], 8)] for name, value in found.items()]
    return f"<details><summary>Parameters</summary>{_tables.table(['parameter', 'value'], rows)}</details>"


def _view(way: Solution, picture: dict[str, Any]) -> str:
    """The picture with what moves it, and in its place lines where the reader's browser has no WebGL."""
    options = "".join(f"<option>{html.escape(field['words'])}</option>" for field in picture["fields"])
    last = len(picture["states"]) - 1
    return f"""<div id="view">
<canvas id="picture" tabindex="0" aria-label="The network; drag to turn it"></canvas>
<div id="tip" hidden></div>
<div id="controls">
<button id="play" type="button">Play</button>
<label>Way <input id="state" type="range" min="0" max="{last}" value="{last}"></label>
<span id="where"></span>
<label>Colour <select id="field">{options}</select></label>
<label><input id="ghost" type="checkbox" checked> unloaded shape</label>
</div>
<div id="legend"></div>
</div>
<div id="still" hidden><p>This browser has no WebGL 2: the network is drawn as lines.</p>{_still(way)}</div>
<noscript><p>Without JavaScript the network is drawn as lines.</p>{_still(way)}</noscript>
<p class="about">Drag turns, shift and drag moves, the wheel zooms, a double click puts it back; the pointer names what it is on.</p>"""


def _still(way: Solution) -> str:
    """The last state as lines, seen from where the picture is seen from."""
    drawing = way.drawing()
    plane = way.network.dimension == "plane"
    turn, rise = _picture.VIEWS["plane" if plane else "space"]
    towards = np.array([np.cos(rise) * np.cos(turn), np.cos(rise) * np.sin(turn), np.sin(rise)])
    right = np.array([-np.sin(turn), np.cos(turn), 0.0])
    flat = shapes.places(drawing) @ np.stack([right, np.cross(towards, right)], axis=1)
    own = np.flatnonzero(drawing["cell_data"]["kind"] != shapes.RIGID)
    field = fields.fields(*_picture.units(way))["axial_force"]
    values = fields.values(drawing, field)[own]
    colours = [colour.tolist() for colour in fields.scale_of(field, values).colours(values)]
    bars = shapes.bar_nodes(drawing)
    lines = np.concatenate([bars, np.asarray(drawing["lines"])[own]])
    widths = 2 * drawing["point_data"]["radius"][lines].mean(axis=1)
    widths[: len(bars)] = 2 * shapes.bars(drawing)[2]
    colours = [[round(255 * part) for part in _picture.BODY]] * len(bars) + colours
    low, high = flat.min(axis=0), flat.max(axis=0)
    margin = 0.08 * float(np.linalg.norm(high - low)) + float(widths.max(initial=0.0))
    frame = (low[0] - margin, low[1] - margin, high[0] - low[0] + 2 * margin, high[1] - low[1] + 2 * margin)
    names = ["#" + bytes(colour).hex() for colour in colours]
    return _curves.still(flat[lines], names, np.maximum(widths, 0.004 * max(frame[2:])), frame)


def _curves_of(way: Solution) -> str:
    """Every probe over the way; whole numbers are the ends of steps."""
    history = way.history
    index = {name: place for place, name in enumerate(way.steps)}
    steps = np.array([index[name] for name in history.steps.tolist()], dtype=np.float64)
    x = steps + history["fraction"]
    x[0] = 0.0
    ends = [row for row in range(len(x)) if row + 1 == len(x) or steps[row + 1] != steps[row]]
    found = []
    for name in way.probes:
        unit = history.units.get(name, "")
        found.append(_curves.curve(x, history[name], list(way.steps), ends, f"{name}, {unit}" if unit else name))
    if not any(found):
        return "<p>There are no probes to draw.</p>"
    return f'<div class="curves">{"".join(found)}</div><p class="about">Probes through the steps one after the other; dots are the ends of steps.</p>'
