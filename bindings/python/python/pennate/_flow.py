"""The load flow: which members of a mechanism transmit what its input puts in, and which of them muscles may replace."""

from __future__ import annotations

import dataclasses
import functools
import json
import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    from ._network import Network

Array = npt.NDArray[np.float64]


@dataclasses.dataclass(frozen=True)
class FlowStep:
    """A network in which muscles took the place of all transmitters up to a level."""

    level: int
    """The level that was replaced last, counted from one: the so many-th member of a path."""
    muscles: tuple[str, ...]
    """Members that are muscles now."""
    network: Network
    """The network, ready to be solved."""
    status: str
    """How its one step ended, as `Solution.status`."""
    stable: bool | None
    """Whether that state is stable; `None` where nobody can say."""
    displacement: Array
    """(outputs, 3), length."""
    rotation: Array
    """(outputs, 3), rotation vector, radians."""
    stress: float
    """The greatest stress of a fibre of any member, force per area; not a number where a section has no shape."""
    required: dict[str, float]
    """Values of the probes that something is required of."""
    met: dict[str, bool]
    """Whether each of these requirements is met."""

    def __repr__(self) -> str:
        return f"<FlowStep level {self.level}: {' '.join(self.muscles)}, {self.status}>"


@dataclasses.dataclass(frozen=True)
class FlowGraph:
    """The mechanism as a graph: joints and the members between them that the ground does not hold."""

    edges: dict[str, tuple[str, str]]
    """Members, each with its joints in the direction of the flow; of a rigid body its reference node stands for all."""
    depth: dict[str, int]
    """Members between the input and a node at least."""
    paths: tuple[tuple[str, ...], ...]
    """Members from an input to the first output on the way."""
    levels: dict[str, int]
    """The place of a member in a path, counted from one; the nearest to the input of several."""


def _number(value: float | None) -> float:
    """What is no number in the file either."""
    return np.nan if value is None else value


class Flow:
    """The load flow of a network, from `Network.flow`; rows of arrays follow `members`, points go from the start of a member.

        flow = pennate.load("gripper.toml").flow()
        flow.roles["T2"], flow.senses["T2"]      # ("transmitter", "compression")
        flow.steps[-1].network.solve()
    """

    def __init__(self, network: Network, text: str, report: str, picture: str, steps: Sequence[Network]) -> None:
        self.network = network
        self.svg = picture
        self._text, self._report, self._networks = text, report, tuple(steps)

    @functools.cached_property
    def _found(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self._text)
        return found

    def _column(self, key: str) -> Array:
        return np.array([each[key] for each in self._found["members"].values()], dtype=np.float64)

    def _points(self, key: str, width: int) -> Array:
        members = self._found["members"].values()
        points = [[point[key] for point in each["points"]] for each in members]
        return np.array(points, dtype=np.float64).reshape(len(members), -1, width)

    @property
    def members(self) -> tuple[str, ...]:
        """Members of the mechanism, in the order of the file."""
        return tuple(self._found["members"])

    @property
    def outputs(self) -> tuple[str, ...]:
        """Nodes that are moved."""
        return tuple(self._found["outputs"])

    @property
    def roles(self) -> dict[str, str]:
        """`"transmitter"`, `"constraint"`, or `"idle"` where the input moves nothing."""
        return {name: str(each["role"]) for name, each in self._found["members"].items()}

    @property
    def senses(self) -> dict[str, str]:
        """`"tension"` or `"compression"` of the transmitters, seen from the input; other members have none."""
        return {name: str(each["sense"]) for name, each in self._found["members"].items() if each["sense"]}

    @functools.cached_property
    def shares(self) -> Array:
        """(members, 3), axial, transverse and moment's share of the transferred energy; they add up to 1, or to 0 where idle."""
        rows = [each["shares"] for each in self._found["members"].values()]
        return np.array([[row["axial"], row["transverse"], row["moment"]] for row in rows]).reshape(len(rows), 3)

    @functools.cached_property
    def axial_load(self) -> Array:
        """(members,), mean axial load under the unit load of the input, positive in tension."""
        return self._column("axial_load")

    @functools.cached_property
    def passed(self) -> Array:
        """(members,), mean transferred energy over that of the input."""
        return self._column("passed")

    @functools.cached_property
    def positions(self) -> Array:
        """(members, points, 3), points inside of the members that are looked at, length."""
        return self._points("position", 3)

    @functools.cached_property
    def loads(self) -> Array:
        """(members, points, 6), transferred force and moment: what a clamp there would receive, with the other sign."""
        return self._points("load", 6)

    @functools.cached_property
    def motions(self) -> Array:
        """(members, points, 6), displacement and rotation (radians) under the unit load of the input."""
        return self._points("motion", 6)

    @functools.cached_property
    def output_motions(self) -> Array:
        """(outputs, 6), displacement and rotation (radians) of the outputs under the unit load of the input."""
        return np.array(list(self._found["outputs"].values()), dtype=np.float64).reshape(len(self.outputs), 6)

    @functools.cached_property
    def graph(self) -> FlowGraph:
        """Joints, members that carry the flow, and paths."""
        members = self._found["members"]
        return FlowGraph(
            {name: (each["from"], each["to"]) for name, each in members.items() if not each["grounded"]},
            dict(self._found["depth"]),
            tuple(tuple(path) for path in self._found["paths"]),
            {name: each["level"] for name, each in members.items() if each["level"] is not None},
        )

    @functools.cached_property
    def steps(self) -> tuple[FlowStep, ...]:
        """The networks with muscles, in the order in which they were solved."""
        return tuple(map(self._step, self._found["steps"], self._networks))

    def _step(self, step: dict[str, Any], network: Network) -> FlowStep:
        moved = list(step["outputs"].values())

        def rows(key: str) -> Array:
            values = [[_number(value) for value in each[key]] for each in moved]
            return np.array(values, dtype=np.float64).reshape(len(moved), 3)

        muscles = tuple(step["muscles"])
        motions = rows("displacement"), rows("rotation_vector")
        stress = _number(step["stress"])
        required = {name: _number(each["value"]) for name, each in step["required"].items()}
        met = {name: bool(each["met"]) for name, each in step["required"].items()}
        return FlowStep(step["level"], muscles, network, step["status"], step["stable"], *motions, stress, required, met)

    @property
    def decisions(self) -> dict[int, str]:
        """What is done at each level: `"replace"`, `"pass_over"`, or `"stop"`, where some members fit and some do not."""
        return {level["level"]: str(level["decision"]) for level in self._found["levels"]}

    @property
    def end(self) -> str:
        """Why there are no more steps, in words."""
        return str(self._found["end"])

    def to_dict(self) -> dict[str, Any]:
        """What `flow.json` holds."""
        found: dict[str, Any] = json.loads(self._text)
        return found

    def write(self, directory: str | os.PathLike[str]) -> None:
        """Writes `flow.json`, `flow.svg` and the networks of the steps, as `pennate flow -o` does."""
        folder = Path(directory)
        folder.mkdir(parents=True, exist_ok=True)
        for network in self._networks:
            (folder / network.name).write_text(network.text, "utf-8")
        (folder / "flow.svg").write_text(self.svg, "utf-8")
        (folder / "flow.json").write_text(self._text, "utf-8")

    def __str__(self) -> str:
        return self._report

    def __repr__(self) -> str:
        roles = list(self.roles.values())
        title = self.network.title or self.network.name
        counts = f"{roles.count('transmitter')} transmitters, {roles.count('constraint')} constraints"
        return f"<Flow {title!r}: {counts}, {len(self.steps)} steps of muscles; {self.end}>"

    def _repr_svg_(self) -> str:
        return self.svg
