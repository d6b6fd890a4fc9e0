"""Reaching as a decision process: what is seen, what may be done, what it earns, and when it ends."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from .. import _arguments
from . import _checks
from ._arms import Arm, Array

Floats = npt.NDArray[np.float32]
Flags = npt.NDArray[np.bool_]
Rows = npt.NDArray[np.intp]

# How often a pair of start and target is drawn again because a state has no equilibrium.
DRAWS = 100
# What changes as episodes go on.
CHANGING = ("inputs", "targets", "tips", "errors", "moves", "_levels")


@dataclass(frozen=True)
class Levels:
    """Discrete actions: one input goes up or down by some levels of a lattice; each stride up, then the same down."""

    counts: tuple[int, ...]
    """Levels of each input, both limits included."""
    strides: tuple[int, ...] = (1, 2, 4)
    """How many levels an action may go."""

    def table(self) -> npt.NDArray[np.int64]:
        """(actions, k), the change of levels by each action."""
        signed = [sign * stride for stride in self.strides for sign in (1, -1)]
        rows = [(place, change) for place in range(len(self.counts)) for change in signed]
        found = np.zeros((len(rows), len(self.counts)), dtype=np.int64)
        for row, (place, change) in zip(found, rows):
            row[place] = change
        return found


@dataclass(frozen=True)
class Changes:
    """Continuous actions: a number from -1 to 1 for each input, times its largest change."""

    largest: tuple[float, ...]
    """Of each input, in its unit."""


@dataclass(frozen=True)
class Rules:
    """What a task asks for and pays. Lengths are in the unit of the network."""

    tolerance: float
    """Error at which an episode ends well."""
    steps: int
    """Moves after which it ends all the same."""
    success: float
    """Error that counts as success in tests."""
    unit: float = 10.0
    """Length of error that is worth 1."""
    scale: float = 100.0
    """Length that is seen as 1."""
    rounding: float = 0.0
    """What is seen of the way to the target is rounded to multiples of this length; 0: not at all."""
    cost: float = 2.0
    """Of a move."""
    prize: float = 100.0
    """For an error within the tolerance."""
    fine: float | None = 100.0
    """For inputs beyond their limits; `None`: the cost of a move and the error."""
    late: bool = False
    """Whether the last move pays the cost of a move and the error as well where it comes to nothing."""
    truncate: bool = False
    """Whether too many moves truncate an episode, instead of ending it as a failure."""

    def __post_init__(self) -> None:
        for name in ("tolerance", "success", "rounding"):
            _checks.length(name, getattr(self, name))
        for name in ("unit", "scale"):
            if not _checks.length(name, getattr(self, name)) > 0:
                raise ValueError(f"{name}: a length above 0 expected, not 0")
        if _arguments.whole(self.steps, "steps") < 1:
            raise ValueError("steps: one move or more expected, not 0")
        for name in ("cost", "prize", "fine"):
            value = getattr(self, name)
            if not (name == "fine" and value is None) and not np.isfinite(_arguments.real(value, name)):
                raise ValueError(f"{name}: a finite number expected, not {value}")
        for name in ("late", "truncate"):
            if not isinstance(getattr(self, name), bool | np.bool_):
                raise TypeError(f"{name}: True or False expected, not {_arguments.shown(getattr(self, name))}")


class Task:
    """Episodes of some arms side by side. Arrays are over them; no arm depends on another one."""

    def __init__(self, arm: Arm, actions: Levels | Changes, rules: Rules, count: int) -> None:
        width = len(arm.names)
        sizes = actions.counts if isinstance(actions, Levels) else actions.largest
        if len(sizes) != width:
            raise ValueError(f"the arm has {width} inputs ({', '.join(arm.names)}), but the actions have {len(sizes)}")
        self.arm, self.actions, self.rules, self.count = arm, actions, rules, count
        self.range = arm.upper - arm.lower
        if isinstance(actions, Levels):
            self._table = actions.table()
            self._top = np.array(actions.counts) - 1
        self.inputs, self.targets, self.tips = np.zeros((count, width)), np.zeros((count, 3)), np.zeros((count, 3))
        self.errors, self.moves = np.zeros(count), np.zeros(count, dtype=np.int64)
        # Levels are counted, so that no sum of steps drifts off the lattice.
        self._levels = np.zeros((count, width), dtype=np.int64)

    def begin(
        self,
        which: Rows,
        generators: Sequence[np.random.Generator],
        start: npt.ArrayLike | None = None,
        target: npt.ArrayLike | None = None,
    ) -> None:
        """New episodes of some arms, each with its own generator: a start and a target, both inputs drawn evenly.

        Args:
            start: (k,) inputs instead of those drawn; with levels, the nearest of the lattice.
            target: (3,) a point instead of the tip at inputs drawn.
        """
        left = which
        if start is not None:
            start = _checks.within("start", start, self.arm)[0]
        if target is not None:
            target = _checks.rows("target", target, 3)[0]
        for _ in range(DRAWS):
            drawn = np.array([self._draw(generators[row]) for row in left]).reshape(len(left), 2, -1)
            if start is not None:
                drawn[:, 0] = self._share(np.asarray(start))
            begin, goals = self.arm.lower + drawn[:, 0] * self.range, self.arm.lower + drawn[:, 1] * self.range
            to = self.arm.tip(goals) if target is None else np.asarray(target)
            self.place(left, begin, to)
            left = left[np.isnan(self.errors[left])]
            if not len(left):
                return
        at = ", ".join(f"{name} = {value:.6g}" for name, value in zip(self.arm.names, self.inputs[left[0]]))
        raise RuntimeError(f"no episode begins: after {DRAWS} draws there is no equilibrium, as at {at}")

    def place(self, which: Rows, starts: Array, targets: Array) -> None:
        """Episodes with (n, k) inputs, those of the nearest levels where there are levels, and (n, 3) targets."""
        self._place(which, self._share(starts))
        self.targets[which] = targets
        self.tips[which] = self.arm.tip(self.inputs[which])
        self.errors[which] = _distances(self.tips[which], self.targets[which])
        self.moves[which] = 0

    def step(self, which: Rows, actions: npt.ArrayLike) -> tuple[Array, Flags, Flags]:
        """Moves some arms: rewards, and whether the episodes ended or were truncated."""
        rules = self.rules
        shares, over = self._moved(which, actions)
        before, old = self.errors[which], self.inputs[which]
        levels = self._levels[which]
        self._place(which, shares)
        tips = self.arm.tip(self.inputs[which])
        lost = np.isnan(tips).any(axis=1)
        if lost.any():
            # Without an equilibrium the arm stays where it was, and the episode ends as beyond the limits.
            back = which[lost]
            self.inputs[back], self._levels[back], tips[lost] = old[lost], levels[lost], self.tips[back]
            over = over | lost
        self.tips[which] = tips
        self.errors[which] = _distances(tips, self.targets[which])
        self.moves[which] += 1
        errors = self.errors[which]
        hit = (errors <= rules.tolerance) & ~over
        late = (self.moves[which] >= rules.steps) & ~hit & ~over
        failed = -rules.cost - errors / rules.unit
        reward = -rules.cost + (before - errors) / rules.unit
        reward = np.where(late, failed, reward) if rules.late else reward
        reward = np.where(over, failed if rules.fine is None else -rules.fine, reward)
        reward = np.where(hit, rules.prize, reward)
        return reward, hit | over | (late & (not rules.truncate)), late & rules.truncate

    def seen(self, which: Rows) -> Floats:
        """(n, 3 + k): the way to the target over `scale`, rounded if that is asked for, and inputs as shares of their limits."""
        way = self.targets[which] - self.tips[which]
        if self.rules.rounding:
            way = np.round(way / self.rules.rounding) * self.rules.rounding
        # An input that goes both ways is seen from -1 to 1.
        signed = self.arm.lower < 0
        shares = self._share(self.inputs[which])
        return np.concatenate([way / self.rules.scale, np.where(signed, 2 * shares - 1, shares)], axis=1).astype(
            np.float32
        )

    def allowed(self, which: Rows) -> npt.NDArray[np.int8]:
        """(n, actions), 1 for discrete actions that stay within the limits."""
        after = self._levels[which][:, None, :] + self._table
        inside: Flags = np.all((after >= 0) & (after <= self._top), axis=2)
        return inside.astype(np.int8)

    def places(self, which: Rows) -> tuple[npt.NDArray[np.int64], npt.NDArray[np.int64]]:
        """(n,) numbers of the levels, one for all inputs together, and (n, actions) those after each discrete action."""
        after = self._levels[which][:, None, :] + self._table
        sizes = np.cumprod([1, *self._top + 1])[:-1]
        return self._levels[which] @ sizes, after @ sizes

    def present(self) -> dict[str, npt.NDArray[Any]]:
        """Where all episodes are."""
        return {name: getattr(self, name) for name in CHANGING}

    def go_on(self, arrays: Mapping[str, npt.NDArray[Any]]) -> None:
        """Puts all episodes where they were once."""
        for name in CHANGING:
            getattr(self, name)[:] = arrays[name]

    def _draw(self, generator: np.random.Generator) -> Array:
        """(2, k), shares of the ranges for a start and a target."""
        if isinstance(self.actions, Levels):
            drawn: Array = generator.integers(0, self._top + 1, (2, len(self._top))) / self._top
            return drawn
        return generator.random((2, len(self.range)))

    def _share(self, inputs: Array) -> Array:
        found: Array = (inputs - self.arm.lower) / self.range
        return found

    def _place(self, which: Rows, shares: Array) -> None:
        if isinstance(self.actions, Levels):
            self._levels[which] = np.rint(shares * self._top)
            shares = self._levels[which] / self._top
        self.inputs[which] = np.clip(self.arm.lower + shares * self.range, self.arm.lower, self.arm.upper)

    def _moved(self, which: Rows, actions: npt.ArrayLike) -> tuple[Array, Flags]:
        """Shares of the ranges after actions, within the limits, and whether the actions went beyond them."""
        if isinstance(self.actions, Levels):
            after = self._levels[which] + self._table[_checks.strides(actions, len(self._table), len(which))]
            over: Flags = np.any((after < 0) | (after > self._top), axis=1)
            shares: Array = np.clip(after, 0, self._top) / self._top
            return shares, over
        changes = _checks.changes(actions, self.arm.names, len(which)) * self.actions.largest
        wanted = self.inputs[which] + changes
        over = np.any((wanted < self.arm.lower) | (wanted > self.arm.upper), axis=1)
        return np.clip(self._share(wanted), 0.0, 1.0), over


def _distances(tips: Array, targets: Array) -> Array:
    """Written out, so that a row has the same digits in any array."""
    x, y, z = (tips - targets).T
    found: Array = np.sqrt(x * x + y * y + z * z)
    return found
