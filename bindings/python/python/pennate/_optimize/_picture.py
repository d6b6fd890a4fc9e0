"""Pictures of a search: a front between objectives, or the error against designs."""

from __future__ import annotations

import importlib.util
import os
from collections.abc import Sequence
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np

from ._front import costs
from ._study import Named, Study
from ._table import Design

# Blue, orange and grey that people who do not tell red from green can tell apart (Okabe and Ito).
FRONT, PICK, OTHER = "#0072b2", "#d55e00", "#b8b8b8"
# Inches, of one pair of objectives.
SIZE = (5.4, 4.2)
# The same bytes for the same designs.
STYLE: Any = {"svg.hashsalt": "pennate", "svg.fonttype": "none", "font.size": 9}
STYLE |= {"axes.spines.top": False, "axes.spines.right": False}


def can_draw() -> bool:
    """Whether matplotlib is there: it comes with the extra `study`."""
    return importlib.util.find_spec("matplotlib") is not None


def load() -> None:
    """Brings matplotlib in: it takes longer than a picture."""
    import matplotlib.backends.backend_svg
    import matplotlib.figure  # noqa: F401


def name(study: Study) -> str:
    """The file of the picture."""
    return "front.svg" if len(study.objectives) > 1 else "progress.svg"


def draw(
    study: Study,
    path: Path,
    designs: Sequence[Design],
    best: Sequence[Design],
    picks: Sequence[Design],
    progress: Sequence[dict[str, float]],
) -> None:
    """Draws what is known so far; the file is whole at any time."""
    import matplotlib
    from matplotlib.backends.backend_svg import FigureCanvasSVG
    from matplotlib.figure import Figure

    with matplotlib.rc_context(STYLE):
        pairs = list(combinations(range(len(study.objectives)), 2))
        figure = Figure(figsize=(SIZE[0] * max(len(pairs), 1), SIZE[1]), layout="constrained")
        FigureCanvasSVG(figure)
        panels: Any = figure.subplots(1, max(len(pairs), 1), squeeze=False)[0]
        if pairs:
            for panel, pair in zip(panels, pairs):
                _front(panel, study, pair, designs, best, picks)
        else:
            _progress(panels[0], study, progress)
        if study.title:
            figure.suptitle(study.title, fontsize=10)
        beside = path.with_name(path.name + ".new")
        figure.savefig(beside, format="svg", dpi=110, metadata={"Date": None, "Creator": "pennate"})
    os.replace(beside, path)


def _front(
    panel: Any, study: Study, pair: tuple[int, int], designs: Sequence[Design], best: Sequence[Design], picks: Sequence[Design]
) -> None:
    """Two objectives of all feasible designs, the front, and what was picked of it."""
    signs = np.array([each.sign for each in study.objectives])

    def places(of: Sequence[Design]) -> Any:
        return (costs(study, of) * signs)[:, pair]

    feasible = places([design for design in designs if design.violation == 0.0])
    panel.plot(*feasible.T, ".", color=OTHER, markersize=1.5, rasterized=True, zorder=1, label="designs within limits")
    line = "-" if len(study.objectives) == 2 else ""
    panel.plot(*places(best).T, "o" + line, color=FRONT, markersize=3, linewidth=0.6, zorder=2, label="front")
    for number, place in enumerate(places(picks), 1):
        panel.plot(*place, "o", color=PICK, markersize=5, zorder=3, label="picks" if number == 1 else None)
        panel.annotate(str(number), place, textcoords="offset points", xytext=(5, 4), color=PICK)
    if len(best):
        # Designs far from the front would make it a dot in a corner.
        ends = places(best)
        low, high = np.minimum(ends.min(0), 0.0), np.maximum(ends.max(0), 0.0)
        room = 0.05 * np.where(high > low, high - low, 1.0)
        panel.set_xlim(low[0] - room[0], high[0] + room[0])
        panel.set_ylim(low[1] - room[1], high[1] + room[1])
    words = {-1.0: "greatest", 1.0: "least"}
    for k, label in zip(pair, (panel.set_xlabel, panel.set_ylabel)):
        label(f"{named(study, study.objectives[k])} ({words[study.objectives[k].sign]} is best)")
    panel.legend(frameon=False, fontsize=8, markerscale=1.5)


def named(study: Study, wanted: Named) -> str:
    """The name of what is wanted, with its unit where it is a probe."""
    probe = wanted.value.text.strip().removeprefix("=").strip().partition("@")[0]
    unit = study.network.probes.get(probe, "")
    return f"{wanted.name}, {unit}" if unit else wanted.name


def _progress(panel: Any, study: Study, progress: Sequence[dict[str, float]]) -> None:
    """The error, or the one objective, against the designs that were solved."""
    known = [(entry["solved"], entry["best"]) for entry in progress if np.isfinite(entry.get("best", np.nan))]
    if known:
        panel.plot(*np.array(known).T, "-", color=FRONT, linewidth=1.2, drawstyle="steps-post")
        if study.targets and all(value > 0.0 for _, value in known):
            panel.set_yscale("log")
    sign = -1.0 if study.objectives and study.objectives[0].sign < 0 else 1.0
    what = "error, root mean square" if study.targets else named(study, study.objectives[0])
    panel.set_ylabel(what if sign > 0 else f"minus {what}")
    panel.set_xlabel("designs solved")
