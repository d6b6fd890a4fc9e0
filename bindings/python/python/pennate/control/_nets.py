"""The networks of the policies, for skrl on JAX. Needs `pennate[train]`.

They draw their random actions themselves: skrl 2 draws them from a copy of the generator of the space of actions, which is the
same at each move, so that an arm would explore by one action for ever, another one in each run.
"""

from __future__ import annotations

from typing import Any

import flax.linen as nn
import jax.numpy as jnp
import numpy as np
from skrl.models.jax import DeterministicMixin, Model

from . import br2
from ._recipes import RECIPES
from ._task import Levels


def _begin(net: Any, **given: Any) -> None:
    Model.__init__(net, **given)
    DeterministicMixin.__init__(net)


def _inside(seen: Any, actions: int) -> Any:
    """(n, actions), whether strides stay within the limits; `seen` is an array of NumPy or of JAX."""
    # Two inputs, each up and down by each stride.
    changes = Levels(br2.LEVELS, br2.STRIDES[: actions // 4]).table() / (np.array(br2.LEVELS) - 1)
    after = seen[:, None, 3:] + changes.astype(np.float32)
    return ((after > -1e-3) & (after < 1 + 1e-3)).all(axis=2)


class Actor(DeterministicMixin, Model):  # type: ignore[misc]
    """Changes of inputs as shares of the largest."""

    # Flax makes a data class of what has no constructor of its own; skrl asks for the names of these arguments.
    def __init__(self, observation_space: Any, action_space: Any, device: Any = None, **rest: Any) -> None:
        _begin(self, observation_space=observation_space, action_space=action_space, device=device, **rest)

    @nn.compact  # type: ignore[untyped-decorator]
    def __call__(self, inputs: Any, role: str) -> Any:
        x = inputs["observations"]
        for _ in range(2):
            x = nn.relu(nn.Dense(RECIPES["ddpg"].width)(x))
        return nn.tanh(nn.Dense(3, kernel_init=nn.initializers.normal(3e-3))(x)), {}

    def random_act(self, inputs: Any, *, role: str = "", params: Any = None) -> tuple[Any, dict[str, Any]]:
        """Changes drawn evenly."""
        return np.random.uniform(-1.0, 1.0, (len(inputs["observations"]), 3)).astype(np.float32), {}


class Critic(DeterministicMixin, Model):  # type: ignore[misc]
    """What a state and an action are worth."""

    def __init__(self, observation_space: Any, action_space: Any, device: Any = None, **rest: Any) -> None:
        _begin(self, observation_space=observation_space, action_space=action_space, device=device, **rest)

    @nn.compact  # type: ignore[untyped-decorator]
    def __call__(self, inputs: Any, role: str) -> Any:
        x = jnp.concatenate([inputs["observations"], inputs["taken_actions"]], axis=-1)
        for _ in range(2):
            x = nn.relu(nn.Dense(RECIPES["ddpg"].width)(x))
        return nn.Dense(1)(x), {}


class Values(DeterministicMixin, Model):  # type: ignore[misc]
    """What each stride is worth; strides beyond the limits are worth less than any other, in the target as well."""

    def __init__(self, observation_space: Any, action_space: Any, device: Any = None, **rest: Any) -> None:
        _begin(self, observation_space=observation_space, action_space=action_space, device=device, **rest)

    @nn.compact  # type: ignore[untyped-decorator]
    def __call__(self, inputs: Any, role: str) -> Any:
        seen = inputs["observations"]
        x = seen
        for _ in range(3):
            x = nn.tanh(nn.Dense(RECIPES["dqn"].width)(x))
        values = nn.Dense(int(self.action_space.n))(x)
        return jnp.where(_inside(seen, int(self.action_space.n)), values, -10.0), {}

    def random_act(self, inputs: Any, *, role: str = "", params: Any = None) -> tuple[Any, dict[str, Any]]:
        """Strides drawn evenly among those that stay within the limits."""
        inside = _inside(np.asarray(inputs["observations"]), int(self.action_space.n))
        return np.where(inside, np.random.random(inside.shape), -1.0).argmax(axis=1)[:, None], {}
