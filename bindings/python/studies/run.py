"""Runs the studies of this folder, prints what came of them, and draws the pictures of docs/synthesis.md.

    python studies/run.py boxes            one of them; without a name, a list
    python studies/run.py boxes --draw     with its picture in docs/

Designs are kept in target/studies: what was solved once is not solved again.
"""

from __future__ import annotations

import argparse
import statistics
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

import pennate

HERE = Path(__file__).parent
ROOT = HERE.parents[2]
KEPT = ROOT / "target" / "studies"
COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00")
Values = npt.NDArray[np.float64]


def run(study: str, name: str, **given: Any) -> pennate.Outcome:
    """A study with other settings, in a folder of its own."""
    outcome = pennate.optimize(HERE / f"{study}_study.toml", KEPT / name, **given)
    failed = sum(design.status != "solved" for design in outcome.designs)
    print(f"  {name}: {len(outcome.designs)} designs, {failed} without an answer", flush=True)
    return outcome


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
    name: str, fronts: Sequence[tuple[str, Values]], labels: tuple[str, str], title: str, style: str = "-", pairs: bool = False
) -> None:
    """A picture of some curves; of pairs each has a colour, and its second curve is dashed."""
    import matplotlib
    from matplotlib.figure import Figure

    matplotlib.rcParams.update({"svg.hashsalt": "pennate", "svg.fonttype": "none"})
    figure = Figure(figsize=(7.6 if pairs else 6.2, 4.2), layout="constrained")
    panel: Any = figure.subplots()
    for k, (label, values) in enumerate(fronts):
        colour, line = (COLOURS[k // 2], ("-", "--")[k % 2]) if pairs else (COLOURS[k], style)
        panel.plot(*values.T, line, color=colour, markersize=3, linewidth=1.2, label=label)
    panel.set_xlabel(labels[0])
    panel.set_ylabel(labels[1])
    panel.set_title(title, fontsize=10)
    panel.spines[["top", "right"]].set_visible(False)
    if labels[1].startswith("error"):
        panel.set_yscale("log")
    if pairs:
        figure.legend(frameon=False, fontsize=9, loc="outside right upper")
    else:
        panel.legend(frameon=False, fontsize=9)
    figure.savefig(ROOT / "docs" / f"synthesis-{name}.svg", metadata={"Date": None})


FORCE = ("stroke, mm", "blocked force of one half, N")


def boxes(wanted: bool) -> None:
    """Three members in boxes of 180, 270 and 360 mm, three seeds each: hypervolume against what is asked for."""
    asked = {180: (2000, 2150), 270: (3300, 3500), 360: (3700, 3900)}
    fronts: dict[int, Values] = {}
    print("box  median of all found, of the last population  must  should  seeds")
    for side, (must, should) in asked.items():
        found = [run("inverter", f"box_{side}_{seed}", settings={"D": side}, seed=seed) for seed in (1, 2, 3)]
        all_found, last = ([volume(each, key) for each in found] for key in ("hypervolume", "population"))
        fronts[side] = points(found[0])
        medians = f"{statistics.median(all_found):.0f} {statistics.median(last):.0f}"
        print(f"{side}  {medians}  {must} {should}  " + " ".join(f"{value:.0f}" for value in all_found))
    for small, large in ((180, 270), (270, 360)):
        print(f"front of {small} dominated by {large}: {dominated(fronts[small], fronts[large]):.0f} %")
    if wanted:
        draw("boxes", [(f"box of {side} mm", values) for side, values in fronts.items()], FORCE, "Three members, three boxes")


def members(wanted: bool) -> None:
    """Three against five members in a box of 270 mm, by the length of the muscles; and with the length open."""
    fronts = []
    print("length  members: hypervolume, stroke  dominated by the other")
    for length in (110, 140, 170):
        three = run("three", f"three_{length}", settings={"L1": length})
        five = run("five", f"five_{length}", settings={"length": length})
        a, b = points(three), points(five)
        for count, outcome, own, other in ((3, three, a, b), (5, five, b, a)):
            print(f"{length}  {count}: {volume(outcome):.0f}, {own[:, 0].max():.1f}  {dominated(own, other):.0f} %")
        print(f"{length}  ratio of hypervolumes {volume(three) / volume(five):.2f}")
        fronts += [(f"3 members, {length} mm", a), (f"5 members, {length} mm", b)]
    free = run("five_free", "five_free")
    print(f"length open  5: {volume(free):.0f}, {points(free)[:, 0].max():.1f}; 3: see box_270")
    if wanted:
        draw("members", fronts, FORCE, "Three and five members, muscles of one length", pairs=True)


def stress(wanted: bool) -> None:
    """Bending stress of the wires at most 1200 MPa, against no limit."""
    limited, free = run("stress", "stress"), run("inverter", "box_270_1", settings={"D": 270}, seed=1)
    for word, outcome in (("at most 1200 MPa", limited), ("no limit", free)):
        print(f"{word}: hypervolume {volume(outcome):.0f}, greatest stroke {points(outcome)[:, 0].max():.1f} mm")
    solved = [design for design in limited.designs if design.status == "solved"]
    print(f"violated by {100 * np.mean([design.violation > 0 for design in solved]):.0f} % of the designs that were solved")
    if wanted:
        draw("stress", [("no limit", points(free)), ("at most 1200 MPa", points(limited))], FORCE, "Bending stress of the wires")


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
    import dataclasses
    import tempfile

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
        draw("shapes", courses[:6], ("designs solved", "error, root mean square, mm"), "Least squares from 16 random designs, seed 1")


def heights(wanted: bool) -> None:
    """The same three small targets by CMA-ES, as the dissertation looks for them."""
    for name in ("concave", "convex", "sinusoidal"):
        settings = dict(zip(("hA", "hB", "hC"), map(float, TARGETS[name])))
        outcome = run("shape_cma", f"cma_{name}", settings=settings)
        until = next((each["solved"] for each in outcome.progress if each["best"] <= 0.1), float("nan"))
        print(f"{name}: 0.1 mm after {until:.0f} designs, {outcome.progress[-1]['best']:.3f} mm in the end")


def profiles(wanted: bool) -> None:
    """Whole profiles at 13 points: the error after at most 2500 designs, by least squares."""
    cases = {"concave": (-30, 0, 0), "convex": (30, 0, 0), "half wave": (0, 20, 0), "full wave": (0, 0, 20)}
    places = np.linspace(-1.0, 1.0, 13)
    curves = []
    for name, (bow, half, wave) in cases.items():
        settings = {"bow": float(bow), "half": float(half), "wave": float(wave)}
        outcome = run("profile", f"profile_{name.replace(' ', '_')}", settings=settings)
        print(f"{name}: {outcome.progress[-1]['best']:.3f} mm after {len(outcome.designs)} designs")
        target = bow * (1 - places**2 / 2) + half * np.sin(np.pi * places / 2) + wave * np.sin(np.pi * places)
        curves.append((name, np.column_stack([180 * (1 + places), np.array(outcome.best[0].wanted) + target])))
        curves.append((f"{name}, wanted", np.column_stack([180 * (1 + places), target])))
    if wanted:
        draw("profiles", curves, ("place along the surface, mm", "height, mm"), "Whole profiles: reached and wanted", pairs=True)


def wing(wanted: bool) -> None:
    """The wing section of Fig. 26: bend of the skin against its distortion."""
    outcome = run("wing", "wing")
    front = points(outcome)
    for limit in (0.2, 1.0, 3.0):
        kept = front[front[:, 1] <= limit]
        print(f"distortion at most {limit} mm: bend {kept[:, 0].max() if len(kept) else float('nan'):.1f} mm")
    if wanted:
        labels = ("bend, mm", "distortion, root mean square, mm")
        draw("wing", [("front", front), ("as assumed for Fig. 26", np.array([[5.94, 0.90]]))], labels, "Wing section", "o")


def whole(wanted: bool) -> None:
    """Whole inverters that are stable in space, with the output free and on a slide, against halves judged in the plane."""
    plane = run("inverter", "box_270_1", settings={"D": 270}, seed=1)
    fronts = [("half, judged in the plane", points(plane))]
    values = np.array([design.x for design in plane.best])
    for study, word in (("slide", "output on a slide"), ("whole", "output free")):
        stable = run(study, study)
        kinds = Counter(design.status for design in stable.designs)
        print(f"{word}: hypervolume {volume(stable):.0f}, stroke {points(stable)[:, 0].max():.1f} mm; {dict(kinds)}")
        names = [each.name for each in stable.study.variables]
        problem = stable.study.network.problem(names, ["u@free", "f@blocked", "k@blocked"], accuracy=1e-4)
        y = problem(values)
        lost = sum(reason is not None for reason in problem.reasons)
        snaps = int(np.sum(y[:, 2] < 0.0))
        what = f"of the {len(values)} designs of the front in the plane"
        print(f"{word}: {what} {lost} are lost in space, {snaps} more snap when let go")
        fronts.append((f"whole, {word}, in space", points(stable)))
    if wanted:
        draw("whole", fronts, FORCE, "The spatial verdict")


def robust(wanted: bool) -> None:
    """What is reached for certain with joints off by 0.5 mm and the pressure by 2 %: looked for, and of the plain front."""
    from pennate._optimize import evaluate
    from pennate._optimize._front import area, undominated

    plain = run("inverter", "box_270_1", settings={"D": 270}, seed=1)
    certain = run("robust", "robust", first=plain.directory / "front.csv")
    designs = [each for each in evaluate(certain.study, np.array([each.x for each in plain.best])) if each.status == "solved"]
    worst = np.array([design.wanted for design in designs])
    drawn = worst + np.array([design.spread for design in designs])
    volumes = []
    for values in (drawn, worst[[design.violation == 0.0 for design in designs]]):
        kept = values[(values > 0.0).all(1)]
        kept = kept[undominated(-kept)]
        volumes.append(area(-kept, np.zeros(2)))
    words = f"hypervolume {volumes[0]:.0f} as drawn, {volumes[1]:.0f} for certain"
    print(f"plain front at this pressure: {words}; looked for {volume(certain):.0f}")
    print(f"of its {len(plain.best)} designs {len(designs)} have derivatives; {int((worst <= 0.0).any(1).sum())} promise nothing")
    if wanted:
        curves = [("plain front, as drawn", drawn), ("plain front, for certain", kept), ("looked for", points(certain))]
        draw("robust", curves, FORCE, "Joints off by 0.5 mm, pressure by 2 %")


def stage(wanted: bool) -> None:
    """The front of the stage: stroke, tilt and stiffness."""
    outcome = run("stage", "stage")
    front = points(outcome)
    names = [each.name for each in outcome.study.variables]
    for k, word in enumerate(("stroke, mm", "tilt, degrees", "stiffness, N/mm")):
        best = outcome.best[int(front[:, k].argmax())]
        values = ", ".join(f"{name} {value:.1f}" for name, value in zip(names, best.x))
        print(f"greatest {word}: {front[:, k].max():.3g} ({values}; {', '.join(f'{value:.3g}' for value in best.wanted)})")
    print(f"hypervolume {volume(outcome):.4g}, {len(front)} designs on the front")
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


def kills(wanted: bool, moments: int = 10) -> None:
    """A search that is killed at ten random moments and gone on with, against one that is not: the same bytes."""
    import random
    import shutil
    import subprocess
    import sys
    import time

    study = HERE / "inverter_study.toml"
    whole, killed = KEPT / "box_270_1", KEPT / "killed"
    run("inverter", whole.name, settings={"D": 270}, seed=1)
    shutil.rmtree(killed, ignore_errors=True)
    command = [sys.executable, "-m", "pennate", "optimize", str(study), "-o", str(killed), "--set", "D=270"]
    # Moments by what is written then: on a busy machine seconds say nothing.
    table, size = killed / "designs.csv", (whole / "designs.csv").stat().st_size
    draws = random.Random(1)
    for part in sorted(draws.random() for _ in range(moments)):
        with subprocess.Popen(command, stdout=subprocess.DEVNULL) as search:
            while search.poll() is None and (not table.exists() or table.stat().st_size < part * size):
                time.sleep(0.001)
            time.sleep(0.2 * draws.random())
            search.kill()
        print(f"  killed at {part:.3f}: {table.stat().st_size} of {size} bytes", flush=True)
    subprocess.run(command, stdout=subprocess.DEVNULL, check=True)
    print("the same bytes" if table.read_bytes() == (whole / "designs.csv").read_bytes() else "OTHER BYTES")


def campaign(wanted: bool, generations: int = 3000) -> None:
    """100 designs and 3000 generations, as the dissertation has: what it costs, and how much of it in Rust."""
    import dataclasses
    import tempfile
    import time

    from pennate._optimize import _evaluate

    inside = [0.0]
    solve = _evaluate.Solver.__call__

    def timed(solver: Any, x: Values, slopes: bool) -> Any:
        begin = time.process_time()
        answers = solve(solver, x, slopes)
        inside[0] += time.process_time() - begin
        return answers

    _evaluate.Solver.__call__ = timed  # type: ignore[method-assign]
    study = pennate.read_study(HERE / "inverter_study.toml")
    study = dataclasses.replace(study, generations=generations)
    with tempfile.TemporaryDirectory() as folder:
        begin, clock = time.process_time(), time.monotonic()
        outcome = pennate.optimize(study, folder, threads=2)
        total, passed = time.process_time() - begin, time.monotonic() - clock
    _evaluate.Solver.__call__ = solve  # type: ignore[method-assign]
    rest = total - inside[0]
    spent = f"{total:.1f} s of CPU, {inside[0]:.1f} s of them solving, {rest:.1f} s not"
    print(f"{len(outcome.designs)} designs of {100 * generations}: {spent}")
    print(f"on two cores that is {inside[0] / 2 + rest:.1f} s; here it took {passed:.0f} s; hypervolume {volume(outcome):.0f}")


ALL = (boxes, members, stress, shapes, heights, profiles, wing, whole, robust, stage, kills, campaign)
STUDIES: dict[str, Callable[..., None]] = {each.__name__: each for each in ALL}


def main() -> None:
    """Does what the arguments ask for."""
    listed = "\n".join(f"  {name:9} {study.__doc__}" for name, study in STUDIES.items())
    parser = argparse.ArgumentParser(epilog=listed, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("study", nargs="*", metavar="STUDY", help="those below")
    parser.add_argument("--draw", action="store_true", help="draw the pictures of the book")
    given = parser.parse_args()
    for name in given.study:
        if name not in STUDIES:
            parser.error(f"there is no study '{name}'; there are {', '.join(STUDIES)}")
    for name in given.study:
        print(f"{name}: {STUDIES[name].__doc__}")
        STUDIES[name](given.draw)
    if not given.study:
        parser.print_help()


if __name__ == "__main__":
    main()
