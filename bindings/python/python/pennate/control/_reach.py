"""Inputs that bring a tip to a target: Gauss-Newton, damped after Levenberg, within the limits of the inputs.

With r the way from the tip to its target and J the derivatives of the tip by the inputs, both over the ranges of the inputs,
a move s is the least of |J s - r|^2 + mu tr(J'J)/k |s|^2 within the limits. A move that brings the tip no nearer is taken
back, and mu grows; else it shrinks with how well the model foretold the gain.

The tip is that of the arm, as it would be measured. J is that of a model, which may be another one: without the load that the
arm carries, say. Where the way ends in front of a target, the model alone looks for a better one from other starts, which
moves nothing; only from the inputs that it finds a new way begins on the arm, and the better of both ends counts.

Marquardt, An algorithm for least-squares estimation of nonlinear parameters, SIAM J. Appl. Math. 11 (1963); Nielsen, Damping
parameter in Marquardt's method, IMM-REP-1999-05, for the rule by which mu shrinks and grows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from .. import _arguments
from .._problem import Problem
from . import _checks
from ._arms import Arm, Array, Bounds, Followed

if TYPE_CHECKING:
    from pennate import Live

Counts = npt.NDArray[np.int64]
Flags = npt.NDArray[np.bool_]
Rows = npt.NDArray[np.intp]

# Damping at first, as a share of the mean square of the slopes. With less, random pairs of the BR2 arm take more moves (2.5; 2.9
# with 1e-3); with more, fewer get through the gap behind it without restarts (76 %; 33 % with 0.1).
MU = 0.03
# Bounds of the damping: below, the digits of J'J end; above, moves are smaller than `STILL`.
LEAST, GREATEST = 1e-8, 1e8
# A way ends where the next move is smaller than this share of the inputs' ranges: valves do not resolve it.
STILL = 1e-6


# A restart is tried where the model foretells less than this share of the present error, and at most so many times: where it ends,
# what the model is beside the arm is known better.
WORTH = 0.9
ROUNDS = 2


@dataclass(frozen=True)
class Reach:
    """How near a tip came to its target. With one target every array is without its first axis."""

    inputs: Array
    """(n, k), where the arm is left."""
    tip: Array
    """(n, 3), as measured there."""
    error: Array
    """(n,), distance between tip and target, in the unit of lengths; infinite where there is no equilibrium."""
    reached: Flags
    """(n,), whether the error is within the tolerance."""
    moves: Counts
    """(n,), how often inputs were set on the arm, starts not counted."""
    jacobians: Counts
    """(n,), how often the model was asked for tip and derivatives, restarts included."""
    restarts: Counts
    """(n,), how often the way began anew at inputs that the model proposed."""


def reach(
    arm: Arm | Live,
    target: npt.ArrayLike,
    *,
    start: npt.ArrayLike | None = None,
    model: Arm | None = None,
    tolerance: float = 1.0,
    moves: int = 15,
    largest: npt.ArrayLike | None = None,
    restarts: int = 8,
    inputs: Bounds | None = None,
    tip: Sequence[str] = ("x", "y", "z"),
) -> Reach:
    """Moves an arm until its tip is at a target, or as near as it comes.

    Args:
        arm: What is moved and measured. A live state needs `inputs`, its parameters that may change with their limits,
            and has one target; `tip` are the three probes of its tip.
        target: (3,) or (n, 3), in the unit of lengths of the network.
        start: (k,) or (n, k) inputs to begin with, within their limits; the middle of these, or where a live state is.
        model: What gives derivatives, and proposes restarts; the arm itself unless given.
        tolerance: An error that is small enough, in the unit of lengths.
        moves: At most so many on the arm from each start.
        largest: (k,) changes of the inputs that a move does not exceed, above 0.
        restarts: From so many other starts the model looks for a better way where the first ends short of the target.
    """
    moved = _adapted(arm, inputs, tip)
    tolerance, largest = _checks.length("tolerance", tolerance), _checks.largest(largest, moved)
    moves, restarts = _arguments.whole(moves, "moves"), _arguments.whole(restarts, "restarts")
    targets = _checks.rows("target", target, 3)
    alone = np.ndim(target) == 1
    if isinstance(moved, Followed) and len(targets) > 1:
        raise ValueError(f"a live state goes to one target at a time, not to {len(targets)}")
    what = "start"
    if start is None and isinstance(moved, Followed):
        what, start = "where the live state is", moved.inputs
    elif start is None:
        start = (moved.lower + moved.upper) / 2
    begin = _checks.starts(start, moved, len(targets), what)
    way = _Way(moved, moved if model is None else model, targets, tolerance, largest)
    way.begin(begin)
    way.go(moves)
    for _ in range(ROUNDS if restarts else 0):
        if way.there.all() or not _restart(way, moves, restarts):
            break
    way.go_back()
    found = (way.inputs, way.tips, way.errors, way.there, way.moves, way.jacobians, way.restarts)
    return Reach(*((each[0] for each in found) if alone else found))


def _restart(way: _Way, moves: int, count: int) -> bool:
    """Lets the model look for better ways to the targets that were not reached, and goes them; whether there were any."""
    late = np.flatnonzero(~way.there)
    foretold, inputs = _looked_for(way, late, count)
    # Only what is better by more than the model is likely to be wrong by is worth a move.
    worth = foretold < WORTH * way.errors[late]
    if not worth.any():
        return False
    before = way.begin_anew(late[worth], inputs[worth])
    way.go(moves)
    way.keep_better(late[worth], *before)
    return True


def _looked_for(way: _Way, late: Rows, count: int) -> tuple[Array, Array]:
    """Errors that the model foretells, and inputs: of those that are good enough the nearest ones, else the best."""
    # Where the tip measured is beside that of the model, the target is put as far beside itself. Without an equilibrium nothing
    # is known of that.
    targets = way.targets[late] + np.nan_to_num(way.model.tip(way.inputs[late]) - way.tips[late])
    enough, width = way.tolerance / 2, len(way.range)
    starts = way.model.lower + spread(count, width) * way.range
    # All targets from all starts, side by side.
    search = _Way(way.model, way.model, np.tile(targets, (count, 1)), enough, np.full(width, np.inf))
    search.begin(np.repeat(starts, len(late), axis=0))
    search.go(30)
    ends, errors = search.inputs.reshape(count, len(late), width), search.errors.reshape(count, len(late))
    way.jacobians[late] += search.jacobians.reshape(count, len(late)).sum(axis=0)
    away = np.linalg.norm((ends - way.inputs[late]) / way.range, axis=2)
    # Errors below what is asked for are all as good: among them, distance decides.
    order = np.where(errors <= enough, away - away.max() - 1.0, errors)
    chosen = order.argmin(axis=0), np.arange(len(late))
    return errors[chosen], ends[chosen]


class _Way:
    """Arms on their way to targets, side by side."""

    def __init__(self, arm: Arm, model: Arm, targets: Array, tolerance: float, largest: Array) -> None:
        self.arm, self.model, self.targets, self.tolerance = arm, model, targets, tolerance
        self.range = arm.upper - arm.lower
        self.largest = largest / self.range
        count = len(targets)
        self.moves, self.jacobians, self.restarts = (np.zeros(count, dtype=np.int64) for _ in range(3))

    def begin(self, inputs: Array) -> None:
        count = len(self.targets)
        self.inputs = np.clip(inputs, self.arm.lower, self.arm.upper)
        self.tips = self.arm.tip(self.inputs)
        self.errors = self._errors(self.tips, self.targets)
        self.last = self.inputs.copy()
        self._mu, self._growth = np.full(count, MU), np.full(count, 2.0)
        self._slopes = np.zeros((count, 3, len(self.range)))
        self._fresh = np.zeros(count, dtype=bool)
        self.still = np.zeros(count, dtype=bool)

    def begin_anew(self, which: Rows, inputs: Array) -> tuple[Array, Array, Array]:
        """Sets some arms to other inputs, be they farther from their targets at first; the inputs, tips and errors before."""
        before = self.inputs[which].copy(), self.tips[which].copy(), self.errors[which].copy()
        self.restarts[which] += 1
        self.still[which] = False
        self._mu[which], self._growth[which] = MU, 2.0
        # As many moves as the largest change of inputs asks for.
        moves = np.ceil((np.abs(inputs - self.inputs[which]) / self.range / self.largest).max(axis=1) - 1e-9)
        self.moves[which] += np.maximum(moves, 1).astype(np.int64)
        self.inputs[which] = self.last[which] = inputs
        self.tips[which] = self.arm.tip(inputs)
        self.errors[which] = self._errors(self.tips[which], self.targets[which])
        self._fresh[which] = False
        return before

    def keep_better(self, which: Rows, inputs: Array, tips: Array, errors: Array) -> None:
        """Where arms were nearer to their targets before, that is where they are to go back to."""
        worse = self.errors[which] > errors
        back = which[worse]
        self.inputs[back], self.tips[back], self.errors[back] = inputs[worse], tips[worse], errors[worse]
        self._fresh[back] = False

    @property
    def there(self) -> Flags:
        return self.errors <= self.tolerance

    def go(self, moves: int) -> None:
        """Makes moves until all are there, or as near as they come."""
        # Where there is no equilibrium no way can be shown.
        self.still |= np.isinf(self.errors)
        for _ in range(moves):
            which = np.flatnonzero(~self.there & ~self.still)
            if not len(which):
                return
            self._look(which)
            step, foretold = self._step(which)
            still = np.abs(step).max(axis=1) < STILL
            self.still[which[still]] = True
            go = ~still
            which, step, foretold = which[go], step[go], foretold[go]
            before = self.errors[which]
            better = self._try(which, self.inputs[which] + step * self.range)
            gain = (before**2 - self.errors[which] ** 2) / np.where(foretold > 0, foretold, 1.0)
            self._damp(which, better, gain)

    def go_back(self) -> None:
        """Sets arms whose last move was no better to where they were best, which is a move as well."""
        which = np.flatnonzero((self.last != self.inputs).any(axis=1))
        if not len(which):
            return
        # Where the arm has a history it does not come back to where it was: what counts is what is measured now.
        self.moves[which] += 1
        self.last[which] = self.inputs[which]
        self.tips[which] = self.arm.tip(self.inputs[which])
        self.errors[which] = self._errors(self.tips[which], self.targets[which])

    def _try(self, which: Rows, inputs: Array) -> Flags:
        """Moves some arms; whether they are nearer to their targets. The others keep the inputs that were best."""
        inputs = np.clip(inputs, self.arm.lower, self.arm.upper)
        tips = self.arm.tip(inputs)
        errors = self._errors(tips, self.targets[which])
        self.moves[which] += 1
        self.last[which] = inputs
        better = errors < self.errors[which]
        kept = which[better]
        self.inputs[kept], self.tips[kept], self.errors[kept] = inputs[better], tips[better], errors[better]
        self._fresh[kept] = False
        return better

    def _look(self, which: Rows) -> None:
        """Derivatives by inputs as shares of their ranges, where they are not known yet."""
        which = which[~self._fresh[which]]
        if len(which):
            slopes = self.model.jacobian(self.inputs[which])[1] * self.range
            # Where the model has no derivative no way can be shown.
            self.still[which[np.isnan(slopes).any(axis=(1, 2))]] = True
            self._slopes[which] = np.nan_to_num(slopes)
            self._fresh[which] = True
            self.jacobians[which] += 1

    def _step(self, which: Rows) -> tuple[Array, Array]:
        """Moves as shares of the ranges, and by how much they lessen the squares of the errors if the model is right."""
        slopes = self._slopes[which]
        way = self.targets[which] - self.tips[which]
        present = (self.inputs[which] - self.arm.lower) / self.range
        low, high = np.maximum(-present, -self.largest), np.minimum(1.0 - present, self.largest)
        square = np.einsum("nij,nik->njk", slopes, slopes)
        width = len(self.range)
        mean = np.einsum("njj->n", square) / width
        # Where nothing moves the tip, nothing is divided by zero.
        damped = square + (self._mu[which] * mean + (mean == 0))[:, None, None] * np.eye(width)
        pull = np.einsum("nij,ni->nj", slopes, way)
        step = np.where((pull < 0) & (low >= 0), low, np.where((pull > 0) & (high <= 0), high, 0.0))
        free = ~(((pull < 0) & (low >= 0)) | ((pull > 0) & (high <= 0)))
        # Inputs that the way takes beyond a limit are put onto it, and the others find their way again.
        for _ in range(width):
            held = np.where(free, 0.0, step)
            rest = pull - np.einsum("njk,nk->nj", damped, held)
            matrix = np.where(free[:, :, None] & free[:, None, :], damped, np.eye(width))
            step = np.linalg.solve(matrix, np.where(free, rest, held)[:, :, None])[:, :, 0]
            beyond = free & ((step < low) | (step > high))
            step = np.clip(step, low, high)
            free &= ~beyond
            if not beyond.any():
                break
        left = way - np.einsum("nij,nj->ni", slopes, step)
        return step, np.einsum("ni,ni->n", way, way) - np.einsum("ni,ni->n", left, left)

    def _damp(self, which: Rows, better: Flags, gain: Array) -> None:
        """Nielsen's rule: less damping the better the model foretold, ever more where moves are in vain."""
        mu, growth = self._mu[which], self._growth[which]
        shrink = np.maximum(1 / 3, 1 - (2 * np.clip(gain, 0.0, 1.0) - 1) ** 3)
        self._mu[which] = np.clip(np.where(better, mu * shrink, mu * growth), LEAST, GREATEST)
        self._growth[which] = np.where(better, 2.0, 2 * growth)

    @staticmethod
    def _errors(tips: Array, targets: Array) -> Array:
        """Distances; infinite where there is no equilibrium."""
        found: Array = np.nan_to_num(np.linalg.norm(tips - targets, axis=1), nan=np.inf)
        return found


def spread(count: int, width: int) -> Array:
    """(count, width), points in the unit cube that lie apart: multiples of powers of a generalized golden ratio."""
    # The root of x**(width + 1) = x + 1, by the iteration that Roberts gives for his quasirandom sequences (2018).
    root = 1.5
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (width + 1))
    powers = root ** -np.arange(1.0, width + 1.0)
    found: Array = (0.5 + np.arange(1, count + 1)[:, None] * powers) % 1.0
    return found


def _adapted(arm: Arm | Live, inputs: Bounds | None, tip: Sequence[str]) -> Arm:
    if isinstance(arm, Arm):
        if inputs is not None:
            raise ValueError("inputs: an arm has inputs already; they are given with a live state alone")
        return arm
    if not isinstance(getattr(arm, "problem", None), Problem):
        raise TypeError(f"an arm, or a live state of a problem, expected, not {_arguments.shown(arm)}")
    if inputs is None:
        raise ValueError("inputs: the parameters of the live state that may change, with their limits, are needed")
    return Followed(arm, inputs, tip)
