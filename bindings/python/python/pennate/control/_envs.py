"""Gymnasium environments: an arm, or many side by side, whose tip is to reach a target."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.utils import seeding
from gymnasium.vector import AutoresetMode
from gymnasium.vector.utils import batch_space

from pennate import Network

from .. import _arguments
from ._arms import Arm, Array, Bounds, Solved
from ._draw import picture
from ._table import Table
from ._task import Changes, Floats, Levels, Rules, Task

Space = gymnasium.spaces.Space[Any]


class Env(gymnasium.Env[Any, Any]):
    """One arm whose tip is to reach a target, by discrete or continuous changes of its inputs.

    An observation is (3 + k,): the way from tip to target over `rules.scale`, and the inputs as shares of their limits.
    `info` has `inputs` (k,), `tip` (3,), `target` (3,), `error`, `is_success`, and for discrete actions `action_mask`,
    where 1 stays within the limits. `reset(options={"start": inputs, "target": point})` sets what is drawn otherwise.
    The same seed and actions give the same digits: every state is an equilibrium by itself, or a value of the table.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 5}

    def __init__(
        self,
        network: Network | Arm,
        inputs: Bounds | None = None,
        tip: Sequence[str] = ("x", "y", "z"),
        *,
        actions: Levels | Changes,
        rules: Rules,
        table: Sequence[int] | None = None,
        kinks: Sequence[Sequence[float]] | None = None,
        accuracy: float = 1e-6,
        length: float = np.inf,
        render_mode: str | None = None,
        painter: str = "numpy",
    ) -> None:
        """
        Args:
            network: What is moved; or an arm, which has its inputs already.
            inputs: Parameters of the network, each with its least and greatest value.
            tip: Three probes, the coordinates of the tip.
            actions: What may be done.
            rules: What is asked for, and what it earns.
            table: Points along each input of a table that is made at first and interpolated; without it each move is solved for.
            kinks: Of each input, values at which the slope of the tip jumps: see `Table`.
            accuracy: Of the solves.
            length: How far from the origin a tip may come; it bounds what is seen.
            render_mode: `"rgb_array"`, or none.
            painter: `"numpy"` draws lines in two views with nothing else installed; `"pyvista"` draws tubes, and needs
                `pennate[view]` and a graphics library such as EGL or OSMesa.
        """
        self._task = Task(arm_of(network, inputs, tip, table, kinks, accuracy), actions, rules, 1)
        self.observation_space, self.action_space = spaces(self._task, length)
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ValueError(f"render_mode: 'rgb_array' or None expected, not {render_mode!r}")
        self.render_mode, self._painter = render_mode, painter
        self._only = np.zeros(1, dtype=np.intp)
        self._begun = False

    @property
    def arm(self) -> Arm:
        """What is moved."""
        return self._task.arm

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Floats, dict[str, Any]]:
        super().reset(seed=seed)
        self._task.begin(self._only, [self.np_random], **_options(options))
        self._begun = True
        seen = self._task.seen(self._only)
        _near_enough(seen, self.observation_space, options)
        return seen[0], self._info()

    def step(self, action: Any) -> tuple[Floats, float, bool, bool, dict[str, Any]]:
        if not self._begun:
            raise gymnasium.error.ResetNeeded("no episode has begun: call reset() before step()")
        reward, ended, cut = self._task.step(self._only, np.asarray(action)[None])
        return self._task.seen(self._only)[0], float(reward[0]), bool(ended[0]), bool(cut[0]), self._info()

    def render(self) -> Any:
        """(480, 960, 3), bytes: the network in the present state from the side and from above, and the target."""
        if self.render_mode is None:
            return None
        return picture(self.arm, self._task.inputs[0], self._task.targets[0], self._painter)

    def _info(self) -> dict[str, Any]:
        return {name: values[0] for name, values in known(self._task, self._only).items()}


class VectorEnv(gymnasium.vector.VectorEnv[Any, Any, Any]):
    """Arms side by side; the i-th gives the digits of an `Env` seeded with `seed + i`, as long as its first episode lasts.

    A move of all of them is one call of the solver or of the table. Episodes that ended begin anew as `autoreset_mode` says.
    """

    metadata: dict[str, Any] = {"render_modes": [], "autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(
        self,
        num_envs: int,
        network: Network | Arm,
        inputs: Bounds | None = None,
        tip: Sequence[str] = ("x", "y", "z"),
        *,
        actions: Levels | Changes,
        rules: Rules,
        table: Sequence[int] | None = None,
        kinks: Sequence[Sequence[float]] | None = None,
        accuracy: float = 1e-6,
        length: float = np.inf,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
        render_mode: str | None = None,
    ) -> None:
        """The arguments are those of `Env`; nothing is drawn."""
        if render_mode is not None:
            raise ValueError("render_mode: arms side by side are not drawn; use a single environment")
        self.num_envs = num_envs = _arguments.count(num_envs, "num_envs", None)
        self._task = Task(arm_of(network, inputs, tip, table, kinks, accuracy), actions, rules, num_envs)
        self.single_observation_space, self.single_action_space = spaces(self._task, length)
        self.observation_space = batch_space(self.single_observation_space, num_envs)
        self.action_space = batch_space(self.single_action_space, num_envs)
        self._autoreset = AutoresetMode(autoreset_mode)
        self.metadata = {**self.metadata, "autoreset_mode": self._autoreset}
        self._all = np.arange(num_envs)
        self._done, self._begun = np.zeros(num_envs, dtype=bool), np.zeros(num_envs, dtype=bool)
        self._generators: list[np.random.Generator] = []

    @property
    def arm(self) -> Arm:
        """What is moved."""
        return self._task.arm

    def reset(
        self, *, seed: int | list[int | None] | None = None, options: dict[str, Any] | None = None
    ) -> tuple[Floats, dict[str, Any]]:
        """Begins all episodes anew, or those of `options["reset_mask"]`."""
        self._seed(seed)
        options = dict(options or {})
        mask = options.pop("reset_mask", None)
        which = self._all if mask is None else np.flatnonzero(mask)
        self._task.begin(which, self._generators, **_options(options))
        self._done[which], self._begun[which] = False, True
        seen = self._task.seen(self._all)
        _near_enough(seen, self.single_observation_space, options)
        return seen, self._info()

    def step(self, actions: Any) -> tuple[Floats, Array, npt.NDArray[np.bool_], npt.NDArray[np.bool_], dict[str, Any]]:
        if not self._begun.all():
            raise gymnasium.error.ResetNeeded("no episode has begun of some arms: call reset() before step()")
        actions = np.asarray(actions)
        if actions.shape[:1] != (self.num_envs,):
            raise ValueError(f"actions have the shape {actions.shape}: a row for each of {self.num_envs} arms expected")
        new = self._done if self._autoreset is AutoresetMode.NEXT_STEP else np.zeros_like(self._done)
        go = np.flatnonzero(~new)
        reward, ended, cut = np.zeros(self.num_envs), np.zeros_like(new), np.zeros_like(new)
        reward[go], ended[go], cut[go] = self._task.step(go, actions[go])
        if new.any():
            self._task.begin(np.flatnonzero(new), self._generators)
        self._done = ended | cut
        if self._autoreset is AutoresetMode.SAME_STEP and self._done.any():
            last, final = self._task.seen(self._all), self._info()
            self._task.begin(np.flatnonzero(self._done), self._generators)
            info = self._info()
            info.update(final_obs=last, _final_obs=self._done.copy(), final_info=final, _final_info=self._done.copy())
        else:
            info = self._info()
        return self._task.seen(self._all), reward, ended, cut, info

    def _seed(self, seed: int | list[int | None] | None) -> None:
        seeds: Sequence[int | None]
        if isinstance(seed, int | np.integer):
            seeds = [int(seed) + place for place in range(self.num_envs)]
        else:
            seeds = [None] * self.num_envs if seed is None else seed
        if len(seeds) != self.num_envs:
            raise ValueError(f"seed: {self.num_envs} seeds expected, not {len(seeds)}")
        # An arm without a seed goes on with the generator that it has.
        kept = dict(enumerate(self._generators))
        self._generators = [
            kept[place] if one is None and place in kept else seeding.np_random(one)[0]
            for place, one in enumerate(seeds)
        ]

    def _info(self) -> dict[str, Any]:
        info: dict[str, Any] = known(self._task, self._all)
        there = np.ones(self.num_envs, dtype=bool)
        return {**info, **{f"_{name}": there for name in info}}


def arm_of(
    network: Network | Arm,
    inputs: Bounds | None,
    tip: Sequence[str],
    table: Sequence[int] | None,
    kinks: Sequence[Sequence[float]] | None,
    accuracy: float,
) -> Arm:
    """The arm of a network, solved for or tabulated."""
    if isinstance(network, Network):
        if inputs is None:
            raise ValueError("inputs: the parameters of the network that are inputs, with their limits, are needed")
        arm: Arm = Solved(network, inputs, tip, accuracy=accuracy)
    elif inputs is not None:
        raise ValueError("inputs: an arm has inputs already; they are given with a network alone")
    else:
        arm = network
    return arm if table is None else Table(arm, table, kinks)


def spaces(task: Task, length: float) -> tuple[Space, Space]:
    """What is seen, and what may be done."""
    # A tip and a target on opposite sides, and what rounding adds.
    far = (2.0 * length + task.rules.rounding) / task.rules.scale
    width = len(task.arm.names)
    low = np.concatenate([np.full(3, -far), np.where(task.arm.lower < 0, -1.0, 0.0)]).astype(np.float32)
    high = np.concatenate([np.full(3, far), np.ones(width)]).astype(np.float32)
    seen = gymnasium.spaces.Box(low, high, dtype=np.float32)
    if isinstance(task.actions, Levels):
        return seen, gymnasium.spaces.Discrete(len(task.actions.table()))
    return seen, gymnasium.spaces.Box(-1.0, 1.0, (width,), dtype=np.float32)


def known(task: Task, which: npt.NDArray[np.intp]) -> dict[str, Any]:
    """What stands in `info`, an array each."""
    info: dict[str, Any] = {
        "inputs": task.inputs[which],
        "tip": task.tips[which],
        "target": task.targets[which],
        "error": task.errors[which],
        "is_success": task.errors[which] <= task.rules.success,
    }
    if isinstance(task.actions, Levels):
        info["action_mask"] = task.allowed(which)
    return info


def _options(options: dict[str, Any] | None) -> dict[str, Any]:
    given = dict(options or {})
    unknown = set(given) - {"start", "target"}
    if unknown:
        raise ValueError(f"options: 'start' and 'target' are known, not {', '.join(sorted(map(repr, unknown)))}")
    return given


def _near_enough(seen: Floats, space: Space, options: dict[str, Any] | None) -> None:
    """Refuses a target that is farther away than what can be seen."""
    if options and "target" in options and not all(space.contains(row) for row in seen):
        raise ValueError(f"target: {options['target']} is farther away than twice the `length` of the environment")
