"""Learned policies: layers of plain arrays, evaluated by NumPy."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from ._arms import Arm, Array
from ._task import Changes, Levels, Rules, Task

Layer = tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]
KINDS = ("discrete", "continuous")


@dataclass(frozen=True)
class Policy:
    """What is seen, (n, 3 + k), to actions: continuous ones (n, k) from -1 to 1, or values (n, actions) of discrete ones."""

    kind: str
    """`"discrete"`: tanh inside, as the text has it; `"continuous"`: rectifiers inside, and tanh at the end."""
    layers: tuple[Layer, ...]
    """Weights (in, out) and offsets (out,) of each layer."""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"kind: 'discrete' or 'continuous' expected, not {self.kind!r}")

    def __call__(self, seen: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        inside = seen
        for place, (weights, offsets) in enumerate(self.layers):
            inside = inside @ weights + offsets
            if place + 1 == len(self.layers):
                break
            inside = np.tanh(inside) if self.kind == "discrete" else np.maximum(inside, 0)
        return np.tanh(inside) if self.kind == "continuous" else inside

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes an `.npz` file, which holds arrays and nothing that is run when it is read."""
        arrays = {f"{name}{place}": part for place, layer in enumerate(self.layers) for name, part in zip("wb", layer)}
        with open(path, "wb") as file:
            np.savez(file, kind=np.array(self.kind), **arrays)  # type: ignore[arg-type]

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Policy:
        """Reads what `save` wrote."""
        with np.load(path, allow_pickle=False) as file:
            count = sum(name.startswith("w") for name in file)
            if "kind" not in file or not count:
                raise ValueError(f"{os.fspath(path)} holds no policy")
            return cls(str(file["kind"]), tuple((file[f"w{place}"], file[f"b{place}"]) for place in range(count)))


@dataclass(frozen=True)
class Rollout:
    """Where a policy took some arms; arrays are over them."""

    inputs: Array
    """(n, k), the inputs at the end."""
    errors: Array
    """(n,), the errors there, in the unit of lengths."""
    closest: Array
    """(n,), the least errors on the way."""
    moves: npt.NDArray[np.int64]
    """(n,)."""


def follow(
    policy: Policy,
    arm: Arm,
    starts: Array,
    targets: Array,
    *,
    actions: Levels | Changes,
    rules: Rules,
) -> Rollout:
    """Lets a policy act, without exploring, until the error is within the tolerance or the moves are used up.

    Discrete actions that would leave the limits are not chosen, and continuous ones end at the limit: assumed, as the text
    does not say what its tests do there.
    """
    task = Task(arm, actions, rules, len(starts))
    everyone = np.arange(len(starts))
    task.place(everyone, starts, targets)
    closest = task.errors.copy()
    for _ in range(rules.steps):
        go = everyone[task.errors > rules.tolerance]
        if not len(go):
            break
        values = policy(task.seen(go))
        if isinstance(actions, Levels):
            task.step(go, np.where(task.allowed(go) > 0, values, -np.inf).argmax(axis=1))
        else:
            task.step(go, values)
        closest[go] = np.minimum(closest[go], task.errors[go])
    return Rollout(task.inputs, task.errors, closest, task.moves)


def visit(policy: Policy, arm: Arm, start: Array, points: Sequence[Array], rules: Rules, actions: Changes) -> Rollout:
    """Goes from point to point, to each from where the last one ended; arrays of the rollout are over points."""
    found, inputs = [], start[None]
    for point in points:
        one = follow(policy, arm, inputs, point[None], actions=actions, rules=rules)
        found.append(one)
        inputs = one.inputs
    each = [[getattr(one, name) for one in found] for name in ("inputs", "errors", "closest", "moves")]
    return Rollout(*(np.concatenate(parts) for parts in each))
