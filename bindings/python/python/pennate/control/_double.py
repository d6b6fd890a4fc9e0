"""Double DQN of skrl with the action of the target chosen by the network that learns. Needs `pennate[train]`.

skrl 2 compiles its update with the parameters that this network has at the first one: from then on the actions of the targets are chosen by
a network that has learned nothing, and a training that goes on in another process compiles others.
"""

from __future__ import annotations

import functools
from typing import Any

import jax
import jax.numpy as jnp
from skrl.agents.jax.ddqn import DDQN


@functools.partial(jax.jit, static_argnames="act")
def _gradient(act: Any, params: Any, targets: Any, now: Any, ahead: Any, taken: Any, worth: Any, ended: Any, discount: Any) -> Any:
    """Of the squared error of values of the actions taken; `targets` are values of the target network ahead."""
    role = "q_network"
    best = act(ahead, role=role, params=params)[0].argmax(axis=1)
    wanted = worth[:, 0] + discount * jnp.logical_not(ended[:, 0]) * targets[jnp.arange(len(best)), best]

    def error(params: Any) -> Any:
        values = act(now, role=role, params=params)[0]
        return ((values[jnp.arange(len(best)), taken[:, 0]] - wanted) ** 2).mean()

    return jax.grad(error)(params)


class DoubleQ(DDQN):  # type: ignore[misc]
    """One gradient step and one move of the target network at each update, by the rate of the scheduler; settings for more are not read."""

    optimizer: Any
    learning_rate: float

    def update(self, *, timestep: int, timesteps: int) -> None:
        """Learns from a batch of the memory, and moves the target network."""
        names = ["observations", "actions", "rewards", "next_observations", "terminated"]
        seen, taken, worth, ahead, ended = self.memory.sample(names=names, batch_size=self.cfg.batch_size)[0]
        now, after = ({"observations": each, "states": None} for each in (seen, ahead))
        targets = self.target_q_network.act(after, role="target_q_network")[0]
        params = self.q_network.state_dict.params
        grad = _gradient(self.q_network.act, params, targets, now, after, taken, worth, ended, self.cfg.discount_factor)
        self.optimizer = self.optimizer.step(grad=grad, model=self.q_network, lr=self.learning_rate)
        self.target_q_network.update_parameters(self.q_network, polyak=self.cfg.polyak)
        self.learning_rate *= self.scheduler(timestep)
