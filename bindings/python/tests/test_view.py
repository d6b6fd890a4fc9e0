"""The live page: who is let in, and that what it shows is what the solver says. No browser is needed."""

from __future__ import annotations

import html
import http.client
import json
import pathlib
import re
import socket
import time
from collections.abc import Iterator
from typing import Any

import numpy as np
import pytest

import pennate

viser = pytest.importorskip("viser")
import websockets.exceptions  # noqa: E402
import websockets.sync.client as websocket  # noqa: E402
from viser._messages import ShareUrlRequest  # noqa: E402

from pennate._look import shapes  # noqa: E402
from pennate._view import Session, follow, handles, meshes, save, server  # noqa: E402

# A shallow frame that snaps where F passes 65.6 N, and back.
SNAP = """\
format = "pennate/1"
title = "two strips"
dimension = "plane"
[parameters]
F = 50    # the push, N
rise = 10
top = "= 2 * rise"
[nodes]
A = [-100, 0]
B = [100, 0]
C = [0, "= rise"]
[materials]
steel = { youngs_modulus = 200000, poissons_ratio = 0.3 }
[sections]
strip = { rectangle = { width = 10, height = 1 } }
[members]
left = { nodes = ["A", "C"], section = "strip", material = "steel" }
right = { nodes = ["B", "C"], section = "strip", material = "steel" }
[supports]
A = "clamped"
B = "clamped"
[[steps]]
name = "press"
force = { C = [0, "= -F"] }
[probes]
down = { node = "C", displacement = "uy" }
"""


@pytest.fixture(scope="module")
def page(dyad: pennate.Network) -> Iterator[Session]:
    """A page of the dyad."""
    with dyad.view(port=8470) as found:
        yield found.settle()


@pytest.fixture(scope="module")
def spiral() -> pennate.Solution:
    """Many members, each of many lines."""
    return pennate.scene("spiral", cells=4).solve(accuracy=1e-4)


def ask(page: Session, path: str, **headers: str) -> tuple[int, bytes, http.client.HTTPMessage]:
    """Status, body and heads of the answer to a request; `Host` is right unless it is given."""
    connection = http.client.HTTPConnection("127.0.0.1", page.server.guard.port, timeout=10)
    connection.putrequest("GET", path, skip_host="Host" in headers)
    for name, value in headers.items():
        connection.putheader(name, value)
    connection.endheaders()
    answer = connection.getresponse()
    found = answer.status, answer.read(), answer.headers
    connection.close()
    return found


def test_the_server_listens_on_this_machine_alone(page: Session) -> None:
    port = page.server.guard.port
    assert page.address.startswith(f"http://127.0.0.1:{port}/") and len(page.server.guard.key) >= 24
    # Another address of this machine's own loopback network has nobody who listens.
    with socket.socket() as other, pytest.raises(ConnectionRefusedError):
        other.connect(("127.0.0.2", port))


def test_who_has_the_address_gets_the_page(page: Session) -> None:
    status, body, heads = ask(page, f"/{page.server.guard.key}/")
    assert status == 200 and b"<html" in body and heads["Referrer-Policy"] == "no-referrer"
    assert ask(page, f"/{page.server.guard.key}/../../../etc/passwd")[0] == 404


@pytest.mark.parametrize("path", ["/", "/index.html", "/wrong/", "/KEYx/", "/?key=KEY", "/x/KEY/"])
def test_without_the_key_nobody_is_let_in(page: Session, path: str) -> None:
    status, body, _ = ask(page, path.replace("KEY", page.server.guard.key))
    assert status == 403 and b"this address is not valid" in body


@pytest.mark.parametrize("host", ["example.org", "127.0.0.1", "127.0.0.1:1", "127.0.0.1.example.org:PORT", ":PORT", ""])
def test_other_hosts_are_refused(page: Session, host: str) -> None:
    """A name of somebody else that leads to this machine does not help."""
    assert ask(page, f"/{page.server.guard.key}/", Host=host.replace("PORT", str(page.server.guard.port)))[0] == 403


def connect(page: Session, key: str, origin: str | None) -> None:
    """Opens a socket as viser's page does."""
    port = page.server.guard.port
    protocol = websockets.typing.Subprotocol(f"viser-v{viser.__version__}")
    asked = websockets.typing.Origin(origin) if origin else None
    with websocket.connect(
        f"ws://127.0.0.1:{port}/{key}", origin=asked, subprotocols=[protocol], compression=None
    ) as found:
        assert found.recv(timeout=10)


def test_the_page_itself_may_open_its_socket(page: Session) -> None:
    connect(page, page.server.guard.key, page.address.rsplit("/", 2)[0])


@pytest.mark.parametrize("origin", ["http://example.org", "https://127.0.0.1:PORT", "http://127.0.0.1:1", "null", None])
def test_pages_of_others_may_not(page: Session, origin: str | None) -> None:
    origin = origin.replace("PORT", str(page.server.guard.port)) if origin else None
    with pytest.raises(websockets.exceptions.InvalidStatus, match="403"):
        connect(page, page.server.guard.key, origin)


def test_a_socket_needs_the_key(page: Session) -> None:
    with pytest.raises(websockets.exceptions.InvalidStatus, match="403"):
        connect(page, "wrong", page.address.rsplit("/", 2)[0])


def test_no_tunnel_to_the_outside_can_be_asked_for(page: Session) -> None:
    assert ShareUrlRequest not in page.server._websock_server._incoming_handlers
    assert page.server.request_share_url() is None


def test_other_names_are_let_in_when_they_are_asked_for() -> None:
    guard = server.Guard("key", ("lab.example.org",), 8080)
    assert guard.knows("lab.example.org:8080") and guard.knows("localhost:8080")
    assert not guard.knows("lab.example.org") and not guard.knows("example.org:8080")
    assert not server.Guard("key", (), 8080).knows("lab.example.org:8080")


def test_what_a_slider_leads_to_is_what_the_solver_says(page: Session, dyad: pennate.Network) -> None:
    for values in ({"beta": 24.0}, {"beta": 30.0, "pressure": 22.0}, {"L": 120.0}):
        page.set(**values).settle()
        exact = dyad.set(**page.panel.values()).solve()
        for name, probe in page.probes().items():
            error = probe.error + float(exact.error[name][-1]) + 1e-9
            assert probe.value == pytest.approx(float(exact[name][-1]), abs=error)
            shown = re.search(rf'data-probe="{name}" data-value="([^"]*)"', page.panel.numbers.content)
            assert shown is not None and float(shown[1]) == probe.value
        assert "Stable" in page.panel.verdict.content
        # The picture too: its nodes are where the solver has them.
        assert page.display.shown is not None
        nodes = shapes.places(page.display.shown[0])[: len(dyad.nodes)]
        np.testing.assert_allclose(nodes, exact.network.positions + exact.displacement[-1], atol=1e-2)
    page.set(L=130, beta=22, pressure=25).settle()


def test_the_step_slider_goes_through_all_steps(page: Session, dyad: pennate.Network) -> None:
    exact = dyad.solve()
    page.set(step=1).settle()
    assert page.probes()["stroke"].value == pytest.approx(exact["stroke@inflate"], abs=1e-4)
    page.set(step=1.5).settle()
    assert "push back" in page.panel.verdict.content
    half = float(re.findall(r'data-probe="stroke" data-value="([^"]*)"', page.panel.numbers.content)[0])
    assert half == pytest.approx(exact["stroke@inflate"] / 2, rel=0.03)
    # Errors are known at the ends of steps alone.
    assert page.probes()["stroke"].value == half and np.isnan(page.probes()["stroke"].error)
    page.set(step=0).settle()
    assert "Unloaded" in page.panel.verdict.content and page.probes()["stroke"].value == 0.0
    page.set(step=2).settle()


def test_sliders_move_to_finite_numbers_alone(page: Session) -> None:
    before = page.settle().panel.values()
    for name, value in (("beta", float("nan")), ("L", float("inf")), ("step", float("nan"))):
        with pytest.raises(ValueError, match=f"{name}: a finite number expected, not"):
            page.set(pressure=10.0, **{name: value})
    with pytest.raises(TypeError, match="beta: a number expected, not '30'"):
        page.set(beta="30")  # type: ignore[arg-type]
    assert page.settle().panel.values() == before


def test_a_click_finds_the_member_that_is_seen_there(page: Session, dyad: pennate.Network) -> None:
    page.settle()
    assert page.display.shown is not None
    nodes = page.display.picture.scaled(shapes.places(page.display.shown[0])[:3])
    for index, foot in enumerate(nodes[:2]):
        above = (foot + nodes[2]) / 2 + [0.0, 0.0, 5.0]
        assert page.display.picture.member_along(above, np.array([0.0, 0.0, -1.0])) == index
    assert page.display.picture.member_along(np.array([0.0, 9.0, 5.0]), np.array([0.0, 0.0, -1.0])) is None


def test_every_pressure_and_every_free_parameter_has_a_slider() -> None:
    network = pennate.loads(SNAP)
    assert [handle.name for handle in handles.moving(network, {})[1]] == ["F", "rise"]
    stated = pennate.load(pathlib.Path(__file__).parents[3] / "models/networks/dyad.toml")
    moved, found = handles.moving(stated, {"beta": (10.0, 60.0)})
    assert [handle.label for handle in found] == ["L", "beta", "pressure left, psi", "pressure pair, psi"]
    assert (found[1].low, found[1].high) == (10.0, 60.0) and (found[2].low, found[2].high) == (0.0, 25.0)
    # The same network, with the same digits.
    np.testing.assert_allclose(moved.solve()["stroke"], stated.solve()["stroke"], rtol=1e-12)


@pytest.mark.parametrize(
    ("ranges", "error", "message"),
    [
        ({"bet": (0, 1)}, pennate.NetworkError, r"(?s)no parameter 'bet' to move.*did you mean 'beta'\?"),
        ({"beta": (3, 1)}, ValueError, r"ranges\['beta'\]: the least and the greatest value expected, not \(3, 1\)"),
        ({"beta": 3}, ValueError, "the least and the greatest value expected, not 3"),
        ({"beta": "10:60"}, TypeError, r"ranges\['beta'\]: numbers expected, not '10:60'"),
        ([3], TypeError, r"ranges: a dictionary expected, not \[3\]"),
    ],
)
def test_limits_of_what_cannot_be_moved_are_refused(
    dyad: pennate.Network, ranges: Any, error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        Session(dyad, ranges=ranges)


def test_a_port_that_there_is_not_is_refused(dyad: pennate.Network) -> None:
    for port, error in (("8080", TypeError), (-1, ValueError), (70000, ValueError)):
        with pytest.raises(error, match="port: a .*number.* expected, not"):
            Session(dyad, port=port)  # type: ignore[arg-type]


def test_a_limit_is_shown_and_the_jump_is_played() -> None:
    with pennate.loads(SNAP).view(port=8480, ranges={"F": (-100.0, 100.0)}) as page:
        page.settle().panel.snaps.value = False
        page.set(F=70).settle()
        assert page.now is not None and page.now.lost and page.now.values["F"] == pytest.approx(65.559, abs=0.02)
        assert "Here it ends" in page.panel.verdict.content
        page.panel.snaps.value = True
        page.set(F=80).settle()
        jumped = pennate.loads(SNAP, F=80).edit(steps={"press": {"method": "jump"}}).solve()
        assert page.probes()["down"].value == pytest.approx(float(jumped["down"][-1]), abs=1e-4)
        assert "snapped" in page.panel.verdict.content
        # On the way back it stays on the other side, where a solve from the unloaded network would not be.
        page.set(F=20).settle()
        assert page.probes()["down"].value < -15
        followed = page.follows[1]
        assert followed.whole and page.display.shown is not None
        at = shapes.places(page.display.shown[0])[:3]
        assert at[2, 1] == pytest.approx(10 + page.probes()["down"].value, abs=1e-2)


def test_a_probe_that_looks_back_at_an_earlier_step_is_that_of_the_present_values() -> None:
    network = pennate.scene("stage", beta=32)
    found = follow.Follow(network, ("beta", "push"))
    now = found.go({"beta": 31.0, "push": 0.5})
    assert found.relative == {"stiffness"}
    assert now.probes["stiffness"].value == pytest.approx(
        float(network.set(beta=31).solve()["stiffness"][-1]), rel=1e-6
    )


def test_a_shape_that_is_elsewhere_is_not_shown_as_computed() -> None:
    network = pennate.loads(SNAP)
    found = follow.Follow(network, ("F", "rise"))
    now = found.go({"F": 60.0, "rise": 10.0})
    assert found.shape(now) and found.whole
    assert now.displacement is not None
    elsewhere = follow.Now(now.values, now.probes, True, "", False, now.displacement - [0.0, 9.0, 0.0], now.turn)
    assert not found.shape(elsewhere) and not found.whole


def wait_for(condition: object, seconds: float = 10.0) -> None:
    """Until a condition holds."""
    assert callable(condition)
    end = time.monotonic() + seconds
    while not condition():
        assert time.monotonic() < end, "it did not happen"
        time.sleep(0.02)


def test_a_file_is_read_again_and_a_mistake_leaves_the_last_good_network(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "snap.toml"
    path.write_text(SNAP)
    with Session(pennate.load(path), path, port=8490) as page:
        page.settle()
        before = page.probes()["down"].value
        path.write_text(SNAP.replace('section = "strip"', 'section = "strap"', 1))
        wait_for(lambda: page.panel.mistake.visible)
        assert "snap.toml:17" in page.panel.mistake.content and "strap" in page.panel.mistake.content
        # It can still be moved.
        page.set(F=40).settle()
        assert before < page.probes()["down"].value < 0
        path.write_text(SNAP.replace("rise = 10", "rise = 12"))
        wait_for(lambda: not page.panel.mistake.visible)
        page.settle()
        exact = pennate.load(path).solve()
        assert page.probes()["down"].value == pytest.approx(float(exact["down"][0]), abs=1e-6)
        # Colours have the units of the file as it is now.
        assert page.panel.shown_field.unit == "N" and page.display.fields["displacement"].unit == "mm"
        path.write_text(SNAP.replace('format = "pennate/1"', 'format = "pennate/1"\nunits = "m-N-Pa"'))
        wait_for(lambda: page.network.units == "m-N-Pa")
        page.settle()
        assert page.display.fields["displacement"].unit == "m" and page.panel.fields is page.display.fields


def test_a_network_that_cannot_be_followed_is_solved_anew() -> None:
    """The file's own step ends at a bifurcation: the state before it is shown, and what the program says."""
    with pennate.loads(SNAP, F=1000).view(port=8500) as page:
        page.settle()
        assert "ends at a bifurcation" in page.panel.verdict.content
        assert page.probes()["down"].value == pytest.approx(-0.17, abs=1e-3)
        page.set(F=500).settle()
        assert "13.1" in page.panel.verdict.content


def test_the_network_file_is_saved_with_the_present_values_and_its_comments(tmp_path: pathlib.Path) -> None:
    path = tmp_path / "snap.toml"
    path.write_text(SNAP)
    with Session(pennate.load(path), path, port=8510) as page:
        page.set(F=40.5).settle()
        text, kind = save.network_file(page)
        assert kind == "toml" and "F = 40.5    # the push, N" in text and 'top = "= 2 * rise"' in text
        assert pennate.loads(text).parameters["F"] == 40.5


def test_a_stated_pressure_is_saved_where_it_stands() -> None:
    stated = pennate.load(pathlib.Path(__file__).parents[3] / "models/networks/dyad.toml")
    with stated.view(port=8520) as page:
        page.set(pressure_left_1=20).settle()
        text, kind = save.network_file(page)
        saved = pennate.loads(text).solve()
        assert kind == "json"
        np.testing.assert_allclose(float(saved["holding"][-1]), page.probes()["holding"].value, rtol=1e-6)


def test_the_page_begins_with_our_script_and_is_whole(page: Session) -> None:
    _, body, heads = ask(page, f"/{page.server.guard.key}/", **{"Accept-Encoding": "gzip"})
    assert int(heads["Content-Length"]) == len(body) and heads["Content-Encoding"] == "identity"
    begin = body.index(b"<head>") + len(b"<head>")
    assert body[begin:].startswith(b"<script>") and b"antialias: false" in body[begin : begin + 4000]


def test_a_network_without_members_has_a_page(loose: pennate.Network) -> None:
    with Session(loose, port=0) as page:
        page.settle()
        assert page.display.shown is not None and "Error" not in page.panel.verdict.content


def test_pieces_of_several_lines_end_where_sections_and_members_do(spiral: pennate.Solution) -> None:
    drawing = spiral.drawing()
    fine, coarse = shapes.tubes(drawing, 1), shapes.tubes(drawing, 1, shapes.runs(drawing, 4))
    assert len(coarse.start) < 0.4 * len(fine.start)
    for member in np.unique(fine.member):
        own, rough = fine.member == member, coarse.member == member
        np.testing.assert_array_equal(fine.start[own][0], coarse.start[rough][0])
        np.testing.assert_array_equal(fine.end[own][-1], coarse.end[rough][-1])
        np.testing.assert_array_equal(coarse.start[rough][1:], coarse.end[rough][:-1])
        # As long as before with each radius, but for what a chord of four lines is shorter.
        for radius in np.unique(fine.radius[own]):
            lengths = [
                np.linalg.norm(found.end - found.start, axis=1)[(found.member == member) & (found.radius == radius)].sum()
                for found in (fine, coarse)
            ]
            assert 0.97 * lengths[0] <= lengths[1] <= lengths[0] * (1 + 1e-12)


@pytest.mark.parametrize("mesh", [meshes.rod(9), meshes.cone(7), meshes.ball(6), meshes.ball(0)])
def test_meshes_are_closed_and_face_outwards(mesh: meshes.Mesh) -> None:
    points, faces = mesh
    places = np.unique(points.round(9), axis=0, return_inverse=True)[1].ravel()[faces]
    edges = [tuple(pair) for face in places.tolist() for pair in zip(face, face[1:] + face[:1], strict=True)]
    assert len(set(edges)) == len(edges) and all((b, a) in set(edges) for a, b in edges)
    a, b, c = (points[faces[:, corner]] for corner in range(3))
    assert np.einsum("ij,ij->", a, np.cross(b, c)) > 0


def test_the_page_knows_where_names_are(page: Session, dyad: pennate.Network) -> None:
    page.settle()
    page.display.name()
    text = re.search(r'data-pn-places="([^"]*)"', page.panel.places.content)
    assert text is not None and page.display.shown is not None
    found = {each["name"].split(":")[0]: each for each in json.loads(html.unescape(text[1]))}
    assert set(found) == {*dyad.members, *(f"node {name}" for name in dyad.nodes)}
    at = page.display.picture.scaled(shapes.places(page.display.shown[0])[: len(dyad.nodes)])
    for name, (first, last) in dyad.ends.items():
        points = np.array(found[name]["points"])
        for point, node in ((points[0], first), (points[-1], last)):
            np.testing.assert_allclose(point, at[dyad.nodes.index(node)], atol=2e-3)
        assert "tension" in found[name]["name"]


def test_a_shape_that_nobody_waits_for_any_longer_changes_nothing() -> None:
    found = follow.Follow(pennate.scene("stage", beta=32), ("beta",))
    assert found.shape(found.go({"beta": 32.0}))
    before = found.drawing
    assert found.shape(found.go({"beta": 30.0}), lambda: True) is None and found.drawing is before
