"""The load flow from Python: what the program finds, as arrays, and its networks."""

from __future__ import annotations

import json
import pickle
from pathlib import Path

import numpy as np
import pytest

import pennate

GRIPPER = """
# The wire gripper of the dissertation, one half; coordinates as in the scene of that name.
format = "pennate/1"
title = "gripper"

[nodes]
I = [0, 0]
J1 = [59, 0]
J2 = [29, 30]
J3 = [101, 30]
K = [279.9, 10]
O = [429, 26.7]
G1 = [59, -60]
G2 = [29, 90]
G3 = [101, -10]
G4 = [101, 90]

[materials]
steel = { youngs_modulus = 2e5, poissons_ratio = 0.3 }

[sections]
wire = { circle = { radius = 0.75 }, shear = false }

[muscles]
silicone = { library = "silicone" }

[members]
T1 = { nodes = ["I", "J1"], section = "wire", material = "steel" }
T2 = { nodes = ["J1", "J2"], section = "wire", material = "steel" }
T3 = { nodes = ["J2", "J3"], section = "wire", material = "steel" }
T4 = { nodes = ["J3", "K"], section = "wire", material = "steel" }
jaw2 = { nodes = ["K", "O"], section = "wire", material = "steel" }
C1 = { nodes = ["J1", "G1"], section = "wire", material = "steel" }
C2 = { nodes = ["J2", "G2"], section = "wire", material = "steel" }
C4 = { nodes = ["J3", "G4"], section = "wire", material = "steel" }
jaw1 = { nodes = ["K", "G3"], section = "wire", material = "steel" }

[supports]
G1 = "clamped"
G2 = "clamped"
G3 = "clamped"
G4 = "clamped"

[load_flow]
input = { node = "I", direction = [-1, 0] }
outputs = ["O"]
"""


@pytest.fixture(scope="module")
def flow() -> pennate.Flow:
    return pennate.loads(GRIPPER).flow()


def test_roles_senses_and_steps_are_those_of_the_dissertation(flow: pennate.Flow) -> None:
    transmitters = {name for name, role in flow.roles.items() if role == "transmitter"}
    assert transmitters == {"T1", "T2", "T3", "T4"}
    assert flow.senses == {"T1": "tension", "T2": "compression", "T3": "tension", "T4": "tension"}
    assert [step.muscles for step in flow.steps] == [("T1",), ("T1", "T3"), ("T1", "T3", "T4")]
    assert flow.decisions == {1: "replace", 2: "pass_over", 3: "replace", 4: "replace", 5: "pass_over"}
    assert flow.graph.paths == (("T1", "T2", "T3", "T4", "jaw2"),)
    assert flow.graph.edges["T3"] == ("J2", "J3") and "C1" not in flow.graph.edges
    assert flow.graph.depth["O"] == 5 and flow.graph.levels["T4"] == 4


def test_arrays_hold_energy_and_shares(flow: pennate.Flow) -> None:
    energy = (flow.loads * flow.motions).sum(2)
    assert energy.shape == (9, 7) and flow.positions.shape == (9, 7, 3) and (energy > -1e-12).all()
    np.testing.assert_allclose(flow.shares.sum(1), 1.0)
    # Along its axis a transmitter passes on what its axial share says.
    row = flow.members.index("T4")
    ends = flow.network.positions[[flow.network.nodes.index(node) for node in flow.network.ends["T4"]]]
    axis = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    axial = (flow.loads[row, :, :3] @ axis) * (flow.motions[row, :, :3] @ axis)
    assert axial.sum() / energy[row].sum() == pytest.approx(flow.shares[row, 0], rel=1e-9)


def test_networks_of_the_steps_move_as_they_are_said_to(flow: pennate.Flow) -> None:
    last = flow.steps[-1]
    assert last.network.muscles == ("T1", "T3", "T4") and last.status == "converged"
    solution = last.network.solve()
    np.testing.assert_allclose([solution["O_ux"][0], solution["O_uy"][0]], last.displacement[0, :2], rtol=1e-9)


def test_a_flow_is_written_pickled_and_drawn(flow: pennate.Flow, tmp_path: Path) -> None:
    flow.write(tmp_path)
    assert json.loads((tmp_path / "flow.json").read_text()) == flow.to_dict()
    assert {path.name for path in tmp_path.iterdir()} == {"flow.json", "flow.svg", "level_1.toml", "level_3.toml", "level_4.toml"}
    assert flow.svg.startswith("<svg") and ">jaw2<" in flow.svg.replace("\n", "")
    again = pickle.loads(pickle.dumps(flow))
    assert again.senses == flow.senses and repr(again) == repr(flow)
    assert "compression" in str(flow)


def test_a_flow_ends_with_the_network_that_meets_its_requirements(flow: pennate.Flow) -> None:
    stress = [step.stress for step in flow.steps]
    assert all(np.isfinite(stress)) and flow.steps[0].required == {}
    closed = [abs(step.displacement[0, 1]) for step in flow.steps]
    least = (closed[0] + closed[1]) / 2
    text = f"requirements = {{ closed = {{ least = {least} }} }}\n[probes]\nclosed = {{ node = \"O\", displacement = [0, -1] }}"
    signed = text if flow.steps[0].displacement[0, 1] < 0 else text.replace("[0, -1]", "[0, 1]")
    met = pennate.loads(GRIPPER + signed).flow()
    assert [step.met["closed"] for step in met.steps] == [False, True] and "all requirements are met" in met.end
    assert met.steps[1].required["closed"] == pytest.approx(closed[1]) and "closed" in str(met)
    missed = pennate.loads(GRIPPER + signed.replace(f"least = {least}", "least = 1000")).flow()
    assert len(missed.steps) == 3 and "at least 1000 is required" in missed.end


def test_a_network_without_a_load_flow_is_refused() -> None:
    with pytest.raises(pennate.NetworkError, match=r"add \[load_flow\]"):
        pennate.loads(GRIPPER.partition("[load_flow]")[0]).flow()
