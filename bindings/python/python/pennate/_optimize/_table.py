"""`designs.csv`: every design that was asked for and solved, in order; and what is read from it when a search goes on."""

from __future__ import annotations

import csv
import hashlib
import importlib.metadata
import io
import json
import math
import os
import time
from pathlib import Path
from typing import NamedTuple

from .._core import __version__
from ._reader import StudyError
from ._study import Study

# Violation of what has no value: worse than any that has one. Its cell is empty.
UNSOLVED = math.inf
# Seconds after which what was written is brought to the disk itself: a machine that loses its power loses no more.
SAFE = 1.0
# The table of designs, what it belongs to, and the files of a search beside them.
TABLE = "designs.csv"
KEY = "study.json"
WRITTEN = (KEY, "front.csv", "best.csv", "progress.csv", "picks.json", "pick_1.toml", "front.svg", "progress.svg")
VERDICTS: dict[bool | None, str] = {True: "true", False: "false", None: ""}


class Design(NamedTuple):
    """A design and what came of it."""

    number: int
    """Counted from one in `designs.csv`; 0 where it was not solved."""
    batch: int
    """The batch that it was asked for in, counted from zero."""
    x: tuple[float, ...]
    """Values of the variables."""
    status: str
    """`"solved"`, `"geometry"`, `"unstable"`, `"no_value"`, or the kind of a `Reason`."""
    stable: bool | None
    """Whether the ends of all steps are stable; `None` where nobody can say."""
    probes: tuple[float, ...]
    """Values of the probes that the study refers to."""
    wanted: tuple[float, ...]
    """Objectives or targets; with tolerances the worst that objectives may be."""
    spread: tuple[float, ...]
    """By how much tolerances worsen each objective; nothing without tolerances."""
    violation: float
    """What constraints are violated by, each over its scale."""
    reason: str
    """Why there is no answer."""
    slopes: tuple[float, ...] = ()
    """Derivatives of the probes by the variables, row after row, where the search asked for them."""


def digits(value: float) -> str:
    """A number that reads as the same double; nothing where there is none."""
    return repr(value) if math.isfinite(value) else ""


def check_owner(directory: Path) -> None:
    """Refuses a directory with files of somebody else that a search would write over."""
    if (directory / TABLE).exists() or _earlier(directory) is not None:
        return
    for name in WRITTEN:
        if (directory / name).exists():
            help = "give another directory with -o: a search would write over it"
            raise StudyError(f"error: {directory / name} is no file of a search\nhelp: {help}")


def _earlier(directory: Path) -> dict[str, str] | None:
    """What a directory belongs to; nothing where it is not one of a search."""
    try:
        sources = json.loads((directory / KEY).read_text(encoding="utf-8"))["sources"]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return sources if isinstance(sources, dict) else None


class Table:
    """The designs of a study, in memory and in a file that grows by whole batches."""

    def __init__(self, study: Study, directory: Path) -> None:
        self.path = directory / TABLE
        self.study = study
        self.known: dict[tuple[float, ...], Design] = {}
        """Designs of the batches that were asked for so far: what comes later in the file is not known yet."""
        self.order: list[Design] = []
        self.batches: dict[int, list[Design]] = {}
        names = [each.name for each in study.wanted]
        variables = [each.name for each in study.variables]
        spread = [f"{name}_spread" for name in names] if study.tolerances else []
        slopes = [f"{probe}/{name}" for probe in study.probes for name in variables]
        slopes = slopes if study.method == "least-squares" else []
        found = [*study.probes, *names, *spread, "violation", "reason", *slopes]
        self.head = ["number", "batch", *variables, "status", "stable", *found]
        self.widths = (len(variables), len(study.probes), len(names), len(spread), len(slopes))
        self.key = directory / KEY
        self.synced = 0.0
        directory.mkdir(parents=True, exist_ok=True)
        self._open()

    def facts(self) -> dict[str, str]:
        """What the rows belong to."""
        study = self.study
        parameters = study.network.parameters
        sources = {
            # Texts alone: a folder with a study may be moved.
            "network": json.dumps([text for _, text in study.network._sources()]),
            "parameters": json.dumps({name: parameters[name] for name in sorted(parameters)}),
        }
        sources["wanted"] = json.dumps(
            [
                [(each.name, each.value.text) for each in (*study.constraints, *study.wanted)],
                [(each.name, each.least, each.most, each.scale) for each in study.constraints],
                [(each.name, each.sign) for each in study.objectives],
                [(each.name, each.wanted, each.weight) for each in study.targets],
                [(each.name, each.low, each.high) for each in study.variables],
                study.tolerances,
                study.accuracy,
            ]
        )
        # What decides which designs are asked for; generations and stops only say how many.
        libraries = {"numpy", {"nsga2": "pymoo", "cma-es": "cma"}.get(study.method, "scipy")}
        made = [f"{name} {importlib.metadata.version(name)}" for name in sorted(libraries)]
        search = [study.method, study.seed, study.population, study.screen, study.starts, study.first.tolist(), __version__, made]
        sources["search"] = json.dumps(search)
        return {name: hashlib.sha256(text.encode()).hexdigest() for name, text in sources.items()}

    def _open(self) -> None:
        facts, earlier = self.facts(), _earlier(self.path.parent)
        if not self.path.exists():
            self._write_head(facts)
            return
        if earlier != facts:
            words = {"network": "another network", "parameters": "other parameters", "wanted": "other variables, limits or wishes"}
            words["search"] = "another seed, method, population, or version of a library"
            changed = [words[name] for name, value in facts.items() if earlier is not None and earlier.get(name) != value]
            what = f"was solved with {' and '.join(changed)}" if changed else "is no table of a search that could go on"
            help = "give another directory with -o, or remove the one that may go"
            raise StudyError(f"error: {self.path} {what}\nhelp: {help}")
        self._read()

    def _write_head(self, facts: dict[str, str]) -> None:
        # The key comes first, and each file appears whole: a table without its key would belong to nobody.
        key = json.dumps({"format": "pennate-study-results/1", "sources": facts}, indent=2) + "\n"
        for path, text in ((self.key, key), (self.path, _lines([self.head]))):
            beside = path.with_name(path.name + ".new")
            beside.write_text(text, "utf-8", newline="")
            beside.replace(path)

    def _read(self) -> None:
        """The rows, but for a last one that an interrupt cut off."""
        written = self.path.read_bytes()
        whole = written[: written.rfind(b"\n") + 1]
        if whole != written:
            os.truncate(self.path, len(whole))
        rows = list(csv.reader(io.StringIO(whole.decode("utf-8"))))
        if not rows:
            self._write_head(self.facts())
            return
        if rows[0] != self.head:
            raise StudyError(f"error: {self.path} has other columns\nhelp: give another directory with -o")
        for line, row in enumerate(rows[1:], 2):
            try:
                self._keep(self._design(row))
            except (ValueError, IndexError):
                help = "remove the table, or give another directory with -o"
                raise StudyError(f"error: line {line} of {self.path} is no design\nhelp: {help}") from None

    def _design(self, row: list[str]) -> Design:
        if len(row) != len(self.head):
            raise ValueError
        places = iter(row)
        number, batch = int(next(places)), int(next(places))

        def values(count: int) -> tuple[float, ...]:
            return tuple(float(cell) if (cell := next(places)) else math.nan for _ in range(count))

        variables, probes, wanted, spread, slopes = self.widths
        x, status, stable = values(variables), next(places), {"true": True, "false": False}.get(next(places))
        found = (values(probes), values(wanted), values(spread))
        violation, reason = float(next(places) or UNSOLVED), next(places)
        if math.isnan(violation):
            raise ValueError
        rates = values(slopes)
        return Design(number, batch, x, status, stable, *found, violation, reason, rates if not all(map(math.isnan, rates)) else ())

    def _keep(self, design: Design) -> None:
        self.order.append(design)
        self.batches.setdefault(design.batch, []).append(design)

    def add(self, designs: list[Design]) -> None:
        """Appends the designs of a batch at once."""
        text = _lines([self._row(design) for design in designs])
        with self.path.open("a", encoding="utf-8", newline="") as file:
            file.write(text)
            file.flush()
            if time.monotonic() > self.synced + SAFE:
                os.fsync(file.fileno())
                self.synced = time.monotonic()
        for design in designs:
            self._keep(design)

    def take(self, batch: int) -> list[Design]:
        """The designs of a batch, which are known from now on."""
        designs = self.batches.get(batch, [])
        self.known.update((design.x, design) for design in designs)
        return designs

    def drop_from(self, batch: int) -> None:
        """Takes away the designs of a batch and of all behind it."""
        kept = [design for design in self.order if design.batch < batch]
        self.order, self.batches = [], {}
        for design in kept:
            self._keep(design)
        beside = self.path.with_suffix(".new")
        beside.write_text(_lines([self.head, *map(self._row, kept)]), "utf-8", newline="")
        beside.replace(self.path)

    def _row(self, design: Design) -> list[str]:
        head = [str(design.number), str(design.batch), *map(digits, design.x), design.status, VERDICTS[design.stable]]
        found = map(digits, (*design.probes, *design.wanted, *design.spread, design.violation))
        slopes = map(digits, design.slopes) if design.slopes else [""] * self.widths[-1]
        return [*head, *found, design.reason, *slopes]


def _lines(rows: list[list[str]]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()
