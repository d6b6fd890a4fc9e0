#!/usr/bin/env python3
"""Prints what `pennate modes` and `pennate buckle` take on every scene and every network of models/networks, as a table.

Times are the processor's in user mode, in milliseconds: medians of runs that take turns, so that a busy machine slows both
alike. Buckling is to take twice the time of vibrations at most; runs end with status 1 where it takes more.

Usage: validation/spectra.py PENNATE [--runs N] [NAME ...], the path of the built program. Python's standard library is enough.
"""

import argparse
import os
import pathlib
import re
import statistics
import subprocess
import sys
import tempfile

NETWORKS = pathlib.Path(__file__).parent.parent / "models" / "networks"
# Of the time of vibrations.
MOST = 2.0


def user_time(command):
    """Milliseconds in user mode, and the exit status."""
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    return 1e3 * usage.ru_utime, process.returncode


def networks(program, folder):
    """Names and files of all scenes and networks."""
    listed = subprocess.run([program, "scene"], check=True, capture_output=True, text=True).stdout
    for name in re.findall(r"^(\w+) ", listed, flags=re.MULTILINE):
        file = pathlib.Path(folder) / f"{name}.toml"
        file.write_text(subprocess.run([program, "scene", name], check=True, capture_output=True, text=True).stdout)
        yield name, file
    for file in sorted(NETWORKS.glob("*.toml")):
        yield file.name, file


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("names", nargs="*", help="these alone")
    parser.add_argument("--runs", type=int, default=9, help="of each command (default 9)")
    arguments = parser.parse_args()
    slow = False
    print("| network | modes, ms | buckle, ms | ratio |")
    print("|---|---:|---:|---:|")
    with tempfile.TemporaryDirectory() as folder:
        for name, file in networks(arguments.program, folder):
            if arguments.names and name not in arguments.names:
                continue
            commands = [[arguments.program, word, "--threads", "1", str(file)] for word in ("modes", "buckle")]
            times = ([], [])
            for _ in range(arguments.runs):
                for command, taken in zip(commands, times):
                    time, status = user_time(command)
                    taken.append(time)
                    if status != 0:
                        taken.append(float("nan"))
            if any(time != time for taken in times for time in taken):
                print(f"| {name} | no answer | | |")
                continue
            modes, buckle = map(statistics.median, times)
            slow |= buckle > MOST * modes
            print(f"| {name} | {modes:.1f} | {buckle:.1f} | {buckle / modes:.2f} |", flush=True)
    return int(slow)


if __name__ == "__main__":
    sys.exit(main())
