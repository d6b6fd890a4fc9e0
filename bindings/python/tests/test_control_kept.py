"""The policies that come with the package score what their files say, by NumPy alone."""

from __future__ import annotations

import pathlib
from dataclasses import replace

import numpy as np
import pytest

from pennate.control import Policy, br2, follow, hybrid
from pennate.control import __main__, _policy
from pennate.control._judge import Judge, setting, setting_of
from pennate.control._task import Levels
from pennate.control.trials import pairs, policies

# Another order of sums turns some close decisions.
TOLERANCE = 0.003


@pytest.mark.parametrize("name", _policy.KEPT)
def test_a_kept_policy_scores_what_its_file_says(name: str) -> None:
    policy = Policy.kept(name)
    _, actions, _ = setting_of(policy)
    strides = actions.strides if isinstance(actions, Levels) else br2.STRIDES
    share, moves, error = Judge(policy.kind, policy.about["validation_pairs"], strides).mark(policy)
    assert abs(share - policy.about["validation_share"]) <= TOLERANCE
    assert abs(moves - policy.about["validation_moves"]) < 0.05
    assert abs(error - policy.about["validation_error"]) < 0.05
    # Strides need 6.4 moves at least, the smallest alone 23.
    assert share >= 0.985 and moves < {"dqn": 7, "ddpg": 3, "fine": 25}[name]
    assert policy.about["command"].startswith(f"python -m pennate.control train {name} --steps ")


@pytest.mark.parametrize(
    ("name", "load", "bar"), [("dqn", 0, 0.973), ("dqn", 12, 0.96), ("ddpg", 0, 0.98), ("ddpg", 9, 0.98)]
)
def test_a_kept_policy_does_as_well_on_pairs_that_chose_no_checkpoint(name: str, load: int, bar: float) -> None:
    policy = Policy.kept(name)
    arm, actions, rules = setting(policy.kind, load)
    rng = np.random.default_rng(5)
    if name == "dqn":
        starts, targets = pairs.pairs(load, 1000, 5)
    else:
        starts, ends = (arm.lower + rng.random((1000, 3)) * (arm.upper - arm.lower) for _ in range(2))
        targets = arm.tip(ends)
    found = follow(policy, arm, starts, targets, actions=actions, rules=rules)
    assert np.mean(found.errors <= rules.success) >= bar


def test_kept_policies_go_live_as_they_go_by_table() -> None:
    policy = Policy.kept("dqn")
    starts, targets = pairs.pairs(6, 60, 7)
    _, actions, rules = setting("discrete")
    ends = [
        follow(policy, arm, starts, targets, actions=actions, rules=rules).errors
        for arm in (br2.table(6), br2.solved(6))
    ]
    assert np.abs(ends[0] - ends[1]).max() < 0.01


def test_without_visiting_levels_again_a_policy_no_longer_goes_round_in_circles() -> None:
    policy = Policy.kept("dqn")
    starts, targets = pairs.pairs(18, 500, 11)
    _, actions, rules = setting("discrete")
    shares = [
        np.mean(follow(policy, br2.table(18), starts, targets, actions=actions, rules=rules, again=again).errors <= 15)
        for again in (False, True)
    ]
    assert shares[0] > shares[1] + 0.01


def test_kept_policies_take_little_room_and_say_which_there_are() -> None:
    folder = pathlib.Path(_policy.__file__).parent / "kept"
    files = sorted(folder.glob("*.npz"))
    assert [file.stem for file in files] == sorted(_policy.KEPT)
    assert sum(file.stat().st_size for file in files) < 3_000_000
    with pytest.raises(ValueError, match="there is no kept policy 'sac'; there are dqn, ddpg, fine"):
        Policy.kept("sac")


def test_live_and_by_table_the_command_prints_the_same_shares(capsys: pytest.CaptureFixture[str]) -> None:
    printed = policies.live(Policy.kept("dqn"), 0.003, 2).splitlines()
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in printed[4:]]
    assert [row[0] for row in rows] == ["0 g", "6 g", "9 g", "12 g", "18 g"]
    assert all(row[1] == row[4] and row[7] == "100.00" for row in rows)
    assert __main__.main(["score", "ddpg", "--live"]) == 2
    assert "for policies of discrete actions" in capsys.readouterr().err


def test_a_damaged_policy_is_refused_and_the_file_is_named(tmp_path: pathlib.Path) -> None:
    whole = (pathlib.Path(_policy.__file__).parent / "kept" / "dqn.npz").read_bytes()
    middle = len(whole) // 2
    turned = bytes(255 - byte for byte in whole[middle : middle + 100])
    file = tmp_path / "policy.npz"
    flipped = whole[:middle] + turned + whole[middle + 100 :]
    for content in (b"", b"no policy", whole[:middle], b"XX" + whole[2:], flipped):
        file.write_bytes(content)
        with pytest.raises(ValueError, match="policy.npz holds no policy, or is damaged"):
            Policy.load(file)
    assert __main__.main(["score", str(file)]) == 2
    for layer in ((np.zeros((5, 3)), np.zeros(4)), (np.full((5, 12), np.nan), np.zeros(12))):
        np.savez(file, kind=np.array("discrete"), w0=layer[0], b0=layer[1])
        with pytest.raises(ValueError, match="layers: "):
            Policy.load(file)


def test_a_policy_of_another_arm_is_refused() -> None:
    dqn = Policy.kept("dqn")
    _, actions, rules = setting("discrete")
    _, changes, _ = setting("continuous")
    with pytest.raises(ValueError, match="the policy has discrete actions"):
        follow(dqn, br2.table(0), np.zeros((1, 2)), np.zeros((1, 3)), actions=changes, rules=rules)
    three = br2.table(0, both=True, swivel=True)
    with pytest.raises(ValueError, match=r"made for 2 inputs and 12 actions, and the arm has 3 \(Pb, Pr, swivel\)"):
        hybrid(three, [100.0, 0.0, -250.0], dqn, start=[80.0, 0.0, 0.0])
    softer = replace(dqn, about={"inputs": {"Pb": [0.0, 100.0], "Pr": [0.0, br2.ROTATING]}})
    with pytest.raises(ValueError, match="its inputs are Pb from 0 to 100, .* those of the arm Pb from 0 to 172.36"):
        follow(softer, br2.table(0), np.zeros((1, 2)), np.zeros((1, 3)), actions=actions, rules=rules)
