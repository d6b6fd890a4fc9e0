"""`python -m pennate.control test`: the tests of chapter 4, as Markdown tables."""

from __future__ import annotations

import argparse
import importlib.util
import os
import sys
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from ._policy import KEPT, Policy
from ._recipes import RECIPES
from .trials import edges, pairs, paths

# Each trial by its name: what it prints, with so many cases and a seed.
TRIALS: dict[str, Callable[[float, int], str]] = {
    "table8": lambda share, seed: pairs.table8(round(10_000 * share), seed),
    "three": lambda share, seed: pairs.three_inputs(round(5_000 * share), seed),
    "fig34": lambda share, seed: paths.extremes(),
    "fig35": lambda share, seed: pairs.fewest_moves(round(300 * share), seed),
    "table9": lambda share, seed: paths.loaded_waypoints(),
    "table11": lambda share, seed: paths.curves(round(60 * share)),
    "table12": lambda share, seed: paths.bench_arm(round(30 * share)),
    "fig40": lambda share, seed: edges.beyond(round(200 * share), seed),
    "fig41": lambda share, seed: edges.gap(round(300 * share), seed),
}


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs trials and prints their tables."""
    parser = argparse.ArgumentParser(prog="python -m pennate.control", description="Control of the BR2 arm.")
    commands = parser.add_subparsers(dest="command", required=True)
    test = commands.add_parser("test", help="the tests of chapter 4: reported, prototype, reached here")
    test.add_argument("trials", nargs="*", metavar="TRIAL", help=f"some of: {', '.join(TRIALS)}; all by default")
    test.add_argument("--seed", type=int, default=1, help="of all that is drawn (1)")
    test.add_argument("--quick", action="store_true", help="a tenth of the cases")
    learn = commands.add_parser("train", help="a policy by skrl on JAX; needs pennate[train]")
    learn.add_argument("method", choices=("ddpg", "dqn", "fine"))
    learn.add_argument("--steps", type=int, help="moves of 64 arms at once (6000; ddpg 4800)")
    learn.add_argument("--seed", type=int, default=0, help="of arms, networks and exploration (0)")
    kept = "where the best checkpoint is kept; a training that was killed goes on"
    learn.add_argument("-o", "--output", required=True, metavar="FILE.npz", help=kept)
    trained = commands.add_parser("trained", help="what trainings came to, a row for each policy")
    trained.add_argument("policies", nargs="+", metavar="POLICY", help="files, or policies that come along")
    score = commands.add_parser("score", help="the tests of chapter 4 for a policy, by NumPy alone")
    score.add_argument("policy", metavar="POLICY", help=f"a file, or one that comes along: {', '.join(KEPT)}")
    score.add_argument("--seed", type=int, default=1, help="of all that is drawn (1)")
    score.add_argument("--live", action="store_true", help="Table 8 by solves, beside the tables; discrete policies")
    score.add_argument("--quick", action="store_true", help="a tenth of the cases")
    report = commands.add_parser("report", help="one page: all tests, with pictures; needs pennate[view]")
    report.add_argument("page", metavar="PAGE.md", help="pictures go into the folder `pictures` beside it")
    report.add_argument("--only", nargs="+", default=[], metavar="SECTION", help="renews these sections of the page")
    report.add_argument("--seed", type=int, default=1, help="of all that is drawn (1)")
    report.add_argument("--quick", action="store_true", help="a tenth of the cases")
    given = parser.parse_args(arguments)
    if given.command == "train":
        return _train(given.method, given.steps, given.seed, given.output)
    if given.command == "trained":
        return _trained(given.policies)
    if given.command == "report":
        return _report(given.page, given.only, 0.1 if given.quick else 1.0, given.seed)
    if given.command == "score":
        return _score(given.policy, 0.1 if given.quick else 1.0, given.seed, given.live)
    unknown = [name for name in given.trials if name not in TRIALS]
    if unknown:
        parser.error(f"there is no trial '{unknown[0]}'; there are {', '.join(TRIALS)}")
    for name in given.trials or TRIALS:
        begin = time.perf_counter()
        print(TRIALS[name](0.1 if given.quick else 1.0, given.seed), flush=True)
        print(
            f"\n{name}, seed {given.seed}: {time.perf_counter() - begin:.1f} s, tables of states included.\n",
            flush=True,
        )
    return 0


def _read(path: str) -> Policy | None:
    """A policy from a file or from the package; where there is none, that is said."""
    try:
        return Policy.kept(path) if path in KEPT else Policy.load(path)
    except (OSError, ValueError) as error:
        help = f"help: a file that `train` wrote, or one of {', '.join(KEPT)}"
        print(f"error: no policy is read: {error}\n{help}", file=sys.stderr)
        return None


def _trained(paths: Sequence[str]) -> int:
    """Prints what trainings came to."""
    from .trials import trainings

    policies = [_read(path) for path in paths]
    if None in policies:
        return 2
    print(trainings.trained([policy for policy in policies if policy is not None and "history" in policy.about]))
    return 0


def _score(path: str, share: float, seed: int, live: bool) -> int:
    """Prints the tests of a policy."""
    from .trials import policies

    policy = _read(path)
    if policy is None:
        return 2
    begin = time.perf_counter()
    if live and policy.kind != "discrete":
        print("error: --live is for policies of discrete actions", file=sys.stderr)
        return 2
    print((policies.live if live else policies.score)(policy, share, seed))
    print(f"\n{path}, seed {seed}: {time.perf_counter() - begin:.1f} s, tables of states included.")
    return 0


def _report(page: str, only: Sequence[str], share: float, seed: int) -> int:
    """Writes the page of all tests."""
    if importlib.util.find_spec("matplotlib") is None:
        print("error: matplotlib is not installed\nhelp: pip install 'pennate[view]'", file=sys.stderr)
        return 2
    from .trials import report

    unknown = [name for name in only if name not in report.SECTIONS]
    if unknown:
        known = ", ".join(report.SECTIONS)
        print(f"error: there is no section '{unknown[0]}'\nhelp: there are {known}", file=sys.stderr)
        return 2
    report.write(Path(page), only, share, seed)
    return 0


def _train(method: str, steps: int | None, seed: int, output: str) -> int:
    """Trains a policy and keeps its best checkpoint, as it comes."""
    # Before JAX is imported: it would look for other devices, and take all threads.
    os.environ.setdefault("JAX_PLATFORMS", "cpu")
    try:
        from . import _train
    except ModuleNotFoundError as error:
        print(f"error: {error.name} is not installed\nhelp: pip install 'pennate[train]'", file=sys.stderr)
        return 2
    try:
        policy, share = _train.train(method, steps or RECIPES[method].steps, seed, output=output)
    except (OSError, ValueError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(f"{output}: {100 * share:.1f} % of the validation pairs in {policy.about['validation_moves']:.2f} moves")
    return 0


if __name__ == "__main__":
    sys.exit(main())
