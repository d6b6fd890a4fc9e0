"""What `view`, `plot` and `report` have in common: a network file, values of its parameters, and how a mistake is told."""

from __future__ import annotations

import argparse
import pathlib
import sys
from typing import TYPE_CHECKING

from . import _arguments

if TYPE_CHECKING:
    from ._network import Network
    from ._solution import Solution

# The exit status after a mistake.
WRONG = 2


def parser(command: str, description: str, examples: str, source: str = "a network file") -> argparse.ArgumentParser:
    """A command that reads a network file; others add what else it understands."""
    found = argparse.ArgumentParser(
        prog=f"pennate {command}",
        description=description,
        epilog=examples,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    add = found.add_argument
    add("source", type=pathlib.Path, help=source)
    add("--set", dest="settings", type=setting, action="append", default=[], metavar="NAME=VALUE", help="a parameter")
    add("--accuracy", type=relative, default=1e-6, help="discretization error asked for")
    return found


def setting(text: str) -> tuple[str, str]:
    """NAME=VALUE."""
    name, equals, value = text.partition("=")
    if not (equals and name.strip() and value.strip()):
        raise argparse.ArgumentTypeError("NAME=VALUE expected, such as beta=30")
    return name.strip(), value.strip()


def relative(text: str) -> float:
    """A discretization error."""
    try:
        return _arguments.accuracy(float(text))
    except ValueError:
        raise argparse.ArgumentTypeError("a number between 0 and 1 expected, such as 1e-6") from None


def network(parsed: argparse.Namespace) -> Network:
    """The network of the file, with the values that were given."""
    from . import load

    return load(parsed.source).set(**dict(parsed.settings))


def solution(parsed: argparse.Namespace) -> Solution:
    """The solution of the network; what is remarkable is printed."""
    found = network(parsed).solve(accuracy=parsed.accuracy)
    for finding in (*found.warnings, *found.failures):
        print(finding, file=sys.stderr)
    return found


def check_output(parsed: argparse.Namespace) -> None:
    """Refuses an output that is the source."""
    source, output = parsed.source, parsed.output
    if source.resolve() == output.resolve() or (source.exists() and output.exists() and source.samefile(output)):
        raise ValueError(f"{output} is the network file itself, which is not written over; give another file with -o")


def status(found: Solution) -> int:
    """The exit status after a solution."""
    return 0 if found.status == "converged" else 1


def wrong(error: Exception) -> int:
    """Tells a mistake; returns the exit status."""
    text = str(error)
    print(text if text.startswith("error") else f"error: {text}", file=sys.stderr)
    return WRONG


def missing(error: ImportError, what: str) -> int:
    """Tells which library is not there; returns the exit status."""
    print(f"error: {error}\nhelp: pip install 'pennate[view]' installs what {what}", file=sys.stderr)
    return 1
