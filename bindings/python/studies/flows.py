"""The load flow of the mechanisms of the dissertation, and of some more: roles, steps, and what it takes."""

from __future__ import annotations

import statistics
import time

from common import ROOT

import pennate

CASES = ROOT / "analysis" / "tests" / "flow" / "cases"
TIMES = 15


def flow(wanted: bool) -> None:
    """Transmitters with their senses and axial shares, what muscles replace, and the time of a flow with all its steps."""
    for path in sorted(CASES.glob("*.toml")):
        network = pennate.load(path)
        found = network.flow()
        shares = dict(zip(found.members, found.shares[:, 0]))
        roles = [f"{name}{'+' if sense == 'tension' else '-'} {shares[name]:.3f}" for name, sense in found.senses.items()]
        others = max((shares[name] for name, role in found.roles.items() if role == "constraint"), default=0.0)
        steps = "; ".join(" ".join(step.muscles) for step in found.steps)
        print(f"{path.stem}: {', '.join(roles) or 'no transmitters'}; others at most {others:.3f}")
        print(f"  muscles: {steps or 'none'}; {found.end}; {median(network):.1f} ms")


def median(network: pennate.Network) -> float:
    """Milliseconds of CPU of a flow, by the median."""
    times = []
    for _ in range(TIMES):
        begin = time.process_time()
        network.flow()
        times.append(time.process_time() - begin)
    return 1e3 * statistics.median(times)
