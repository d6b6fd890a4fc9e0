"""Learned policies: layers of plain arrays, evaluated by NumPy."""

from __future__ import annotations

import json
import os
import zipfile
import zlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import IO, Any

import numpy as np
import numpy.typing as npt

from . import _checks
from ._arms import Arm, Array
from ._task import Changes, Levels, Rules, Task

Layer = tuple[npt.NDArray[np.float32], npt.NDArray[np.float32]]
KINDS = ("discrete", "continuous")
KEPT = ("dqn", "ddpg", "fine")


@dataclass(frozen=True)
class Policy:
    """What is seen, (n, 3 + k), to actions: continuous ones (n, k) from -1 to 1, or values (n, actions) of discrete ones."""

    kind: str
    """`"discrete"`: tanh inside, as the text has it; `"continuous"`: rectifiers inside, and tanh at the end."""
    layers: tuple[Layer, ...]
    """Weights (in, out) and offsets (out,) of each layer."""
    scale: float = 100.0
    """Length that is seen as 1; what is seen is not rounded."""
    about: Mapping[str, Any] = field(default_factory=dict)
    """How it was made: command, seed, rules, networks, versions, and what it scored. Plain values, by their names."""

    def __post_init__(self) -> None:
        if self.kind not in KINDS:
            raise ValueError(f"kind: 'discrete' or 'continuous' expected, not {self.kind!r}")
        widths = [width for weights, _ in self.layers for width in weights.shape]
        fitting = widths[1:-1:2] == widths[2::2] and all(w.shape[1:] == b.shape for w, b in self.layers)
        if not self.layers or len(widths) != 2 * len(self.layers) or not fitting:
            shapes = ", ".join(f"{w.shape} and {b.shape}" for w, b in self.layers) or "none"
            raise ValueError(
                f"layers: weights (in, out) and offsets (out,), each from the last one's out, expected, not {shapes}"
            )
        if not all(np.isfinite(part).all() for layer in self.layers for part in layer):
            raise ValueError("layers: a weight is not a finite number")

    def __call__(self, seen: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
        inside = seen
        for place, (weights, offsets) in enumerate(self.layers):
            inside = inside @ weights + offsets
            if place + 1 == len(self.layers):
                break
            inside = np.tanh(inside) if self.kind == "discrete" else np.maximum(inside, 0)
        return np.tanh(inside) if self.kind == "continuous" else inside

    def check(self, arm: Arm, actions: Levels | Changes) -> None:
        """Raises `ValueError` where this is no policy for an arm with such actions."""
        seen, acts = len(self.layers[0][0]), len(self.layers[-1][1])
        discrete_policy, width = self.kind == "discrete", len(arm.names)
        if discrete_policy != isinstance(actions, Levels):
            expected = "Levels" if discrete_policy else "Changes"
            raise ValueError(f"the policy has {self.kind} actions: {expected} expected, not {actions}")
        choices = len(actions.table()) if isinstance(actions, Levels) else width
        if (seen, acts) != (3 + width, choices):
            raise ValueError(
                f"the policy is of another arm: it is made for {seen - 3} inputs and {acts} actions, and the arm has "
                f"{width} ({', '.join(arm.names)}) and {choices}"
            )
        limits = {name: [low, high] for name, low, high in zip(arm.names, arm.lower.tolist(), arm.upper.tolist())}
        made = self.about.get("inputs", limits)
        if list(made) != list(limits) or not np.allclose(list(made.values()), list(limits.values()), rtol=1e-6):
            raise ValueError(
                f"the policy is of another arm: its inputs are {_ranges(made)}, those of the arm {_ranges(limits)}"
            )

    def halved(self) -> Policy:
        """The same with weights rounded to half precision, as files keep them."""
        return replace(self, layers=tuple((_halved(weights), _halved(offsets)) for weights, offsets in self.layers))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Writes an `.npz` file: arrays of half precision, and nothing that is run when it is read."""
        arrays = {
            f"{name}{place}": part.astype(np.float16)
            for place, layer in enumerate(self.layers)
            for name, part in zip("wb", layer)
        }
        about = np.array(json.dumps(dict(self.about), indent=1))
        # A training that is killed while it writes leaves the last checkpoint whole.
        beside = f"{os.fspath(path)}.part"
        with open(beside, "wb") as file:
            np.savez_compressed(file, kind=np.array(self.kind), scale=np.array(self.scale), about=about, **arrays)  # type: ignore[arg-type]
        os.replace(beside, path)

    @classmethod
    def kept(cls, name: str) -> Policy:
        """One that comes with the package: `"dqn"`, two inputs by strides, `"fine"`, by the smallest alone, or `"ddpg"`, three inputs."""
        if name not in KEPT:
            raise ValueError(f"there is no kept policy '{name}'; there are {', '.join(KEPT)}")
        return cls.load(Path(__file__).parent / "kept" / f"{name}.npz")

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Policy:
        """Reads what `save` wrote; raises `ValueError` where a file is damaged or holds no policy."""
        with open(path, "rb") as file:
            try:
                return cls._read(file)
            except (ValueError, KeyError, EOFError, TypeError, zipfile.BadZipFile, zlib.error) as error:
                raise ValueError(f"{os.fspath(path)} holds no policy, or is damaged: {error}") from error

    @classmethod
    def _read(cls, source: IO[bytes]) -> Policy:
        if not zipfile.is_zipfile(source):
            raise ValueError("it is no whole .npz file")
        source.seek(0)
        with np.load(source, allow_pickle=False) as file:
            count = sum(name.startswith("w") for name in file)
            if "kind" not in file or not count:
                raise ValueError("there are no layers 'w0', 'b0', ... and no 'kind'")
            layers = tuple((_whole(file[f"w{place}"]), _whole(file[f"b{place}"])) for place in range(count))
            scale = float(file["scale"]) if "scale" in file else cls.scale
            about = json.loads(str(file["about"])) if "about" in file else {}
            return cls(str(file["kind"]), layers, scale, about)


def _ranges(limits: Mapping[str, Sequence[float]]) -> str:
    return ", ".join(f"{name} from {low:g} to {high:g}" for name, (low, high) in limits.items())


def _halved(array: npt.NDArray[np.float32]) -> npt.NDArray[np.float32]:
    return array.astype(np.float16).astype(np.float32)


def _whole(array: npt.NDArray[Any]) -> npt.NDArray[np.float32]:
    return array.astype(np.float32)


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
    tips: Array
    """(n, 3), as measured at the end."""


def follow(
    policy: Policy,
    arm: Arm,
    starts: Array,
    targets: Array,
    *,
    actions: Levels | Changes,
    rules: Rules,
    again: bool = False,
) -> Rollout:
    """Lets a policy act, without exploring, until the error is within the tolerance or the moves are used up.

    Discrete actions that would leave the limits are not chosen, and continuous ones end at the limit: assumed, as the text
    does not say what its tests do there. A greedy policy that comes back to levels where it was would go round in circles
    until its moves are used up: of discrete actions only those to levels not visited yet are chosen, where there are any.

    Args:
        rules: What is asked for; what is seen, and how, belongs to the policy.
        again: Whether levels may be visited again.
    """
    policy.check(arm, actions)
    starts, targets = _checks.rows("starts", starts, len(arm.names)), _checks.rows("targets", targets, 3)
    task = Task(arm, actions, replace(rules, scale=policy.scale, rounding=0.0), len(starts))
    everyone = np.arange(len(starts))
    task.place(everyone, starts, targets)
    closest = task.errors.copy()
    track = _Track(task) if isinstance(actions, Levels) else None
    for _ in range(rules.steps):
        go = everyone[task.errors > rules.tolerance]
        if not len(go):
            break
        values = policy(task.seen(go))
        task.step(go, values if track is None else track.choose(go, values, again))
        closest[go] = np.minimum(closest[go], task.errors[go])
    return Rollout(task.inputs, task.errors, closest, task.moves, task.tips)


class _Track:
    """Which levels arms have visited, and the best of the actions that lead elsewhere."""

    def __init__(self, task: Task) -> None:
        self.task = task
        self.visited: list[npt.NDArray[np.int64]] = []

    def choose(self, go: npt.NDArray[np.intp], values: npt.NDArray[np.float32], again: bool) -> npt.NDArray[np.intp]:
        """(n,), actions of the arms `go`."""
        here, ahead = self.task.places(go)
        allowed = self.task.allowed(go) > 0
        if not again:
            self.visited.append(np.full(self.task.count, -1))
            self.visited[-1][go] = here
            before = np.stack([visited[go] for visited in self.visited], axis=1)
            new = allowed & ~(ahead[:, :, None] == before[:, None, :]).any(axis=2)
            allowed = np.where(new.any(axis=1)[:, None], new, allowed)
        found: npt.NDArray[np.intp] = np.where(allowed, values, -np.inf).argmax(axis=1)
        return found


def visit(policy: Policy, arm: Arm, start: Array, points: Sequence[Array], rules: Rules, actions: Changes) -> Rollout:
    """Goes from point to point, to each from where the last one ended; arrays of the rollout are over points."""
    found, inputs = [], start[None]
    for point in points:
        one = follow(policy, arm, inputs, point[None], actions=actions, rules=rules)
        found.append(one)
        inputs = one.inputs
    each = [[getattr(one, name) for one in found] for name in ("inputs", "errors", "closest", "moves", "tips")]
    return Rollout(*(np.concatenate(parts) for parts in each))
