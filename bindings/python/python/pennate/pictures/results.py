"""What pictures are drawn from: a solution, or a folder with `results.json` and the `.vtu` files that belong to it."""

from __future__ import annotations

import dataclasses
import functools
import json
import os
import pathlib
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

# Without a display VTK tries X first and complains; this asks for off-screen rendering at once.
if not os.environ.get("DISPLAY"):
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")

import numpy as np
import numpy.typing as npt
import pyvista

if TYPE_CHECKING:
    from .._network import Network
    from .._solution import Solution

Array = npt.NDArray[np.float64]
Integers = npt.NDArray[np.int64]

RESULTS = "results.json"
WRITES = "'pennate solve FILE -o DIR --vtk' writes results and pictures into DIR"

# Units of length and force in the two unit systems of a network file.
UNITS = {"mm-N-MPa": ("mm", "N"), "m-N-Pa": ("m", "N")}


class PictureError(ValueError):
    """Something that the user can mend; the text says what, where, and how."""


@dataclasses.dataclass(frozen=True)
class Step:
    """What `results.json` says of a step, as far as pictures need it."""

    name: str
    status: str
    # Decimal digits that rounding leaves of the largest displacement, rotation, force and moment; None: rounding alone.
    digits: dict[str, float | None]
    # The largest force and moment at the ends of members, and the largest displacement of a node.
    largest: dict[str, float]


@dataclasses.dataclass(frozen=True)
class State:
    """The state at a fraction of a step; step None is the unloaded network."""

    step: int | None
    fraction: float
    load: Callable[[], Shape]


@dataclasses.dataclass(frozen=True)
class Shape:
    """The arrays of one state. The first points are the nodes of the network in their order."""

    points: Array
    cells: Integers
    point_data: dict[str, npt.NDArray[Any]]
    cell_data: dict[str, npt.NDArray[Any]]


@dataclasses.dataclass(frozen=True)
class Run:
    """A solved network."""

    title: str
    length_unit: str
    force_unit: str
    # The unit of pressures, that of the first muscle; empty where there are none.
    pressure_unit: str
    plane: bool
    # Names of nodes and members in the order of the file, which is that of the points and of `member_id`.
    nodes: tuple[str, ...]
    members: tuple[str, ...]
    steps: tuple[Step, ...]
    states: tuple[State, ...]
    # Estimated error of the mesh relative to the largest values; zero where it is not known.
    mesh_error: float

    def state_after(self, step: int | None) -> State:
        """The last state of a step, or the unloaded one for None."""
        found = [state for state in self.states if state.step == step]
        if not found:
            what = "the unloaded state" if step is None else f"step '{self.steps[step].name}'"
            raise PictureError(f"there is no picture of {what}: it was not reached")
        return found[-1]

    def step_named(self, name: str) -> int:
        """The index of a step."""
        for index, step in enumerate(self.steps):
            if step.name == name:
                return index
        known = ", ".join(f"'{step.name}'" for step in self.steps)
        raise PictureError(f"there is no step '{name}'; there are 'unloaded', {known}")


def find_pvd(source: pathlib.Path) -> pathlib.Path:
    """The `.pvd` file that `results.json` of a folder lists, or the one that was named, if it is that one.

    Others may be of another run: of another network, or of one that was solved with other parameters.
    """
    folder = source.parent if source.is_file() else source
    listed = [str(name) for name in contents(folder).get("pictures", []) if str(name).endswith(".pvd")]
    if not listed:
        raise PictureError(f"{folder / RESULTS} lists no pictures: the network was solved without them; {WRITES}")
    pvd = folder / listed[0]
    if source.is_file() and source.name != pvd.name:
        raise PictureError(f"{source} is of another run: {folder / RESULTS} belongs to {pvd.name}")
    if not pvd.is_file():
        raise PictureError(f"{pvd} is missing, though {folder / RESULTS} lists it; {WRITES}")
    return pvd


def contents(folder: pathlib.Path) -> dict[str, Any]:
    """What `results.json` of a folder holds."""
    place = folder / RESULTS
    if not place.is_file():
        raise PictureError(f"{place} is missing; {WRITES}")
    try:
        found = json.loads(place.read_text(encoding="utf-8"))
    except ValueError as error:
        raise PictureError(f"{place} holds no results: {error}") from None
    if not (isinstance(found, dict) and found.get("steps")):
        raise PictureError(f"{place} holds no results of 'pennate solve'")
    return found


def list_files(pvd: pathlib.Path) -> list[pathlib.Path]:
    """The files that a `.pvd` names, whose times must increase."""
    reader: Any = pyvista.get_reader(str(pvd))  # type: ignore[no-untyped-call]
    if not reader.datasets:
        raise PictureError(f"{pvd}: no data sets")
    times = list(reader.time_values)
    if any(later <= sooner for sooner, later in zip(times, times[1:])):
        raise PictureError(f"{pvd}: times do not increase: {times}")
    files = [pvd.parent / data.path for data in reader.datasets]
    missing = [file.name for file in files if not file.is_file()]
    if missing:
        raise PictureError(f"{pvd} lists {missing[0]}, which is missing; {WRITES}")
    return files


def read(source: pathlib.Path) -> Run:
    """Reads a folder of results, or the folder that a `.pvd` file lies in."""
    pvd = find_pvd(source)
    states = tuple(state_of(file) for file in list_files(pvd))
    return run_of(contents(pvd.parent), states)


def of(solution: Solution) -> Run:
    """A solution, with the shapes of all its increments."""
    states = []
    for step in (None, *range(len(solution.steps))):
        fractions = [0.0] if step is None else solution.fractions(step)
        for increment, fraction in enumerate(fractions):
            states.append(State(step, float(fraction), functools.partial(shape_of, solution, step, increment)))
    return run_of(solution.to_dict(), tuple(states))


def of_network(network: Network) -> Run:
    """A network as it is built, which nobody has solved."""
    length, force = UNITS[network.units]
    return Run(
        title=network.title,
        length_unit=length,
        force_unit=force,
        pressure_unit=network.pressure_unit,
        plane=network.dimension == "plane",
        nodes=network.nodes,
        members=network.members,
        steps=(),
        states=(State(None, 0.0, functools.partial(built, network)),),
        mesh_error=0.0,
    )


def run_of(results: dict[str, Any], states: tuple[State, ...]) -> Run:
    """A run from what `results.json` holds."""
    length, force = UNITS[results["units"]]
    first = results["steps"][0]
    return Run(
        title=results["title"],
        length_unit=length,
        force_unit=force,
        pressure_unit=results.get("pressure_unit", ""),
        plane=results["dimension"] == "plane",
        nodes=tuple(first["nodes"]),
        members=tuple(first["members"]),
        steps=tuple(step_of(step) for step in results["steps"]),
        states=states,
        mesh_error=results["accuracy"]["reached"] or 0.0,
    )


def step_of(step: dict[str, Any]) -> Step:
    """A step of `results.json`."""
    ends = [member[end] for member in step["members"].values() for end in ("start", "end")]
    supports = step["nodes"].values()

    def largest(vectors: list[list[float]]) -> float:
        return max((float(np.linalg.norm(vector)) for vector in vectors), default=0.0)

    return Step(
        name=step["name"],
        status=step["status"],
        digits=step["digits"] or {},
        largest={
            "displacement": largest([node["displacement"] for node in supports]),
            "force": largest([end["force"] for end in ends] + [node["reaction_force"] for node in supports]),
            "moment": largest([end["moment"] for end in ends] + [node["reaction_moment"] for node in supports]),
        },
    )


def state_of(file: pathlib.Path) -> State:
    """Which step and fraction a `.vtu` file belongs to, which its field data say."""
    fields = pyvista.read(str(file)).field_data
    if "step" not in fields or "fraction" not in fields:
        raise PictureError(
            f"{file}: written by a version of pennate that did not say which step it is of; solve the network again"
        )
    number = int(fields["step"][0])
    load = functools.partial(load_file, file)
    return State(step=number - 1 if number else None, fraction=float(fields["fraction"][0]), load=load)


def load_file(file: pathlib.Path) -> Shape:
    """The arrays of a `.vtu` file."""
    mesh = pyvista.read(str(file))
    return Shape(
        points=np.asarray(mesh.points, dtype=np.float64),
        cells=np.asarray(mesh.cells, dtype=np.int64).reshape(-1, 3)[:, 1:],
        point_data={name: np.asarray(mesh.point_data[name]) for name in mesh.point_data},
        cell_data={name: np.asarray(mesh.cell_data[name]) for name in mesh.cell_data},
    )


def built(network: Network) -> Shape:
    """The arrays of a network as it is built."""
    drawing = network._read.drawing()
    if drawing is None:
        raise PictureError("there is nothing to draw")
    return Shape(drawing["points"], drawing["lines"], drawing["point_data"], drawing["cell_data"])


def shape_of(solution: Solution, step: int | None, increment: int) -> Shape:
    """The arrays of an increment of a solution."""
    drawing = solution.drawing("unloaded" if step is None else step, increment)
    return Shape(drawing["points"], drawing["lines"], drawing["point_data"], drawing["cell_data"])
