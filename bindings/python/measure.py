"""Measures what the package costs beside Rust: import, the call of one design, memory over many calls. Prints a table.

What is more than it may be ends it with status 1.
"""

from __future__ import annotations

import resource
import statistics
import subprocess
import sys
import time

import numpy as np

import pennate
from pennate import _core

IMPORT_S, CALL_US, MEMORY_KIB = 0.2, 5.0, 1024
CALLS = 100_000


def main() -> int:
    """The table, and the exit status."""
    rows = [
        ("import, s", import_time(), IMPORT_S),
        ("call of one design over the same in Rust, µs", call_overhead(), CALL_US),
        (f"memory over {CALLS} calls, KiB", float(memory()), float(MEMORY_KIB)),
    ]
    for what, found, most in rows:
        print(f"{what:46} {found:10.4g}   at most {most:g}{'' if found <= most else '   MISSED'}")
    return int(any(found > most for _, found, most in rows))


def import_time() -> float:
    """Of the package with NumPy, in a new interpreter, beyond that of an empty one: processor time, the median of several."""

    def run(code: str) -> float:
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        subprocess.run([sys.executable, "-c", code], check=True)
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime

    run("import pennate")
    return statistics.median(run("import pennate") - run("pass") for _ in range(9))


def problem() -> pennate.Problem:
    """A small network, on one thread."""
    network = pennate.scene("dyad")
    return network.problem(list(network.parameters)[:2], threads=1)


def call_overhead() -> float:
    """Microseconds of a call beyond what the same evaluations take in Rust, one by one, of this thread's own time."""
    asked = problem()
    x = asked.middle
    count = 200
    differences = []
    for _ in range(25):
        begin = time.thread_time()
        for _ in range(count):
            asked(x)
        middle = time.thread_time()
        asked._call.repeated(x, count)
        end = time.thread_time()
        differences.append(((middle - begin) - (end - middle)) / count)
    return 1e6 * statistics.median(differences)


def memory() -> int:
    """Growth in KiB over many calls: half of them with an answer, half without."""
    asked = problem()
    x = np.stack([asked.middle, np.full(len(asked.middle), np.nan)])

    def run(calls: int) -> int:
        for call in range(calls):
            # Most without a solve, which would take long and hold no more.
            asked(x[1] if call % 50 else x[0])
            asked.reasons
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss

    before = run(CALLS // 10)
    return run(CALLS) - before


if __name__ == "__main__":
    assert _core.__version__ == pennate.__version__
    sys.exit(main())
