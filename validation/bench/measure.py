"""Measures the other programs on the seven problems; prints comma-separated values as examples/formulations.rs does.

    python measure.py              every program on every problem
    python measure.py kratos       one program

A point is a fresh process on one thread. It looks for the fewest equal load steps, of those below, that reach the right
equilibrium, and takes the least CPU time of several solves with so many, the model being built. A program is given the
reference of its own theory, with shear or without.
"""

import importlib
import json
import os
import subprocess
import sys
from importlib.metadata import version
from pathlib import Path

STEPS = [1, 2, 3, 4, 6, 8, 10, 15, 20, 30, 40, 60, 100]
PROGRAMS = ["opensees", "kratos", "exudyn", "skfem"]
# An error above this is another equilibrium, or none.
WRONG = 0.2
PATIENCE = 120  # seconds for one point


def point(program, problem, size):
    import numpy as np
    from problems import PROBLEMS

    module = importlib.import_module(f"program_{program}")
    frame = PROBLEMS[problem][0](size)
    reference = np.array(frame.references[module.THEORY])
    for steps in STEPS:
        try:
            displacement, seconds = module.solve(frame, steps)
        except Exception:  # noqa: BLE001 - it has failed, whatever it says
            continue
        error = float(np.linalg.norm(np.array(displacement) - reference) / np.linalg.norm(reference))
        if not error < WRONG:
            continue
        repeats = 1 if seconds > 5 else 3 if seconds > 0.5 else 9
        seconds = min([seconds, *(module.solve(frame, steps)[1] for _ in range(repeats))])
        return {"elements": len(frame.conn), "error": error, "seconds": seconds, "steps": steps}
    return None


def environment():
    own = dict(os.environ, OMP_NUM_THREADS="1")
    # OpenSeesPy brings libraries of its own, and finds them where the system has none only so.
    libraries = next(Path(sys.prefix).glob("lib/python*/site-packages/openseespylinux/lib"), None)
    if libraries:
        own["LD_LIBRARY_PATH"] = f"{libraries}:{own.get('LD_LIBRARY_PATH', '')}"
    return own


def main():
    if sys.argv[1:2] == ["--point"]:
        print("@" + json.dumps(point(sys.argv[2], sys.argv[3], int(sys.argv[4]))))
        return
    from problems import PROBLEMS

    for program in sys.argv[1:] or PROGRAMS:
        package = importlib.import_module(f"program_{program}").PACKAGE
        print(f"{program}: {package} {version(package)}", file=sys.stderr)
    print("problem,program,version,elements,error,steps,milliseconds")
    for problem, (make, sizes) in PROBLEMS.items():
        for program in sys.argv[1:] or PROGRAMS:
            module = importlib.import_module(f"program_{program}")
            release = version(module.PACKAGE)
            if not getattr(module, "serves", lambda frame: True)(make(sizes[0])):
                continue
            for size in sizes:
                command = [sys.executable, __file__, "--point", program, problem, str(size)]
                try:
                    run = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, env=environment())
                except subprocess.TimeoutExpired:
                    print(f"{program}, {problem}, {size}: no answer in {PATIENCE} s", file=sys.stderr)
                    break
                answers = [line[1:] for line in run.stdout.splitlines() if line.startswith("@")]
                found = json.loads(answers[0]) if answers else None
                if found is None:
                    print(f"{program}, {problem}, {size}: no equilibrium found", file=sys.stderr)
                    continue
                row = [f'"{problem}"', program, release, found["elements"], f"{found['error']:.3e}", found["steps"], f"{1e3 * found['seconds']:.4f}"]
                print(",".join(map(str, row)), flush=True)


if __name__ == "__main__":
    main()
