"""The registered environments, by the functions that Gymnasium calls; their arguments are those of `br2.environment`."""

from __future__ import annotations

from typing import Any

from . import br2
from ._envs import Env, VectorEnv

# What belongs to the environment, and not to its arm and rules.
OWN = ("render_mode", "painter", "autoreset_mode")


def discrete(**given: Any) -> Env:
    """Two pressures, twelve strides."""
    own, task = _parted(given)
    return Env(**br2.environment("discrete", **task), **own)


def continuous(**given: Any) -> Env:
    """Two pressures, of which one has a sign, and the swivel."""
    own, task = _parted(given)
    return Env(**br2.environment("continuous", **task), **own)


def discrete_side_by_side(num_envs: int = 1, **given: Any) -> VectorEnv:
    """Arms side by side, with strides."""
    own, task = _parted(given)
    return VectorEnv(num_envs, **br2.environment("discrete", **task), **own)


def continuous_side_by_side(num_envs: int = 1, **given: Any) -> VectorEnv:
    """Arms side by side, with continuous changes."""
    own, task = _parted(given)
    return VectorEnv(num_envs, **br2.environment("continuous", **task), **own)


def _parted(given: dict[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    own = {name: value for name, value in given.items() if name in OWN}
    return own, {name: value for name, value in given.items() if name not in OWN}
