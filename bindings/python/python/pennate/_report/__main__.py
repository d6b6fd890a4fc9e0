"""`pennate report`: from a network file to one page that can be sent to a colleague."""

from __future__ import annotations

import argparse
import pathlib
import sys
from collections.abc import Sequence

from .. import _commands

EXAMPLES = """examples:
  pennate report dyad.toml -o report.html
  pennate report dyad.toml --set beta=30 -o beta30.html
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line; returns the exit status."""
    parsed = parser().parse_args(arguments)
    from .._errors import Error
    from . import check, write

    try:
        check(parsed.output)
        _commands.check_output(parsed)
        solution = _commands.solution(parsed)
        write(solution, parsed.output)
    except (Error, OSError, ValueError) as error:
        return _commands.wrong(error)
    size = parsed.output.stat().st_size
    print(f"{parsed.output}: {size / 1e6:.1f} MB, one page that needs nothing else")
    return _commands.status(solution)


def parser() -> argparse.ArgumentParser:
    """What the command line understands."""
    description = "From a network file to one page: a picture that turns, results with errors, curves, what the run said."
    found = _commands.parser("report", description, EXAMPLES)
    found.add_argument("-o", "--output", type=pathlib.Path, required=True, help="the page: .html")
    return found


if __name__ == "__main__":
    sys.exit(main())
