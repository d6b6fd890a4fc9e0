"""One equilibrium that is followed as parameters move: numbers at once, the shape as soon as it is known.

The state at the end of a step is kept by `Problem.live`, whose probes are those of the file and the places and turns of all
nodes. What lies between the nodes is solved for: from the unloaded network through the steps of the file, and, where the state
was reached by a snap, through the state after that snap. Only a shape whose nodes are where the live state has them is shown as
one that was computed; else the last one is carried along, which the page says.
"""

from __future__ import annotations

import dataclasses
import math
import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from .._errors import Error, NetworkError, SolveError
from .._look import carry
from .._look.shapes import Array, Integers
from .._network import Network
from .._problem import Live, Problem
from .._solution import Solution

# Of the mesh of shapes, relative: pictures need no more.
DRAFT = 1e-4
# Nodes of a computed shape are where the live state has them within this part of the size: other equilibria are further away.
SAME = 2e-3
# Names of the probes that are added; no file has such names.
OWN = "\N{ZERO WIDTH SPACE}node"
# Keys of steps that say where loads go, and so may be said again in a step after them.
TARGETS = (
    "pressure", "actuation", "force", "moment", "follower_force", "follower_moment", "distributed", "gravity",
    "displacement", "rotation",
)  # fmt: skip


@dataclasses.dataclass(frozen=True)
class Probe:
    """A number of the state with its error, not a number where there is no estimate."""

    value: float
    error: float
    unit: str


@dataclasses.dataclass(frozen=True)
class Now:
    """The present state, without its shape."""

    values: dict[str, float]
    probes: dict[str, Probe]
    stable: bool | None
    # Why the state is not where it was to go, and whether that is because it ends or loses its stability there.
    failure: str = ""
    lost: bool = False
    # (nodes, 3) and (nodes, 3, 3); none where they are not known apart from a shape.
    displacement: Array | None = None
    turn: Array | None = None


class Follow:
    """Follows the state at the end of a step."""

    def __init__(self, network: Network, parameters: tuple[str, ...], step: int | None = None, accuracy: float = 1e-6):
        self.network, self.parameters = until(network, step), parameters
        self.plane = network.dimension == "plane"
        self.joined: Integers = np.array(
            [[network.nodes.index(end) for end in network.ends[name]] for name in network.members], dtype=np.int64
        ).reshape(-1, 2)
        self.accuracy = accuracy
        self.relative = looking_back(self.user_probes(self.network))
        # The values at which it last snapped; loads come from there.
        self.anchor: dict[str, float] | None = None
        self.drawing: dict[str, Any] | None = None
        self.at: Array | None = None
        self.unloaded: dict[str, Any] | None = None
        self.solution: Solution | None = None
        self.whole = False
        self.live: Live | None = None
        self.refused: str = ""
        self._start(self.network)

    def _start(self, network: Network) -> None:
        """Begins at the values of a network; where it does not reach the end of its steps, every state is solved anew."""
        probes = {**own_probes(network), **self.user_probes(network)}
        wide = network.edit(probes=probes)
        self.live, self.refused = None, ""
        self.problem = None
        try:
            self.problem = wide.problem(parameters=self.parameters, accuracy=self.accuracy)
            live = self.problem.live()
            assert isinstance(live, Live)
            self.live = live
            self._sort(self.problem)
        except NetworkError as error:
            # A parameter that sets a count: networks are read anew.
            self.refused = str(error)
        except SolveError as error:
            self.refused = str(error)

    def _sort(self, problem: Problem) -> None:
        """Where the probes of the file are among all, and those of places and turns of nodes."""
        own = np.array([OWN in name for name in problem.probes], dtype=bool)
        self.own, units = np.flatnonzero(own), problem.network.probes
        errors = problem.error.tolist()
        self.named = [
            (name, place, errors[place], units.get(name, ""))
            for place, name in enumerate(problem.probes)
            if not own[place]
        ]

    @staticmethod
    def user_probes(network: Network) -> dict[str, Any]:
        """The probes of the file."""
        found: dict[str, Any] = network.to_dict().get("probes", {})
        return found

    def go(self, values: Mapping[str, float]) -> Now:
        """Goes to values of the parameters, or as far as the way leads."""
        if self.live is None:
            return self._anew(values)
        failure, lost = "", False
        try:
            self.live.set(**values).solve()
        except SolveError as error:
            failure, lost = str(error), "lost" in str(error)
        except NetworkError as error:
            failure = str(error)
        return self._now(failure, lost)

    def _now(self, failure: str, lost: bool) -> Now:
        live = self.live
        assert live is not None and self.problem is not None
        probes = {name: Probe(float(live.values[place]), error, unit) for name, place, error, unit in self.named}
        displacement, vectors = self._motion(live.values)
        if self.relative:
            probes |= self._from_the_beginning(live.present, displacement)
        return Now(live.present, probes, live.stable, failure, lost, displacement, carry.rotations(vectors))

    def _motion(self, values: Array) -> tuple[Array, Array]:
        """(nodes, 3) displacements and rotation vectors in radians, of the values of all probes."""
        count = len(self.network.nodes)
        motion = values[self.own].reshape(count, -1)
        displacement, vectors = np.zeros((count, 3)), np.zeros((count, 3))
        if self.plane:
            displacement[:, :2], vectors[:, 2] = motion[:, :2], np.deg2rad(motion[:, 2])
        else:
            displacement, vectors = motion[:, :3], np.deg2rad(motion[:, 3:])
        return displacement, vectors

    def _from_the_beginning(
        self, values: dict[str, float], displacement: Array
    ) -> dict[str, Probe]:
        """Probes that look back at earlier steps: a live state knows these at its own beginning alone.

        They are those of the steps of the file at the present values, where these lead to the present state, and not numbers
        where they do not.
        """
        assert self.problem is not None
        y = self.problem(np.array([values[name] for name in self.problem.parameters]))
        there = bool(np.abs(self._motion(y)[0] - displacement).max(initial=0.0) <= SAME * self.size)
        return {
            name: Probe(float(y[place]) if there else math.nan, error, unit)
            for name, place, error, unit in self.named
            if name in self.relative
        }

    def _anew(self, values: Mapping[str, float]) -> Now:
        """Solves from the unloaded network, whose state at the end is shown, or the last one before."""
        try:
            solution = self.network.set(**values).solve(accuracy=self.accuracy)
        except Error as error:
            return Now(dict(values), {}, None, str(error))
        place = last_step(solution)
        if place is None:
            return Now(dict(values), {}, None, "\n\n".join(map(str, solution.failures)))
        self._keep(solution)
        units = solution.network.probes
        probes = {
            name: Probe(float(solution[name][place]), float(solution.error[name][place]), units.get(name, ""))
            for name in solution.probes
        }
        lost = solution.status in ("limit_point", "bifurcation")
        return Now(dict(values), probes, solution.stable[place], "\n\n".join(map(str, solution.failures)), lost)

    def _keep(self, solution: Solution) -> None:
        self.solution = solution
        self.drawing, self.unloaded = solution.drawing(), solution.drawing("unloaded")
        place = last_step(solution)
        assert place is not None
        self.at = carry.rotations(solution.rotation[place])
        self.whole = True

    def sketch(self, now: Now) -> dict[str, Any] | None:
        """The shape at once: the last one, carried to where the nodes are."""
        if self.drawing is None or self.at is None or now.displacement is None or now.turn is None:
            return self.drawing
        turn = now.turn @ np.swapaxes(self.at, 1, 2)
        return carry.carried(self.drawing, self.joined, now.displacement, turn)

    def shape(self, now: Now, is_stale: Callable[[], bool] = lambda: False) -> bool | None:
        """Solves for the shape of the present state, which `sketch` gives from then on; whether it is one that was computed.

        Nothing, and nothing is changed, where nobody waits for it any longer.
        """
        if self.live is None or now.displacement is None:
            return self.drawing is not None
        for network in self._ways(now.values):
            try:
                solution = network.solve(accuracy=DRAFT, progress=lambda *_: not is_stale())
            except Error:
                continue
            if is_stale():
                return None
            if solution.status != "converged" or not self._same(solution, now.displacement):
                continue
            self._keep(solution)
            return True
        # What is carried from now on is what was carried so far.
        sketch = self.sketch(now)
        if sketch is not None:
            self.drawing, self.at = sketch, now.turn
        self.whole = False
        return False

    def _same(self, solution: Solution, displacement: Array) -> bool:
        place = len(solution.steps) - 1
        return bool(np.abs(solution.displacement[place] - displacement).max(initial=0.0) <= SAME * self.size)

    @property
    def size(self) -> float:
        """Of the unloaded network."""
        return float(np.linalg.norm(np.ptp(self.network.positions, axis=0))) or 1.0

    def _ways(self, values: Mapping[str, float]) -> list[Network]:
        """Networks whose last step may end in the present state."""
        plain = self.network.set(**values)
        if self.anchor is None:
            return [plain]
        return [snapping(self.network, self.anchor).set(**values), plain]

    def snap(self, values: Mapping[str, float]) -> str:
        """Lets it snap: begins again where the steps lead at these values if they may jump. Says why not, where it does not."""
        tree = self.network.to_dict()
        steps = [{**step, "method": "jump"} for step in tree.get("steps", [])]
        before = self.live, self.problem, self.refused
        try:
            jumping = self.network.set(**values).edit(steps=steps)
        except Error as error:
            return str(error)
        self._start(jumping)
        if self.live is None:
            why = self.refused
            self.live, self.problem, self.refused = before
            return why or "there is no stable equilibrium near by"
        self.anchor = dict(values)
        return ""


def until(network: Network, step: int | None) -> Network:
    """The network with its steps up to one of them, and the probes that have a meaning there."""
    tree = network.to_dict()
    steps = tree.get("steps", [])
    if step is None or step >= len(steps) - 1:
        return network
    gone = [str(each.get("name", "")) for each in steps[step + 1 :]]
    probes = dict(tree.get("probes", {}))
    while True:
        bad = [
            name
            for name, probe in probes.items()
            if isinstance(probe, str)
            and (
                any(f"@{each}" in probe for each in gone if each) or mentions(probe, set(tree["probes"]) - set(probes))
            )
        ]
        if not bad:
            break
        for name in bad:
            del probes[name]
    dropped = {name: probes.get(name) for name in tree.get("probes", {})}
    return network.edit(steps=steps[: step + 1], probes=dropped)


def looking_back(probes: Mapping[str, Any]) -> set[str]:
    """The probes that take a value after an earlier step, themselves or by another probe."""
    texts = {name: probe for name, probe in probes.items() if isinstance(probe, str)}
    found = {name for name, text in texts.items() if "@" in text}
    while more := {name for name, text in texts.items() if mentions(text, found)} - found:
        found |= more
    return found


def mentions(text: str, names: set[str]) -> bool:
    """Whether an expression uses one of some names."""
    return any(re.search(rf"(?<![\w@]){re.escape(name)}(?!\w)", text) for name in names)


def own_probes(network: Network) -> dict[str, Any]:
    """Probes of the places and turns of all nodes, in their order."""
    plane = network.dimension == "plane"
    translations, turns = (("ux", "uy"), ("rz",)) if plane else (("ux", "uy", "uz"), ("rx", "ry", "rz"))
    found: dict[str, Any] = {}
    for index, node in enumerate(network.nodes):
        found |= {f"{OWN} {index} {key}": {"node": node, "displacement": key} for key in translations}
        found |= {f"{OWN} {index} {key}": {"node": node, "rotation": key} for key in turns}
    return found


def last_step(solution: Solution) -> int | None:
    """The last step of which something was reached."""
    counts: list[int] = solution._facts["increments"]
    reached = [index for index, count in enumerate(counts) if count]
    return reached[-1] if reached else None


def snapping(network: Network, anchor: Mapping[str, float]) -> Network:
    """The steps of a network as they were at the values of an anchor, with snaps, and one more from there to the present."""
    tree = network.to_dict()
    steps: list[dict[str, Any]] = tree.get("steps", [])
    known = network.parameters
    names = [name for name in anchor if name in known]
    frozen = {f"{name}__then": network._stated(name, anchor[name]) for name in names}

    def then(value: Any) -> Any:
        if isinstance(value, str) and value.lstrip().startswith("="):
            for name in names:
                value = re.sub(rf"(?<!\w){re.escape(name)}(?!\w)", f"{name}__then", value)
            return value
        if isinstance(value, Mapping):
            return {key: then(entry) for key, entry in value.items()}
        if isinstance(value, list):
            return [then(entry) for entry in value]
        return value

    again: dict[str, Any] = {}
    for step in steps:
        for key in TARGETS:
            if key in step:
                table = step[key]
                again[key] = {**again.get(key, {}), **table} if isinstance(table, Mapping) else table
    first = [{**then(step), "method": "jump"} for step in steps]
    return network.edit(parameters=frozen, steps=[*first, {"name": free_step(steps), **again}])


def free_step(steps: list[dict[str, Any]]) -> str:
    """A name of a step that there is not yet."""
    name = "to the present"
    while any(step.get("name") == name for step in steps):
        name += " "
    return name
