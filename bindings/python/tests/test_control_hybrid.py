"""A policy and Gauss-Newton together are better than both, and feedback takes the bias of an arm out."""

from __future__ import annotations

import numpy as np
import pytest

from pennate import control
from pennate.control import Policy, Servo, br2, hybrid, reach
from pennate.control._bench import Bench, bench
from pennate.control._judge import setting
from pennate.control.trials import edges, half, pairs, whole
from pennate.control.trials.paths import TABLE_12, curve, fresh


@pytest.mark.parametrize("load", [0, 9, 18])
def test_the_hybrid_reaches_999_of_1000_in_fewer_moves_than_either(load: int) -> None:
    starts, targets = pairs.pairs(load, 1000, 3)
    model, policy = half(0), Policy.kept("dqn")
    both = hybrid(half(load), targets, policy, start=starts, model=model, tolerance=10.0)
    plain = reach(half(load), targets, start=starts, model=model, tolerance=10.0)
    assert np.mean(both.error <= 15.0) >= 0.999
    assert both.moves.mean() < 0.85 * plain.moves.mean()


@pytest.mark.parametrize("load", [0, 6])
def test_with_three_inputs_the_hybrid_makes_fewer_moves_than_the_policy_and_all_of_them_end_well(load: int) -> None:
    arm, policy = whole(load), Policy.kept("ddpg")
    rng = np.random.default_rng(4)
    starts, ends = (arm.lower + rng.random((500, 3)) * (arm.upper - arm.lower) for _ in range(2))
    targets = arm.tip(ends)
    given = {"start": starts, "model": whole(0), "tolerance": 15.0, "largest": br2.LARGEST}
    both = hybrid(arm, targets, policy, **given)
    _, actions, rules = setting("continuous")
    alone = control.follow(policy, arm, starts, targets, actions=actions, rules=rules)
    assert both.reached.all() and both.moves.mean() < alone.moves.mean() < reach(arm, targets, **given).moves.mean()


def test_the_hybrid_goes_through_the_gap_behind_the_arm() -> None:
    starts, targets = edges.crossings(60, 3)
    found = hybrid(whole(0), targets, Policy.kept("ddpg"), start=starts, tolerance=15.0, largest=br2.LARGEST)
    assert found.reached.all() and found.moves.mean() < 4


def test_no_move_of_the_hybrid_is_too_large_and_its_moves_are_counted() -> None:
    arm, asked = whole(0), []

    class Watched:
        names, lower, upper = arm.names, arm.lower, arm.upper

        def tip(self, inputs: control._arms.Array) -> control._arms.Array:
            asked.append(inputs.copy())
            return arm.tip(inputs)

        def jacobian(self, inputs: control._arms.Array) -> tuple[control._arms.Array, control._arms.Array]:
            raise AssertionError("the arm's own derivatives are not known")

    target = arm.tip(np.array([[150.0, -150.0, 50.0]]))[0]
    start = np.array([20.0, 100.0, -50.0])
    found = hybrid(Watched(), target, None, start=start, model=arm, tolerance=5.0, largest=br2.LARGEST)
    way = np.concatenate(asked)
    moved = np.abs(np.diff(way, axis=0))
    assert found.reached and (moved <= np.array(br2.LARGEST) + 1e-9).all()
    assert found.moves == (moved.max(axis=1) > 0).sum() >= 4


@pytest.mark.parametrize(("worse", "allowed"), [(1.0, 5.0), (1.5, 13.0)])
def test_feedback_with_integral_action_brings_a_biased_arm_to_its_waypoints(worse: float, allowed: float) -> None:
    for name in TABLE_12:
        errors, moves = _served(fresh(bench(9, worse)), curve(name, 10))
        assert np.mean(errors) < allowed and moves < 10


def test_feedback_follows_a_target_that_moves() -> None:
    arm = fresh(bench(0))
    inputs = np.array([br2.BENDING / 2, 0.0, 0.0])
    servo, tip, errors = Servo(whole(0), inputs, tolerance=2.0, restarts=0), arm.tip(inputs[None])[0], []
    for target in curve("circle", 120)[:50]:
        tip = arm.tip(servo.step(tip, target)[None])[0]
        errors.append(np.linalg.norm(tip - target))
    # Waypoints are 2 mm apart; without feedback the arm is 37 mm off.
    assert np.mean(errors[10:]) < 4.0


def test_integration_does_not_wind_up_at_a_limit() -> None:
    arm = half(0)
    servo = Servo(arm, [100.0, 50.0])
    tip = arm.tip(servo.inputs[None])[0]
    for _ in range(10):
        tip = arm.tip(servo.step(tip, [300.0, 0.0, -100.0])[None])[0]
    assert servo.offset is not None and np.abs(servo.offset).max() < 1e-9
    back = arm.tip(np.array([[90.0, 60.0]]))[0]
    for _ in range(3):
        tip = arm.tip(servo.step(tip, back)[None])[0]
    assert np.linalg.norm(tip - back) < 1.0
    with pytest.raises(ValueError, match="gain: more than 0"):
        Servo(arm, [0.0, 0.0], gain=0.0)


def test_a_servo_refuses_what_it_cannot_go_by() -> None:
    model = br2.table(0)
    for wrong, message in (
        ({"tolerance": np.nan}, "tolerance: a length, 0 or more, expected, not nan"),
        ({"largest": (0.0, 1.0)}, "largest: changes above 0 expected, not 0 for Pb"),
        ({"restarts": -1}, "restarts: a whole number, 0 or more, expected"),
        ({"gain": 2.0}, "gain: more than 0 and at most 1 expected"),
    ):
        with pytest.raises(ValueError, match=message):
            control.Servo(model, (100.0, 100.0), **wrong)  # type: ignore[arg-type]


def _served(arm: Bench, points: control._arms.Array) -> tuple[list[float], float]:
    """Errors at waypoints, each to 3 mm or at most 15 moves, and the mean of the moves."""
    inputs = np.array([br2.BENDING / 2, 0.0, 0.0])
    servo, tip, errors, moves = Servo(whole(0), inputs, tolerance=3.0), arm.tip(inputs[None])[0], [], 0
    for point in points:
        for _ in range(15):
            if np.linalg.norm(tip - point) <= 3.0:
                break
            tip, moves = arm.tip(servo.step(tip, point)[None])[0], moves + 1
        errors.append(float(np.linalg.norm(tip - point)))
    return errors, moves / len(points)
