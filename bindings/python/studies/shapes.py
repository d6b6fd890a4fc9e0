"""Studies of surfaces that take a shape: heights of points, and whole profiles."""

from __future__ import annotations

import dataclasses
import statistics
import tempfile

import numpy as np
from common import HERE, draw, middle, runs

import pennate

TARGETS = {
    "concave": (-10, -20, -30),
    "convex": (10, 20, 30),
    "sinusoidal": (-20, 0, 20),
    "prototype": (-13, 1, 18),
    "concave, twice": (-20, -40, -60),
    "convex, twice": (20, 40, 60),
    "sinusoidal, twice": (-40, 0, 40),
    "alternating": (-30, 30, -30),
}


def shapes(wanted: bool, seeds: int = 4) -> None:
    """Heights of three points by least squares: designs solved until the error is 0.1 mm, screening included."""
    print("heights  reached, designs solved: median, least, most")
    totals, courses = [], []
    for name, heights in TARGETS.items():
        counts = []
        for seed in range(1, seeds + 1):
            settings = dict(zip(("hA", "hB", "hC"), map(float, heights)))
            study = pennate.read_study(HERE / "shape_study.toml", settings=settings, seed=seed)
            study = dataclasses.replace(study, stop={"error": 0.1, "evaluations": 1000})
            with tempfile.TemporaryDirectory() as folder:
                outcome = pennate.optimize(study, folder, draw=False)
            if outcome.progress[-1]["best"] <= 0.1:
                counts.append(len(outcome.designs))
            if seed == 1:
                courses.append((name, np.array([(each["solved"], each["best"]) for each in outcome.progress])))
        totals += counts
        ends = f"{statistics.median(counts)}, {min(counts)}, {max(counts)}"
        print(f"{name} {heights}: {len(counts)} of {seeds}, {ends}", flush=True)
    print(f"all: {len(totals)} of {seeds * len(TARGETS)}, median {statistics.median(totals)}")
    if wanted:
        draw("shapes", courses[:6], ("designs solved", "error, root mean square, mm"), "Least squares from 16 random designs, seed 1", scale=("linear", "log"))


def heights(wanted: bool) -> None:
    """The same three small targets by CMA-ES, as the dissertation looks for them."""
    for name in ("concave", "convex", "sinusoidal"):
        found = runs("shape_cma", f"cma_{name}", **dict(zip(("hA", "hB", "hC"), map(float, TARGETS[name]))))
        print(f"{name}: 0.1 mm after {middle(found, until)} designs, {middle(found, last, '.3f')} mm in the end")


def until(outcome: pennate.Outcome) -> float:
    """Designs that were solved until the error was 0.1 mm; infinitely many where it never was."""
    return next((each["solved"] for each in outcome.progress if each["best"] <= 0.1), float("inf"))


def last(outcome: pennate.Outcome) -> float:
    """The error in the end."""
    return outcome.progress[-1]["best"]


def profiles(wanted: bool) -> None:
    """Whole profiles at 13 points: the error after at most 2500 designs, by least squares."""
    cases = {"concave": (-30, 0, 0), "convex": (30, 0, 0), "half wave": (0, 20, 0), "full wave": (0, 0, 20)}
    places = np.linspace(-1.0, 1.0, 13)
    curves = []
    for name, (bow, half, wave) in cases.items():
        found = runs("profile", f"profile_{name.replace(' ', '_')}", bow=float(bow), half=float(half), wave=float(wave))
        outcome = found[0]
        print(f"{name}: {middle(found, last, '.3f')} mm after {middle(found, lambda each: len(each.designs))} designs")
        target = bow * (1 - places**2 / 2) + half * np.sin(np.pi * places / 2) + wave * np.sin(np.pi * places)
        curves.append((name, np.column_stack([180 * (1 + places), np.array(outcome.best[0].wanted) + target])))
        curves.append((f"{name}, wanted", np.column_stack([180 * (1 + places), target])))
    if wanted:
        draw("profiles", curves, ("place along the surface, mm", "height, mm"), "Whole profiles: reached and wanted", "o", pairs=True)
