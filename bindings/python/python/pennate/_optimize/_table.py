"""`designs.csv`: every design that was asked for and solved, in order; and what is read from it when a search goes on."""

from __future__ import annotations

import csv
import dataclasses
import hashlib
import importlib.metadata
import io
import json
import os
from pathlib import Path

import numpy as np
import numpy.typing as npt

from .._core import __version__
from ._study import Study, StudyError

Values = npt.NDArray[np.float64]

# Designs that were not solved: worse than any violation of a constraint.
UNSOLVED = 1e9


@dataclasses.dataclass(frozen=True)
class Design:
    """A design and what came of it."""

    number: int
    batch: int
    x: tuple[float, ...]
    status: str
    probes: tuple[float, ...]
    wanted: tuple[float, ...]
    violation: float
    reason: str


def digits(value: float) -> str:
    """A number that reads as the same double; nothing where there is none."""
    return repr(float(value)) if np.isfinite(value) else ""


class Table:
    """The designs of a study, in memory and in a file that grows by whole batches."""

    def __init__(self, study: Study, directory: Path) -> None:
        self.path = directory / "designs.csv"
        self.study = study
        self.known: dict[tuple[float, ...], Design] = {}
        self.order: list[Design] = []
        names = [each.name for each in study.wanted]
        variables = [each.name for each in study.variables]
        self.head = ["number", "batch", *variables, "status", *study.probes, *names, "violation", "reason"]
        self.key = directory / "study.json"
        directory.mkdir(parents=True, exist_ok=True)
        self._open()

    def facts(self) -> dict[str, str]:
        """What the rows belong to."""
        study = self.study
        sources = {
            "network": study.network.text,
            "parameters": json.dumps({name: study.network.parameters[name] for name in sorted(study.network.parameters)}),
        }
        sources["wanted"] = json.dumps(
            [
                [(each.name, each.value.text) for each in (*study.constraints, *study.wanted)],
                [(each.name, each.least, each.most, each.scale) for each in study.constraints],
                [(each.name, each.wanted) for each in study.targets],
                [(each.name, each.low, each.high) for each in study.variables],
                study.accuracy,
            ]
        )
        # What decides which designs are asked for; generations and stops only say how many.
        library = {"nsga2": "pymoo", "cma-es": "cma"}.get(study.method, "numpy")
        made = [f"{name} {importlib.metadata.version(name)}" for name in sorted({library, "numpy"})]
        search = [study.method, study.seed, study.population, study.screen, study.starts, __version__, made]
        sources["search"] = json.dumps(search)
        return {name: hashlib.sha256(text.encode()).hexdigest() for name, text in sources.items()}

    def _open(self) -> None:
        facts = self.facts()
        if not self.path.exists():
            self._write_head(facts)
            return
        try:
            earlier = json.loads(self.key.read_text(encoding="utf-8"))["sources"]
        except (OSError, ValueError, KeyError, TypeError):
            earlier = None
        if earlier != facts:
            words = {"network": "another network", "parameters": "other parameters", "wanted": "other variables, limits or wishes"}
            words["search"] = "another seed, method, population, or version of a library"
            changed = [words[name] for name, value in facts.items() if earlier is not None and earlier.get(name) != value]
            what = " and ".join(changed) or "something else"
            raise StudyError(
                f"error: {self.path} was solved with {what}\n"
                "help: give another directory with -o, or remove the one that may go"
            )
        self._read()

    def _write_head(self, facts: dict[str, str]) -> None:
        self.key.write_text(json.dumps({"format": "pennate-study-results/1", "sources": facts}, indent=2) + "\n", "utf-8")
        self.path.write_text(_line(self.head), "utf-8", newline="")

    def _read(self) -> None:
        """The rows, but for a last one that an interrupt cut off."""
        text = self.path.read_bytes().decode("utf-8")
        if not text.endswith("\n"):
            text = text[: text.rfind("\n") + 1]
            self.path.write_text(text, "utf-8", newline="")
        rows = list(csv.reader(io.StringIO(text)))
        k, m = len(self.study.variables), len(self.study.probes)
        designs: list[Design] = []
        if not rows:
            self._write_head(self.facts())
            return
        if rows[0] != self.head:
            raise StudyError(f"error: {self.path} has other columns\nhelp: give another directory with -o")
        for row in rows[1:]:
            if len(row) != len(self.head):
                break
            values = [float(each) if each else float("nan") for each in row[2 : 2 + k] + row[3 + k : -2]]
            x, rest = tuple(values[:k]), values[k:]
            violation = float(row[-2]) if row[-2] else float("inf")
            designs.append(
                Design(int(row[0]), int(row[1]), x, row[2 + k], tuple(rest[:m]), tuple(rest[m:]), violation, row[-1])
            )
        for design in designs:
            self.known[design.x] = design
            self.order.append(design)

    def add(self, designs: list[Design]) -> None:
        """Appends the designs of a batch at once."""
        text = "".join(_line(self._row(design)) for design in designs)
        with self.path.open("a", encoding="utf-8", newline="") as file:
            file.write(text)
            file.flush()
            os.fsync(file.fileno())
        for design in designs:
            self.known[design.x] = design
            self.order.append(design)

    def drop_from(self, batch: int) -> None:
        """Takes away the designs of a batch and of all behind it."""
        self.order = [design for design in self.order if design.batch < batch]
        self.known = {design.x: design for design in self.order}
        beside = self.path.with_suffix(".new")
        text = _line(self.head) + "".join(_line(self._row(design)) for design in self.order)
        beside.write_text(text, "utf-8", newline="")
        beside.replace(self.path)

    def _row(self, design: Design) -> list[str]:
        values = [digits(value) for value in design.x]
        after = [digits(value) for value in (*design.probes, *design.wanted)]
        numbers = [str(design.number), str(design.batch)]
        return [*numbers, *values, design.status, *after, digits(design.violation), design.reason]


def _line(cells: list[str]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerow(cells)
    return out.getvalue()
