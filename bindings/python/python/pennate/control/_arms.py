"""Arms: inputs in, the position of a tip out, with derivatives."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Protocol, runtime_checkable

import numpy as np
import numpy.typing as npt

from .. import _arguments

if TYPE_CHECKING:
    import concurrent.futures

    from pennate import Live, Network

Array = npt.NDArray[np.float64]
Bounds = Mapping[str, tuple[float, float]]

# Step of differences, as a share of an input's range: halfway, in digits, between rounding and curvature of a smooth tip.
STEP = 1e-4


@runtime_checkable
class Arm(Protocol):
    """What is moved. Inputs and positions are in the units of the network file; angles are in degrees."""

    names: tuple[str, ...]
    """Of the k inputs."""
    lower: Array
    """(k,), the least values of the inputs."""
    upper: Array
    """(k,), the greatest."""

    def tip(self, inputs: Array) -> Array:
        """(n, k) inputs to (n, 3) positions; not a number where there is no equilibrium."""

    def jacobian(self, inputs: Array) -> tuple[Array, Array]:
        """(n, 3) positions and their derivatives by the inputs, (n, 3, k)."""


class Solved:
    """A network whose tip is solved for, each state by itself: no answer depends on the ones before it."""

    def __init__(
        self,
        network: Network,
        inputs: Bounds,
        tip: Sequence[str] = ("x", "y", "z"),
        *,
        accuracy: float = 1e-6,
        threads: int | None = None,
        executor: concurrent.futures.Executor | None = None,
    ) -> None:
        """
        Args:
            network: With the parameters of `inputs`; its other parameters stay as they are.
            inputs: Each parameter that is an input, with its least and greatest value.
            tip: Three probes, the coordinates of the tip.
            executor: Whose workers solve where many states are asked for at once, as in `pennate.sweep`.
        """
        if executor is not None:
            _arguments.executor(executor)
        self.names, self.lower, self.upper = _limits(inputs)
        probes = _three(tip)
        self.network = network
        problem = network.problem(parameters=self.names, probes=probes, accuracy=accuracy, threads=threads)
        self.problem = problem if executor is None else problem.on(executor)
        self.differences = 0
        """States whose derivatives were differences, as the problem had none."""

    def tip(self, inputs: Array) -> Array:
        """(n, k) inputs to (n, 3) positions; not a number where there is no equilibrium."""
        return self.problem(inputs)

    def jacobian(self, inputs: Array) -> tuple[Array, Array]:
        """(n, 3) positions and their derivatives by the inputs, (n, 3, k)."""
        tips, slopes = self.problem.gradient(inputs)
        missing = np.isnan(slopes).any(axis=(1, 2)) & ~np.isnan(tips).any(axis=1)
        if missing.any():
            self.differences += int(missing.sum())
            slopes[missing] = differences(self, inputs[missing], tips[missing])
        return tips, slopes


class Followed:
    """One equilibrium that follows its inputs, with the history that this gives it: one state at a time."""

    def __init__(self, live: Live, inputs: Bounds, tip: Sequence[str] = ("x", "y", "z")) -> None:
        """
        Args:
            live: Of a problem with the parameters of `inputs` and the probes of `tip`; other parameters stay as they are.
            inputs: Each parameter that is an input, with its least and greatest value.
            tip: Three probes, the coordinates of the tip.
        """
        self.names, self.lower, self.upper = _limits(inputs)
        self.live = live
        self.network = live.problem.network
        self._tip = _three(tip)
        known = live.problem.parameters
        self._columns = [_index(name, known, "parameter") for name in self.names]
        self._rows = [_index(name, live.problem.probes, "probe") for name in self._tip]

    @property
    def inputs(self) -> Array:
        """(k,), where the arm is."""
        present = self.live.present
        return np.array([present[name] for name in self.names])

    def tip(self, inputs: Array) -> Array:
        """Goes from each state to the next; (n, 3). Stays where it is, and gives no number, where the way is lost."""
        from pennate import SolveError

        tips = np.full((len(inputs), 3), np.nan)
        for tip, row in zip(tips, inputs):
            try:
                self.live.set(**dict(zip(self.names, row.tolist()))).solve()
                tip[:] = self.live.values[self._rows]
            except SolveError:
                self.live.set(**self.live.present)
        return tips

    def jacobian(self, inputs: Array) -> tuple[Array, Array]:
        """From the problem, whose states have no history; the live state does not move."""
        rows = np.tile([self.live.present[name] for name in self.live.problem.parameters], (len(inputs), 1))
        rows[:, self._columns] = inputs
        values, slopes = self.live.problem.gradient(rows)
        return values[:, self._rows], slopes[:, self._rows][:, :, self._columns]


class Swivelled:
    """An arm on a base that turns about the vertical through the origin: one input more, in degrees.

    Gravity and dead loads at the tip are vertical, so the tip turns rigidly with the base.
    """

    def __init__(self, arm: Arm, name: str = "swivel", least: float = -60.0, greatest: float = 60.0) -> None:
        self.arm = arm
        self.network: Network | None = getattr(arm, "network", None)
        self.names = (*arm.names, name)
        self.lower = np.append(arm.lower, least)
        self.upper = np.append(arm.upper, greatest)

    def tip(self, inputs: Array) -> Array:
        """(n, k) inputs to (n, 3) positions; not a number where there is no equilibrium."""
        return _turned(self.arm.tip(inputs[:, :-1]), np.radians(inputs[:, -1]))

    def jacobian(self, inputs: Array) -> tuple[Array, Array]:
        """(n, 3) positions and their derivatives by the inputs, (n, 3, k)."""
        tips, slopes = self.arm.jacobian(inputs[:, :-1])
        angles = np.radians(inputs[:, -1])
        tips = _turned(tips, angles)
        columns = [_turned(slopes[:, :, column], angles) for column in range(slopes.shape[2])]
        # The velocity of a turn by one degree a unit of time: e3 x r.
        spin = np.radians(1.0) * np.stack([-tips[:, 1], tips[:, 0], np.zeros(len(tips))], axis=1)
        return tips, np.stack([*columns, spin], axis=2)


def differences(arm: Arm, inputs: Array, tips: Array) -> Array:
    """(n, 3, k), derivatives by forward differences, backward ones beside an upper limit."""
    slopes = np.empty((*tips.shape, len(arm.names)))
    for column, (low, high) in enumerate(zip(arm.lower, arm.upper)):
        step = STEP * (high - low)
        steps = np.where(inputs[:, column] + step > high, -step, step)
        moved = inputs.copy()
        moved[:, column] += steps
        slopes[:, :, column] = (arm.tip(moved) - tips) / steps[:, None]
    return slopes


def _turned(points: Array, angles: Array) -> Array:
    """(n, 3), points turned about the vertical by (n,) radians."""
    c, s = np.cos(angles), np.sin(angles)
    x, y, z = points.T
    return np.stack([c * x - s * y, s * x + c * y, z], axis=1)


def _limits(inputs: Bounds) -> tuple[tuple[str, ...], Array, Array]:
    if not inputs:
        raise ValueError("inputs: at least one parameter with its limits expected, such as {'pressure': (0, 25)}")
    for name, pair in inputs.items():
        if np.shape(pair) != (2,):
            raise ValueError(f"the limits of '{name}' are {pair!r}: two finite numbers expected, the lesser first")
        low, high = (_arguments.real(limit, f"the limits of '{name}'", "two finite numbers") for limit in pair)
        if not low < high or not np.isfinite([low, high]).all():
            raise ValueError(
                f"the limits of '{name}' are {low:g} and {high:g}: two finite numbers expected, the lesser first"
            )
    bounds = np.array(list(inputs.values()), dtype=np.float64)
    return tuple(inputs), bounds[:, 0].copy(), bounds[:, 1].copy()


def _three(tip: Sequence[str]) -> tuple[str, str, str]:
    if isinstance(tip, str) or len(tip) != 3:
        raise ValueError(f"tip: three probes expected, one for each coordinate, not {tip!r}")
    x, y, z = tip
    return x, y, z


def _index(name: str, known: Sequence[str], what: str) -> int:
    if name not in known:
        raise ValueError(f"the live state's problem has no {what} '{name}'; it has {', '.join(known)}")
    return list(known).index(name)
