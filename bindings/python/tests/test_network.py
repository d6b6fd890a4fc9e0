"""Networks are read, changed and asked as the program reads them."""

from __future__ import annotations

import inspect
import pathlib
import pickle
import sys
from collections.abc import Callable

import numpy as np
import pytest

import pennate
from conftest import DYAD


def test_a_network_says_what_it_is(dyad: pennate.Network) -> None:
    assert repr(dyad) == (
        "<Network 'pennate dyad': 3 nodes, 2 muscles, plane, parameters L=130 beta=22 pressure=25>"
    )
    assert (dyad.nodes, dyad.muscles, dyad.steps) == (("A", "B", "J"), ("left", "right"), ("inflate", "push back"))
    assert dyad.probes == {"stroke": "mm", "holding": "N"}
    assert dyad.ends["left"] == ("A", "J")
    np.testing.assert_allclose(dyad.lengths, 130.0)
    assert dyad.positions.shape == (3, 3)


def test_parameters_are_set_by_numbers_and_by_texts(tmp_path: pathlib.Path) -> None:
    file = tmp_path / "dyad.toml"
    file.write_text(DYAD)
    assert pennate.load(file, beta=30).parameters["beta"] == 30.0
    assert pennate.load(str(file), beta="0.5 rad").parameters["beta"] == pytest.approx(np.rad2deg(0.5))
    assert pennate.load(file, L=np.float32(100)).set(beta=10).parameters == {"L": 100, "beta": 10, "pressure": 25}


def test_a_dictionary_is_a_network_like_its_file(dyad: pennate.Network, solution: pennate.Solution) -> None:
    again = pennate.Network(dyad.to_dict())
    np.testing.assert_array_equal(again.solve().displacement, solution.displacement)
    np.testing.assert_array_equal(again.set(beta=30).solve()["stroke"], dyad.set(beta=30).solve()["stroke"])
    array = pennate.Network({**dyad.to_dict(), "nodes": {"A": np.array([-100.0, 0]), "B": (100, 0), "J": [0, 50]}})
    assert array.positions[0, 0] == -100.0


def test_an_edit_makes_another_network(dyad: pennate.Network) -> None:
    soft = dyad.edit(
        muscles={"soft": {**dyad.to_dict()["muscles"]["silicone"], "wall": 1.5}},
        members={"left": {"muscle": "soft"}},
        steps={"inflate": {"pressure": {"all": 20}}},
        probes={"holding": None},
    )
    assert dyad.to_dict()["members"]["left"]["muscle"] == "silicone" and "holding" in dyad.probes
    assert soft.to_dict()["members"]["left"] == {"nodes": ["A", "J"], "muscle": "soft"}
    assert list(soft.probes) == ["stroke"]
    assert soft.set(beta=30).parameters["beta"] == 30.0
    assert abs(soft.solve()["stroke@inflate"]) != abs(dyad.solve()["stroke@inflate"])
    with pytest.raises(KeyError, match="'deflate'"):
        dyad.edit(steps={"deflate": {}})
    with pytest.raises(pennate.NetworkError, match=r"(?s)'silicon', which is not defined.*dyad.toml \(edited\):"):
        dyad.edit(members={"left": {"muscle": "silicon"}})


def test_networks_are_values(dyad: pennate.Network) -> None:
    assert dyad == pennate.loads(DYAD, name="dyad.toml") != dyad.set(beta=23)
    assert len({dyad, pennate.loads(DYAD, name="dyad.toml"), dyad.set(beta=23)}) == 2
    assert pickle.loads(pickle.dumps(dyad.set(beta=23))) == dyad.set(beta=23)


def test_a_muscle_file_is_read_once_and_goes_with_the_network(tmp_path: pathlib.Path) -> None:
    table = DYAD.split("[muscles.silicone]\n")[1].split("\n\n[members]")[0]
    (tmp_path / "silicone.toml").write_text(table)
    file = tmp_path / "dyad.toml"
    file.write_text(DYAD.replace(f"[muscles.silicone]\n{table}", '[muscles]\nsilicone = { file = "silicone.toml" }\n'))
    network = pennate.load(file)
    before = network.solve()["stroke"]
    kept = pickle.dumps(network)
    (tmp_path / "silicone.toml").unlink()
    for same in (network, network.set(beta=22), network.edit(title="other"), pickle.loads(kept)):
        np.testing.assert_array_equal(same.solve()["stroke"], before)
    with pytest.raises(pennate.NetworkError, match="cannot be read"):
        pennate.load(file)


def test_scenes_are_networks() -> None:
    assert "chi" in pennate.scenes()["dyad"]
    assert pennate.scene("dyad", chi=30).solve().status == "converged"
    with pytest.raises(pennate.NetworkError, match="there is no scene 'dyat'"):
        pennate.scene("dyat")
    assert "nodes" in pennate.schema()["properties"]


def test_a_check_says_what_the_network_is(dyad: pennate.Network) -> None:
    assert str(dyad.check()).endswith("2 steps; ready to be solved")
    assert dyad.check().warnings == []


def test_a_mechanism_tells_its_motions(dyad: pennate.Network) -> None:
    alone = dyad.edit(
        members={"left": {"release": {"start": "pin"}}, "right": None},
        nodes={"B": None},
        supports={"A": "pinned", "B": None},
        steps=[],
        probes={"holding": None},
    )
    for ask in (alone.check, alone.solve, alone.modes, lambda: alone.problem(["beta"], ["stroke"])):
        with pytest.raises(pennate.MechanismError, match="the network is a mechanism: node J moves freely") as caught:
            ask()
        motion = caught.value.motions[0]
        assert (motion.node, motion.member, motion.turns, motion.nodes) == ("J", None, False, ["J"])
        across = [-np.sin(np.deg2rad(22)), np.cos(np.deg2rad(22)), 0.0]
        np.testing.assert_allclose(abs(motion.direction @ across), 1.0, rtol=1e-9)
        assert caught.value.errors[0].name == "J" and "moves freely" in str(motion)


def test_modes_and_factors(dyad: pennate.Network, strut: pennate.Network) -> None:
    modes = dyad.modes(3, step="inflate")
    assert modes.frequency.shape == (3,) and (np.diff(modes.frequency) >= 0).all()
    assert modes.shapes.shape == (3, 3, 6) and modes.nodes == ("A", "B", "J")
    factors = strut.buckle(2)
    # Euler's load of a clamped and free strut over the load of the step.
    euler = np.pi**2 / 4 * 200000 * np.pi / 4 * 0.75**4 / 100**2
    np.testing.assert_allclose(factors.factor[0], euler / 40, rtol=2e-4)
    assert "factors" in repr(factors) and "factor" in str(factors)
    with pytest.raises(pennate.NetworkError, match="has no step 'deflate'"):
        dyad.modes(step="deflate")


def test_a_notebook_shows_a_network_in_words_at_least(dyad: pennate.Network, monkeypatch: pytest.MonkeyPatch) -> None:
    assert dyad._repr_mimebundle_(include=None, exclude=None)["text/plain"] == repr(dyad)
    # Without the library that draws.
    monkeypatch.setitem(sys.modules, "pyvista", None)
    for name in [name for name in sys.modules if name.startswith("pennate.pictures")]:
        monkeypatch.delitem(sys.modules, name)
    assert dyad._repr_mimebundle_() == {"text/plain": repr(dyad)}


@pytest.mark.parametrize(
    ("wanted", "error", "message"),
    [
        (lambda _: pennate.loads(3), TypeError, "text: a text expected, not 3"),
        (lambda _: pennate.scene(3), TypeError, "scene: a text expected, not 3"),
        (lambda network: network.edit(3), TypeError, "changes: a dictionary expected, not 3"),
        (lambda network: network.set(beta=1j), TypeError, "parameter 'beta': a number or a text expected, not 1j"),
        (lambda network: network.set(beta=np.array([22.0])), TypeError, "parameter 'beta': a number or a text expected"),
        (lambda network: network.solve(threads="2"), TypeError, "threads: a whole number"),
        (lambda network: network.solve(accuracy=None), TypeError, "accuracy: a number between 0 and 1"),
        (lambda network: network.solve(progress=3), TypeError, "progress: something that can be called"),
        (lambda network: network.modes("3"), TypeError, "count: a whole number"),
        (lambda network: network.modes(step=1), TypeError, "step: a text expected, not 1"),
        (lambda network: network.buckle(along=1), TypeError, "along: a text expected, not 1"),
    ],
)
def test_arguments_are_checked(
    dyad: pennate.Network, wanted: Callable[[pennate.Network], object], error: type[Exception], message: str
) -> None:
    with pytest.raises(error, match=message):
        wanted(dyad)


def test_whatever_is_public_says_what_it_is() -> None:
    import pennate.control

    silent = []
    for module in (pennate, pennate.control):
        for name in module.__all__:
            try:
                thing = getattr(module, name)
            except ImportError:
                # What needs an extra.
                continue
            parts = {name: thing}
            if inspect.isclass(thing):
                parts |= {f"{name}.{part}": what for part, what in vars(thing).items() if not part.startswith("_")}
            asked = {name: what for name, what in parts.items() if callable(what) or isinstance(what, property)}
            silent += [f"{module.__name__}.{name}" for name, what in asked.items() if not inspect.getdoc(what)]
    assert silent == []


def test_there_is_no_attribute_to_change(dyad: pennate.Network) -> None:
    with pytest.raises(AttributeError):
        dyad.title = "other"  # type: ignore[misc]
    dyad.positions[:] = 0.0
    assert dyad.positions.any()
