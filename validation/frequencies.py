#!/usr/bin/env python3
"""Prints the frequencies of 19_natural_frequencies beside those of `pennate modes`, as a Markdown table.

Usage: validation/frequencies.py PENNATE, the path of the built program. Python's standard library is enough.
"""

import json
import pathlib
import subprocess
import sys

FOLDER = pathlib.Path(__file__).parent / "19_natural_frequencies"
# Network file, arguments, and the entry of the reference.
RUNS = [
    ("C", "cantilever.toml", [], 0),
    ("C0", "cantilever.toml", ["--set", "L=10"], 1),
    ("H straight", "hsim.toml", ["--step", "straight"], 2),
    ("H contracted", "hsim.toml", [], 3),
]


def main(program):
    reference = json.loads((FOLDER / "reference.json").read_text())["results"]
    print("| set | kind | worst relative error | frequencies |")
    print("|---|---|---:|---:|")
    for name, file, arguments, entry in RUNS:
        command = [program, "modes", str(FOLDER / file), "--count", "60", "--json", *arguments]
        found = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        angular = [mode["angular_frequency"] for mode in found["modes"] if mode["angular_frequency"]]
        for kind in ("bending", "axial", "torsion"):
            expected = [float(text) for text in reference[entry].get(f"{kind}_angular_frequencies_rad_s", [])]
            errors = [min(abs(value / one - 1) for value in angular) for one in expected]
            if errors:
                print(f"| {name} | {kind} | {max(errors):.1e} | {len(errors)} |")


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
