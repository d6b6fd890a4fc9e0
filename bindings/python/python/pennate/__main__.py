"""The program: the same arguments as the Rust program, and more: `view` shows a live page, `plot` draws, `report` writes a page, `optimize` looks for designs."""

from __future__ import annotations

import importlib
import signal
import sys
from collections.abc import Sequence

from . import _core

# Commands that are done here, and the modules that do them; the program names them in its help.
HERE = {"optimize": "_optimize", "plot": "pictures", "report": "_report", "view": "_view"}


def main(arguments: Sequence[str] | None = None) -> int:
    """Does what the arguments ask for, and returns the exit status."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    if arguments[:1] == ["help"] and len(arguments) == 2 and arguments[1] in HERE:
        arguments = [arguments[1], "--help"]
    if arguments and arguments[0] in HERE:
        command = importlib.import_module(f".{HERE[arguments[0]]}.__main__", __package__)
        status: int = command.main(arguments[1:])
        return status
    # The program listens for interrupts itself.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _core.main(arguments)


if __name__ == "__main__":
    sys.exit(main())
