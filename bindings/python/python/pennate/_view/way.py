"""The way through all steps: equilibria between the ends of steps, solved from the unloaded network."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .._look import words
from .._look.fields import number
from .._look.finer import finer
from .._network import Network
from .._solution import Solution
from .follow import Probe

# Increments of each step, at least.
FRAMES = 24


class Way:
    """All states from unloaded to the end, or to where the run ended."""

    def __init__(self, network: Network, accuracy: float) -> None:
        self.solution: Solution = finer(network.solve(accuracy=accuracy), FRAMES, accuracy)
        self.states = [
            (step, increment, float(fraction))
            for step in range(len(self.solution.steps))
            for increment, fraction in enumerate(self.solution.fractions(step))
        ]

    def nearest(self, position: float) -> int | None:
        """The state nearest to a position: the number of whole steps and a part of the next; `None` is the unloaded one."""
        step, part = int(position), position - int(position)
        if position <= 0 or not self.states:
            return None
        if part == 0:
            step, part = step - 1, 1.0
        own = [place for place, state in enumerate(self.states) if state[0] == step]
        if not own:
            return len(self.states) - 1
        fractions = np.array([self.states[place][2] for place in own])
        if (np.diff(fractions) <= 0).any():
            # Along an arc the fraction goes back and forth; the increments go on.
            return own[round(part * (len(own) - 1))]
        return own[int(np.abs(fractions - part).argmin())]

    def drawing(self, place: int | None) -> dict[str, Any]:
        """The shape of a state."""
        if place is None:
            return self.solution.drawing("unloaded")
        step, increment, _ = self.states[place]
        return self.solution.drawing(step, increment)

    def probes(self, place: int | None) -> dict[str, Probe]:
        """The probes of a state; errors are known at the ends of steps alone."""
        row, units = (0 if place is None else place + 1), self.solution.history.units
        return {
            name: Probe(float(self.solution.history[name][row]), math.nan, units.get(name, ""))
            for name in self.solution.probes
        }

    def label(self, place: int | None) -> str:
        """Where a state is, in words."""
        if place is None:
            return "Unloaded."
        step, _, fraction = self.states[place]
        return f"On the way, at {number(100 * fraction)} % of step ‘{self.solution.steps[step]}’."

    def verdict(self, place: int | None) -> str:
        """What is known of its stability."""
        if place is None:
            return ""
        content = self.solution.to_dict()["steps"][self.states[place][0]]
        passed = words.critical(content, self.solution.network.units)
        if not passed:
            return words.verdict(content["stable"], content["stability"], self.solution.network.dimension)
        return " ".join(["The verdict is stated at the ends of steps; this step passes:", *passed])
