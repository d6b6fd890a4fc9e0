"""Runs the studies of this folder, prints what came of them, and draws the pictures of docs/synthesis.md.

    python studies/run.py boxes            one of them; without a name, a list
    python studies/run.py boxes --draw     with its picture in docs/

Designs are kept in target/studies: what was solved once is not solved again.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable

from costs import campaign, kills
from flows import flow
from fronts import boxes, members, robust, stage, strained, stress, whole, wing
from shapes import heights, profiles, shapes

ALL = (flow, boxes, members, strained, stress, shapes, heights, profiles, wing, whole, robust, stage, kills, campaign)
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
