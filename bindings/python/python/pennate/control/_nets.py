"""The networks of the policies, for skrl on JAX. Needs `pennate[train]`."""

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
        top = np.array(br2.LEVELS) - 1
        # Two inputs, each up and down by each stride.
        strides = br2.STRIDES[: self.action_space.n // 4]
        changes = jnp.asarray(Levels(br2.LEVELS, strides).table() / top)
        after = seen[:, None, 3:] + changes
        inside = ((after > -1e-3) & (after < 1 + 1e-3)).all(axis=2)
        return jnp.where(inside, nn.Dense(len(changes))(x), -10.0), {}
