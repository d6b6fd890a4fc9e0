"""`pennate report`: from a network file to one page that can be sent to a colleague."""

from __future__ import annotations

import argparse
import pathlib
import sys
from collections.abc import Sequence

from .._settings import setting

EXAMPLES = """examples:
  pennate report dyad.toml -o report.html
  pennate report dyad.toml --set beta=30 -o beta30.html
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line; returns the exit status."""
    parsed = parser().parse_args(arguments)
    from .. import load
    from .._errors import Error
    from . import write

    try:
        network = load(parsed.source).set(**dict(parsed.settings))
        solution = network.solve(accuracy=parsed.accuracy)
        for finding in (*solution.warnings, *solution.failures):
            print(finding, file=sys.stderr)
        write(solution, parsed.output)
    except (Error, OSError, ValueError) as error:
        text = str(error)
        print(text if text.startswith("error") else f"error: {text}", file=sys.stderr)
        return 2
    size = parsed.output.stat().st_size
    print(f"{parsed.output}: {size / 1e6:.1f} MB, one page that needs nothing else")
    return 0 if solution.status == "converged" else 1


def parser() -> argparse.ArgumentParser:
    """What the command line understands."""
    found = argparse.ArgumentParser(
        prog="pennate report",
        description="From a network file to one page: a picture that turns, results with errors, curves, what the run said.",
        epilog=EXAMPLES,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = found.add_argument
    add("source", type=pathlib.Path, help="a network file")
    add("-o", "--output", type=pathlib.Path, required=True, help="the page: .html")
    add("--set", dest="settings", type=setting, action="append", default=[], metavar="NAME=VALUE", help="a parameter")
    add("--accuracy", type=float, default=1e-6, help="discretization error asked for")
    return found


if __name__ == "__main__":
    sys.exit(main())
