"""A feedback law with integral action, for an arm that is not what its model says."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from .. import _arguments
from . import _checks
from ._arms import Arm, Array
from ._reach import reach

# By how much of what is left unexplained the offset between model and arm changes at each move. More is faster; with play in the valves,
# less overshoots less where an input begins to act again.
GAIN = 0.8
# The model comes as near to its target as this share of the tolerance.
SHARE = 0.2
# Where so many moves in a row have left more than this share of the error, other inputs are looked for.
PATIENCE, STALLED = 4, 0.9


class Servo:
    """Tip measured and target in, next inputs out, move by move, as targets stand or move.

        servo = Servo(model, inputs)
        for target in targets:
            inputs = servo.step(tip_measured, target)

    The offset d between arm and model is estimated by integration, d += gain (tip - model(inputs) - d), and the next inputs
    bring the model to target - d, those nearest to the present ones. Any bias of the arm that stays, a load, another
    stiffness, play, is so taken out without an error that is left; inputs at their limits wind nothing up, as d is compared with
    what the inputs in use give.
    """

    def __init__(
        self,
        model: Arm,
        inputs: npt.ArrayLike,
        *,
        tolerance: float = 1.0,
        gain: float = GAIN,
        largest: npt.ArrayLike | None = None,
        restarts: int = 8,
    ) -> None:
        """
        Args:
            inputs: (k,), those in use.
            tolerance: Within it nothing is done; in the unit of lengths.
            gain: Between 0 and 1.
            largest: (k,) changes of the inputs that a move does not exceed.
            restarts: From so many other starts the model looks for other inputs where moves no longer help; on the way to
                such the tip may be far off for some moves. 0 keeps to what is nearby, as for a target that moves.
        """
        if not 0.0 < gain <= 1.0:
            raise ValueError(f"gain: more than 0 and at most 1 expected, not {gain}")
        self.model, self.tolerance, self.gain = model, _checks.length("tolerance", tolerance), gain
        self.inputs: Array = np.clip(_checks.rows("inputs", inputs, len(model.names))[0], model.lower, model.upper)
        """(k,), in use since the last step."""
        self.offset: Array | None = None
        """(3,), how far the tip is beside that of the model; `None` before anything is measured."""
        self.restarts, self._before, self._vain = _arguments.whole(restarts, "restarts"), np.inf, 0
        self._away: Array | None = None
        self._largest = _checks.largest(largest, model)

    def step(self, tip: npt.ArrayLike, target: npt.ArrayLike) -> Array:
        """(k,), the next inputs, from the (3,) tip measured with the present ones."""
        measured, wanted = _checks.rows("tip", tip, 3)[0], _checks.rows("target", target, 3)[0]
        beside = measured - self.model.tip(self.inputs[None])[0]
        self.offset = beside if self.offset is None else self.offset + self.gain * (beside - self.offset)
        error = float(np.linalg.norm(measured - wanted))
        if self._away is None and error > self.tolerance:
            self._aim(wanted - self.offset, error)
        self._before = error
        if self._away is not None:
            change = np.clip(self._away - self.inputs, -self._largest, self._largest)
            self.inputs = np.clip(self.inputs + change, self.model.lower, self.model.upper)
            if np.allclose(self.inputs, self._away, rtol=0, atol=1e-9):
                self._away = None
        return self.inputs

    def _aim(self, aim: Array, error: float) -> None:
        """The inputs to go to with the model at (3,): those nearby that it knows, or, where moves no longer help, others farther away."""
        self._vain = self._vain + 1 if error > STALLED * self._before else 0
        elsewhere = self.restarts if self._vain == PATIENCE else 0
        self._vain %= PATIENCE
        enough = SHARE * self.tolerance
        found = reach(self.model, aim, start=self.inputs, tolerance=enough, restarts=elsewhere)
        # A long way is gone to its end; of a short one the next measurement may change the rest.
        near = np.clip(found.inputs, self.inputs - self._largest, self.inputs + self._largest)
        self._away = found.inputs if found.restarts else near
