"""The report: one page that is complete in itself and says what the solver says."""

from __future__ import annotations

import base64
import html
import json
import pathlib
import re
from typing import Any

import numpy as np
import pytest

import pennate
from pennate._look import carry, fields, finer, shapes
from pennate._report import page
from pennate.__main__ import main


# A shallow arch whose path comes back below no load at all: where a step ends depends on how many increments it counts.
ARCH = """\
format = "pennate/1"
dimension = "plane"
nodes = { A = [0, 0], C = [100, 10], B = [200, 0] }
materials.rubber = { youngs_modulus = 2000, poissons_ratio = 0.3 }
sections.strip = { rectangle = { width = 10, height = 2 } }
members.left = { nodes = ["A", "C"], section = "strip", material = "rubber" }
members.right = { nodes = ["C", "B"], section = "strip", material = "rubber" }
supports = { A = "pinned", B = "pinned" }
probes.down = { node = "C", displacement = "uy" }
[[steps]]
name = "push"
force = { C = [0, -60] }
method = "arc_length"
branch = "primary"
stop = { increments = 30 }
"""


def data_of(text: str) -> dict[str, Any]:
    """What the picture of a page is drawn from."""
    found = re.search(r'<script type="application/json" id="data">(.*?)</script>', text, re.S)
    assert found is not None
    content: dict[str, Any] = json.loads(found[1])
    return content


def array(content: dict[str, Any], place: list[int], kind: type) -> np.ndarray[Any, Any]:
    """One array of the packed block."""
    block = base64.b64decode(content["blob"])
    return np.frombuffer(block, kind, count=place[1], offset=place[0])


def test_the_page_asks_for_nothing_outside_of_itself(solution: pennate.Solution) -> None:
    text = page(solution)
    assert "default-src 'none'" in text
    without_data = re.sub(r'<script type="application/json".*?</script>', "", text, flags=re.S)
    assert not re.search(r"https?://|\bsrc=|\bhref=|@import|url\(|fetch\(|XMLHttpRequest|import\(", without_data)


def test_the_table_has_the_numbers_of_the_solver_with_their_errors(solution: pennate.Solution) -> None:
    text = html.unescape(page(solution))
    value, error = solution["stroke@inflate"], float(solution.error["stroke"][0])
    cell = fields.with_error(value, error, "mm")
    assert f"<td>{cell}</td>" in text
    shown, behind = cell.split(" ± ")
    assert float(shown.replace("\N{MINUS SIGN}", "-")) == pytest.approx(value, abs=error)
    assert behind.endswith("mm")


def test_the_picture_has_the_places_of_the_solver(solution: pennate.Solution) -> None:
    content = data_of(page(solution))
    state = content["states"][-1]
    packed = array(content, state["places"], np.int16).reshape(-1, 3) * content["reach"] / 32767
    last = shapes.places(solution.drawing())
    # The way is solved with more increments; the mesh and its nodes are the same.
    nodes = len(solution.nodes)
    apart = packed[:nodes] - packed[0], last[:nodes] - last[0]
    np.testing.assert_allclose(apart[0], apart[1], atol=content["reach"] / 10000)
    assert state["label"] == "push back, 100 %"
    # More states than the solver's own increments, which would jump from one end to the other.
    assert len(content["states"]) > 20


def test_the_way_ends_where_the_solution_does() -> None:
    network = pennate.loads(ARCH)
    found = network.solve()
    # A step that counts its increments would stop elsewhere with finer ones.
    way = finer.finer(found, 60, 1e-4)
    assert way["down"] == pytest.approx(found["down"], rel=1e-3)
    assert data_of(page(found))["states"][-1]["label"] == f"push, {fields.number(100 * found.fraction[0])} %"
    # What stops at a place of its path gets there with any increments.
    lower = network.edit(
        steps={"push": {"stop": {"increments": None, "node": "C", "displacement": "uy", "at": -12}}}
    ).solve()
    fine = finer.finer(lower, 60, 1e-4)
    assert len(fine.fractions(0)) > len(lower.fractions(0)) and fine["down"] == pytest.approx(-12.0)


def test_states_are_compared_by_places_and_not_by_how_their_steps_ended() -> None:
    network = pennate.loads(ARCH)
    found, coarser = network.solve(), network.solve(accuracy=1e-3)
    other = network.edit(steps={"push": {"stop": {"increments": 20}}}).solve()
    assert other.status == found.status
    assert finer.first_elsewhere(found, other) == 0
    assert finer.first_elsewhere(found, coarser) is None


def test_increments_that_are_an_expression_are_no_fewer_on_the_way() -> None:
    network = pennate.loads(ARCH).edit(steps={"push": {"method": "newton", "stop": None, "branch": None}})
    asked = network.edit(steps={"push": {"force": {"C": [0, -1]}, "increments": "= 4 * 10"}}).solve()
    assert len(finer.finer(asked, 12, 1e-4).fractions(0)) >= 40


def test_a_step_that_fails_is_said_in_words(snap: pennate.Network) -> None:
    found = snap.solve()
    text = html.unescape(page(found))
    assert "bifurcation" in text and "The last state before that is shown." in text
    assert "step 'press' ends at a bifurcation" in text
    assert 'method = "jump"' in text


def test_jumps_are_said_with_their_energy(snap: pennate.Network) -> None:
    found = snap.edit(steps={"press": {"method": "jump"}}).solve()
    text = html.unescape(page(found))
    assert re.search(r"it snaps to the next stable equilibrium: node C moves by 16\.\d+ mm, 53\d\.\d+ N mm", text)


def test_names_cannot_end_the_page(snap: pennate.Network) -> None:
    wicked = snap.edit(title="</script><b>x", steps=None, probes={"</script>": {"node": "C", "displacement": "uy"}})
    text = page(wicked.solve())
    assert text.count("</script>") == 2 and "<b>x" not in text


def test_one_command_goes_from_a_file_to_a_page(tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]) -> None:
    network = tmp_path / "dyad.toml"
    network.write_text(pennate.scene("dyad").text)
    assert main(["report", str(network), "--set", "pressure=20", "-o", str(tmp_path / "dyad.html")]) == 0
    assert (tmp_path / "dyad.html").stat().st_size < 300_000
    capsys.readouterr()
    for output in (network, tmp_path / "page.txt"):
        assert main(["report", str(network), "-o", str(output)]) == 2
        assert "a page is an .html" in capsys.readouterr().err
    named = tmp_path / "network.html"
    named.write_text(network.read_text())
    assert main(["report", str(named), "-o", str(tmp_path / ".." / tmp_path.name / "network.html")]) == 2
    assert "is the network file itself, which is not written over" in capsys.readouterr().err
    assert named.read_text() == network.read_text() == pennate.scene("dyad").text
    with pytest.raises(ValueError, match="a page is an .html"):
        pennate.load(network).solve().report(tmp_path / "dyad.toml")
    network.write_text(network.read_text().replace("clamped", "clampd"))
    assert main(["report", str(network), "-o", str(tmp_path / "no.html")]) == 2
    assert "dyad.toml:" in capsys.readouterr().err and not (tmp_path / "no.html").exists()


# A beam with a guide at its end, which a step moves or turns.
GUIDED = """\
format = "pennate/1"
nodes = { A = [0, 0], B = [100, 0] }
sections.rod = { circle = { radius = 2 } }
materials.rubber = { youngs_modulus = 2000, poissons_ratio = 0.3 }
members.beam = { nodes = ["A", "B"], section = "rod", material = "rubber" }
supports = { A = "clamped", B = %s }
probes.force = { node = "B", reaction = "uy" }
probes.moment = { node = "B", reaction = "rz" }
[[steps]]
name = "move"
%s
"""


@pytest.mark.parametrize(
    ("support", "motion", "kind", "probe"),
    [
        ('["ux"]', "displacement = { B = { uy = -10 } }", "held by", "force"),
        ('"pinned"', "rotation = { B = [0, 0, 20] }", "held by moment", "moment"),
    ],
)
def test_what_a_motion_takes_is_told_from_what_supports_take(support: str, motion: str, kind: str, probe: str) -> None:
    found = pennate.loads(GUIDED % (support, motion)).solve()
    arrows = shapes.arrows(found.drawing(), found.drawing("unloaded"), len(found.nodes), 100.0)
    assert [(arrow.kind, arrow.node) for arrow in arrows] == [(kind, 1)]
    assert arrows[0].strength == pytest.approx(abs(found[probe][0]), rel=1e-9)
    assert all(arrow[0] in data_of(page(found))["arrow"] for arrow in data_of(page(found))["states"][-1]["arrows"])


def test_what_a_motion_takes_is_along_the_axes_that_it_is_prescribed_in() -> None:
    support = '{ fix = ["ux"], x_axis = [0.8, 0.6, 0] }'
    found = pennate.loads(GUIDED % (support, "displacement = { B = { uy = -10 } }")).solve()
    force, moment = shapes.held_by(found.drawing()["point_data"], found.drawing("unloaded")["point_data"], 2)
    across = np.array([-0.6, 0.8, 0.0])
    assert abs(found.reaction[0, 1, :3] @ np.array([0.8, 0.6, 0.0])) > 1.0
    np.testing.assert_allclose(force[1], (found.reaction[0, 1, :3] @ across) * across, rtol=1e-9)
    assert not force[0].any() and not moment.any()


# A dyad whose right muscle has its pressures in another unit.
MIXED: dict[str, Any] = {
    "members": {"right": {"muscle": "other"}},
    "steps": {"inflate": {"pressure": {"all": None, "left": "15 psi", "right": "15 kPa"}}},
}


def test_pressures_in_different_units_are_shown_in_that_of_the_first_muscle(dyad: pennate.Network) -> None:
    other = {**dyad.to_dict()["muscles"]["silicone"], "pressure_unit": "kPa"}
    network = dyad.edit(muscles={"other": other}, **MIXED)
    solution = network.solve()
    cells = solution.drawing()["cell_data"]
    right = cells["pressure"][cells["member_id"] == network.members.index("right")]
    # A pound-force per square inch in kilopascals.
    assert np.allclose(right, 15 / 6.894757293168361, rtol=1e-12)
    field = next(field for field in data_of(page(solution))["fields"] if field["key"] == "pressure")
    assert field["unit"] == network.pressure_unit == solution.to_dict()["pressure_unit"] == "psi"


def test_a_support_is_drawn_until_a_step_frees_it() -> None:
    network = pennate.loads(GUIDED % ('["uy"]', "force = { B = [1, 0] }"))
    freed = network.edit(steps=[*network.to_dict()["steps"], {"name": "let go", "free": {"B": ["uy"]}}]).solve()
    labelled = {state["label"]: [each[:2] for each in state["supports"]] for state in data_of(page(freed))["states"]}
    assert labelled["unloaded"] == labelled["move, 100 %"] == [["block", 0], ["guide", 1]]
    assert labelled["let go, 100 %"] == [["block", 0]]


def test_all_numbers_are_those_of_the_last_step_also_where_its_fraction_is_below_zero() -> None:
    network = pennate.loads(ARCH)
    (push,) = network.to_dict()["steps"]
    before = {"name": "before", "increments": 1}
    found = network.edit(steps=[before, {**push, "stop": {"increments": 22}}]).solve()
    assert found.fraction[1] < 0 and found.status == "converged"
    assert "At the end of step ‘push’" in page(found)


def test_a_network_without_members_is_shown(loose: pennate.Network) -> None:
    text = page(loose.solve())
    content = data_of(text)
    assert content["members"] == [] and len(content["bars"]) == 2
    # A node at which nothing ends is a ball.
    assert [ball[0] for ball in content["balls"]] == [3]
    assert min(ball[1] for ball in content["balls"]) > 0.005 * content["size"]
    # The lines in place of the picture are those of the body.
    still = text.split("<noscript>")[1].split("</noscript>")[0]
    assert still.count("<line") == 2 and "nan" not in still


def joined_of(network: pennate.Network) -> np.ndarray[Any, Any]:
    """(members, 2), the nodes at the ends of each member."""
    return np.array([[network.nodes.index(end) for end in network.ends[name]] for name in network.members])


def test_a_carried_drawing_follows_a_rigid_motion(solution: pennate.Solution) -> None:
    drawing = solution.drawing("inflate")
    turn = carry.rotations(np.array([[0.3, -0.2, 1.1]]))[0]
    nodes = len(solution.nodes)
    moved = (shapes.places(drawing) @ turn.T + [3.0, 4.0, 5.0])[:nodes]
    found = carry.carried(
        drawing, joined_of(solution.network), moved - drawing["points"][:nodes], np.tile(turn, (nodes, 1, 1))
    )
    np.testing.assert_allclose(shapes.places(found), shapes.places(drawing) @ turn.T + [3.0, 4.0, 5.0], atol=1e-9)
    first = drawing["point_data"]["frame_e1"][nodes:]
    np.testing.assert_allclose(found["point_data"]["frame_e1"][nodes:], first @ turn.T, atol=1e-9)


def test_a_carried_drawing_is_near_the_equilibrium_that_it_was_carried_to() -> None:
    """From 20 to 25 psi the joint moves by millimetres; between the nodes less than a tenth of a radius is missed."""
    network = pennate.scene("dyad")
    before, after = (network.set(pressure=pressure).solve(accuracy=1e-4) for pressure in (20, 25))
    turn = carry.rotations(after.rotation[-1]) @ np.swapaxes(carry.rotations(before.rotation[-1]), 1, 2)
    found = shapes.places(carry.carried(before.drawing(), joined_of(network), after.displacement[-1], turn))
    exact, radius = shapes.places(after.drawing()), float(after.drawing()["point_data"]["radius"].max())
    moved = np.linalg.norm(exact - shapes.places(before.drawing()), axis=1).max()
    assert moved > 0.5 and np.linalg.norm(found - exact, axis=1).max() < 0.1 * radius


@pytest.mark.parametrize(
    ("value", "error", "text"),
    [
        (-36.529644, 1.2e-6, "\N{MINUS SIGN}36.529644 ± 1.2·10⁻⁶\N{NO-BREAK SPACE}mm"),
        (565.0, 0.07, "565.00 ± 0.07\N{NO-BREAK SPACE}mm"),
        (1e-9, 1e-6, "0 ± 1·10⁻⁶\N{NO-BREAK SPACE}mm"),
        (float("nan"), 1.0, "–"),
    ],
)
def test_a_number_has_the_digits_that_its_error_leaves(value: float, error: float, text: str) -> None:
    assert fields.with_error(value, error, "mm") == text
