"""Results as tables, and what the run said, in HTML."""

from __future__ import annotations

import html
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from .._look import words
from .._look.fields import number, with_error

if TYPE_CHECKING:
    from .._solution import Solution

# Tables of more rows than this say how many are left out; the file of results has them all.
MOST = 400


def table(heads: Iterable[str], rows: Iterable[Iterable[str]], left_out: int = 0) -> str:
    """Cells are HTML already."""
    head = "".join(f"<th>{each}</th>" for each in heads)
    body = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows)
    more = f"<p>{left_out} more are left out.</p>" if left_out else ""
    return f'<div class="wide"><table><thead><tr>{head}</tr></thead><tbody>{body}</tbody></table></div>{more}'


def verdicts(solution: Solution, content: dict[str, Any]) -> str:
    """How every step ended, whether it is stable, and what it passed."""
    found = []
    for step in content["steps"]:
        reached = step["status"] != "not_reached"
        lines = [f"<b>{html.escape(step['name'])}</b> {words.status(step)}."]
        if reached:
            sentence = words.verdict(step["stable"], step["stability"], content["dimension"])
            lines.append(
                sentence if step["status"] == "converged" else f"The last state before that is shown. {sentence}"
            )
        lines += [html.escape(each) for each in words.critical(step, solution.network.units)]
        good = step["status"] == "converged" and step["stable"] is not False
        found.append(
            f'<div class="verdict{"" if good else " bad"}">' + "".join(f"<p>{line}</p>" for line in lines) + "</div>"
        )
    return "".join(found)


def said(solution: Solution) -> str:
    """Warnings and errors with their notes and help."""
    found = []
    for severity, message, notes, advice in words.findings(solution):
        parts = [f"<p><b>{severity}:</b> {html.escape(message)}</p>"]
        parts += [f"<p>note: {html.escape(note)}</p>" for note in notes]
        parts += [f"<p>help: {html.escape(advice)}</p>"] if advice else []
        found.append(f'<div class="verdict{" bad" if severity == "error" else ""}">' + "".join(parts) + "</div>")
    return "".join(found) or "<p>Nothing remarkable.</p>"


def probes(solution: Solution) -> str:
    """Probes at the ends of the steps, with the errors of the mesh."""
    if not solution.probes:
        return "<p>The file has no probes.</p>"
    kinds = solution.network.probes
    rows = []
    for name in solution.probes:
        values, errors = solution[name], solution.error[name]
        cells = [with_error(float(value), float(error), kinds.get(name, "")) for value, error in zip(values, errors)]
        rows.append([html.escape(name), *cells])
    return table(["probe", *map(html.escape, solution.steps)], rows)


def nodes(solution: Solution, length: str, force: str) -> str:
    """Displacements and reactions of nodes at the end of the last step that was reached."""
    step = last(solution)
    heads = ["node", *(f"u{axis}, {length}" for axis in "xyz"), *(f"R{axis}, {force}" for axis in "xyz")]
    noise = 1e-9 * float(np.nanmax(np.abs(solution.end_forces[step][..., :3]), initial=0.0))
    rows = []
    for index, name in enumerate(solution.nodes[:MOST]):
        reaction = solution.reaction[step, index, :3]
        held = np.where(np.abs(reaction) <= noise, 0.0, reaction)
        numbers = [*solution.displacement[step, index], *held]
        rows.append([html.escape(name), *(number(float(value), 6) for value in numbers)])
    return table(heads, rows, max(0, len(solution.nodes) - MOST))


def members(solution: Solution, length: str, force: str) -> str:
    """Length, tension and pressure of members at the end of the last step that was reached."""
    step = last(solution)
    heads = ["member", f"length, {length}", f"tension in the middle, {force}", "pressure or actuation"]
    rows = [
        [
            html.escape(name),
            number(float(solution.length[step, index]), 6),
            number(float(solution.axial_force[step, index]), 6),
            number(float(solution.pressure[step, index]), 6),
        ]
        for index, name in enumerate(solution.members[:MOST])
    ]
    return table(heads, rows, max(0, len(solution.members) - MOST))


def last(solution: Solution) -> int:
    """The last step of which there are results, at whatever part of its ramp it ended."""
    reached = np.flatnonzero(np.isfinite(solution.energy))
    return int(reached[-1]) if len(reached) else 0
