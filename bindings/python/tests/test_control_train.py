"""Training makes checkpoints that are policies; whether they are good is for `python -m pennate.control score` to say."""

from __future__ import annotations

import os
import pathlib
import signal
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

os.environ.setdefault("JAX_PLATFORMS", "cpu")
pytest.importorskip("skrl")
pytestmark = pytest.mark.filterwarnings("ignore")


@pytest.mark.parametrize(
    ("method", "kind", "actions"), [("ddpg", "continuous", 3), ("dqn", "discrete", 12), ("fine", "discrete", 4)]
)
def test_a_training_keeps_its_best_checkpoint(method: str, kind: str, actions: int, tmp_path: pathlib.Path) -> None:
    from pennate.control import __main__, _train
    from pennate.control._policy import Policy

    file = tmp_path / "policy.npz"
    monkey = pytest.MonkeyPatch()
    monkey.setattr(_train, "RECIPES", {method: replace(_train.RECIPES[method], pairs=50)})
    monkey.setattr(_train, "CHECKPOINTS", 2)
    try:
        # Learning starts after 46 moves of the arms.
        assert __main__.main(["train", method, "--steps", "52", "--seed", "1", "-o", str(file)]) == 0
    finally:
        monkey.undo()
    policy = Policy.load(file)
    seen = np.zeros((4, 6 if method == "ddpg" else 5), dtype=np.float32)
    assert policy.kind == kind and policy(seen).shape == (4, actions)


# A training of a few moves, in a process of its own; killed after its first checkpoint where that is asked for.
RUN = """
import os, signal, sys
from dataclasses import replace
from pennate.control import _train
_train.CHECKPOINTS = 2
_train.RECIPES = {name: replace(recipe, pairs=50) for name, recipe in _train.RECIPES.items()}
def say(line):
    print(line)
    if sys.argv[3] == "kill" and line.startswith("64 moves"):
        os.kill(os.getpid(), signal.SIGKILL)
_train.train(sys.argv[1], 128, 5, say=say, output=sys.argv[2])
"""


@pytest.mark.parametrize("method", ["ddpg", "dqn"])
def test_a_training_that_is_killed_goes_on_digit_for_digit(method: str, tmp_path: pathlib.Path) -> None:
    from pennate.control._policy import Policy

    def run(name: str, how: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", RUN, method, str(tmp_path / name), how]
        return subprocess.run(command, capture_output=True, text=True)

    whole, killed = run("whole.npz", "on"), run("killed.npz", "kill")
    assert whole.returncode == 0, whole.stderr
    assert killed.returncode == -signal.SIGKILL and (tmp_path / "killed.npz.training").exists()
    again = run("killed.npz", "on")
    assert again.returncode == 0 and "goes on after 64 moves" in again.stdout, again.stderr
    assert sorted(file.name for file in tmp_path.iterdir()) == ["killed.npz", "whole.npz"]
    first, second = (Policy.load(tmp_path / name) for name in ("whole.npz", "killed.npz"))
    for one, other in zip(first.layers, second.layers):
        assert all(np.array_equal(a, b) for a, b in zip(one, other))
    # Moves, episodes and marks; times differ.
    histories = [[row[:2] + row[4:] for row in policy.about["history"]] for policy in (first, second)]
    assert histories[0] == histories[1] and len(histories[0]) == 2


def test_a_training_does_not_go_on_with_what_is_not_its_own(
    tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from pennate.control import __main__

    file = tmp_path / "policy.npz"
    beside = tmp_path / "policy.npz.training"
    beside.write_bytes(b"no training")
    assert __main__.main(["train", "ddpg", "--steps", "48", "-o", str(file)]) == 2
    np.savez(beside.open("wb"), values=np.array('{"about": {"command": "another"}}'))
    assert __main__.main(["train", "ddpg", "--steps", "48", "-o", str(file)]) == 2
    printed = capsys.readouterr().err
    assert "is damaged: delete it to begin anew" in printed and "belongs to another training, 'another'" in printed


def test_arms_explore_by_other_strides_at_each_move_and_stay_within_their_limits() -> None:
    from pennate.control._judge import setting
    from pennate.control._learner import Arms, Learner
    from pennate.control._recipes import RECIPES
    from pennate.control._task import Task

    arm, actions, _ = setting("discrete")
    arms = Arms(Task(arm, actions, RECIPES["dqn"].rules, 64), 0)
    learner = Learner(RECIPES["dqn"], arms, 100, 0)
    seen, all_arms = arms.reset()[0], np.arange(64)
    drawn = [learner.nets["q_network"].random_act({"observations": seen})[0][:, 0] for _ in range(400)]
    counts = np.stack([np.bincount(each, minlength=12) for each in np.array(drawn).T])
    allowed = arms.task.allowed(all_arms) > 0
    assert (counts[~allowed] == 0).all()
    # Each of those that are left is drawn evenly: the deviation of a count is at most the root of 400 / 4.
    expected = np.where(allowed, 400 / allowed.sum(axis=1)[:, None], 0)
    assert np.abs(counts - expected).max() < 60
