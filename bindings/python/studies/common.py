"""What studies have in common: runs with other settings and seeds, fronts, and pictures."""

from __future__ import annotations

import dataclasses
import statistics
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import pennate
from pennate._optimize import _check
from pennate._optimize._expression import Expression
from pennate._optimize._study import Constraint

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
KEPT = ROOT / "target" / "studies"
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
SEEDS = (1, 2, 3)
Values = npt.NDArray[np.float64]


def run(study: str | pennate.Study, name: str, **given: Any) -> pennate.Outcome:
    """A study with other settings, in a folder of its own."""
    read = HERE / f"{study}_study.toml" if isinstance(study, str) else study
    outcome = pennate.optimize(read, KEPT / name, **given)
    failed = sum(design.status != "solved" for design in outcome.designs)
    print(f"  {name}: {len(outcome.designs)} designs, {failed} without an answer; {checks(outcome)}", flush=True)
    return outcome


def checks(outcome: pennate.Outcome) -> str:
    """What came of the best designs on meshes of their own."""
    off = _check.off(outcome.study, outcome.designs, outcome.best, outcome.checked)
    known = off[np.isfinite(off)]
    beyond = int((known > outcome.study.accuracy).sum())
    lost = _check.ends(outcome.checked).total()
    found = f"of the {len(outcome.best)} best {lost} do not hold by themselves, {beyond} are off by more than {outcome.study.accuracy:g}"
    return f"{found}, by {known.max(initial=0.0):.0e} at most"


def runs(study: str, name: str, limit: float | None = None, **settings: float) -> list[pennate.Outcome]:
    """The same by three seeds; with a limit of the bending stress, MPa."""
    found = []
    for seed in SEEDS:
        read = pennate.read_study(HERE / f"{study}_study.toml", settings=settings, seed=seed)
        found.append(run(read if limit is None else limited(read, limit), f"{name}_{seed}"))
    return found


def limited(study: pennate.Study, limit: float) -> pennate.Study:
    """A study of inverters with a limit of the bending stress."""
    value = Expression("= max(stress@free, stress@blocked)")
    stress = Constraint("stress", value, -np.inf, limit, limit, before=False)
    probes = tuple(sorted({*study.probes, "stress@free", "stress@blocked"}))
    return dataclasses.replace(study, constraints=(*study.constraints, stress), probes=probes)


def middle(found: Sequence[pennate.Outcome], of: Callable[[pennate.Outcome], float], form: str = ".0f") -> str:
    """The median of something over the seeds, and what each has."""
    values = [of(outcome) for outcome in found]
    return f"{statistics.median(values):{form}} ({', '.join(f'{value:{form}}' for value in values)})"


def most(objective: int) -> Callable[[pennate.Outcome], float]:
    """What tells the largest value of an objective on a front."""
    return lambda outcome: float(points(outcome)[:, objective].max())


def shares(one: Sequence[pennate.Outcome], other: Sequence[pennate.Outcome]) -> str:
    """How much of fronts is dominated by others, seed by seed: the median, and each."""
    values = [dominated(points(a), points(b)) for a, b in zip(one, other)]
    return f"{statistics.median(values):.0f} % ({', '.join(f'{value:.0f}' for value in values)})"


def points(outcome: pennate.Outcome) -> Values:
    """(front, objectives)"""
    return np.array([design.wanted for design in outcome.best]).reshape(len(outcome.best), -1)


def volume(outcome: pennate.Outcome, key: str = "hypervolume") -> float:
    """What the front dominates from zero on."""
    return outcome.progress[-1][key]


def dominated(one: Values, other: Values) -> float:
    """Per cent of the designs of one front that a design of another one is at least equal to in both objectives."""
    return 100.0 * float(np.mean([(other >= row).all(1).any() for row in one]))


def draw(
    name: str,
    curves: Sequence[tuple[str, Values]],
    labels: tuple[str, str],
    title: str,
    style: str = "-",
    pairs: bool = False,
    scale: tuple[str, str] = ("linear", "linear"),
) -> None:
    """A picture of some curves; of pairs each has a colour, and its second curve is dashed, or made of circles."""
    import matplotlib
    from matplotlib.figure import Figure

    matplotlib.rcParams.update({"svg.hashsalt": "pennate", "svg.fonttype": "none"})
    figure = Figure(figsize=(7.6 if pairs else 6.2, 4.2), layout="constrained")
    panel: Any = figure.subplots()
    for k, (label, values) in enumerate(curves):
        colour, line = (COLOURS[k // 2], ("-", style)[k % 2]) if pairs else (COLOURS[k], style)
        panel.plot(*values.T, line, color=colour, markersize=4, markerfacecolor="none", linewidth=1.2, label=label)
    panel.set_xlabel(labels[0])
    panel.set_ylabel(labels[1])
    panel.set_title(title, fontsize=10)
    panel.spines[["top", "right"]].set_visible(False)
    panel.set_xscale(scale[0])
    panel.set_yscale(scale[1])
    for axis, kind in zip((panel.xaxis, panel.yaxis), scale):
        if kind == "log":
            axis.set_major_formatter(matplotlib.ticker.FormatStrFormatter("%g"))
    if pairs:
        figure.legend(frameon=False, fontsize=9, loc="outside right upper")
    else:
        panel.legend(frameon=False, fontsize=9)
    figure.savefig(ROOT / "docs" / f"synthesis-{name}.svg", metadata={"Date": None})


def fronts(name: str, curves: Sequence[tuple[str, Values]], title: str, pairs: bool = False) -> None:
    """A picture of fronts between stroke and force: on scales of ratios, as both ends run along an axis. Ends without use are cut."""
    useful = [(label, values[(values[:, 0] >= 0.5) & (values[:, 1] >= 1.0)]) for label, values in curves]
    draw(name, useful, ("stroke, mm", "blocked force of one half, N"), title, "--" if pairs else "-", pairs, ("log", "log"))
