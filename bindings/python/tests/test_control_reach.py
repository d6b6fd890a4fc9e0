"""Tips come to their targets, by derivatives of a model, within limits, and as near as they can be brought."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

import pennate
from pennate import control
from pennate.control import br2, reach
from pennate.control._arms import differences

Array = npt.NDArray[np.float64]


class Turned:
    """A tip on a curve through space: the distance to a target has two minima along it."""

    names = ("a",)
    lower, upper = np.array([-1.0]), np.array([1.0])

    def tip(self, inputs: Array) -> Array:
        a = inputs[:, 0]
        return np.stack([100 * (a**2 + 0.3 * a), 0 * a, 0 * a], axis=1)

    def jacobian(self, inputs: Array) -> tuple[Array, Array]:
        a = inputs[:, 0]
        return self.tip(inputs), np.stack([100 * (2 * a + 0.3), 0 * a, 0 * a], axis=1)[:, :, None]


@pytest.fixture(scope="module")
def inputs() -> Array:
    """Random pressures of half the workspace, kPa."""
    return np.random.default_rng(7).random((60, 2)) * [br2.BENDING, br2.ROTATING]


def test_the_table_of_the_arm_gives_what_solves_give(inputs: Array) -> None:
    # 0.2 mm are asked for; splines on the lattice of 0.5 and 1 psi leave a few thousandths.
    for load in (0.0, 12.0):
        away = inputs + [0.0, 0.05] * (br2.ROTATING - inputs)
        error = np.linalg.norm(br2.table(load).tip(away) - br2.solved(load).tip(away), axis=1)
        assert error.max() < 5e-3, load


def test_derivatives_of_table_and_solves_agree(inputs: Array) -> None:
    table, solved = br2.table(0), br2.solved(0)
    tips, slopes = table.jacobian(inputs)
    assert np.array_equal(tips, table.tip(inputs))
    some = solved.jacobian(inputs[:4])[1]
    assert np.abs(some - slopes[:4]).max() < 1e-4 * np.abs(slopes).max()
    assert np.abs(differences(table, inputs, tips) - slopes).max() < 1e-3 * np.abs(slopes).max()


def test_a_table_keeps_the_kink_where_one_actuator_takes_over_from_the_other() -> None:
    table = br2.table(0, both=True)
    beside = np.array([[124.1, -1e-9], [124.1, 1e-9]])
    tips, slopes = table.jacobian(beside)
    assert np.abs(tips[0] - tips[1]).max() < 1e-6
    mirrored = slopes[0, :, 1] * [-1, 1, -1]
    assert np.abs(mirrored - slopes[1, :, 1]).max() < 1e-6 and abs(slopes[1, 0, 1]) > 1e-3


def test_derivatives_by_the_swivel_are_those_of_the_turned_tip() -> None:
    arm = br2.table(0, swivel=True)
    at = np.array([[100.0, 50.0, 20.0], [60.0, 150.0, -45.0]])
    tips, slopes = arm.jacobian(at)
    assert np.abs(differences(arm, at, tips) - slopes).max() < 5e-3


def test_a_swivelled_table_is_the_network_with_its_base_turned() -> None:
    arm = br2.table(6, swivel=True)
    problem = pennate.scene("br2", load=6).problem(parameters=["Pb", "Pr", "swivel"], probes=["x", "y", "z"])
    at = np.array([[100.0, 50.0, 20.0], [60.0, 150.0, -45.0]])
    assert np.abs(arm.tip(at) - problem(at)).max() < 5e-3


def test_what_is_reported_of_the_way_is_true() -> None:
    arm = br2.table(0)
    target = arm.tip(np.array([[80.0, 90.0]]))[0]
    found = reach(arm, target, tolerance=0.5)
    assert np.array_equal(arm.tip(found.inputs[None])[0], found.tip)
    assert found.error == np.linalg.norm(found.tip - target) and found.reached == (found.error <= 0.5)
    assert reach(arm, target, start=found.inputs, tolerance=0.5).moves == 0


def test_a_way_that_ends_at_the_wrong_minimum_begins_anew_where_the_model_finds_a_better_one() -> None:
    arm = Turned()
    stuck = reach(arm, [80.0, 0.0, 0.0], start=[-0.9], restarts=0)
    assert not stuck.reached and stuck.inputs == [-1.0] and stuck.error == pytest.approx(10.0)
    cured = reach(arm, [80.0, 0.0, 0.0], start=[-0.9])
    assert cured.reached and cured.restarts == 1 and cured.inputs[0] > 0.7


def test_no_move_leaves_the_limits_or_is_too_large() -> None:
    arm, asked = br2.table(0), []

    class Watched:
        names, lower, upper = arm.names, arm.lower, arm.upper

        def tip(self, inputs: Array) -> Array:
            asked.append(inputs.copy())
            return arm.tip(inputs)

        def jacobian(self, inputs: Array) -> tuple[Array, Array]:
            return arm.jacobian(inputs)

    largest = np.array([31.2, 96.5])
    outside = 1.3 * arm.tip(np.array([[172.0, 190.0]]))[0]
    reach(Watched(), outside, start=[20.0, 10.0], model=arm, largest=largest, restarts=0)
    way = np.concatenate(asked)
    assert ((way >= arm.lower) & (way <= arm.upper)).all()
    assert (np.abs(np.diff(way[:5], axis=0)) <= largest + 1e-9).all() and len(way) > 5


def test_a_live_state_is_moved_by_derivatives_of_its_problem() -> None:
    network = pennate.scene("br2", load=6)
    live = network.problem(parameters=["Pb", "Pr"], probes=["x", "y", "z"]).live()
    target = br2.table(6).tip(np.array([[80.0, 90.0]]))[0]
    found = reach(live, target, inputs=br2.HALF, tolerance=0.1)
    assert found.reached and live.present["Pb"] == found.inputs[0]
    assert np.linalg.norm([live["x"], live["y"], live["z"]] - target) == pytest.approx(found.error, abs=1e-6)


def test_what_is_wrong_is_said() -> None:
    arm = br2.table(0)
    for wrong, message in (
        ({"moves": "15"}, "moves: a whole number expected, not '15'"),
        ({"tolerance": "1"}, "tolerance: a length expected, not '1'"),
    ):
        with pytest.raises(TypeError, match=message):
            reach(Turned(), [0, 0, 0], **wrong)  # type: ignore[arg-type]
    with pytest.raises(TypeError, match="an arm, or a live state of a problem, expected, not 3"):
        reach(3, [0, 0, 0])  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="target: numbers expected"):
        reach(Turned(), np.array([0, 0, 1j]))
    for pair, error in ((5.0, ValueError), (("5", "9"), TypeError)):
        with pytest.raises(error, match="the limits of 'beta'.* two finite numbers expected"):
            control.Solved(pennate.scene("dyad"), {"beta": pair}, tip=("x", "y", "z"))  # type: ignore[dict-item]
    with pytest.raises(ValueError, match=r"target has the shape \(2,\)"):
        reach(arm, [1.0, 2.0])
    with pytest.raises(ValueError, match="are given with a live state alone"):
        reach(arm, [1.0, 2.0, 3.0], inputs=br2.HALF)
    with pytest.raises(ValueError, match="limits of 'Pb' are 5 and 5"):
        control.Solved(pennate.scene("br2"), {"Pb": (5, 5)})
    with pytest.raises(ValueError, match="not between its limits"):
        control.Table(arm, (10, 10), ((), (200.0,)))


class Wall:
    """A plane table that has no equilibrium beyond half of its first input."""

    names = ("a", "b")
    lower, upper = np.zeros(2), np.ones(2)

    def tip(self, inputs: Array) -> Array:
        tips = np.stack([10 * inputs[:, 0], 10 * inputs[:, 1], 0 * inputs[:, 0]], axis=1)
        tips[inputs[:, 0] > 0.5] = np.nan
        return tips

    def jacobian(self, inputs: Array) -> tuple[Array, Array]:
        return self.tip(inputs), np.tile(np.array([[10.0, 0.0], [0.0, 10.0], [0.0, 0.0]]), (len(inputs), 1, 1))


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"largest": [0.0, 0.0]}, "largest: changes above 0 expected, not 0 for a"),
        ({"largest": [1.0, np.nan]}, "largest: changes above 0 expected, not nan for b"),
        ({"largest": [-1.0, 1.0]}, "largest: changes above 0 expected, not -1 for a"),
        ({"largest": [1.0]}, r"largest has the shape \(1,\): \(2,\) expected, for a, b"),
        ({"tolerance": np.nan}, "tolerance: a length, 0 or more, expected, not nan"),
        ({"tolerance": -1.0}, "tolerance: a length, 0 or more, expected, not -1"),
        ({"start": [1000.0, 0.5]}, "start: a = 1000 is beyond its limits, 0 to 1"),
        ({"start": [[0.1, 0.1], [0.2, 0.2]]}, "start: one row, or 1, one for each target, expected, not 2"),
        ({"moves": -1}, "moves: a whole number, 0 or more, expected, not -1"),
    ],
)
def test_what_cannot_be_gone_by_is_refused_before_anything_moves(wrong: dict[str, Any], message: str) -> None:
    asked: dict[str, Any] = {"start": [0.1, 0.1], **wrong}
    with pytest.raises(ValueError, match=message):
        reach(Wall(), [3.0, 3.0, 0.0], **asked)
    with pytest.raises(ValueError, match=message):
        control.hybrid(Wall(), [3.0, 3.0, 0.0], None, **asked)


def test_a_start_without_an_equilibrium_begins_anew_where_there_is_one() -> None:
    targets, starts = np.array([[3.0, 3.0, 0.0], [2.0, 4.0, 0.0]]), np.array([[0.9, 0.1], [0.2, 0.1]])
    found = reach(Wall(), targets, start=starts)
    assert found.reached.all() and found.restarts.tolist() == [1, 0]
    alone = reach(Wall(), targets, start=starts, restarts=0)
    assert alone.reached.tolist() == [False, True] and np.isinf(alone.error[0])
    assert control.hybrid(Wall(), targets, None, start=starts).reached.all()


def test_an_arm_that_buckles_leans_to_the_side_of_its_actuator_live_and_in_its_table() -> None:
    # Solved for by themselves, such states end on either side, 10 cm apart.
    arm, table = br2.solved(18), br2.table(18)
    rng = np.random.default_rng(2)
    beside = np.column_stack([rng.uniform(145, 172, 40), rng.uniform(0, 6, 40)])
    tips = arm.tip(beside)
    assert (tips[:, 1] < 0).all() and tips[:, 1].min() < -50
    assert np.linalg.norm(table.tip(beside) - tips, axis=1).max() < 1.0
    mirrored = br2.solved(18, both=True).tip(beside[:5] * [1, -1])
    assert np.abs(mirrored * [1, -1, 1] - tips[:5]).max() < 1e-3
    # The arm leans to the side of its actuator even without pressure in it.
    bare = np.array([[172.36, 0.0]])
    assert arm.tip(bare)[0, 1] < -50 and np.linalg.norm(table.tip(bare) - arm.tip(bare)) < 1e-3


@pytest.mark.parametrize("load", [18.0, 22.0, 30.0, 60.0])
def test_an_arm_leans_to_the_side_of_the_first_actuator_with_any_load(load: float) -> None:
    bending = np.linspace(0.0, br2.BENDING, 40)
    bare, least, little = (np.stack([bending, 0 * bending + Pr], axis=1) for Pr in (0.0, 0.01, 0.02))
    arm = br2.solved(load, both=True)
    tips = arm.tip(bare)
    assert tips[:, 1].max() < 0.05 and tips[:, 1].min() < -1.0
    assert np.abs(tips - arm.tip(least)).max() < 1e-6
    # It does not come back from the other side where there is a little pressure.
    assert arm.tip(little)[:, 1].max() < 0.05
    assert np.abs(arm.tip(little * [1, -1]) * [1, -1, 1] - arm.tip(little)).max() < 1e-3


def test_a_table_has_its_further_points_where_the_arm_with_its_load_buckles() -> None:
    arm, table = br2.solved(25), br2.table(25)
    rng = np.random.default_rng(3)
    beside = np.column_stack([rng.uniform(110, 130, 60), rng.uniform(0, 1, 60)])
    assert np.linalg.norm(table.tip(beside) - arm.tip(beside), axis=1).max() < 0.3
    bare = np.array([[120.0, 0.0], [124.1, 0.0], [150.0, 0.0]])
    assert np.linalg.norm(table.tip(bare) - arm.tip(bare), axis=1).max() < 0.3


def test_a_table_keeps_a_jump_and_has_further_points() -> None:
    class Jump:
        names = ("a",)
        lower, upper = np.array([-1.0]), np.array([1.0])

        def tip(self, inputs: Array) -> Array:
            a = inputs[:, 0]
            return np.stack([np.where(a < 0, -5.0, 5.0) + a**3, np.cbrt(a - 0.5), 0 * a], axis=1)

        def jacobian(self, inputs: Array) -> tuple[Array, Array]:
            raise NotImplementedError

    at = np.array([[-1e-3], [1e-3]])
    made = control.Table(Jump(), [9], [[0.0]])
    assert np.abs(made.tip(at)[:, 0] - [-5, 5]).max() < 1e-5
    finer = control.Table(Jump(), [9], [[0.0]], [[0.4, 0.45, 0.55, 0.6]])
    near = np.linspace(0.4, 0.6, 41)[:, None]
    error = [np.abs(each.tip(near) - Jump().tip(near)).max() for each in (made, finer)]
    assert error[1] < 0.7 * error[0]
