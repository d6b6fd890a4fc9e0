"""Draws error against run time, and writes the least time to three accuracies as a page with a table.

    python chart.py PENNATE.csv OTHERS.csv PICTURE.svg PAGE.md

PENNATE.csv is what examples/formulations.rs --csv prints, OTHERS.csv what measure.py prints.
"""

import csv
import sys
from collections import defaultdict
from pathlib import Path

import matplotlib

matplotlib.use("svg")
matplotlib.rcParams.update({"svg.hashsalt": "pennate", "svg.fonttype": "none", "font.size": 8})
import matplotlib.pyplot as plt

TARGETS = [1e-3, 1e-4, 1e-6]
STYLES = {
    "pennate, order 4": ("#08306b", "o-"),
    "pennate, order 3": ("#2171b5", "s-"),
    "pennate, order 2": ("#6baed6", "^-"),
    "pennate, order 1": ("#9ecae1", "v-"),
    "pennate, corotational": ("#cb181d", "D-"),
    "OpenSees": ("#525252", "x--"),
    "Kratos": ("#238b45", "+--"),
    "Exudyn": ("#d94801", "1--"),
    "scikit-fem": ("#6a51a3", "2--"),
}
NAMES = {"opensees": "OpenSees", "kratos": "Kratos", "exudyn": "Exudyn", "skfem": "scikit-fem"}


def read(pennate, others):
    """Points (milliseconds, error) by problem and program, in the order of the files; versions of the others."""
    points, versions = defaultdict(lambda: defaultdict(list)), {}
    with open(pennate) as file:
        for row in csv.DictReader(file):
            exact = row["formulation"] == "exact"
            name = f"pennate, order {row['order']}" if exact else "pennate, corotational"
            points[row["problem"]][name].append((float(row["milliseconds"]), float(row["error"])))
    with open(others) as file:
        for row in csv.DictReader(file):
            name = NAMES[row["program"]]
            versions[name] = row["version"]
            points[row["problem"]][name].append((float(row["milliseconds"]), float(row["error"])))
    return points, versions


def draw(points, picture):
    figure, axes = plt.subplots(2, 4, figsize=(11, 5.6), sharey=True)
    axes = axes.ravel()
    for axis, (problem, programs) in zip(axes, points.items()):
        for name, (colour, style) in STYLES.items():
            if name in programs:
                times, errors = zip(*programs[name])
                axis.loglog(times, errors, style, color=colour, markersize=3.5, linewidth=1, label=name)
        axis.set_title(problem)
        axis.set_ylim(1e-10, 1)
        axis.grid(True, which="major", linewidth=0.3)
        axis.set_xlabel("time, ms")
    for axis in axes[:: 4]:
        axis.set_ylabel("error of the displacement")
    handles = {}
    for axis in axes:
        handles.update(zip(*reversed(axis.get_legend_handles_labels())))
    for axis in axes[len(points):]:
        axis.axis("off")
    axes[len(points)].legend([handles[name] for name in STYLES if name in handles], [name for name in STYLES if name in handles], loc="center")
    figure.tight_layout()
    figure.savefig(picture, metadata={"Date": None})


HEADER = """\
# Error against run time

How long pennate and other programs take to an error of a given size. Written by `validation/bench.sh`, which measures all of them one after
the other on the machine at hand: {machine}.

![Error of a displacement against the time of the solve]({picture})

Every program meshes the same seven problems finer and finer, every segment of every member alike. The error is that of
the displacement of one node, over its norm, against a solution known to nine digits or more for the program's own
theory: OpenSees' beams have no shear, all others have. Pennate's elastica is Euler's, that of the others a slender rod;
the plate of the tripod is rigid in pennate, and a star of stiff bars in the others.

Times are those of the solve on one thread, the network being read. The others are given the fewest equal load steps
that lead to the right equilibrium, plain Newton, and the fastest of their linear solvers that were tried; the time to
build their model is left out. scikit-fem has no rods: one of order 3 is written in its forms, for problems that are one
plane chain, `validation/bench/program_skfem.py`. Pennate's is the time from a structure to its equilibrium, steps of its own choice and
checks of stability included. `order` is that of exact elements.

The least time in milliseconds to an error no larger than that in the second column; – where no mesh tried got there:

"""


def machine():
    names = [line.split(":")[1].strip() for line in open("/proc/cpuinfo") if line.startswith("model name")]
    return names[0] if names else "unknown"


def table(points, versions):
    lines = []
    names = [name for name in STYLES if any(name in programs for programs in points.values())]
    titles = [f"{name} {versions[name]}" if name in versions else name for name in names]
    lines.append("| problem | error | " + " | ".join(titles) + " |")
    lines.append("|---|---:|" + "---:|" * len(names))
    for problem, programs in points.items():
        for target in TARGETS:
            least = [min((t for t, error in programs.get(name, []) if error <= target), default=None) for name in names]
            known = [time for time in least if time is not None]
            shown = ["–" if t is None else f"**{t:.3g}**" if t == min(known) else f"{t:.3g}" for t in least]
            lines.append(f"| {problem} | {target:.0e} | " + " | ".join(shown) + " |")
    return "\n".join(lines) + "\n"


def main():
    pennate, others, picture, page = sys.argv[1:]
    points, versions = read(pennate, others)
    draw(points, picture)
    text = table(points, versions)
    print(text, end="")
    Path(page).write_text(HEADER.format(machine=machine(), picture=Path(picture).name) + text)


if __name__ == "__main__":
    main()
