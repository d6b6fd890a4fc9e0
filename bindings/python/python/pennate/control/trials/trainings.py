"""What trainings came to, by what the files of their policies say: one row each."""

from __future__ import annotations

from collections.abc import Sequence

from .._policy import Policy
from . import table

# What is asked for of DDPG: so many of a hundred validation pairs by so many episodes, with each seed.
SHARE, EPISODES = 0.98, 50_000


def trained(policies: Sequence[Policy]) -> str:
    """A row for each policy: when it was good enough, how good it was by 50,000 episodes, and what was kept."""
    return table(
        f"Trainings, by {policies[0].about['validation_pairs']} validation pairs",
        [
            "training",
            "seed",
            f"{100 * SHARE:g} % after, episodes",
            "s",
            f"best by {EPISODES:,} episodes, %",
            "kept: episodes",
            "%",
            "moves",
            "error, cm",
            "s in all",
            "of processor time",
        ],
        [_row(policy) for policy in policies],
    )


def _row(policy: Policy) -> list[str]:
    about = policy.about
    history = about["history"]
    # Moves, episodes, seconds, processor time; then share, moves and error of the network, and of its mean.
    good = next((each for each in history if _best(each) >= SHARE), None)
    early = [_best(each) for each in history if each[1] <= EPISODES]
    method, steps = about["command"].split(" train ")[1].split(" --steps ")
    return [
        f"`{method}`, {steps.split()[0]} moves",
        f"{about['seed']}",
        "–" if good is None else f"{good[1]:,}",
        "–" if good is None else f"{good[2]:.0f}",
        f"{100 * max(early):.2f}" if early else "–",
        f"{about['episodes']:,}",
        f"{100 * about['validation_share']:.2f}",
        f"{about['validation_moves']:.2f}",
        f"{about['validation_error'] / 10:.2f}",
        f"{history[-1][2]:.0f}",
        f"{history[-1][3]:.0f}",
    ]


def _best(row: Sequence[float]) -> float:
    return max(row[4], row[7])
