"""`sweep.csv` and `sweep.json`, as `pennate sweep` writes them: rows that are there are not solved again."""

from __future__ import annotations

import csv
import io
import itertools
import json
import math
import os
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
import numpy.typing as npt

from .. import _core
from .._network import Network
from ._job import Answers
from ._plan import Plan, digits

STABLE = {1: "yes", 0: "no", -1: ""}
KNOWN = {word: value for value, word in STABLE.items()}
# Names of files that come with the program.
LIBRARY = "library/"
# Bytes that are copied at a time.
COPIED = 1 << 20


class Rows:
    """What is known of all designs, an array entry each."""

    def __init__(self, plan: Plan, probes: int) -> None:
        self.plan, self.probes = plan, probes
        self.forget()

    def forget(self) -> None:
        """Nothing is known any more."""
        plan, probes = self.plan, self.probes
        self.values = np.full((plan.count, probes), np.nan)
        self.stable = np.full(plan.count, -1, dtype=np.int8)
        self.error = np.full(plan.count, np.nan)
        # Texts that many rows share are kept once.
        self.status: npt.NDArray[np.object_] = np.full(plan.count, "", dtype=object)
        self.reason: npt.NDArray[np.object_] = np.full(plan.count, "", dtype=object)
        self.known = np.zeros(plan.count, dtype=bool)

    def take(self, numbers: npt.NDArray[np.int64], found: Answers) -> None:
        """Takes the answers of some designs."""
        self.values[numbers], self.stable[numbers] = found.values, found.stable
        # Two digits are more than an estimate has.
        self.error[numbers] = [float(f"{error:.1e}") for error in found.error.tolist()]
        self.status[numbers], self.reason[numbers] = found.status, ""
        for place, reason in found.reasons.items():
            self.reason[numbers[place]] = " ".join(reason.split())
        self.known[numbers] = True

    def lines(self, begin: int, end: int) -> list[str]:
        """Consecutive rows as they are written."""
        part = slice(begin, end)
        columns = [_numbers(column) for column in self.values[part].T.tolist()]
        stable = [STABLE[value] for value in self.stable[part].tolist()]
        error = [_estimate(value) for value in self.error[part].tolist()]
        reason = [_quoted(text) for text in self.reason[part].tolist()]
        keys = list(zip(*self.plan.keys(begin, end)))
        return list(map(",".join, zip(*keys, self.status[part].tolist(), stable, *columns, error, reason)))


def _numbers(values: list[float]) -> list[str]:
    """Numbers as `digits` writes them; nothing where there is none. All at once is three times as fast."""
    texts = repr(values)[1:-1].split(", ")
    return [
        text if text[-2:] != ".0" and "e" not in text and text != "nan" else "" if math.isnan(value) else digits(value)
        for text, value in zip(texts, values)
    ]


def _estimate(error: float) -> str:
    if math.isnan(error):
        return ""
    mantissa, _, exponent = f"{error:.1e}".partition("e")
    return f"{mantissa}e{int(exponent)}"


def _quoted(text: str) -> str:
    return '"' + text.replace('"', '""') + '"' if "," in text or '"' in text else text


class Table:
    """The table of a sweep in a directory, which grows while the sweep runs."""

    def __init__(self, directory: Path, head: list[str], manifest: dict[str, Any], rows: Rows) -> None:
        self.path, self.manifest_path = directory / "sweep.csv", directory / "sweep.json"
        self.head, self.manifest, self.rows = head, manifest, rows
        # Where the row of each design is in the file, so that no row is put together twice.
        self.begins, self.ends = np.zeros(rows.plan.count, dtype=np.int64), np.zeros(rows.plan.count, dtype=np.int64)
        # Held open: whoever else writes a table to that place puts another file there, and this one stays as it is.
        self.file: BinaryIO | None = None

    def begin(self, overwrite: bool) -> None:
        """Takes over what an earlier run left, and begins the table anew with that."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        why: str | None = "there is none"
        if self.path.exists():
            why = self._earlier()
            if why and not overwrite:
                self._close()
                raise FileExistsError(f"{self.path} is that of another sweep: {why}; give another directory, or overwrite=True")
        if why:
            self.rows.forget()
            _write(self.manifest_path, [json.dumps(self.manifest, indent=2).encode()])
        self._write_whole()

    def add(self, numbers: npt.NDArray[np.int64]) -> None:
        """Appends rows that were solved."""
        file = self.file
        assert file is not None, "a table is begun before rows are added"
        place = file.seek(0, os.SEEK_END)
        # Numbers of a chunk are consecutive but for those that were known.
        for run in np.split(numbers, np.flatnonzero(np.diff(numbers) != 1) + 1):
            lines = [f"{line}\n".encode() for line in self.rows.lines(int(run[0]), int(run[-1]) + 1)]
            self.ends[run] = place + np.cumsum([len(line) for line in lines])
            self.begins[run] = self.ends[run] - [len(line) for line in lines]
            place = int(self.ends[run[-1]])
            file.write(b"".join(lines))
        file.flush()

    def end(self) -> None:
        """Writes the whole table in the order of the designs."""
        try:
            self._write_whole()
        finally:
            self._close()

    def _close(self) -> None:
        if self.file is not None:
            self.file.close()

    def _write_whole(self) -> None:
        """The head, and the rows that are known, in order; then the file is that one."""
        known = np.flatnonzero(self.rows.known)
        begins, ends = self.begins[known], self.ends[known]
        out = io.StringIO()
        csv.writer(out, lineterminator="\n").writerow(self.head)
        top = out.getvalue().encode()
        _write(self.path, itertools.chain([top], _copied(self.file, begins, ends)))
        self._close()
        self.file = self.path.open("r+b")
        self.ends[known] = len(top) + np.cumsum(ends - begins)
        self.begins[known] = self.ends[known] - (ends - begins)

    def _earlier(self) -> str | None:
        """Reads the rows that there are; what is different, where they are those of another sweep."""
        try:
            known = json.loads(self.manifest_path.read_text(encoding="utf-8"))
            # The muscles that come with the program are known by its version.
            known["sources"] = [source for source in known["sources"] if not source[0].startswith(LIBRARY)]
        except (OSError, ValueError, TypeError, KeyError):
            return "there is no sweep.json that says what it belongs to"
        if known["sources"] != self.manifest["sources"]:
            return "its network or what was set in it was different"
        if known.get("accuracy") != self.manifest["accuracy"]:
            return "its accuracy was different"
        if known != self.manifest:
            return "another version of pennate wrote it"
        beyond = 0
        self.file = self.path.open("rb")
        lines = _Lines(self.file)
        records = csv.reader(lines)
        if next(records, None) != self.head:
            return "its columns are different"
        begin = lines.place
        for record in records:
            beyond += not self._read(record, begin, lines.place)
            begin = lines.place
        if beyond:
            return f"it holds {beyond} row{'s' * (beyond > 1)} that this sweep does not ask for"
        return None

    def _read(self, record: list[str], begin: int, end: int) -> bool:
        """Takes a row from its place in the file; whether the sweep asks for it. What is no row is left, to be solved again."""
        rows, width = self.rows, len(self.rows.plan.heads)
        if len(record) != len(self.head) or record[width + 1] not in KNOWN or record[width] == "interrupted":
            return True
        try:
            values = [float(cell) if cell else np.nan for cell in record[width + 2 : -2]]
            error = float(record[-2]) if record[-2] else np.nan
        except ValueError:
            return True
        number = rows.plan.number(record[:width])
        if number is None:
            return False
        rows.values[number], rows.error[number] = values, error
        rows.status[number], rows.stable[number], rows.reason[number] = record[width], KNOWN[record[width + 1]], record[-1]
        rows.known[number], self.begins[number], self.ends[number] = True, begin, end
        return True


def _copied(file: BinaryIO | None, begins: npt.NDArray[np.int64], ends: npt.NDArray[np.int64]) -> Iterator[bytes]:
    """Parts of a file; neighbours that follow each other in it are copied together."""
    if file is None or not len(begins):
        return
    apart = np.flatnonzero(begins[1:] != ends[:-1])
    for first, last in zip(begins[np.r_[0, apart + 1]].tolist(), ends[np.r_[apart, -1]].tolist()):
        file.seek(first)
        for place in range(first, last, COPIED):
            yield file.read(min(COPIED, last - place))


class _Lines:
    """Whole lines of a file, and how far it was read: a run that was cut off may have left half a row at the end."""

    def __init__(self, file: BinaryIO) -> None:
        self.file, self.place = file, 0

    def __iter__(self) -> Iterator[str]:
        for line in self.file:
            if line.endswith(b"\n"):
                self.place += len(line)
                yield line.decode()


def head(plan: Plan, network: Network, probes: Iterable[str]) -> list[str]:
    """Columns, with the units of probes."""
    units = network.probes

    def with_unit(probe: str) -> str:
        unit = units[probe.partition("@")[0].strip()]
        return f"{probe} ({unit})" if unit else probe

    return [*plan.heads, "status", "stable", *(with_unit(probe) for probe in probes), "error", "reason"]


def manifest(network: Network, accuracy: float, method: str) -> dict[str, Any]:
    """What a table belongs to."""
    sources = [list(source) for source in network._sources()]
    sources += [[f"--set {name}", value] for name, value in network._read.parts()[3]]
    if method != "solve":
        sources.append(["--method", method])
    return {"format": "pennate-sweep/1", "version": _core.__version__, "accuracy": accuracy, "sources": sources}


def _write(path: Path, parts: Iterable[bytes]) -> None:
    """Writes a file beside its place and moves it there once it is complete."""
    beside = path.with_name(f".pennate-{os.getpid()}-{path.name}")
    try:
        with beside.open("wb") as file:
            file.writelines(parts)
        beside.replace(path)
    finally:
        beside.unlink(missing_ok=True)
