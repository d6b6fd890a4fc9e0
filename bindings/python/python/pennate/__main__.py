"""The program: the same arguments as the Rust program, and more: `view` shows a live page, `plot` draws, `report` writes a page, `optimize` looks for designs."""

from __future__ import annotations

import signal
import sys
from collections.abc import Sequence

from . import _core

MORE = """
With this package also:
  optimize  Look for designs: pennate optimize STUDY.toml -o DIR
  plot      Draw a network file, or the results of one: pennate plot FILE -o picture.png (or .gif, .mp4)
  view      Show a network file as a page with sliders: pennate view FILE
  report    Write one page to send to a colleague: pennate report FILE -o report.html
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Does what the arguments ask for, and returns the exit status."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    if arguments[:1] == ["plot"]:
        from .pictures.__main__ import main as plot

        return plot(arguments[1:])
    if arguments[:1] == ["view"]:
        from ._view.__main__ import main as view

        return view(arguments[1:])
    if arguments[:1] == ["report"]:
        from ._report.__main__ import main as report

        return report(arguments[1:])
    if arguments[:1] == ["optimize"]:
        from ._optimize.__main__ import main as search

        return search(arguments[1:])
    # The program listens for interrupts itself.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    status = _core.main(arguments)
    if arguments in (["--help"], ["-h"], ["help"]):
        print(MORE, end="")
    return status


if __name__ == "__main__":
    sys.exit(main())
