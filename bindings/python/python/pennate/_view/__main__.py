"""`pennate view`: a network file as a local page with sliders, which follows the file as it changes."""

from __future__ import annotations

import argparse
import pathlib
import signal
import sys
import threading
import webbrowser
from collections.abc import Sequence

from .. import _commands
from .._commands import setting

EXAMPLES = """examples:
  pennate view dyad.toml
  pennate view dyad.toml --set beta=30 --range pressure=0:25
  pennate view dyad.toml --no-browser --port 9000

The page is for this machine alone, and its address has a random key. From another machine, best through ssh:
  ssh -L 8080:127.0.0.1:8080 server      then open the address that the program printed there
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """The command line; returns the exit status."""
    parsed = parser().parse_args(arguments)
    from .._errors import Error

    try:
        from . import Session
    except ImportError as error:
        return _commands.missing(error, "shows pages")
    try:
        network = _commands.network(parsed)
        network.check()
        session = Session(
            network,
            parsed.source,
            settings=dict(parsed.settings),
            ranges=dict(parsed.ranges),
            accuracy=parsed.accuracy,
            port=parsed.port,
            bind=parsed.bind,
            hosts=parsed.hosts,
        )
    except (Error, OSError, RuntimeError) as error:
        return _commands.wrong(error)
    print(f"{session.address}\nThe file is watched. Ctrl-C ends the page.", flush=True)
    if parsed.browser:
        webbrowser.open(session.address)
    wait()
    session.stop()
    return 0


def wait() -> None:
    """Until somebody ends the program."""
    ended = threading.Event()
    for each in (signal.SIGINT, signal.SIGTERM):
        signal.signal(each, lambda *_: ended.set())
    ended.wait()


def limits(text: str) -> tuple[str, tuple[float, float]]:
    """NAME=LOW:HIGH."""
    name, value = setting(text)
    low, colon, high = value.partition(":")
    try:
        found = float(low), float(high)
    except ValueError:
        found = (0.0, 0.0)
    if not colon or not found[0] < found[1]:
        raise argparse.ArgumentTypeError("NAME=LOW:HIGH expected, such as beta=10:60")
    return name, found


def parser() -> argparse.ArgumentParser:
    """What the command line understands."""
    description = "A network file as a local page with sliders, which follows the file as it changes."
    found = _commands.parser("view", description, EXAMPLES)
    add = found.add_argument
    add("--range", dest="ranges", type=limits, action="append", default=[], metavar="NAME=LOW:HIGH", help="of a slider")
    add("--port", type=int, default=8080, help="8080, or the next one that is free")
    add("--no-browser", dest="browser", action="store_false", help="open no browser")
    add(
        "--bind",
        default="127.0.0.1",
        metavar="ADDRESS",
        help="the network address to listen at; this machine alone by default",
    )
    add(
        "--host",
        dest="hosts",
        action="append",
        default=[],
        metavar="NAME",
        help="another name of this machine that browsers may use",
    )
    return found


if __name__ == "__main__":
    sys.exit(main())
