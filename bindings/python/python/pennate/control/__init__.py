"""Control: tips that are brought to targets.

    from pennate import control

    arm = control.br2.table(load=6)
    found = control.reach(arm, [180, -90, -170], tolerance=1.0)
"""

from __future__ import annotations

from . import br2
from ._arms import Arm, Followed, Solved, Swivelled
from ._reach import Reach, reach
from ._table import Table
from ._task import Changes, Levels, Rules

__all__ = [
    "Arm",
    "Changes",
    "Followed",
    "Levels",
    "Reach",
    "Rules",
    "Solved",
    "Swivelled",
    "Table",
    "br2",
    "reach",
]
