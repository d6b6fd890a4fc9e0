"""Training of policies: DDPG and DQN by skrl on JAX, on tables of the BR2 arm. Needs `pennate[train]`.

What the text does not give, or gives and does not lead anywhere, is assumed: see `_recipes`, and the page of the book. Step limits
end episodes as failures, as the text has it: skrl would otherwise take the first state of the next episode for the last one
of this.
"""

from __future__ import annotations

import json
import os
import time
import zipfile
from collections.abc import Callable
from dataclasses import asdict, replace
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
import pennate

from ._judge import Judge, worth
from ._learner import ARMS, POLYAK, Arms, Learner
from ._policy import Policy
from ._recipes import RECIPES
from ._task import Task

CHECKPOINTS = 24


def train(
    method: str,
    steps: int,
    seed: int,
    *,
    say: Callable[[str], None] = print,
    output: str | os.PathLike[str] | None = None,
) -> tuple[Policy, float]:
    """The best checkpoint of a training, by what `worth` says of its way to the validation pairs, and its share of them.

    At each checkpoint the network that learns and its target network, a running mean of it, are judged.

    Args:
        method: `"ddpg"`, `"dqn"`, or `"fine"`, which is `"dqn"` with the smallest strides alone.
        steps: Moves of all arms at once.
        seed: Of arms, networks and exploration.
        say: Gets a line for each checkpoint.
        output: A file that gets each checkpoint that is better than all before, as it comes. Beside it a file `….training` has what
            the next process needs to go on, digit for digit, if this one is killed; it is there until the training ends.
    """
    training = _Training(method, steps, seed, say, None if output is None else Path(output))
    return training.run()


class _Training:
    def __init__(self, method: str, steps: int, seed: int, say: Callable[[str], None], output: Path | None) -> None:
        self.recipe = RECIPES[method]
        self.judge = Judge(self.recipe.kind, self.recipe.pairs, self.recipe.strides)
        self.arms = Arms(Task(self.judge.arm, self.judge.actions, self.recipe.rules, ARMS), seed)
        self.learner = Learner(self.recipe, self.arms, steps, seed)
        self.steps, self.say, self.output = steps, say, output
        self.about = {
            "command": f"python -m pennate.control train {method} --steps {steps} --seed {seed}",
            "seed": seed,
            "arms": ARMS,
            "recipe": asdict(self.recipe),
            "inputs": self.judge.limits,
            "polyak": POLYAK,
            "versions": {"pennate": pennate.__version__} | {name: version(name) for name in ("skrl", "jax", "numpy")},
        }
        self.made, self.mark = 0, -np.inf
        self.history: list[list[float]] = []
        """Of each checkpoint moves, episodes, seconds and processor time; then share, moves and error of the network, and of its mean."""
        self.best: Policy | None = None
        self.seconds = self.processor = 0.0
        if output is not None and self._beside.exists():
            self._go_on()
        self._begin, self._used = time.perf_counter() - self.seconds, time.process_time() - self.processor

    @property
    def _beside(self) -> Path:
        assert self.output is not None
        return self.output.with_name(self.output.name + ".training")

    def run(self) -> tuple[Policy, float]:
        """Trains to the end."""
        every = max(1, self.steps // CHECKPOINTS)
        for move in range(self.made, self.steps):
            self.learner.move(move)
            if (move + 1) % every == 0:
                self._check(move + 1)
        if self.best is None:
            raise RuntimeError("no checkpoint was made: too few steps")
        self._keep(self.best)
        if self.output is not None:
            self._beside.unlink(missing_ok=True)
        return self.best, float(self.best.about["validation_share"])

    def _check(self, made: int) -> None:
        """Judges the network and its mean, and keeps what is better than all before."""
        self.made = made
        self.seconds, self.processor = time.perf_counter() - self._begin, time.process_time() - self._used
        found = []
        for role in self.learner.roles:
            policy = Policy(self.recipe.kind, self.learner.layers(role), self.recipe.rules.scale).halved()
            share, moves, error = self.judge.mark(policy)
            found.append((share, moves, error))
            if worth(share, moves, error) > self.mark:
                self.mark = worth(share, moves, error)
                about = {"checkpoint": made, "network": role, "episodes": self.arms.episodes}
                about |= {"seconds": round(self.seconds), "processor_seconds": round(self.processor)}
                about |= {"validation_pairs": self.recipe.pairs, "validation_share": share, "validation_moves": moves}
                self.best = replace(policy, about={**self.about, **about, "validation_error": error})
        spent = [made, self.arms.episodes, round(self.seconds, 1), round(self.processor, 1)]
        self.history.append([*spent, *found[0], *found[1]])
        assert self.best is not None
        self._keep(self.best)
        self._save()
        marks = [f"{100 * share:.1f} % in {moves:.2f} moves to {error:.2f} mm" for share, moves, error in found]
        self.say(
            f"{made} moves of {ARMS} arms, {self.arms.episodes} episodes, {self.seconds:.0f} s: of {self.recipe.pairs} validation pairs within "
            f"{self.recipe.rules.success:g} mm {marks[0]}, by its mean {marks[1]}"
        )

    def _keep(self, best: Policy) -> None:
        self.best = replace(best, about={**best.about, "history": self.history})
        if self.output is not None:
            self.best.save(self.output)

    def _save(self) -> None:
        """What another process needs to go on."""
        if self.output is None:
            return
        parts = {"arms": self.arms.present(), "learner": self.learner.present()}
        values = {name: part[1] for name, part in parts.items()}
        own = {"about": self.about, "made": self.made, "history": self.history, "mark": self.mark}
        own |= {"seconds": self.seconds, "processor": self.processor}
        arrays = {f"{name}/{key}": array for name, part in parts.items() for key, array in part[0].items()}
        part = self._beside.with_name(self._beside.name + ".part")
        with open(part, "wb") as file:
            np.savez(file, values=np.array(json.dumps({**values, **own}, default=int)), **arrays)
        os.replace(part, self._beside)

    def _go_on(self) -> None:
        """From where a process that was killed had its last checkpoint."""
        try:
            with np.load(self._beside, allow_pickle=False) as file:
                arrays, values = dict(file), json.loads(str(file["values"]))
        except (ValueError, KeyError, EOFError, zipfile.BadZipFile) as error:
            raise ValueError(f"{self._beside} is damaged: delete it to begin anew") from error
        if values["about"] != json.loads(json.dumps(self.about)):
            raise ValueError(
                f"{self._beside} belongs to another training, '{values['about']['command']}', or to other versions: "
                "delete it to begin anew"
            )
        for name, part in (("arms", self.arms), ("learner", self.learner)):
            own = {key.split("/", 1)[1]: array for key, array in arrays.items() if key.startswith(f"{name}/")}
            part.go_on(own, values[name])
        self.made, self.history, self.mark = values["made"], values["history"], values["mark"]
        self.seconds, self.processor = values["seconds"], values["processor"]
        assert self.output is not None
        self.best = Policy.load(self.output)
        self.say(f"goes on after {self.made} moves of {ARMS} arms")
