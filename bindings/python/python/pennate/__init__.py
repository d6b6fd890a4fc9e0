"""Networks of soft pneumatic muscles and compliant parts: how they deform, what they hold, whether they are stable.

    network = pennate.load("dyad.toml", beta=30)
    solution = network.solve()
    solution["stroke"], solution.error["stroke"]
"""

from __future__ import annotations

import logging

from ._core import __version__
from ._errors import (
    Error,
    Finding,
    InternalError,
    Interrupted,
    MechanismError,
    Motion,
    NetworkError,
    SolveError,
    WorkerError,
)
from ._flow import Flow, FlowGraph, FlowStep
from ._network import Check, Network, load, loads, scene, scenes, schema
from ._optimize import Outcome, Study, StudyError, optimize
from ._optimize import read as read_study
from ._problem import Live, Lives, Problem, Reason
from ._solution import History, Member, Node, Solution, Step
from ._spectra import Buckling, Modes
from ._sweep import sweep

__all__ = [
    "Buckling",
    "Check",
    "Error",
    "Finding",
    "Flow",
    "FlowGraph",
    "FlowStep",
    "History",
    "InternalError",
    "Interrupted",
    "Live",
    "Lives",
    "MechanismError",
    "Member",
    "Modes",
    "Motion",
    "Network",
    "NetworkError",
    "Node",
    "Outcome",
    "Problem",
    "Reason",
    "Solution",
    "SolveError",
    "Step",
    "Study",
    "StudyError",
    "WorkerError",
    "__version__",
    "load",
    "loads",
    "optimize",
    "read_study",
    "scene",
    "scenes",
    "schema",
    "sweep",
]

# Nothing is printed unless asked: logging would print warnings by itself.
logging.getLogger("pennate").addHandler(logging.NullHandler())
