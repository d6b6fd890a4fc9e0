"""One page that says all of a run: a picture that turns, results with errors, curves, and what the run said.

The page needs nothing but itself: no request leaves it, and the picture is drawn by WebGL 2 without a library.
"""

from __future__ import annotations

import os
import pathlib
from typing import TYPE_CHECKING

from ._page import page

if TYPE_CHECKING:
    from .._solution import Solution

__all__ = ["check", "page", "write"]


def write(solution: Solution, output: str | os.PathLike[str]) -> None:
    """Writes the report of a solution, which must have its shapes."""
    target = pathlib.Path(output)
    check(target)
    target.write_text(page(solution), encoding="utf-8")


def check(output: pathlib.Path) -> None:
    """Refuses what is no page before anything is solved or written."""
    if output.suffix.lower() not in (".html", ".htm"):
        raise ValueError(f"{output}: a page is an .html")
