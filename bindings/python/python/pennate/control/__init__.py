"""Control: tips that are brought to targets, by Gauss-Newton and as environments of Gymnasium.

    from pennate import control

    arm = control.br2.table(load=6)
    found = control.reach(arm, [169, -69, -214], tolerance=1.0)
    environment = gymnasium.make("pennate/BR2-discrete-v0", load=6)

`reach` needs NumPy alone. `Env`, `VectorEnv` and the registered environments need `pennate[control]`, that is Gymnasium; they are
registered when this module is imported, which `gymnasium.make("pennate.control:pennate/BR2-discrete-v0")` does by itself.
"""

from __future__ import annotations

import importlib.util
from typing import TYPE_CHECKING, Any

from . import br2
from ._arms import Arm, Followed, Solved, Swivelled
from ._hybrid import hybrid
from ._policy import Policy, Rollout, follow
from ._reach import Reach, reach
from ._servo import Servo
from ._table import Table
from ._task import Changes, Levels, Rules

if TYPE_CHECKING:
    from ._envs import Env, VectorEnv

__all__ = [
    "Arm",
    "Changes",
    "Env",
    "Followed",
    "Levels",
    "Policy",
    "Reach",
    "Rollout",
    "Rules",
    "Servo",
    "Solved",
    "Swivelled",
    "Table",
    "VectorEnv",
    "br2",
    "follow",
    "hybrid",
    "reach",
]


def __getattr__(name: str) -> Any:
    """The environments: imported when they are asked for, as Gymnasium is an extra."""
    if name in ("Env", "VectorEnv"):
        try:
            from . import _envs
        except ModuleNotFoundError as error:
            if error.name != "gymnasium":
                raise
            raise ImportError(f"{name} needs Gymnasium: pip install 'pennate[control]'") from error
        return getattr(_envs, name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def _register() -> None:
    """Makes the two decision processes of the BR2 arm known to Gymnasium."""
    from gymnasium.envs.registration import register, registry

    for actions in ("discrete", "continuous"):
        name = f"pennate/BR2-{actions}-v0"
        if name not in registry:
            made = f"{__name__}._made:{actions}"
            register(name, entry_point=made, vector_entry_point=f"{made}_side_by_side")


if importlib.util.find_spec("gymnasium") is not None:
    _register()
