"""Environments keep to the rules of Gymnasium and of the text, and give the same digits alone and side by side."""

from __future__ import annotations

import subprocess
import sys
from typing import Any

import numpy as np
import pytest

import pennate
from pennate import control
from pennate.control import br2

gymnasium = pytest.importorskip("gymnasium")
NAMES = ("pennate/BR2-discrete-v0", "pennate/BR2-continuous-v0")


@pytest.mark.parametrize("source", ["live", "table"])
@pytest.mark.parametrize("name", NAMES)
def test_environments_pass_the_checker(name: str, source: str) -> None:
    from gymnasium.utils.env_checker import check_env

    check_env(gymnasium.make(name, source=source, render_mode="rgb_array").unwrapped)


@pytest.mark.parametrize("source", ["live", "table"])
@pytest.mark.parametrize("name", NAMES)
def test_seeds_give_the_same_digits_alone_and_side_by_side(name: str, source: str) -> None:
    many = gymnasium.make_vec(name, num_envs=5, source=source, vectorization_mode="vector_entry_point")
    many.action_space.seed(3)
    actions = [many.action_space.sample() for _ in range(8)]
    seen, _ = many.reset(seed=11)
    history = [many.step(action) for action in actions]
    many.reset(seed=11)
    for step, again in zip(history, [many.step(action) for action in actions]):
        assert all(np.array_equal(a, b) for a, b in zip(step[:4], again[:4]))
    for place in range(5):
        alone = gymnasium.make(name, source=source)
        assert np.array_equal(alone.reset(seed=11 + place)[0], seen[place])
        for action, (next_seen, reward, ended, cut, info) in zip(actions, history):
            step = alone.step(action[place])
            assert np.array_equal(step[0], next_seen[place]) and step[1:4] == (reward[place], ended[place], cut[place])
            assert np.array_equal(step[4]["tip"], info["tip"][place])
            if step[2] or step[3]:
                break


def test_live_and_table_are_one_arm() -> None:
    live, table = (gymnasium.make(NAMES[1], source=source) for source in ("live", "table"))
    start = {"start": [80.0, 50.0, 10.0], "target": [100.0, -50.0, -250.0]}
    for environment in (live, table):
        environment.reset(seed=0, options=start)
    for action in ([0.5, 0.5, 0.2], [-0.2, -0.9, 0.1]):
        a, b = (environment.step(np.array(action, dtype=np.float32)) for environment in (live, table))
        assert np.abs(a[4]["tip"] - b[4]["tip"]).max() < 5e-3 and abs(a[1] - b[1]) < 1e-2


def discrete(**options: Any) -> Any:
    environment = gymnasium.make(NAMES[0], source="table").unwrapped
    environment.reset(seed=0, options=options)
    return environment


def test_rewards_are_those_of_the_text() -> None:
    target = [10.0, 0.0, -240.0]
    environment = discrete(start=[86.18, 96.525], target=target)
    arm = environment.arm
    levels = np.array([br2.BENDING / 50, br2.ROTATING / 28])
    before = np.linalg.norm(arm.tip(np.array([[25, 14]]) * levels)[0] - target)
    # Action 0 is one level of bending pressure up, action 11 four of rotating pressure down.
    for action, place in ((0, [26, 14]), (11, [26, 10])):
        _, reward, ended, cut, info = environment.step(action)
        after = np.linalg.norm(arm.tip(np.array([place]) * levels)[0] - target)
        assert reward == pytest.approx(-2 + (before - after) / 10, abs=1e-12) and not ended and not cut
        assert np.allclose(info["inputs"], place * levels, rtol=0, atol=1e-10) and info["error"] == pytest.approx(after)
        before = after


def test_an_episode_ends_beyond_the_limits_and_at_the_target() -> None:
    environment = discrete(start=[br2.BENDING, 0.0], target=[10.0, 0.0, -240.0])
    assert environment.step(0)[1:4] == (-100.0, True, False)
    mask = environment._info()["action_mask"]
    assert mask[[0, 2, 4]].sum() == 0 and mask[[1, 3, 5]].all() and mask[6] == 1 and mask[7] == 0
    there = br2.table(0).tip(np.array([[br2.BENDING * 0.5, 0.0]]))[0]
    environment = discrete(start=[br2.BENDING * 0.52, 0.0], target=there)
    _, reward, ended, _, info = environment.step(1)
    assert reward == 100.0 and ended and info["is_success"]


def test_a_continuous_action_beyond_the_limits_pays_its_error() -> None:
    environment = gymnasium.make(NAMES[1], source="table").unwrapped
    environment.reset(seed=0, options={"start": [br2.BENDING, 0.0, 0.0], "target": [10.0, 0.0, -240.0]})
    _, reward, ended, _, info = environment.step(np.array([1.0, 0.0, 0.0], dtype=np.float32))
    assert ended and reward == pytest.approx(-2 - info["error"] / 10)
    # A sum of small steps ends as a failure after 15 moves, which pays the same.
    environment.reset(seed=0, options={"start": [br2.BENDING / 2, 0.0, 0.0], "target": [0.0, 0.0, 200.0]})
    for move in range(15):
        _, reward, ended, cut, info = environment.step(np.zeros(3, dtype=np.float32))
        assert ended == (move == 14) and not cut
    assert reward == pytest.approx(-2 - info["error"] / 10)


def test_too_many_moves_truncate_where_that_is_asked_for() -> None:
    environment = gymnasium.make(NAMES[0], source="table", truncate=True, steps=2).unwrapped
    environment.reset(seed=0, options={"start": [80.0, 80.0], "target": [0.0, 0.0, 200.0]})
    assert environment.step(0)[2:4] == (False, False) and environment.step(1)[2:4] == (False, True)


@pytest.mark.parametrize("mode", ["NextStep", "SameStep", "Disabled"])
def test_episodes_side_by_side_begin_anew_as_asked(mode: str) -> None:
    many = gymnasium.make_vec(
        NAMES[0], num_envs=2, source="table", vectorization_mode="vector_entry_point", autoreset_mode=mode
    )
    many.reset(seed=0, options={"start": [br2.BENDING, 96.525], "target": [10.0, 0.0, -240.0]})
    # The first arm leaves its limits, the second one does not.
    seen, _, ended, _, info = many.step([0, 1])
    assert ended.tolist() == [True, False]
    first = info["inputs"][0]
    if mode == "SameStep":
        assert info["final_info"]["inputs"][0][0] == br2.BENDING and not np.array_equal(info["final_obs"][0], seen[0])
    else:
        assert first[0] == br2.BENDING
    if mode == "Disabled":
        seen, info = many.reset(options={"reset_mask": np.array([True, False])})
        assert info["inputs"][0].tolist() != first.tolist() and info["inputs"][1][0] < br2.BENDING
    if mode == "NextStep":
        _, reward, ended, _, info = many.step([0, 1])
        assert reward[0] == 0 and not ended[0] and info["inputs"][0].tolist() != first.tolist()


def test_any_network_can_be_an_environment() -> None:
    network = pennate.loads(BEAM)
    environment = control.Env(
        network,
        {"down": (0.0, 1.0)},
        actions=control.Levels((11,), (1, 3)),
        rules=control.Rules(tolerance=1.0, steps=10, success=1.0),
        render_mode="rgb_array",
    )
    environment.reset(seed=0, options={"start": [0.2], "target": [100.0, 0.0, 0.0]})
    assert environment.action_space.n == 4
    _, reward, *_ = environment.step(1)
    assert reward > -2.0
    picture = environment.render()
    assert picture.shape == (480, 960, 3) and picture.dtype == np.uint8 and len(np.unique(picture)) > 10
    environment.step(0), environment.step(0)
    assert not np.array_equal(environment.render(), picture)


@pytest.mark.parametrize("table", [None, (11,)])
@pytest.mark.parametrize("actions", [control.Levels((11,), (1, 3)), control.Changes((0.3,))])
def test_environments_of_any_network_pass_the_checker(
    actions: control.Levels | control.Changes, table: tuple[int, ...] | None
) -> None:
    from gymnasium.utils.env_checker import check_env

    rules = control.Rules(tolerance=1.0, steps=10, success=1.0)
    given = {"actions": actions, "rules": rules, "table": table, "length": 120.0}
    # Other modes of rendering are tried where an environment was registered.
    check_env(control.Env(pennate.loads(BEAM), {"down": (0.0, 1.0)}, **given), skip_render_check=True)


@pytest.mark.parametrize("side_by_side", [False, True])
def test_actions_that_are_none_are_refused(side_by_side: bool) -> None:
    given = {"num_envs": 2, "vectorization_mode": "vector_entry_point"} if side_by_side else {}
    make = gymnasium.make_vec if side_by_side else gymnasium.make
    environments = [make(name, source="table", **given) for name in NAMES]
    for environment in environments:
        environment.reset(seed=0)
    wrap = (lambda action: np.array([action] * 2)) if side_by_side else np.array
    for bad, said in ((12, "no action 12: whole numbers from 0 to 11"), (-1, "no action -1"), (np.nan, "no action nan")):
        with pytest.raises(ValueError, match=said):
            environments[0].step(wrap(bad))
    for action, said in (([0.0, np.nan, 0.0], "the action for Pr is nan"), ([0.0, 0.0], "numbers from -1 to 1 for Pb")):
        with pytest.raises(ValueError, match=said):
            environments[1].step(wrap(action))
    with pytest.raises(ValueError, match=r"target is \(0, nan, 0\): finite numbers"):
        environments[0].reset(options={"target": [0.0, np.nan, 0.0]})
    with pytest.raises(ValueError, match="start: Pb = 200 is beyond its limits, 0 to 172.36"):
        environments[0].reset(options={"start": [200.0, 0.0]})
    with pytest.raises(ValueError, match="farther away than twice"):
        environments[0].reset(options={"target": [1e6, 0.0, 0.0]})


def test_tubes_are_seen_where_a_section_has_no_radius() -> None:
    pytest.importorskip("pyvista")
    # In a process of its own, as pyvista ends it where there is no graphics library.
    done = subprocess.run([sys.executable, "-c", TUBES], capture_output=True, text=True)
    if done.returncode < 0:
        pytest.skip("no graphics library")
    assert done.returncode == 0, done.stderr
    assert float(done.stdout) > 0.01


def test_what_is_wrong_is_said() -> None:
    with pytest.raises(ValueError, match="parameters of the network that are inputs"):
        control.Env(pennate.loads(BEAM), actions=control.Levels((5,)), rules=br2.DISCRETE)
    with pytest.raises(ValueError, match=r"1 inputs \(down\), but the actions have 2"):
        control.Env(pennate.loads(BEAM), {"down": (0, 1)}, actions=control.Levels((5, 5)), rules=br2.DISCRETE)
    with pytest.raises(ValueError, match="'live' or 'table' expected"):
        gymnasium.make(NAMES[0], source="guess")
    with pytest.raises(ValueError, match="no setting 'lod'; there are load, source, tolerance"):
        gymnasium.make(NAMES[0], lod=6)
    for load in (np.nan, -1.0, "heavy"):
        with pytest.raises(ValueError, match="a number of grams, 0 or more"):
            gymnasium.make(NAMES[0], load=load)


@pytest.mark.parametrize(
    ("wrong", "error", "message"),
    [
        ({"tolerance": -1.0}, ValueError, "tolerance: a length, 0 or more, expected, not -1"),
        ({"success": np.inf}, ValueError, "success: a length, 0 or more, expected, not inf"),
        ({"steps": 0}, ValueError, "steps: one move or more expected, not 0"),
        ({"steps": 4.5}, TypeError, "steps: a whole number expected, not 4.5"),
        ({"unit": np.nan}, ValueError, "unit: a length, 0 or more, expected, not nan"),
        ({"unit": "1 mm"}, TypeError, "unit: a length expected, not '1 mm'"),
        ({"scale": 0}, ValueError, "scale: a length above 0 expected, not 0"),
        ({"rounding": -1.0}, ValueError, "rounding: a length, 0 or more, expected, not -1"),
        ({"prize": np.nan}, ValueError, "prize: a finite number expected, not nan"),
        ({"fine": "much"}, TypeError, "fine: a number expected, not 'much'"),
        ({"late": 3}, TypeError, "late: True or False expected, not 3"),
    ],
)
def test_rules_that_are_none_are_refused(wrong: dict[str, Any], error: type[Exception], message: str) -> None:
    with pytest.raises(error, match=message):
        control.Rules(**{"tolerance": 1.0, "steps": 10, "success": 1.0, **wrong})
    with pytest.raises(error, match=message):
        gymnasium.make(NAMES[0], **wrong)


def test_arms_side_by_side_are_one_at_least_and_begin_before_they_move() -> None:
    for count, error in ((0, ValueError), (-1, ValueError), ("2", TypeError)):
        with pytest.raises(error, match="num_envs: a whole number, one or more, expected"):
            control.VectorEnv(count, **br2.environment("discrete"))  # type: ignore[arg-type]
    many = control.VectorEnv(2, **br2.environment("discrete"))
    with pytest.raises(gymnasium.error.ResetNeeded, match=r"call reset\(\) before step\(\)"):
        many.step([0, 0])
    many.reset(seed=0, options={"reset_mask": np.array([True, False])})
    with pytest.raises(gymnasium.error.ResetNeeded):
        many.step([0, 0])
    many.reset(seed=0)
    many.step([0, 0])
    one = control.Env(**br2.environment("discrete"))
    with pytest.raises(gymnasium.error.ResetNeeded, match=r"call reset\(\) before step\(\)"):
        one.step(0)
    one.reset(seed=0)
    one.step(0)


# The share of pixels that are neither white nor red.
TUBES = """
import gymnasium, pennate.control
environment = gymnasium.make("pennate/BR2-discrete-v0", render_mode="rgb_array", painter="pyvista")
environment.reset(seed=0)
picture = environment.render().astype(int)
print(((picture[..., 0] < 230) & (abs(picture[..., 0] - picture[..., 2]) < 40)).mean())
"""

BEAM = """\
format = "pennate/1"
dimension = "space"
parameters = { down = 0.5 }
nodes = { A = [0, 0, 0], B = [100, 0, 0] }
materials.steel = { youngs_modulus = 200000, poissons_ratio = 0.3 }
sections.wire = { circle = { radius = 0.75 } }
members.wire = { nodes = ["A", "B"], section = "wire", material = "steel" }
supports = { A = "clamped" }
probes.x = { node = "B", position = "x" }
probes.y = { node = "B", position = "y" }
probes.z = { node = "B", position = "z" }
[[steps]]
name = "press"
force = { B = [0, 0, "= -down"] }
"""
