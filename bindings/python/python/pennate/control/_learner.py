"""What learns: agents of skrl on JAX, and the arms that they move. Needs `pennate[train]`."""

from __future__ import annotations

from typing import Any

import flax.serialization
import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
from skrl.agents.jax.ddpg import DDPG
from skrl.envs.wrappers.jax import Wrapper
from skrl.resources.noises.jax import OrnsteinUhlenbeckNoise
from skrl.utils import set_seed

from . import br2
from ._double import DoubleQ
from ._envs import spaces
from ._memory import Replay
from ._nets import Actor, Critic, Values
from ._policy import Layer
from ._recipes import Recipe
from ._task import Levels, Task

ARMS = 64
# Of a target network towards the one that learns, at each update: the target is its mean over the last 100 updates or so.
POLYAK = 0.01


class Arms(Wrapper):  # type: ignore[misc]
    """Arms side by side as skrl wants them: episodes that end begin anew in the same step."""

    def __init__(self, task: Task, seed: int) -> None:
        # skrl looks for what it does not find here in the environment that is wrapped: here there is none.
        self._env = self._unwrapped = None
        self._device = jax.devices("cpu")[0]
        self.task = task
        self._spaces = spaces(task, br2.LENGTH)
        self._all = np.arange(task.count)
        self._generators = [np.random.default_rng([seed, place]) for place in range(task.count)]
        self.episodes = 0
        self.task.begin(self._all, self._generators)

    @property
    def num_envs(self) -> int:
        return self.task.count

    @property
    def state_space(self) -> None:
        return None

    @property
    def observation_space(self) -> gymnasium.Space[Any]:
        return self._spaces[0]

    @property
    def action_space(self) -> gymnasium.Space[Any]:
        return self._spaces[1]

    def reset(self) -> tuple[Any, dict[str, Any]]:
        return jnp.asarray(self.task.seen(self._all)), {}

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        given = np.asarray(actions)
        given = given.reshape(-1) if isinstance(self.task.actions, Levels) else given
        reward, ended, cut = self.task.step(self._all, given)
        done = np.flatnonzero(ended | cut)
        self.episodes += len(done)
        if len(done):
            self.task.begin(done, self._generators)
        seen = jnp.asarray(self.task.seen(self._all))
        column = (each[:, None] for each in (reward.astype(np.float32), ended, cut))
        return (seen, *column, {})

    def state(self) -> None:
        return None

    def render(self, *_: Any, **__: Any) -> None:
        return None

    def close(self) -> None:
        return None

    def present(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Where the episodes are: arrays, and plain values."""
        states = [generator.bit_generator.state for generator in self._generators]
        return self.task.present(), {"episodes": self.episodes, "generators": states}

    def go_on(self, arrays: dict[str, Any], values: dict[str, Any]) -> None:
        """Puts the episodes where they were."""
        self.task.go_on(arrays)
        self.episodes = values["episodes"]
        for generator, state in zip(self._generators, values["generators"]):
            generator.bit_generator.state = state


class Learner:
    """An agent with its networks and its memory."""

    def __init__(self, recipe: Recipe, arms: Arms, steps: int, seed: int) -> None:
        set_seed(seed)
        self.recipe, self.arms, self.steps = recipe, arms, steps
        discrete = recipe.kind == "discrete"
        kinds: dict[str, Any] = (
            {"q_network": Values, "target_q_network": Values}
            if discrete
            else {"policy": Actor, "target_policy": Actor, "critic": Critic, "target_critic": Critic}
        )
        self.roles = tuple(kinds)[:2]
        """The network that acts, and its running mean."""
        self._optimizers = ("optimizer",) if discrete else ("policy_optimizer", "critic_optimizer")
        self.nets = {name: kind(arms.observation_space, arms.action_space) for name, kind in kinds.items()}
        width = arms.observation_space.shape[0]  # type: ignore[index]
        sample = {"observations": jnp.zeros((1, width)), "states": None, "taken_actions": jnp.zeros((1, width - 3))}
        for name, net in self.nets.items():
            net.init_state_dict(role=name, inputs=sample)
        self.memory = Replay(memory_size=recipe.memory, num_envs=arms.num_envs)
        self.agent = (DoubleQ if discrete else DDPG)(
            models=self.nets,
            memory=self.memory,
            observation_space=arms.observation_space,
            action_space=arms.action_space,
            cfg=self._settings(),
        )
        self.agent.init()
        self.agent.enable_training_mode(True)
        self._seen = arms.reset()[0]

    def _settings(self) -> dict[str, Any]:
        recipe, warm = self.recipe, max(8, 3000 // ARMS)
        common: dict[str, Any] = {
            "gradient_steps": 1,
            "batch_size": recipe.batch,
            "discount_factor": recipe.discount,
            "polyak": POLYAK,
            "learning_starts": warm,
            "random_timesteps": warm,
            "rewards_shaper": lambda reward, *_: reward / recipe.worth,
            "exploration_scheduler": recipe.explores,
            "experiment": {"directory": "", "write_interval": 0, "checkpoint_interval": 0},
        }
        if recipe.kind == "discrete":
            falling = 0.01 ** (1 / self.steps)
            return common | {
                "learning_rate": recipe.rates[0],
                "learning_rate_scheduler": lambda: lambda _: falling,
            }
        return common | {
            "learning_rate": recipe.rates,
            "exploration_noise": OrnsteinUhlenbeckNoise,
            "exploration_noise_kwargs": {"theta": 0.15, "sigma": 0.2, "base_scale": 1.0},
        }

    def move(self, move: int) -> None:
        """One move of all arms, and what is learned from it."""
        counted = {"timestep": move, "timesteps": self.steps}
        actions, _ = self.agent.act(self._seen, None, **counted)
        seen, rewards, ended, cut, info = self.arms.step(actions)
        self.agent.record_transition(
            observations=self._seen,
            states=None,
            actions=actions,
            rewards=rewards,
            next_observations=seen,
            next_states=None,
            terminated=ended,
            truncated=cut,
            infos=info,
            **counted,
        )
        self.agent.post_interaction(**counted)
        self.agent.tracking_data.clear()
        self._seen = seen

    def layers(self, role: str) -> tuple[Layer, ...]:
        """Of a network, as arrays."""
        layers = jax.device_get(self.nets[role].state_dict.params)["params"]
        names = sorted(layers, key=lambda name: int(name.rsplit("_", 1)[1]))
        return tuple((np.asarray(layers[name]["kernel"]), np.asarray(layers[name]["bias"])) for name in names)

    def present(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """All that another process needs to go on, digit for digit: arrays, and plain values."""
        memory, noise = self.memory, getattr(self.agent, "_exploration_noise", None)
        kind, key, place, *rest = np.random.get_state()
        arrays = {f"memory_{name}": tensor for name, tensor in memory.tensors.items()} | {"key": key}
        for name, tree in self._trees().items():
            arrays[f"tree_{name}"] = np.frombuffer(flax.serialization.to_bytes(tree), dtype=np.uint8)
        if noise is not None:
            arrays["noise"] = np.asarray(noise.state)
        values = {"memory": [memory.memory_index, memory.filled], "random": [kind, place, *rest]}
        values |= {"rate": getattr(self.agent, "learning_rate", None), "noise": noise and noise._i}
        return arrays, values

    def go_on(self, arrays: dict[str, Any], values: dict[str, Any]) -> None:
        """Puts everything where it was; the arms are where they were already."""
        for name in self.memory.tensors:
            self.memory.tensors[name][:] = arrays[f"memory_{name}"]
        self.memory.memory_index, self.memory.filled = values["memory"]
        kind, *rest = values["random"]
        np.random.set_state((kind, arrays["key"], *rest))
        for name, tree in self._trees().items():
            found = flax.serialization.from_bytes(tree, arrays[f"tree_{name}"].tobytes())
            if name in self.nets:
                self.nets[name].state_dict = self.nets[name].state_dict.replace(params=found)
            else:
                setattr(self.agent, name, getattr(self.agent, name).replace(state=found))
        if values["rate"] is not None:
            self.agent.learning_rate = values["rate"]
        if values["noise"]:
            self.agent._exploration_noise.state = jnp.asarray(arrays["noise"])
            self.agent._exploration_noise._i = values["noise"]
        self._seen = self.arms.reset()[0]

    def _trees(self) -> dict[str, Any]:
        trees = {name: net.state_dict.params for name, net in self.nets.items()}
        return trees | {name: getattr(self.agent, name).state for name in self._optimizers}
