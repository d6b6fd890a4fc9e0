"""`pennate optimize STUDY.toml -o DIR`."""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections import Counter
from collections.abc import Callable, Sequence

from .._errors import Error
from ._check import Checked, accuracy, ends, off
from ._limits import CHANCES, unmet, unmet_by_chance
from ._picture import can_draw
from ._progress import Terminal
from ._read import read
from ._run import Outcome, optimize
from ._table import Design
from ._write import best_file, holds


def main(arguments: Sequence[str]) -> int:
    """Runs a study, and returns the exit status: 0, 1 where nothing feasible was found, 2 for a wrong input, 130."""
    parser = argparse.ArgumentParser("pennate optimize", description="Looks for designs of a network.")
    parser.add_argument("study", help="study file, TOML")
    parser.add_argument("-o", "--output", required=True, metavar="DIR", help="where designs.csv and the rest are written")
    parser.add_argument("--set", action="append", default=[], metavar="NAME=VALUE", help="give a parameter another value")
    parser.add_argument("--seed", type=_whole(0), metavar="N", help="in place of that of the study")
    parser.add_argument("--threads", type=_whole(1, 1000), metavar="N", help="the files are the same with any number")
    parser.add_argument("--budget", type=_whole(1), default=float("inf"), metavar="N", help="designs to solve at most, in whole batches")
    parser.add_argument("--first", metavar="FILE", help="designs to begin with: a table such as the front.csv of another study")
    parser.add_argument("--live", action="store_true", help="tell of every batch; front.svg or progress.svg is redrawn in any case")
    parser.add_argument("--json", action="store_true", help="print what was found as JSON")
    given = parser.parse_args(list(arguments))
    settings = {}
    for text in given.set:
        name, _, value = text.partition("=")
        try:
            settings[name.strip()] = float(value)
        except ValueError:
            print(f"error: --set {text} is not NAME=VALUE\nhelp: write for example --set D=360", file=sys.stderr)
            return 2
    terminal = None
    try:
        study = read(given.study, settings, given.seed, given.first)
        terminal = Terminal(study) if given.live else None
        outcome = optimize(study, given.output, threads=given.threads, budget=given.budget, progress=terminal)
    except Error as error:
        print(error, file=sys.stderr)
        return 2
    except ImportError as error:
        print(f"error: {error}\nhelp: the libraries of searches come with pip install 'pennate[study]'", file=sys.stderr)
        return 2
    except OSError as error:
        print(f"error: {given.output} cannot be written: {error}\nhelp: give another directory with -o", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        if terminal:
            terminal.close()
        print(f"interrupted; {given.output} holds what was found, and the same command goes on from here", file=sys.stderr)
        return 130
    if terminal:
        terminal.close()
    print(json.dumps(summary(outcome), indent=2) if given.json else words(outcome))
    if not outcome.best:
        print(nothing(outcome), file=sys.stderr)
        return 1
    return 0


def _whole(least: int, most: float = math.inf) -> Callable[[str], int]:
    """Reads a whole number between two."""

    def read(text: str) -> int:
        try:
            found = int(text)
        except ValueError:
            found = least - 1
        if not least <= found <= most:
            upto = f" to {most:.0f}" if math.isfinite(most) else " on"
            raise argparse.ArgumentTypeError(f"a whole number from {least}{upto} expected, not {text!r}")
        return found

    return read


def nothing(outcome: Outcome) -> str:
    """Why there is no design to show."""
    if not outcome.designs:
        counts = unmet_by_chance(outcome.study)
        what = "no design meets the constraints that need no solution; nothing was solved"
        return f"{what}\n{limits(counts, f'{CHANCES:,} random designs')}\nhelp: look at their limits and at the ranges"
    kinds = Counter(each.status for each in outcome.designs if each.status != "solved")
    words = {"no_value": "an objective or target is no number", "unstable": "the end of a step is unstable"}
    told = [(words.get(kind, kind.replace("_", " ")), count) for kind, count in kinds.most_common()]
    lines = [f"{count} designs have no answer: {why}" for why, count in told]
    solved = [each for each in outcome.designs if each.status == "solved"]
    if solved:
        lines.append(limits(unmet(outcome.study, solved), f"{len(solved)} designs with an answer"))
    lines.append("help: look at these limits and at the ranges; designs.csv holds all designs")
    return "\n".join(["no design meets all constraints", *lines])


def limits(counts: dict[str, int], of: str) -> str:
    """Which constraints how many designs violate."""
    found = [f"{count:,} violate '{name}'" for name, count in counts.items() if count]
    return f"of {of} {', '.join(found) or 'each meets each constraint'}"


def words(outcome: Outcome) -> str:
    """What was found, for a person."""
    failed = sum(design.status != "solved" for design in outcome.designs)
    lines = [f"{len(outcome.designs)} designs, {outcome.solved} of them solved now, {failed} without an answer"]
    for design in outcome.best[:1] + outcome.best[1:][-1:]:
        values = [f"{each.name} {value:.6g}" for each, value in zip(outcome.study.wanted, design.wanted)]
        lines.append(f"design {design.number}: " + ", ".join(values))
    lines += [*checks(outcome), *doubtful(outcome)]
    if outcome.progress and not can_draw():
        lines.append("no picture: matplotlib comes with pip install 'pennate[study]'")
    return "\n".join(lines)


def checks(outcome: Outcome) -> list[str]:
    """What the best designs are on meshes of their own, and what would help where they differ."""
    study, checked = outcome.study, [each for each in outcome.checked if each]
    if not checked:
        return []
    count = f"{len(checked)} of the {len(outcome.best)}" if len(checked) < len(outcome.best) else f"the {len(outcome.best)}"
    which, where = f"{count} designs of the front", "each on a mesh of its own"
    if len(study.objectives) < 2:
        which, where = "the best design", "on a mesh of its own"
    parts = [f"{number} with the end '{kind}'" for kind, number in ends(checked).most_common()]
    differences = off(study, outcome.designs, outcome.best, outcome.checked)
    far = differences[differences > study.accuracy]
    if len(far):
        parts.append(f"{len(far)} off by more than {study.accuracy:g} of the largest value, by up to {far.max():.1g}")
    head = f"{which}, solved once more at {accuracy(study):g}, {where}: "
    if not parts:
        return [f"{head}within {study.accuracy:g} of the largest value"]
    help = f"help: a search with accuracy = {study.accuracy / 10.0:g} in the study has a finer mesh"
    return [f"{head}{', '.join(parts)} (columns 'checked' of {best_file(study)})", help]


def doubtful(outcome: Outcome) -> list[str]:
    """Picks that do not converge, or are unstable, where they are solved by themselves."""
    words = [(pick, "unstable" if pick["status"] == "converged" else pick["status"]) for pick in outcome.picks if not holds(pick)]
    return [f"{pick['network']} ends with '{word}' where it is solved by itself" for pick, word in words]


def summary(outcome: Outcome) -> dict[str, object]:
    """The same for programs."""
    names = [each.name for each in outcome.study.variables], [each.name for each in outcome.study.wanted]

    def entry(design: Design) -> dict[str, object]:
        found = {"variables": dict(zip(names[0], design.x)), "wanted": dict(zip(names[1], design.wanted))}
        return {"number": design.number, **found, "stable": design.stable}

    def found_alone(other: Checked | None) -> dict[str, object]:
        if other is None:
            return {"checked": None}
        # JSON knows no number that is none.
        wanted = [value if math.isfinite(value) else None for value in other.wanted]
        return {"checked": {"status": other.status, "stable": other.stable, "wanted": dict(zip(names[1], wanted))}}

    last = outcome.progress[-1] if outcome.progress else {}
    return {
        "designs": len(outcome.designs),
        "solved_now": outcome.solved,
        "without_an_answer": sum(design.status != "solved" for design in outcome.designs),
        **{key: value for key, value in last.items() if key in ("hypervolume", "best") and math.isfinite(value)},
        "best": [{**entry(design), **found_alone(other)} for design, other in zip(outcome.best, outcome.checked)],
        "picks": outcome.picks,
    }


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
