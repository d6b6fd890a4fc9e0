"""Facts that the pictures must keep, on a dyad made by hand: two muscles that meet at a joint."""

from __future__ import annotations

import dataclasses
import io
import json
import pathlib

import numpy as np
import pytest

pyvista = pytest.importorskip("pyvista", reason="pictures need pennate[view]")

from PIL import Image

import pennate
from pennate.__main__ import main
from pennate._look import fields
from pennate.pictures import colours, figure, labels, paper, results, scene, states, surfaces, view

# Two members of two sections from the feet A and B to the joint J: reference places of nodes, then of members.
NODES = np.array([[-4.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0]])
RADIUS, THICK = 0.5, 0.8


def shape_of(force: float, held: int = 0, drop: float = 0.0) -> results.Shape:
    """The dyad with an axial force; `held` are components of J that are held, `drop` is how far J has moved down."""
    points, radii, cells, members, moved = [*NODES], [THICK, THICK, THICK], [], [], [0.0, 0.0, drop]
    for member, foot in enumerate(NODES[:2]):
        for start, end, radius in ((0.0, 0.5, RADIUS), (0.5, 1.0, THICK)):
            cells.append((len(points), len(points) + 1))
            members.append(member)
            for part in (start, end):
                points.append(foot + part * (NODES[2] - foot))
                radii.append(radius)
                moved.append(part * drop)
    count = len(points)
    none = np.zeros((count, 3))
    along = {0: NODES[2] - NODES[0], 1: NODES[2] - NODES[1]}
    second = np.zeros((count, 3))
    for (a, b), member in zip(cells, members, strict=True):
        direction = along[member] / 5.0
        second[[a, b]] = (-direction[1], direction[0], 0.0)
    holds = np.zeros(count, dtype=int)
    holds[:3] = 63, scene.UX | scene.UY, held
    axes = np.where(holds[:, None] > 0, [[1.0, 0.0, 0.0]], 0.0)
    return results.Shape(
        points=np.array(points),
        cells=np.array(cells),
        point_data={
            "displacement": np.stack([np.zeros(count), -np.array(moved), np.zeros(count)], axis=1),
            "radius": np.array(radii),
            "frame_e2": second,
            "frame_e3": np.tile([0.0, 0.0, 1.0], (count, 1)),
            "held": holds,
            "held_x": axes,
            "held_y": np.roll(axes, 1, axis=1),
            "released": np.zeros(count, dtype=int),
            "load_force": none,
            "load_moment": none,
            "reaction_force": none,
            "reaction_moment": none,
        },
        cell_data={
            "axial_force": np.full(4, force),
            "member_id": np.array(members),
            "kind": np.zeros(4, dtype=int),
            "pressure": np.full(4, 20.0),
            "load_distributed": np.zeros((4, 3)),
        },
    )


def run_of(digits: float | None = 12.0, error: float = 1e-7) -> results.Run:
    """A run of one step; the largest force at the end of a member is 10 N."""
    step = results.Step(
        "inflate",
        "converged",
        {"force": digits, "displacement": 15.0},
        {"force": 10.0, "moment": 0.0, "displacement": 1.0},
    )
    return results.Run("dyad", "mm", "N", "psi", True, ("A", "B", "J"), ("left", "right"), (step,), (), error)


AFTER = results.State(0, 1.0, lambda: shape_of(0.0))


def coloured(run: results.Run, *forces: float) -> fields.Scale:
    """The colours of axial forces of this size in several states."""
    states = [(AFTER, shape_of(force)) for force in forces]
    return colours.colouring(colours.field_named(run, "axial_force"), run, states)


def built(shape: results.Shape) -> scene.Scene:
    """The scene of a shape."""
    return scene.build(run_of(), shape, shape.cell_data["axial_force"], shape_of(0.0), 0.0)


@pytest.mark.parametrize(
    ("digits", "error", "forces", "words"),
    [
        # 1e-12 N beside 10 N is rounding at 12 digits, and a force at 14.
        (12.0, 0.0, (1e-12,), "axial force: zero throughout"),
        (14.0, 0.0, (1e-12, 0.0), None),
        # The mesh is right to 1e-3 of 10 N alone.
        (12.0, 1e-3, (5.0, 5.005), "axial force: 5\N{NO-BREAK SPACE}N throughout"),
        (12.0, 1e-5, (5.0, 5.005), None),
        # A kind without digits is rounding alone, however large its numbers look.
        (None, 0.0, (3e-9, -2e-9), "axial force: zero throughout"),
    ],
)
def test_what_the_digits_do_not_tell_apart_has_one_colour(
    digits: float | None, error: float, forces: tuple[float, ...], words: str | None
) -> None:
    found = coloured(run_of(digits, error), *forces)
    assert found.uniform == (words is not None)
    if words is not None:
        assert found.words() == words


def test_zero_has_the_same_colour_whatever_the_limits() -> None:
    both, tension = coloured(run_of(), -3.0, 9.0), coloured(run_of(), 4.9, 5.0)
    assert both.low <= -3.0 < 9.0 <= both.high
    # A variation of two per cent does not fill the bar.
    assert (tension.low, tension.high) == (0.0, 5.0)
    zero = np.zeros(1)
    assert np.abs(both.colours(zero).astype(int) - tension.colours(zero)).max() <= 5
    # Tension is red, compression blue.
    assert both.colours(np.array([9.0]))[0, 0] > both.colours(np.array([9.0]))[0, 2]
    assert both.colours(np.array([-3.0]))[0, 0] < both.colours(np.array([-3.0]))[0, 2]


@pytest.mark.parametrize(("low", "high"), [(0.0, 55.0), (-3.6, 9.8), (-24.4, 0.0), (0.0, 1e-7), (-1e6, 3e6)])
def test_marks_of_the_legend_are_round_and_enclose_the_values(low: float, high: float) -> None:
    marks = np.array(fields.ticks(low, high))
    assert marks[0] <= low < marks[1] and marks[-2] < high <= marks[-1]
    assert 3 <= len(marks) <= 8 and np.allclose(np.diff(marks), marks[1] - marks[0])
    assert (marks == 0.0).any()


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (41.18386, "41.2"),
        (-0.25, "\N{MINUS SIGN}0.25"),
        (1e-3, "0.001"),
        (20.0, "20"),
        (12345.0, "12345"),
        (3e6, "3·10⁶"),
        (0.0, "0"),
    ],
)
def test_numbers_have_three_digits(value: float, text: str) -> None:
    assert fields.number(value) == text


def test_a_change_of_section_makes_a_shoulder() -> None:
    rod = built(shape_of(1.0)).rods[0]
    assert [float(piece.radii[0]) for piece in rod.pieces] == [RADIUS, THICK]
    assert np.allclose(rod.pieces[0].places[-1], rod.pieces[1].places[0])
    assert rod.nodes == (0, 2)


def test_tubes_that_meet_close_their_joint() -> None:
    """On the outer side of the bend two cut tubes leave a wedge; the ball reaches out as far as the tubes are thick."""
    found = built(shape_of(1.0))
    colouring = coloured(run_of(), 0.0, 1.0)
    mesh = surfaces.network(found, colouring, colours.LIGHT, True).mesh(np.array([0.0, 0.0, 1.0]))
    reach = (np.asarray(mesh.points) - NODES[2]) @ np.array([0.0, 1.0, 0.0])
    assert reach.max() == pytest.approx(THICK, rel=0.01)  # a ball of 48 sides; without it 0.8 of that


def test_what_a_step_holds_is_no_support() -> None:
    joints = built(shape_of(1.0, held=scene.UY)).joints
    assert [joint.prescribed for joint in joints] == [0, 0, scene.UY]
    assert joints[0].held == 63


def test_only_what_a_step_prescribes_is_drawn_as_held_by() -> None:
    shape = shape_of(1.0, held=scene.UY)
    shape.point_data["reaction_force"] = np.tile([3.0, 4.0, 0.0], (len(shape.points), 1))
    shape.point_data["reaction_moment"] = np.tile([0.0, 0.0, 5.0], (len(shape.points), 1))
    joints = built(shape).joints
    np.testing.assert_allclose([joint.held_by_force for joint in joints], [[0, 0, 0], [0, 0, 0], [0, 4, 0]])
    assert not any(joint.held_by_moment.any() for joint in joints)
    turned = shape_of(1.0, held=scene.RZ)
    turned.point_data.update({name: shape.point_data[name] for name in ("reaction_force", "reaction_moment")})
    joint = built(turned).joints[2]
    assert not joint.held_by_force.any()
    np.testing.assert_allclose(joint.held_by_moment, [0, 0, 5])


def test_members_end_at_the_node_that_moved_with_them() -> None:
    """Two nodes at one place, of which one stays behind."""
    shape = shape_of(1.0, drop=2.0)
    shape.points[1] = shape.points[2]
    assert scene.node_at(shape, int(shape.cells[1, 1]), 3) == 2


def test_names_cover_nothing() -> None:
    covered = np.zeros((200, 300), dtype=bool)
    covered[90:110] = True
    wish = labels.Wish("J", "node", np.array([150.0, 100.0]), 10.0, np.array([40.0, 12.0]), np.array([0.0, 1.0]), False)
    places = labels.place_all([wish] * 4, covered, covered, 1.0)
    boxes = [(place.centre - wish.size / 2, place.centre + wish.size / 2) for place in places]
    assert len(places) == 4
    for index, (low, high) in enumerate(boxes):
        assert not covered[int(low[1]) : int(np.ceil(high[1])), int(low[0]) : int(np.ceil(high[0]))].any()
        assert all((low >= other[1]).any() or (high <= other[0]).any() for other in boxes[:index])
    # The first one stands where it stands best.
    assert places[0].centre[1] > 110.0


def test_dollar_signs_in_names_are_drawn_as_they_are() -> None:
    name, canvas = r"price $5 and $6, \$\q$", paper.new_figure(300.0, 100.0, "#ffffff", 100)
    # As a formula the signs would go, and what is none would end the drawing.
    wide = paper.write(canvas, 10.0, 10.0, name, size=paper.TITLE)
    assert wide > paper.write(canvas, 10.0, 50.0, name.replace("$", ""), size=paper.TITLE) + 10.0
    assert paper.text_width(name, paper.TITLE, "normal") == pytest.approx(wide, abs=3.0)
    network = pennate.loads(r"""
        format = "pennate/1"
        title = "$\t$"
        nodes = { 'A$\q$' = [0, 0], B = [50, 20] }
        materials.steel = { youngs_modulus = 200000, poissons_ratio = 0.3 }
        sections.wire = { circle = { radius = 0.75 } }
        members.'$\w$' = { nodes = ['A$\q$', "B"], section = "wire", material = "steel" }
        supports.'A$\q$' = "clamped"
        [[steps]]
        name = 'push $\x$'
        force = { 'A$\q$' = [1, 0, 0], B = [0, -1, 0] }
    """)
    drawn = network.solve().plot(names="all")
    texts = [each.get_text() for each in drawn.findobj(match=lambda artist: hasattr(artist, "get_text"))]
    assert r"push \$\x\$" in texts and r"\$\w\$" in texts


def test_a_name_without_a_place_is_left_out_unless_it_is_needed() -> None:
    full = np.ones((100, 100), dtype=bool)
    wish = labels.Wish("F", "load", np.array([50.0, 50.0]), 5.0, np.array([20.0, 10.0]), np.zeros(2), False)
    assert labels.place_all([wish], full, full, 1.0) == []
    assert len(labels.place_all([dataclasses.replace(wish, needed=True)], full, full, 1.0)) == 1


def test_views_look_where_their_names_say() -> None:
    place = np.array([1.0, 2.0, 3.0])
    for name, flat in (("xy", (1.0, 2.0)), ("xz", (1.0, 3.0)), ("yz", (2.0, 3.0))):
        assert np.allclose(view.view_named(name).flat(place), flat)
    found = view.view_named("-60,20")
    assert np.allclose(np.cross(found.right, found.up), found.towards)
    with pytest.raises(results.PictureError, match="azimuth"):
        view.view_named("above")


def test_panels_fill_their_rows_unless_they_get_much_larger() -> None:
    options = states.Options()
    wide, square = (view.Frame(np.zeros(2), np.array(size)) for size in ((10.0, 1.0), (1.0, 1.0)))
    assert (states.lay_out(wide, 3, options).columns, states.lay_out(square, 3, options).columns) == (1, 3)
    for count in range(1, 9):
        found = states.lay_out(square, count, options)
        assert found.columns * found.rows >= count
        assert found.columns * (found.scale + 2 * states.MARGIN) <= options.width * paper.MILLIMETRE


def write_results(folder: pathlib.Path) -> results.Run:
    """A folder as `pennate solve -o` writes it, as far as pictures need it."""
    for number, shape in enumerate((shape_of(0.0), shape_of(7.0, drop=1.5))):
        cells = np.hstack([np.full((len(shape.cells), 1), 2), shape.cells])
        mesh = pyvista.UnstructuredGrid(cells.ravel(), np.full(len(cells), 3), shape.points)
        mesh.point_data.update(shape.point_data)
        mesh.cell_data.update(shape.cell_data)
        mesh.field_data["step"], mesh.field_data["fraction"] = [float(number)], [float(number)]
        mesh.save(folder / f"dyad_{number}.vtu")
    sets = "".join(f'<DataSet timestep="{number}" part="0" file="dyad_{number}.vtu"/>' for number in range(2))
    (folder / "dyad.pvd").write_text(
        f'<VTKFile type="Collection" version="1.0"><Collection>{sets}</Collection></VTKFile>'
    )
    node = {"displacement": [0, 0, 0], "reaction_force": [0, 0, 0], "reaction_moment": [0, 0, 0]}
    end = {"force": [7.0, 0.0, 0.0], "moment": [0.0, 0.0, 0.0]}
    step = {
        "name": "inflate",
        "status": "converged",
        "digits": {"force": 12.0, "displacement": 15.0},
        "nodes": dict.fromkeys("ABJ", node),
        "members": dict.fromkeys(("left", "right"), {"start": end, "end": end}),
    }
    content = {
        "title": "dyad",
        "units": "mm-N-MPa",
        "dimension": "plane",
        "accuracy": {"reached": None},
        "pictures": ["dyad_0.vtu", "dyad_1.vtu", "dyad.pvd"],
        "steps": [step],
    }
    (folder / "results.json").write_text(json.dumps(content))
    (folder / "history.csv").write_text("step,fraction,pressure all (psi)\n")
    return results.read(folder)


def test_pictures_of_another_run_are_not_taken_for_those_of_the_results(tmp_path: pathlib.Path) -> None:
    write_results(tmp_path)
    (tmp_path / "other.pvd").write_text((tmp_path / "dyad.pvd").read_text())
    assert results.find_pvd(tmp_path) == results.find_pvd(tmp_path / "dyad.pvd") == tmp_path / "dyad.pvd"
    with pytest.raises(results.PictureError, match="other.pvd is of another run: .*results.json belongs to dyad.pvd"):
        results.read(tmp_path / "other.pvd")
    (tmp_path / "dyad_1.vtu").rename(tmp_path / "elsewhere.vtu")
    with pytest.raises(results.PictureError, match="lists dyad_1.vtu, which is missing"):
        results.read(tmp_path)
    content = json.loads((tmp_path / "results.json").read_text())
    del content["pictures"]
    (tmp_path / "results.json").write_text(json.dumps(content))
    with pytest.raises(results.PictureError, match="lists no pictures: the network was solved without them; .*--vtk"):
        results.read(tmp_path)
    (tmp_path / "results.json").write_text("{")
    with pytest.raises(results.PictureError, match="holds no results"):
        results.read(tmp_path)


@pytest.mark.parametrize("theme", [colours.LIGHT, colours.DARK])
def test_a_picture_shows_the_network_on_its_paper(tmp_path: pathlib.Path, theme: colours.Theme) -> None:
    run = write_results(tmp_path)
    assert [state.step for state in run.states] == [None, 0]
    options = states.Options(theme=theme, width=100.0, resolution=100)
    output = tmp_path / "picture.png"
    figure.draw(states.make_sheet(run, options, view.view_named("xy")), options, output)
    image = np.asarray(Image.open(output).convert("RGB")).astype(int)
    corner = np.array([int(theme.paper[place : place + 2], 16) for place in (1, 3, 5)])
    assert np.abs(image[0, -1] - corner).max() <= 2
    # Uniform tension has the colour of muscles, whose light side is nearly the colour itself.
    muscle = np.array([int(theme.muscle[place : place + 2], 16) for place in (1, 3, 5)])
    near = np.abs(image - muscle).max(axis=2) < 24
    assert near.mean() > 0.02
    assert image.shape[1] == pytest.approx(figure.LEAST / 25.4 * 100, abs=2)


def test_what_is_hidden_gets_no_name(tmp_path: pathlib.Path) -> None:
    run = write_results(tmp_path)
    options = states.Options()
    sheet = states.make_sheet(run, options, view.view_named("xy"))
    canvas = paper.new_figure(300.0, 300.0, "#ffffff", 100)
    axes = paper.add_axes(canvas, 0.0, 0.0, 300.0, 300.0)
    taken = figure.paint(axes, sheet, sheet.panels[0], sheet.frame, 20.0, options)
    joint = sheet.panels[0].scene.joints[2]
    assert taken.sees(joint.place, joint.radius)
    assert not taken.sees(joint.place - np.array([0.0, 0.0, 5.0]), joint.radius)


def test_a_solution_is_drawn_as_its_files_are() -> None:
    solution = pennate.scene("dyad").solve()
    run = results.of(solution)
    assert run.state_after(None).load().points.shape[1] == 3
    assert run.pressure_unit == "psi"
    assert [step.name for step in run.steps] == list(solution.steps)


@pytest.mark.parametrize("scene", [("dyad", {}), ("spiral", {"cells": 3}), ("stage", {})])
def test_a_notebook_shows_a_network_as_it_is_built(scene: tuple[str, dict[str, int]]) -> None:
    network = pennate.scene(scene[0], **scene[1])
    bundle = network._repr_mimebundle_()
    assert bundle["text/plain"] == repr(network)
    image = np.asarray(Image.open(io.BytesIO(bundle["image/png"])).convert("RGB"))
    assert (image < 250).any(axis=2).mean() > 0.01
    # The lines are where those of a solution are, before anything acts.
    run, solved = results.of_network(network), results.of(network.solve())
    mine, other = (each.state_after(None).load() for each in (run, solved))
    assert run.plane == solved.plane and run.nodes == solved.nodes and run.members == solved.members
    for member in range(len(run.members)):
        ends = [shape.points[shape.cells[shape.cell_data["member_id"] == member]] for shape in (mine, other)]
        np.testing.assert_allclose(ends[0][[0, -1], [0, 1]], ends[1][[0, -1], [0, 1]], atol=1e-6 * network.lengths.max())
    np.testing.assert_array_equal(mine.point_data["held"][: len(run.nodes)], other.point_data["held"][: len(run.nodes)])


def test_what_cannot_be_solved_is_drawn_all_the_same() -> None:
    loose = pennate.loads("""
        format = "pennate/1"
        nodes = { A = [0, 0], B = [50, 20] }
        materials.steel = { youngs_modulus = 200000, poissons_ratio = 0.3 }
        sections.wire = { circle = { radius = 0.75 } }
        members.wire = { nodes = ["A", "B"], section = "wire", material = "steel", arc = { rise = 5 } }
        supports = { A = "pinned" }
    """)
    with pytest.raises(pennate.MechanismError):
        loose.solve()
    assert loose._repr_mimebundle_()["image/png"][:4] == b"\x89PNG"


def test_a_network_without_members_is_drawn(loose: pennate.Network, tmp_path: pathlib.Path) -> None:
    solution = loose.solve()
    assert loose._repr_mimebundle_()["image/png"][:4] == solution._repr_mimebundle_()["image/png"][:4] == b"\x89PNG"
    assert solution.mesh().n_cells == 0
    for run in (results.of(solution), results.of_network(loose)):
        found = states.make_sheet(run, states.Options(), view.view_named("xy")).panels[0].scene
        assert len(found.bodies) == 1 and found.bodies[0].radius > 0
        assert [joint.name for joint in found.joints if joint.alone] == ["D"]
    place = tmp_path / "loose.toml"
    place.write_text(loose.text)
    small = ["--resolution", "40", "--width", "110"]
    assert main(["solve", str(place), "-o", str(tmp_path / "out"), "--vtk"]) == 0
    for source, name in ((place, "a.png"), (tmp_path / "out", "b.png")):
        assert main(["plot", str(source), "-o", str(tmp_path / name), *small]) == 0
    solution.animate(tmp_path / "c.gif", frames=2, resolution=40)
    for name in ("a.png", "b.png", "c.gif"):
        with Image.open(tmp_path / name) as picture:
            assert (np.asarray(picture.convert("L")) < 160).mean() > 0.005


def test_a_mesh_is_tubes_of_the_deformed_members() -> None:
    solution = pennate.scene("dyad").solve()
    mesh = solution.mesh(sides=12)
    drawing = solution.drawing()
    members = drawing["cell_data"]["member_id"] >= 0
    assert mesh.n_cells == 12 * members.sum()
    assert mesh.cell_data["axial_force"].max() == drawing["cell_data"]["axial_force"].max()
    # The tip of a tube is a radius away from where its node is.
    moved = drawing["points"] + drawing["point_data"]["displacement"]
    far = np.linalg.norm(mesh.points[:, None] - moved[None], axis=2).min(axis=1)
    np.testing.assert_allclose(far.max(), drawing["point_data"]["radius"].max(), rtol=1e-6)


def test_one_command_goes_from_a_file_to_a_picture_and_a_film(
    tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]
) -> None:
    network = tmp_path / "dyad.toml"
    network.write_text(pennate.scene("dyad").text)
    small = ["--resolution", "40", "--width", "110"]
    assert main(["plot", str(network), "-o", str(tmp_path / "dyad.png"), *small]) == 0
    with Image.open(tmp_path / "dyad.png") as picture:
        assert picture.size[0] > 100
    solution = pennate.load(network).solve()
    with pytest.raises(results.PictureError, match="a picture is a .png"):
        solution.plot(output=tmp_path / "dyad.bmp")
    solution.animate(tmp_path / "dyad.gif", frames=2, resolution=30)
    with Image.open(tmp_path / "dyad.gif") as moving:
        assert getattr(moving, "n_frames") >= 3
    assert main(["plot", str(network), "-o", str(tmp_path / "dyad.bmp")]) == 2
    capsys.readouterr()
    for wrong, message in (
        (["--width", "3"], "width: one state needs 36 mm or more, not 3"),
        (["--width", "0"], "width: more than 0 and less than 5000 mm expected, not 0"),
        (["--width", "nan"], "width: more than 0 and less than 5000 mm expected, not nan"),
        (["--resolution", "0"], "resolution: 10 to 2000 pixels an inch expected, not 0"),
    ):
        assert main(["plot", str(network), "-o", str(tmp_path / "no.png"), *wrong]) == 2
        assert message in capsys.readouterr().err and not (tmp_path / "no.png").exists()
    assert main(["plot", str(network), "-o", str(tmp_path / "no.gif"), "--steps", "inflate"]) == 2
    assert "steps: a film goes through all of them" in capsys.readouterr().err
    assert main(["plot", str(network), "-o", str(network)]) == 2
    assert pennate.load(network).text == pennate.scene("dyad").text
    assert main(["plot", str(network), "-o", str(tmp_path / "a.png"), "--field", "colour"]) == 2
    assert "there is no field 'colour'" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["plot", str(network), "-o", str(tmp_path / "a.png"), "--accuracy", "7"])
    assert "argument --accuracy: a number between 0 and 1 expected" in capsys.readouterr().err
