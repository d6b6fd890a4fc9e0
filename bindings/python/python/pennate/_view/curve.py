"""A probe over the slider that was moved last: where the file leads from the unloaded network, and where it was moved through."""

from __future__ import annotations

import collections
from collections.abc import Callable
from typing import Any

import numpy as np

from .follow import Follow, Now
from .handles import Handle
from .panel import Panel

# Places of the slider at which the curve is computed, and of one whose shapes take long, in seconds.
GRID, COARSE, LONG = 41, 13, 0.05
# Places that the slider was at.
VISITED = 200


class Curve:
    """The curve and its dots; it belongs to one slider, one probe, one step and the values of all other sliders."""

    def __init__(self, panel: Panel) -> None:
        self.panel = panel
        self.visited: collections.deque[tuple[float, float]] = collections.deque(maxlen=VISITED)
        self.key: Any = None
        self.grid, self.values = np.zeros(0), np.zeros(0)

    @property
    def due(self) -> bool:
        """Whether it has to be computed."""
        return self.key is None

    def forget(self) -> None:
        """Begins anew: another slider, or another probe."""
        self.visited.clear()
        self.key = None

    def visit(self, now: Now, handle: Handle | None) -> None:
        """The state went on to another place."""
        chosen = now.probes.get(self._probe)
        if chosen is not None and handle is not None and handle.name in now.values and not now.failure:
            self.visited.append((now.values[handle.name], chosen.value))
        if self.key is not None:
            if self.key != self._key(now, handle):
                self.key = None
            else:
                self.draw(now, handle)

    def compute(
        self, follow: Follow | None, now: Now | None, handle: Handle | None, seconds: float, is_stale: Callable[[], bool]
    ) -> None:
        """The values at all places of the slider, unless something newer is asked for meanwhile."""
        if handle is None or follow is None or follow.problem is None or now is None or self._probe not in follow.problem.probes:
            self.key, self.grid, self.values = (), np.zeros(0), np.zeros(0)
            return
        problem = follow.problem
        grid = np.linspace(handle.low, handle.high, GRID if seconds < LONG else COARSE)
        present = {**self.panel.values(), **now.values}
        x = np.tile([present[name] for name in problem.parameters], (len(grid), 1))
        x[:, problem.parameters.index(handle.name)] = grid
        found: list[Any] = []
        for row in x:
            if is_stale():
                return
            found.append(problem(row)[problem.probes.index(self._probe)])
        self.key, self.grid, self.values = self._key(now, handle), grid, np.array(found)
        self.draw(now, handle)

    def draw(self, now: Now, handle: Handle | None) -> None:
        """Shows it, with the present place."""
        chosen = now.probes.get(self._probe)
        if chosen is None or handle is None or handle.name not in now.values or not len(self.grid):
            return
        here = now.values[handle.name], chosen.value
        error = chosen.error if np.isfinite(chosen.error) else 0.0
        self.panel.show_curve(handle.label, chosen.unit, self.grid, self.values, list(self.visited), here, error)

    @property
    def _probe(self) -> str:
        return str(self.panel.probe.value)

    def _key(self, now: Now, handle: Handle | None) -> Any:
        moved = handle.name if handle is not None else ""
        kept = {name: value for name, value in now.values.items() if name != moved}
        return moved, self._probe, kept, self.panel.steps.value
