"""What is told on the way: a line in the terminal, and the picture on disk."""

from __future__ import annotations

import math
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TextIO

from . import _picture
from ._evaluate import Evaluator
from ._study import Study
from ._table import Design

# A picture is drawn again after so many times as long as it took to draw: a tenth of the time goes into pictures.
APART = 10.0
# Seconds between two lines where nobody can overwrite one, and in a terminal.
LINES, REDRAWN = 10.0, 0.1


class Picture:
    """Keeps the picture of a search current without holding it up."""

    def __init__(self, study: Study, directory: Path, evaluator: Evaluator, wanted: bool = True) -> None:
        self.study, self.evaluator = study, evaluator
        self.path = directory / _picture.name(study)
        self.next = 0.0
        self.wanted = wanted and _picture.can_draw()

    def __call__(self, best: Sequence[Design], picks: Sequence[Design] = (), at_once: bool = False) -> None:
        if not self.wanted or time.monotonic() < self.next and not at_once:
            return
        _picture.load()
        begin = time.monotonic()
        designs = self.evaluator.designs
        _picture.draw(self.study, self.path, designs, best, picks, self.evaluator.progress)
        end = time.monotonic()
        self.next = end + APART * (end - begin)


class Terminal:
    """A line that tells how far a search is; in a terminal it stays in its place."""

    def __init__(self, study: Study, stream: TextIO | None = None) -> None:
        self.study = study
        self.stream = sys.stderr if stream is None else stream
        self.begin = time.monotonic()
        self.last = -math.inf
        self.line = ""
        self.in_place = self.stream.isatty()

    def __call__(self, entry: dict[str, float]) -> None:
        """Tells of a batch."""
        self.line = self._words(entry)
        now = time.monotonic()
        if now < self.last + (REDRAWN if self.in_place else LINES):
            return
        self.last = now
        self._show()

    def close(self) -> None:
        """Shows the last line and leaves it."""
        if self.line:
            self._show()
            if self.in_place:
                print(file=self.stream)
        self.line = ""

    def _show(self) -> None:
        # Back to the start of the line, and away with what stands behind it.
        text = f"\r{self.line}\x1b[K" if self.in_place else f"{self.line}\n"
        print(text, end="", file=self.stream, flush=True)

    def _words(self, entry: dict[str, float]) -> str:
        seconds = int(time.monotonic() - self.begin)
        most = f" of {self.study.generations}" if self.study.method != "least-squares" else ""
        parts = [f"batch {entry['batch']:.0f}{most}", f"{entry['solved']:,.0f} designs"]
        if entry["failed"]:
            parts.append(f"{entry['failed']:,.0f} without an answer")
        for key, word in (("hypervolume", "hypervolume"), ("best", "error" if self.study.targets else "best")):
            value = entry.get(key, math.nan)
            if math.isfinite(value):
                signed = -value if key == "best" and self.study.objectives and self.study.objectives[0].sign < 0 else value
                parts.append(f"{word} {signed:.6g}")
        return ", ".join(parts) + f"  {seconds // 3600}:{seconds // 60 % 60:02}:{seconds % 60:02}"
