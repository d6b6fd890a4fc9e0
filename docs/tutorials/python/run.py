#!/usr/bin/env python3
"""Runs the tutorials in this folder as scripts, each in a folder of its own, and looks for the pictures that it ends with.

    PYTHON docs/tutorials/python/run.py                 all of them, with a Python that has pennate[view,study]
    PYTHON docs/tutorials/python/run.py --keep FOLDER   keeps their pictures there
"""

import argparse
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import time

HERE = pathlib.Path(__file__).resolve().parent
PICTURE = re.compile(r'"([\w-]+\.png)"')


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("names", nargs="*", help="tutorials; all by default")
    parser.add_argument("--keep", type=pathlib.Path, help="where pictures are kept")
    arguments = parser.parse_args()
    scripts = [HERE / f"{name.removesuffix('.py')}.py" for name in arguments.names]
    scripts = scripts or sorted(script for script in HERE.glob("*.py") if script != pathlib.Path(__file__).resolve())
    failed = [script.name for script in scripts if not run(script, arguments.keep)]
    sys.exit(f"failed: {', '.join(failed)}" if failed else 0)


def run(script, keep):
    """Whether a tutorial ran to its end and drew what it names."""
    begin = time.perf_counter()
    with tempfile.TemporaryDirectory() as folder:
        done = subprocess.run([sys.executable, script], cwd=folder, text=True, capture_output=True)
        wanted = PICTURE.findall(script.read_text(encoding="utf-8"))
        missing = [name for name in wanted if not pathlib.Path(folder, name).is_file()]
        if keep and not missing:
            keep.mkdir(parents=True, exist_ok=True)
            for name in wanted:
                shutil.copyfile(pathlib.Path(folder, name), keep / name)
    fine = done.returncode == 0 and wanted and not missing
    print(f"{script.name}: {'fine' if fine else 'FAILED'}, {time.perf_counter() - begin:.1f} s")
    if not fine:
        print(done.stdout, done.stderr, *(f"no {name}" for name in missing), sep="\n", file=sys.stderr)
    return fine


if __name__ == "__main__":
    main()
