#!/usr/bin/env python3
"""Runs every command of the tutorials and of the start page, and compares what it prints with what the pages show.

    docs/tutorials/run.py --program target/release/pennate             runs and compares; Python alone is enough
    docs/tutorials/run.py --program … --write                          puts what was printed into the pages
    validation/.venv/bin/python docs/tutorials/run.py --program … --pictures   draws the pictures anew as well

A block ```toml``` after "Save this as `out/x.toml`:" is that file, one after "Add this to the end of …" is added to it. Every line of
a block ```sh``` is run, from first to last, in a scratch folder for each page, but for `validation/view.sh`; a block ```text```
that follows is what its last command prints. Times are left aside. Numbers agree to 1e-5; those below 1e-4 in magnitude
are errors, and agree to a factor of ten or are less than 1e-7 on both sides. Increments and iterations may differ by a fifth:
on another processor rounding may decide on one more.
"""

import argparse
import csv
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent.parent
FENCE = re.compile(r"(?:^(Save this as|Add this to the end of) `([^`]+)`:\n\n)?^```(\w+)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?")
TOOK = re.compile(r"\s*Took [\d.]+ \w+.*$", re.MULTILINE)
# Pictures are drawn by --pictures.
LEFT_OUT = ("validation/view.sh", "#")
# Errors of the mesh and what rounding leaves: of these only the size counts.
SMALL, ROUNDING = 1e-4, 1e-7
# A row of the table of steps, up to its increments and iterations.
STEP = re.compile(r"^(.* %) +(\d+) +(\d+) ")
# A row of modes: its numbers. Two modes of one frequency may be any two of their motions, in any order.
MODE = re.compile(r"^ +\d+((?: +[-+.e\d]+){2,3}) +(?=[a-z])")

# Pictures by page: shapes of a folder, curves of columns of a history (- turns a sign), or a picture that the program drew.
PICTURES = {
    "muscle.md": [
        ("muscle.png", "shapes", "out/muscle"),
        ("muscle-load.svg", "curve", "out/muscle/history.csv", "load", "force T y (N)", ["deflection (mm)"]),
    ],
    "dyads.md": [
        ("dyad-angles.svg", "copy", "out/angles/sweep.svg"),
        ("row.png", "shapes", "out/row"),
    ],
    "stage.md": [
        ("stage.png", "shapes", "out/stage"),
    ],
    "snap.md": [
        ("snap-path.svg", "curve", "out/strips/history.csv", "press", "down (mm)", ["-force C y (N)"]),
        ("snap-muscle.svg", "curve", "out/pull/history.csv", None, "pressure muscle (psi)", ["down (mm)"]),
    ],
    "gripper.md": [
        ("fit-curves.svg", "copy", "out/curves.svg"),
        ("gripper.png", "shapes", "out/gripper"),
        ("gripper-designs.svg", "copy", "out/designs/sweep.svg"),
    ],
}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("pages", nargs="*", type=pathlib.Path, help="the tutorials and the start page by default")
    parser.add_argument("--program", required=True, type=pathlib.Path, help="the program, such as target/release/pennate")
    parser.add_argument("--write", action="store_true", help="put what was printed into the pages")
    parser.add_argument("--pictures", action="store_true", help="draw the pictures; needs validation/.venv")
    arguments = parser.parse_args()
    pages = arguments.pages or [HERE.parent / "index.md", *sorted(set(HERE.glob("*.md")) - {HERE / "index.md"})]
    failed = 0
    for page in pages:
        with tempfile.TemporaryDirectory() as folder:
            folder = prepared(pathlib.Path(folder), arguments.program.resolve())
            differences = follow(page, folder, arguments.write)
            if arguments.pictures:
                draw(page.name, folder)
        print(f"{page.name}: {'as shown' if not differences else f'{len(differences)} differences'}")
        for difference in differences:
            print(f"  {difference}", file=sys.stderr)
        failed += len(differences)
    sys.exit(1 if failed and not arguments.write else 0)


def prepared(folder, program):
    """A folder that looks like that of the repository, with `pennate` on the path."""
    (folder / "bin").mkdir()
    (folder / "out").mkdir()
    (folder / "bin" / "pennate").symlink_to(program)
    for name in ("models", "validation"):
        (folder / name).symlink_to(ROOT / name)
    return folder


def follow(page, folder, write):
    """Goes through the blocks of a page; what differs, a line each."""
    text = page.read_text(encoding="utf-8")
    differences, printed, replaced = [], None, []
    for block in FENCE.finditer(text):
        verb, name, kind, body = block.groups()
        if kind == "toml" and name:
            added = verb.startswith("Add")
            with open(folder / name, "a" if added else "w", encoding="utf-8") as file:
                file.write(("\n" if added else "") + body)
        elif kind == "sh":
            printed = run(body, folder, page.name, differences)
        elif kind == "text" and printed is not None:
            difference = compare(body, printed)
            if difference:
                line = text.count("\n", 0, block.start()) + 1
                differences.append(f"{page.name}:{line}: {difference}")
            replaced.append((block.start(4), block.end(4), printed))
            printed = None
    if write:
        for start, end, printed in reversed(replaced):
            text = text[:start] + printed + text[end:]
        page.write_text(text, encoding="utf-8")
    return differences


def run(body, folder, page, differences):
    """Runs the commands of a block; what the last of them prints."""
    printed = None
    environment = {**os.environ, "PATH": f"{folder / 'bin'}:{os.environ['PATH']}", "NO_COLOR": "1"}
    for command in body.splitlines():
        if command.startswith(LEFT_OUT):
            continue
        command = command.replace("cargo run --release -- ", "pennate ", 1)
        done = subprocess.run(["bash", "-c", command], cwd=folder, env=environment, text=True, encoding="utf-8",
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        printed = without_times(done.stdout) or printed
        # A step that ends early is said in what the page shows; everything else has to succeed.
        if done.returncode not in (0, 1) or done.returncode == 1 and "error: step" not in done.stdout:
            differences.append(f"{page}: `{command}` ends with status {done.returncode}:\n{done.stdout}")
    return printed


def without_times(text):
    lines = [line.rstrip() for line in TOOK.sub("", text).splitlines()]
    while lines and not lines[-1]:
        lines.pop()
    return "\n".join(lines) + "\n"


def compare(shown, printed):
    """The first line that differs, or nothing."""
    shown, printed = ([line for line in text.splitlines() if line] for text in (shown, printed))
    for ours, theirs in zip(shown, printed):
        if not same(ours, theirs):
            return f"shown\n    {ours}\n  printed\n    {theirs}"
    if len(shown) != len(printed):
        return f"{len(shown)} lines shown, {len(printed)} printed"
    return None


def same(ours, theirs):
    steps = [STEP.match(line) for line in (ours, theirs)]
    if all(steps):
        work = zip(*(map(int, step.groups()[1:]) for step in steps))
        return same(*(step[1] for step in steps)) and all(abs(a - b) <= max(2, 0.2 * a) for a, b in work)
    modes = [MODE.match(line) for line in (ours, theirs)]
    if all(modes):
        ours, theirs = (mode[1] for mode in modes)
    if re.sub(r"[\s─-]+", "", NUMBER.sub("#", ours)) != re.sub(r"[\s─-]+", "", NUMBER.sub("#", theirs)):
        return False
    return all(close(float(a), float(b)) for a, b in zip(NUMBER.findall(ours), NUMBER.findall(theirs)))


def close(a, b):
    large = max(abs(a), abs(b))
    if large < ROUNDING:
        return True
    if large < SMALL:
        return min(abs(a), abs(b)) > 0.1 * large
    return abs(a - b) <= 1e-5 * large


def draw(page, folder):
    for name, kind, *what in PICTURES.get(page, []):
        target = HERE / name
        if kind == "copy":
            shutil.copyfile(folder / what[0], target)
        elif kind == "shapes":
            view = ROOT / "validation" / "view.sh"
            subprocess.run([view, folder / what[0], "-o", target], check=True, stdout=subprocess.DEVNULL)
        else:
            curve(folder / what[0], target, *what[1:])


def curve(table, target, step, across, columns):
    """Columns of a history against one of them, along one step or all of them."""
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams["svg.hashsalt"] = "pennate"
    import matplotlib.pyplot as plots

    with open(table, encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    if step:
        # With the state that the step begins with.
        inside = [index for index, row in enumerate(rows) if row["step"] == step]
        rows = rows[max(inside[0] - 1, 0) : inside[-1] + 1]
    figure, axes = plots.subplots(figsize=(6.4, 3.6), layout="constrained")
    for column in columns:
        name, sign = column.lstrip("-"), -1 if column.startswith("-") else 1
        points = [(float(row[across]), sign * float(row[name])) for row in rows if row[across] and row[name]]
        axes.plot(*zip(*points), marker="o", markersize=3, linewidth=1.5, color="#1f4e8c")
        axes.set_ylabel(column.replace("-", "−"))
    axes.set_xlabel(across)
    axes.grid(alpha=0.3)
    figure.savefig(target, metadata={"Date": None})
    plots.close(figure)


if __name__ == "__main__":
    main()
