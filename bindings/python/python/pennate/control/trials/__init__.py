"""The tests of chapter 4: what is reported, what a prototype had, and what is reached here.

Each trial prints one table. Lengths are in cm, as in the text. `python -m pennate.control test` runs them.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .. import br2
from .._arms import Arm, Array

CM = 10.0


def half(load: float = 0.0) -> Arm:
    """The arm with one rotating actuator: two inputs."""
    return br2.table(load)


def whole(load: float = 0.0) -> Arm:
    """The arm with both rotating actuators, on a base that swivels: three inputs."""
    return br2.table(load, both=True, swivel=True)


def lattice(arm: Arm) -> Array:
    """(levels of Pb, levels of Pr, 3), tips on the lattice of discrete actions, mm."""
    shares = np.stack(np.meshgrid(*(np.linspace(0, 1, count) for count in br2.LEVELS), indexing="ij"), axis=-1)
    return arm.tip(arm.lower + shares.reshape(-1, 2) * (arm.upper - arm.lower)).reshape(*br2.LEVELS, 3)


def drawn(arm: Arm, generator: np.random.Generator, count: int) -> Array:
    """(count, k), inputs drawn evenly within the limits."""
    return arm.lower + generator.random((count, len(arm.names))) * (arm.upper - arm.lower)


def percent(flags: npt.NDArray[np.bool_]) -> str:
    """The share of what holds."""
    return f"{100.0 * float(np.mean(flags)):.2f}"


def spread(lengths: Array) -> str:
    """Mean and standard deviation of lengths in mm, in cm."""
    return f"{float(np.mean(lengths)) / CM:.2f} ± {float(np.std(lengths)) / CM:.2f}"


def table(title: str, head: list[str], rows: list[list[str]]) -> str:
    """A Markdown table under its title."""
    lines = [f"**{title}**", "", "| " + " | ".join(head) + " |", "|---" + "|---:" * (len(head) - 1) + "|"]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])
