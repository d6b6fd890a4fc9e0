"""Places and words for what is wrong in a study file."""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from .._errors import Finding, NetworkError
from ._expression import Expression

KEYS: dict[str, tuple[str, ...]] = {
    "": (
        "format title network seed accuracy variables parameters tolerances constraints objectives targets search pick".split()  # type: ignore[dict-item]
    ),
    "variables": ("from", "to", "start"),
    "constraints": ("value", "least", "most", "scale"),
    "objectives": ("maximize", "minimize"),
    "targets": ("value", "is", "weight"),
    "search": ("method", "population", "generations", "screen", "starts", "stop", "first", "reference"),
    "stop": ("hypervolume_gain", "over", "evaluations", "error", "minutes"),
    "pick": ("ends", "knee", "spread", "best"),
}


class StudyError(NetworkError):
    """A study file is wrong; `errors` says what, where, and what would help."""


class Reader:
    """The tree of a study with the places of its keys."""

    def __init__(self, path: Path, text: str) -> None:
        self.path, self.text = path, text
        self.findings: list[Finding] = []

    def wrong(self, message: str, help: str, *keys: str) -> None:
        """Notes what is wrong at a key."""
        line = self._line(keys)
        text = f"error: {message}\n --> {self.path}{f':{line}' if line else ''}\nhelp: {help}"
        name = keys[-1] if keys else None
        finding = Finding("error", message, str(self.path), line, 1 if line else None, name, None, [], help, text)
        self.findings.append(finding)

    def _line(self, keys: tuple[str, ...]) -> int | None:
        """Where a key stands: under the header of its table, or else anywhere."""
        if not keys:
            return None
        lines = self.text.splitlines()
        table, found = "", None
        for number, line in enumerate(lines, 1):
            if header := re.match(r"\s*\[+\s*([^\]]+?)\s*\]+", line):
                table = header[1].strip("\"'")
                if keys in ((table,), tuple(table.split("."))):
                    return number
                continue
            key = re.match(r"\s*[\"']?([^\"'=\s]+)[\"']?\s*=", line)
            # A key in a table on one line is found at the line of the table.
            if key and (table, key[1]) in ((".".join(keys[:-1]), keys[-1]), (keys[0], keys[1] if len(keys) > 1 else "")):
                return number
            if key and not table and key[1] == keys[0]:
                found = number
        return found

    def check(self) -> None:
        """Raises all that was noted."""
        if self.findings:
            raise StudyError("\n\n".join(finding.text for finding in self.findings), self.findings)

    def unknown(self, given: Mapping[str, Any], kind: str, *keys: str) -> None:
        """Keys that nobody knows."""
        for key in given:
            if key not in KEYS[kind]:
                near = difflib.get_close_matches(key, KEYS[kind], 1)
                help = f"did you mean '{near[0]}'?" if near else f"known keys are {', '.join(KEYS[kind])}"
                self.wrong(f"there is no key '{key}' here", help, *keys, key)

    def table(self, tree: Mapping[str, Any], key: str) -> dict[str, Any]:
        given = tree.get(key, {})
        if isinstance(given, dict):
            return given
        self.wrong(f"'{key}' is no table", f"write a header [{key}]", key)
        return {}

    def expression(self, given: Any, names: set[str], *keys: str, others: Mapping[str, str] | None = None) -> Expression | None:
        """An expression of some names; `others` are known too, and says why it may not refer to them."""
        if isinstance(given, bool) or not isinstance(given, (int, float, str)):
            self.wrong(f"'{keys[-1]}' is no expression", 'write for example "= u@free"', *keys)
            return None
        if isinstance(given, float) and not math.isfinite(given):
            self.wrong(f"'{keys[-1]}' is {given}", "write a finite number", *keys)
            return None
        try:
            found = Expression(given)
        except ValueError as error:
            self.wrong(str(error), 'write for example "= max(u@free, 0)"', *keys)
            return None
        for name in sorted(found.names - names):
            if others and name in others:
                help = "write a number, or refer to parameters that are the same in all designs"
                self.wrong(f"'{found.text}' refers to '{name}', which {others[name]}", help, *keys)
                return None
            near = difflib.get_close_matches(name, sorted(names), 1)
            known = ", ".join(sorted(names)[:12])
            help = f"did you mean '{near[0]}'?" if near else f"known are {known}"
            self.wrong(f"'{found.text}' refers to '{name}', which is neither a parameter nor a probe", help, *keys)
            return None
        return found

    def whole(self, given: Any, default: int, least: int, *keys: str) -> int:
        """A whole number that is not less than something."""
        found = self.number(given, default, least, *keys)
        if found == int(min(found, 1e15)):
            return int(found)
        self.wrong(f"'{keys[-1]}' is {given!r}", f"write a whole number from {least} on", *keys)
        return default

    def words(self, given: Any, *keys: str) -> str:
        """A text."""
        if isinstance(given, str):
            return given
        self.wrong(f"'{keys[-1]}' is {given!r}", "write a text in quotes", *keys)
        return ""

    def flag(self, given: Any, default: bool, *keys: str) -> bool:
        """`true` or `false`."""
        if given is None or isinstance(given, bool):
            return default if given is None else given
        self.wrong(f"'{keys[-1]}' is {given!r}", "write true or false", *keys)
        return default

    def unlike(self, name: str, known: Iterable[str], what: str) -> str:
        """Help for a name that is not known."""
        names = list(known)
        near = difflib.get_close_matches(name, names, 1)
        return f"did you mean '{near[0]}'?" if near else f"{what} are {', '.join(names)}"

    def number(self, given: Any, default: float, least: float, *keys: str) -> float:
        """A number that is not less than something."""
        if given is None:
            return default
        if isinstance(given, bool) or not isinstance(given, (int, float)) or not given >= least:
            which = f" from {least:g} on" if least > float("-inf") else ""
            self.wrong(f"'{keys[-1]}' is {given!r}", f"write a number{which}", *keys)
            return default
        return given
