"""Studies of fronts: inverters in boxes, with more members, limits, tolerances and verdicts in space; a wing section; the stage."""

from __future__ import annotations

import statistics
from collections import Counter
from typing import Any

import numpy as np
from common import ROOT, SEEDS, Values, draw, fronts, middle, most, points, run, runs, shares, volume

import pennate
from pennate._optimize import evaluate
from pennate._optimize._front import area, undominated


ASKED = {180: (2000, 2150), 270: (3300, 3500), 360: (3700, 3900)}
"""Sides of boxes, mm, and the hypervolumes that they must and should have."""


def boxes(wanted: bool) -> None:
    """Three members in boxes of 180, 270 and 360 mm, three seeds each: hypervolume against what is asked for."""
    found = {side: runs("inverter", f"box_{side}", D=side) for side in ASKED}
    for side, (must, should) in ASKED.items():
        last = middle(found[side], lambda outcome: volume(outcome, "population"))
        print(f"{side}: hypervolume {middle(found[side], volume)}, must {must}, should {should}; last population {last}")
        ends = [middle(found[side], most(k), ".1f") for k in (0, 1)]
        print(f"{side}: greatest stroke {ends[0]} mm, greatest force {ends[1]} N; {without(found[side])}")
    print(f"after 10, 25, 50, 100 generations of 270: {', '.join(grown(found[270], count) for count in (10, 25, 50, 100))}")
    by_boxes(found)
    if wanted:
        curves = [(f"box of {side} mm", points(all_seeds[0])) for side, all_seeds in found.items()]
        fronts("boxes", curves, "Three members, three boxes")


def without(found: list[pennate.Outcome]) -> str:
    """Designs without an answer."""
    failed = sum(design.status != "solved" for outcome in found for design in outcome.designs)
    count = sum(len(outcome.designs) for outcome in found)
    return f"{failed} of {count} designs without an answer, {100 * failed / count:.2f} %"


def grown(found: list[pennate.Outcome], generations: int) -> str:
    """The part of the last hypervolume after some generations, median of the seeds."""
    return f"{statistics.median(each.progress[generations - 1]['hypervolume'] / volume(each) for each in found):.0%}"


def by_boxes(found: dict[int, list[pennate.Outcome]]) -> None:
    """How much of the front of each box is dominated by that of the next one."""
    for small, large in ((180, 270), (270, 360)):
        print(f"front of {small} dominated by {large}: {shares(found[small], found[large])}")


def members(wanted: bool) -> None:
    """Three against five members in a box of 270 mm, by the length of the muscles, and with it open."""
    curves = by_length(None)
    free = runs("five_free", "five_free")
    print(f"length open, 5 members: hypervolume {middle(free, volume)}, stroke {middle(free, most(0), '.1f')} mm; {without(free)}")
    if wanted:
        fronts("members", curves, "Three and five members, muscles of one length", pairs=True)


def strained(wanted: bool) -> None:
    """The same by the length of the muscles with bending stresses of at most 1200 MPa."""
    by_length(1200.0)


def by_length(limit: float | None) -> list[tuple[str, Values]]:
    """Three against five members for three lengths of all muscles; the fronts of the first seed."""
    curves = []
    for length in (110, 140, 170):
        names = [f"{count}_{length}{'' if limit is None else '_stress'}" for count in ("three", "five")]
        three, five = runs("three", names[0], limit, L1=length), runs("five", names[1], limit, length=length)
        for count, own, other in ((3, three, five), (5, five, three)):
            values = f"hypervolume {middle(own, volume)}, stroke {middle(own, most(0), '.1f')} mm"
            print(f"{length} mm, {count} members: {values}, dominated {shares(own, other)}; {without(own)}")
            curves.append((f"{count} members, {length} mm", points(own[0])))
        print(f"{length} mm: ratio of hypervolumes {statistics.median(volume(a) / volume(b) for a, b in zip(three, five)):.2f}")
    return curves


def stress(wanted: bool) -> None:
    """Bending stress of the wires at most 1200 MPa, against no limit, in three boxes."""
    found = {side: runs("stress", f"stress_{side}", D=side) for side in ASKED}
    free = runs("inverter", "box_270", D=270)
    for side, limited in found.items():
        solved = [design for outcome in limited for design in outcome.designs if design.status == "solved"]
        beyond = np.mean([design.violation > 0 for design in solved])
        values = f"hypervolume {middle(limited, volume)}, greatest stroke {middle(limited, most(0), '.1f')} mm"
        print(f"{side}: {values}; violated by {beyond:.0%} of the designs that were solved")
    print(f"270, no limit: hypervolume {middle(free, volume)}, greatest stroke {middle(free, most(0), '.1f')} mm")
    by_boxes(found)
    if wanted:
        curves = [("no limit", points(free[0])), ("at most 1200 MPa", points(found[270][0]))]
        fronts("stress", curves, "Bending stress of the wires, box of 270 mm")


def wing(wanted: bool) -> None:
    """The wing section of Fig. 26: bend of the skin against its distortion."""
    found = runs("wing", "wing")
    for limit in (0.2, 1.0, 3.0):

        def bend(outcome: pennate.Outcome, limit: float = limit) -> float:
            near = [bent for bent, distortion in points(outcome) if distortion <= limit]
            return float(max(near, default=np.nan))

        print(f"distortion at most {limit} mm: bend {middle(found, bend, '.2f')} mm")
    front = points(found[0])
    if wanted:
        labels = ("bend, mm", "distortion, root mean square, mm")
        draw("wing", [("front", front), ("as assumed for Fig. 26", np.array([[5.94, 0.90]]))], labels, "Wing section", "o")


def whole(wanted: bool) -> None:
    """Whole inverters that are stable in space, with the output free and on a slide, against halves judged in the plane."""
    plane = runs("inverter", "box_270", D=270)[0]
    curves = [("half, judged in the plane", points(plane))]
    values = np.array([design.x for design in plane.best])
    for study, word in (("slide", "output on a slide"), ("whole", "output free")):
        found = runs(study, study)
        stable = found[0]
        kinds = Counter(design.status for outcome in found for design in outcome.designs)
        print(f"{word}: hypervolume {middle(found, volume)}, stroke {middle(found, most(0), '.1f')} mm; {dict(kinds)}")
        names = [each.name for each in stable.study.variables]
        problem = stable.study.network.problem(names, ["u@free", "f@blocked", "k@blocked"], accuracy=1e-4)
        y = problem(values)
        lost = sum(reason is not None for reason in problem.reasons)
        snaps = int(np.sum(y[:, 2] < 0.0))
        what = f"of the {len(values)} designs of the front in the plane"
        print(f"{word}: {what} {lost} are lost in space, {snaps} more snap when let go")
        curves.append((f"whole, {word}, in space", points(stable)))
    if wanted:
        fronts("whole", curves, "The spatial verdict")


def robust(wanted: bool) -> None:
    """What is reached for certain with joints off by 0.5 mm and the pressure by 2 %: looked for, and of the plain front."""
    volumes: dict[str, list[float]] = {"as drawn": [], "for certain": [], "looked for": []}
    for seed, plain in zip(SEEDS, runs("inverter", "box_270", D=270)):
        certain = run("robust", f"robust_{seed}", first=plain.directory / "front.csv", seed=seed)
        curves = promised(plain, certain)
        for word, curve in zip(volumes, curves):
            curve = curve[(curve > 0.0).all(1)]
            volumes[word].append(area(-curve[undominated(-curve)], np.zeros(2)))
        if seed == SEEDS[0]:
            drawn = curves
    for word, values in volumes.items():
        print(f"{word}: {statistics.median(values):.0f} ({', '.join(f'{value:.0f}' for value in values)})")
    for word in ("for certain", "looked for"):
        part = statistics.median(a / b for a, b in zip(volumes[word], volumes["as drawn"]))
        print(f"{word}: {part:.3f} of what is drawn")
    if wanted:
        labels = ("plain front, as drawn", "plain front, for certain", "looked for")
        fronts("robust", list(zip(labels, drawn)), "Joints off by 0.5 mm, pressure by 2 %")


def promised(plain: pennate.Outcome, certain: pennate.Outcome) -> list[Values]:
    """The plain front as it is drawn and as it is for certain, and the front that was looked for."""
    designs = [each for each in evaluate(certain.study, np.array([each.x for each in plain.best])) if each.status == "solved"]
    worst = np.array([design.wanted for design in designs])
    as_drawn = worst + np.array([design.spread for design in designs])
    nothing = int((worst <= 0.0).any(1).sum())
    print(f"of {len(plain.best)} designs of the plain front {len(designs)} have derivatives; {nothing} promise nothing")
    kept = worst[[design.violation == 0.0 for design in designs]]
    kept = kept[(kept > 0.0).all(1)]
    return [as_drawn, kept[undominated(-kept)], points(certain)]


def stage(wanted: bool) -> None:
    """The front of the stage: stroke, tilt and stiffness."""
    found = runs("stage", "stage")
    outcome = found[0]
    front = points(outcome)
    names = [each.name for each in outcome.study.variables]
    for k, word in enumerate(("stroke, mm", "tilt, degrees", "stiffness, N/mm")):
        best = outcome.best[int(front[:, k].argmax())]
        values = ", ".join(f"{name} {value:.1f}" for name, value in zip(names, best.x))
        print(f"greatest {word}: {front[:, k].max():.3g} ({values}; {', '.join(f'{value:.3g}' for value in best.wanted)})")
        print(f"greatest {word}, by seeds: {middle(found, most(k), '.4g')}")
    print(f"hypervolume {middle(found, volume)}, {len(front)} designs on the front of seed 1; {without(found)}")
    if wanted:
        from matplotlib.figure import Figure

        figure = Figure(figsize=(6.6, 4.2), layout="constrained")
        panel: Any = figure.subplots()
        dots = panel.scatter(*front[:, :2].T, c=front[:, 2], s=10, norm="log", cmap="viridis", rasterized=True)
        figure.colorbar(dots, label="stiffness when lowered, N/mm")
        panel.set_xlabel("stroke, mm")
        panel.set_ylabel("tilt, degrees")
        panel.set_title("The front of the stage", fontsize=10)
        figure.savefig(ROOT / "docs" / "synthesis-stage.svg", dpi=140, metadata={"Date": None})
