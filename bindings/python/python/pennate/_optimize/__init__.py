"""Search for designs: `pennate optimize STUDY.toml -o DIR`, and `pennate.optimize` for programs.

NSGA-II of pymoo for several objectives, CMA-ES of cma for one, least squares for targets; every design that was solved is a row
of `designs.csv`, and a search that was stopped goes on where it was by asking for the same designs again.
"""

from __future__ import annotations

from ._read import read
from ._reader import StudyError
from ._run import Outcome, evaluate, optimize
from ._study import Study

__all__ = ["Outcome", "Study", "StudyError", "evaluate", "optimize", "read"]
