"""`pennate optimize STUDY.toml -o DIR`."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from .._errors import Error
from ._run import optimize


def main(arguments: Sequence[str]) -> int:
    """Runs a study, and returns the exit status: 0, 1 where nothing feasible was found, 2 for a wrong input, 130."""
    parser = argparse.ArgumentParser("pennate optimize", description="Looks for designs of a network.")
    parser.add_argument("study", help="study file, TOML")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="where designs.csv and the rest are written")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="give a parameter another value")
    parser.add_argument("--seed", type=int, metavar="N", help="in place of that of the study")
    parser.add_argument("--threads", type=int, metavar="N", help="the files are the same with any number")
    parser.add_argument("--budget", type=float, default=float("inf"), metavar="N", help="designs to solve at most")
    given = parser.parse_args(list(arguments))
    settings = {}
    for text in given.set:
        name, _, value = text.partition("=")
        try:
            settings[name.strip()] = float(value)
        except ValueError:
            print(f"error: --set {text} is not NAME=VALUE\nhelp: write for example --set D=360", file=sys.stderr)
            return 2
    try:
        outcome = optimize(
            given.study, given.output, settings=settings, seed=given.seed, threads=given.threads, budget=given.budget
        )
    except Error as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        print("interrupted; the same command goes on from here", file=sys.stderr)
        return 130
    failed = sum(design.status != "solved" for design in outcome.designs)
    print(f"{len(outcome.designs)} designs, {outcome.solved} of them solved now, {failed} without an answer")
    for design in outcome.best[:1] + outcome.best[1:][-1:]:
        print(f"design {design.number}: " + ", ".join(f"{w.name} {v:.6g}" for w, v in zip(outcome.study.wanted, design.wanted)))
    if not outcome.best:
        print("no design meets all constraints", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
