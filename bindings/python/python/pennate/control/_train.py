"""Training of policies: DDPG and DQN by skrl on JAX, on tables of the BR2 arm. Needs `pennate[train]`.

What the text does not give, or gives and does not lead anywhere, is assumed: see `_recipes`, and the page of the book. Step limits
end episodes as failures, as the text has it: skrl would otherwise take the first state of the next episode for the last one
of this.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import asdict, replace
from importlib.metadata import version
from typing import Any

import gymnasium
import jax
import jax.numpy as jnp
import numpy as np
import pennate
from skrl.agents.jax.ddpg import DDPG
from skrl.agents.jax.ddqn import DDQN
from skrl.envs.wrappers.jax import Wrapper
from skrl.memories.jax import RandomMemory
from skrl.resources.noises.jax import OrnsteinUhlenbeckNoise
from skrl.trainers.jax import SequentialTrainer
from skrl.utils import set_seed

from . import br2
from ._envs import spaces
from ._judge import MOVE, PAIRS, Judge
from ._nets import Actor, Critic, Values
from ._policy import Layer, Policy
from ._recipes import RECIPES, Recipe
from ._task import Levels, Task

ARMS = 64
CHECKPOINTS = 24
# Of a target network towards the one that learns, at each update: the target is its mean over the last 100 updates or so.
POLYAK = 0.01


class Arms(Wrapper):  # type: ignore[misc]
    """Arms side by side as skrl wants them: episodes that end begin anew in the same step."""

    def __init__(self, task: Task, length: float, seed: int) -> None:
        # skrl looks for what it does not find here in the environment that is wrapped: here there is none.
        self._env = self._unwrapped = None
        self._device = jax.devices("cpu")[0]
        self.task = task
        self._spaces = spaces(task, length)
        self._all = np.arange(task.count)
        self._generators = [np.random.default_rng([seed, place]) for place in range(task.count)]
        self.episodes = 0
        self._begun = False

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
        if not self._begun:
            self.task.begin(self._all, self._generators)
            self._begun = True
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
        column = (jnp.asarray(each)[:, None] for each in (reward.astype(np.float32), ended, cut))
        return (seen, *column, {})

    def state(self) -> None:
        return None

    def render(self, *_: Any, **__: Any) -> None:
        return None

    def close(self) -> None:
        return None


def train(
    method: str,
    steps: int,
    seed: int,
    *,
    say: Callable[[str], None] = print,
    keep: Callable[[Policy], None] = lambda policy: None,
) -> tuple[Policy, float]:
    """The best checkpoint of a training, by its share of validation pairs that come near enough and its moves, and that share.

    At each checkpoint the network that learns and its target network, a running mean of it, are judged.

    Args:
        method: `"ddpg"`, `"dqn"`, or `"fine"`, which is `"dqn"` with the smallest strides alone.
        steps: Moves of all arms at once.
        seed: Of arms, networks and exploration.
        say: Gets a line for each checkpoint.
        keep: Gets each checkpoint that is better than all before, as it comes.
    """
    recipe = RECIPES[method]
    judge = Judge(recipe.kind, PAIRS, recipe.strides)
    set_seed(seed)
    arms = Arms(Task(judge.arm, judge.actions, recipe.rules, ARMS), br2.LENGTH, seed)
    agent, nets = _agent(method, recipe, arms, steps)
    acting = "q_network" if recipe.kind == "discrete" else "policy"
    best: tuple[float, Policy] | None = None
    begin, learn = time.perf_counter(), agent.post_interaction

    def post_interaction(*, timestep: int, timesteps: int) -> None:
        nonlocal best
        learn(timestep=timestep, timesteps=timesteps)
        if (timestep + 1) % max(1, steps // CHECKPOINTS):
            return
        passed, marks = time.perf_counter() - begin, []
        for role in (acting, f"target_{acting}"):
            policy = Policy(recipe.kind, _layers(nets[role]), recipe.rules.scale).halved()
            share, moves = judge.mark(policy)
            marks.append(f"{100 * share:.1f} % in {moves:.1f} moves")
            if best is None or share - MOVE * moves > best[0]:
                made = _about(method, recipe, steps, seed) | {
                    "checkpoint": timestep + 1,
                    "network": role,
                    "episodes": arms.episodes,
                    "seconds": round(passed),
                    "validation_pairs": PAIRS,
                    "validation_share": share,
                    "validation_moves": moves,
                }
                best = share - MOVE * moves, replace(policy, about=made)
                keep(best[1])
        say(
            f"{timestep + 1} moves of {ARMS} arms, {arms.episodes} episodes, {passed:.0f} s: of {PAIRS} validation pairs within "
            f"{recipe.rules.success:g} mm {marks[0]}, by its mean {marks[1]}"
        )

    agent.post_interaction = post_interaction
    settings = {"timesteps": steps, "headless": True, "disable_progressbar": True}
    SequentialTrainer(env=arms, agents=agent, cfg=settings).train()
    if best is None:
        raise RuntimeError("no checkpoint was made: too few steps")
    return best[1], float(best[1].about["validation_share"])


def _about(method: str, recipe: Recipe, steps: int, seed: int) -> dict[str, Any]:
    """What another person needs to make the policy again."""
    return {
        "command": f"python -m pennate.control train {method} --steps {steps} --seed {seed}",
        "seed": seed,
        "arms": ARMS,
        "recipe": asdict(recipe),
        "polyak": POLYAK,
        "versions": {"pennate": pennate.__version__} | {name: version(name) for name in ("skrl", "jax", "numpy")},
    }


def _agent(method: str, recipe: Recipe, arms: Arms, steps: int) -> tuple[Any, dict[str, Any]]:
    """The agent of a method, and its networks."""
    discrete = recipe.kind == "discrete"
    kinds: dict[str, Any] = (
        {"q_network": Values, "target_q_network": Values}
        if discrete
        else {"policy": Actor, "target_policy": Actor, "critic": Critic, "target_critic": Critic}
    )
    width = arms.observation_space.shape[0]  # type: ignore[index]
    sample = {"observations": jnp.zeros((1, width)), "states": None, "taken_actions": jnp.zeros((1, width - 3))}
    nets = {name: kind(arms.observation_space, arms.action_space) for name, kind in kinds.items()}
    for name, net in nets.items():
        net.init_state_dict(role=name, inputs=sample)
    warm = max(8, 3000 // ARMS)
    common: dict[str, Any] = {
        "gradient_steps": 1,
        "batch_size": recipe.batch,
        "discount_factor": recipe.discount,
        "polyak": POLYAK,
        "learning_starts": warm,
        "random_timesteps": warm,
        "experiment": {"directory": "", "write_interval": 0, "checkpoint_interval": 0},
    }
    if discrete:
        common |= {
            "learning_rate": recipe.rates[0],
            "learning_rate_scheduler": lambda: lambda _: 0.01 ** (1 / steps),
            "target_update_interval": 1,
            # Fewer random actions let loops between two states fill the memory.
            "exploration_scheduler": lambda step, last: max(0.6, 1 - 0.4 * step / (0.6 * last)),
            "rewards_shaper": lambda reward, *_: reward / 100,
        }
    else:
        common |= {
            "learning_rate": recipe.rates,
            "rewards_shaper": lambda reward, *_: reward / 10,
            "exploration_noise": OrnsteinUhlenbeckNoise,
            "exploration_noise_kwargs": {"theta": 0.15, "sigma": 0.2, "base_scale": 1.0},
            "exploration_scheduler": lambda step, last: max(0.15, 1 - step / (0.7 * last)),
        }
    agent = (DDQN if discrete else DDPG)(
        models=nets,
        memory=RandomMemory(memory_size=recipe.memory, num_envs=arms.num_envs),
        observation_space=arms.observation_space,
        action_space=arms.action_space,
        cfg=common,
    )
    return agent, nets


def _layers(net: Any) -> tuple[Layer, ...]:
    """The layers of a network as arrays."""
    layers = jax.device_get(net.state_dict.params)["params"]
    names = sorted(layers, key=lambda name: int(name.rsplit("_", 1)[1]))
    return tuple((np.asarray(layers[name]["kernel"]), np.asarray(layers[name]["bias"])) for name in names)
