"""Trains both policies for a minute each and checks that they learn. Needs `pennate[train]`; not part of the quick tests.

    python learns.py

The marks are far below what whole trainings reach, and far above what a network without training does (1 to 5 %).
"""

from __future__ import annotations

import os
import sys
import time

os.environ.setdefault("JAX_PLATFORMS", "cpu")

from pennate.control import _train  # noqa: E402

# Moves of 64 arms, and the share of validation pairs that the best of six checkpoints has to bring near enough.
MARKS = {"dqn": (600, 0.90), "ddpg": (1200, 0.80)}


def main() -> int:
    """Prints what is reached; 0 where both policies learn."""
    _train.CHECKPOINTS = 6
    good = True
    for method, (steps, mark) in MARKS.items():
        begin = time.process_time()
        policy, share = _train.train(method, steps, seed=0)
        learns = share >= mark
        good &= learns
        print(
            f"{method}: {100 * share:.1f} % after {policy.about['episodes']} episodes, {100 * mark:.0f} % expected, "
            f"{time.process_time() - begin:.0f} s of processor time: {'learns' if learns else 'DOES NOT LEARN'}"
        )
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
