"""What a study leaves behind: the front or the best design, progress, a picture, and the picks as networks."""

from __future__ import annotations

import csv
import io
import json
import os
from collections.abc import Mapping, MutableMapping
from typing import TYPE_CHECKING, Any

import numpy as np

from .._toml import toml_of
from ._front import costs, ranked
from ._study import Study
from ._table import VERDICTS, Design, digits

if TYPE_CHECKING:
    from .._network import Network
    from ._run import Outcome

# Accuracy at which picks are solved once more.
ACCURACY = 1e-8


def best_file(study: Study) -> str:
    """The file of the best designs."""
    return "front.csv" if len(study.objectives) > 1 else "best.csv"


def holds(pick: Mapping[str, Any]) -> bool:
    """Whether a pick that was solved has an equilibrium that is not unstable."""
    return pick["status"] == "converged" and False not in pick["stable"]


def write_best(outcome: Outcome) -> None:
    """Writes the front or the best design, and what it is on a mesh of its own."""
    study = outcome.study
    names = [each.name for each in study.wanted]
    spread = [f"{name}_spread" for name in names] if study.tolerances else []
    columns = ["checked", "checked_stable", *(f"{name}_checked" for name in names)]
    head = ["number", *(each.name for each in study.variables), *study.probes, *names, *spread, *columns]
    rows = []
    for place, design in enumerate(outcome.best):
        found = outcome.checked[place] if outcome.checked else None
        other = [found.status, VERDICTS[found.stable], *map(digits, found.wanted)] if found else [""] * len(columns)
        rows.append([str(design.number), *map(digits, (*design.x, *design.probes, *design.wanted, *design.spread)), *other])
    (outcome.directory / best_file(study)).write_text(_csv([head, *rows]), "utf-8", newline="")


def write(outcome: Outcome) -> list[dict[str, Any]]:
    """Writes everything but `designs.csv`, which grew on the way; returns what is said of the picks."""
    study, directory = outcome.study, outcome.directory
    write_best(outcome)
    if outcome.progress:
        # Kinds of failures that came up, among the columns that all lines have.
        kinds = sorted({key for entry in outcome.progress for key in entry} - set(outcome.progress[0]))
        keys = [*outcome.progress[0], *kinds]
        lines = [[digits(entry.get(key, 0.0)).removesuffix(".0") for key in keys] for entry in outcome.progress]
        (directory / "progress.csv").write_text(_csv([keys, *lines]), "utf-8", newline="")
    for old in directory.glob("pick_*.toml"):
        if old.stem.removeprefix("pick_").isdigit():
            old.unlink()
    summary = []
    for k, design in enumerate(picks(study, outcome.designs, outcome.best), 1):
        summary.append(_pick(study, design, k, outcome))
    (directory / "picks.json").write_text(json.dumps(summary, indent=2) + "\n", "utf-8")
    return summary


def _csv(rows: list[list[str]]) -> str:
    out = io.StringIO()
    csv.writer(out, lineterminator="\n").writerows(rows)
    return out.getvalue()


def picks(study: Study, designs: list[Design], best: list[Design]) -> list[Design]:
    """The ends of a front, its knee, and some between them; else the best designs."""
    if len(study.objectives) < 2:
        return ranked(study, [design for design in designs if design.violation == 0.0])[: study.pick.best]
    if not best:
        return []
    cost = costs(study, best)
    span = np.ptp(cost, axis=0)
    scaled = (cost - cost.min(0)) / np.where(span > 0, span, 1.0)
    chosen: list[int] = []
    if study.pick.ends:
        chosen += [int(np.argmin(cost[:, k])) for k in range(cost.shape[1])]
    if study.pick.knee:
        # The design nearest to the best of all objectives at once.
        chosen.append(int(np.argmin((scaled**2).sum(1))))
    chosen += [int(k) for k in np.linspace(0, len(best) - 1, study.pick.spread).round()]
    return [best[k] for k in sorted(set(chosen))]


def _with_full_paths(network: Network) -> str:
    """A network as TOML that may stand in any directory: the files of its muscles are named by their full paths."""
    import tomlkit

    document = tomlkit.parse(toml_of(network))
    directory = network._read.parts()[2]
    for muscle in document.get("muscles", {}).values():
        if isinstance(muscle, MutableMapping) and "file" in muscle:
            muscle["file"] = os.path.abspath(os.path.join(directory, muscle["file"]))
    return tomlkit.dumps(document)


def _pick(study: Study, design: Design, number: int, outcome: Outcome) -> dict[str, Any]:
    values = {each.name: value for each, value in zip(study.variables, design.x)}
    network = study.network.set(**values)
    name = f"pick_{number}.toml"
    (outcome.directory / name).write_text(_with_full_paths(network), "utf-8")
    solution = network.solve(accuracy=ACCURACY)
    return {
        "network": name,
        "design": design.number,
        "variables": values,
        "status": solution.status,
        "stable": list(solution.stable),
        "wanted": {each.name: value for each, value in zip(study.wanted, design.wanted)},
    }
