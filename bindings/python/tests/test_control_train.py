"""Training makes checkpoints that are policies; whether they are good is for `python -m pennate.control score` to say."""

from __future__ import annotations

import os
import pathlib

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
    monkey.setattr(_train, "PAIRS", 50)
    monkey.setattr(_train, "CHECKPOINTS", 2)
    try:
        # Learning starts after 46 moves of the arms.
        assert __main__.main(["train", method, "--steps", "52", "--seed", "1", "-o", str(file)]) == 0
    finally:
        monkey.undo()
    policy = Policy.load(file)
    seen = np.zeros((4, 6 if method == "ddpg" else 5), dtype=np.float32)
    assert policy.kind == kind and policy(seen).shape == (4, actions)
