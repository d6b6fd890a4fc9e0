"""Which constraints are in the way, where no design meets all of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ._evaluate import known
from ._study import Constraint, Study, Values
from ._table import Design

# Random designs that are looked at where no design was solved.
CHANCES = 10_000


def unmet(study: Study, designs: Sequence[Design]) -> dict[str, int]:
    """How many of some designs with an answer violate each constraint; the worst first."""
    x, probes = np.array([each.x for each in designs]), np.array([each.probes for each in designs])
    return _counted(study, study.constraints, x, probes)


def unmet_by_chance(study: Study) -> dict[str, int]:
    """The same of random designs, by the constraints that need no solution."""
    low, high = (np.array([getattr(each, end) for each in study.variables]) for end in ("low", "high"))
    x = low + (high - low) * np.random.default_rng(study.seed).random((CHANCES, len(low)))
    return _counted(study, [each for each in study.constraints if each.before], x, None)


def _counted(study: Study, constraints: Sequence[Constraint], x: Values, probes: Values | None) -> dict[str, int]:
    values = known(study, [each.name for each in study.variables], x, probes)
    counts = {}
    for each in constraints:
        value = np.broadcast_to(each.value(values), (len(x),))
        counts[each.name] = int(np.sum(~((value >= each.least) & (value <= each.most))))
    return dict(sorted(counts.items(), key=lambda entry: -entry[1]))
