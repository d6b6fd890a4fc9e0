"""What searches cost, and what they survive."""

from __future__ import annotations

import random
import resource
import shutil
import subprocess
import sys
import time

from common import HERE, KEPT, run, volume


def kills(wanted: bool, moments: int = 10) -> None:
    """A search that is killed at ten random moments and gone on with, against one that is not: the same bytes."""

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


def campaign(wanted: bool) -> None:
    """100 designs and 3000 generations, as the dissertation has: what the command takes on two cores, table and pictures included."""

    folder = KEPT / "campaign"
    shutil.rmtree(folder, ignore_errors=True)
    command = [sys.executable, "-m", "pennate", "optimize", str(HERE / "campaign_study.toml"), "-o", str(folder)]
    begin = time.monotonic()
    subprocess.run([*command, "--threads", "2"], check=True)
    spent, passed = resource.getrusage(resource.RUSAGE_CHILDREN), time.monotonic() - begin
    print(f"{passed:.1f} s, {spent.ru_utime:.1f} s of CPU and {spent.ru_stime:.1f} s in the system, {spent.ru_maxrss / 1e3:.0f} MB")
    # Once more without anything to solve: what is left is the search, the table and the pictures.
    begin = time.monotonic()
    outcome = run("campaign", "campaign")
    print(f"gone on with, nothing is solved: {time.monotonic() - begin:.1f} s; hypervolume {volume(outcome):.0f}")
