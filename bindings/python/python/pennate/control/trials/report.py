"""One page with the eight tests of chapter 4: tables, pictures, assumptions, slips. `python -m pennate.control report`."""

from __future__ import annotations

import re
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path


from .._policy import KEPT, Policy
from . import bars, charts, eight

HEAD = """\
# The tests of chapter 4

`python -m pennate.control report PAGE` writes this page; `--only` renews some of its sections. Reported figures are those of the
dissertation; the prototype is an independent program behind the [specification of the arm](control.md). All tips are those of the arm with its
load, as they would be measured; derivatives and plans are those of the model without load. Policies were trained without load.

* DQN and DDPG: the policies that come with the package. DQN visits no levels twice.
* Gauss–Newton: `reach` without restarts, and with them.
* Hybrid: `hybrid`, whose plan costs no move, with the policy and without.
* Feedback: `Servo`.

A move is one change of inputs on the arm, going back included: each of them is a solve, where the arm is solved for. States of the model are those that its
derivatives or its tip were asked for. Times are processor time a target, from tables.
"""

MISSED = """\
## What is not reached

Figures that were asked for before there was a program are compared with the tables above; of a mean with its deviation, the mean. What all trainings
came to stands under [Policies](control.md#policies): five seeds of `ddpg`, of which five have 97 % by 50,000 episodes, three of `dqn`, and one of `ddpg` with three times the
moves, which comes along.
10,000 ways of `dqn` by solves at each of five loads take 65 s on two cores, and 144 s on a machine half as fast, 120 asked for (`score dqn --live`).
"""

WORTH = """\
## What learning is worth

**Little, on this arm.** Where learning buys nothing:

* Table 8, at all loads: Gauss–Newton with restarts ends all pairs well in four tenths of the moves of DQN, without training. A plan on the model makes it one to two
  moves, and Gauss–Newton plans as well as the policy.
* Fig. 34: Gauss–Newton with restarts comes within 1 cm as well, in fewer moves.
* Tables 9 and 10: it ends at the closest point where waypoints are out of reach; the policy goes on from there.
* Table 11: it comes nearer in all rows, as it can be asked for 0.1 cm, in more moves than a policy that stops at 1.5 cm.
* Fig. 35: the policy comes near to the fewest moves that its strides allow, but only strides of the text ask for so many.
* Fig. 40: Gauss–Newton with restarts ends at the closest reachable point. A policy does not know when a target is out of reach, and swings about it.
* Table 12: feedback by the model is nearer in all rows. The policy makes fewer moves, as it stops at 1.5 cm.

Where it buys something: with three inputs, whose moves are limited, the policy takes fewer moves than Gauss–Newton, and shortens the plan by some per cent. Where the
base has to turn all the way back it takes less than half the moves of Gauss–Newton with restarts, as it does not go astray first; the plan takes fewer still.
It asks no model while it acts. Plain Gauss–Newton leaves 2 to 3 of 1,000 pairs of Table 8 behind, more than is asked for: it takes restarts.
"""

ASSUMED = """\
## Assumptions

What stands in the scene file besides, and:

* Discrete: levels of 0.5 and 1 psi [inferred: all pressures of Table 9 lie on the first], at most 40 moves, the offset ζ from the boundaries 0, a pressure below zero
  is treated as one above its limit. Continuous: changes up to 31.2 kPa, 96.5 kPa and 60 degrees, 15 moves.
* Errors in cm in the reward of the environments; in mm in training of `dqn`.
* A hit pays 100 instead of, not besides, the cost of the move. The step limit ends an episode as a failure; `truncate=True` truncates it.
* In tests no action leaves the limits: discrete ones are not chosen, continuous ones end there. No level is visited twice.
* Curves and waypoints of Figs. 34, 38 and 39 are assumed: the text prints no coordinates.
* The physical arm is replaced by a bench arm: curvature by the bending actuator × 0.92, twist × 0.9, bending stiffness × 0.85, torsional stiffness × 0.9, bent by 0.8 and 1.0 1/m
  when it is built, play of ± 6 and ± 8 kPa. At random equal pressures its tip is 4.0 ± 1.4 cm off (reported 3.05 ± 0.97). The worse arm has 1.5 times all of that.

## Slips of the text

The update of Q has the index t on both sides, and a maximum where the argument of it is meant; the final reward of DDPG is printed with
the wrong sign, and would pay for being far away; 31.2 kPa lies on no grid of psi; Eq. 25 shrinks an action towards ζ and is not the
correlated noise that it is named after; Table 9 numbers unreachable points i, i, iii, iii; the variation is 0.30 cm, not 0.31; Table 8 has five rows for "four loads"; in Table 11 the
line and the circle with 3 g are equal; Table 12 has the caption of Table 11.
"""


@dataclass(frozen=True)
class Section:
    """A test: its head, what computes its table, and what draws its pictures."""

    head: str
    tabulate: Callable[[float, int], str]
    note: str = ""
    draw: Callable[[Path, int], str] | None = None
    """Writes a picture beside the page, and returns its caption."""


SECTIONS = {
    "table8": Section("Random pairs, two inputs (Table 8)", eight.table8),
    "three": Section("Random pairs, three inputs", eight.three),
    "fig34": Section("Waypoints at the edge (Fig. 34)", eight.fig34, "", charts.waypoints),
    "fig35": Section(
        "Fewest moves, and strides (Fig. 35)",
        eight.fig35,
        "With the smallest strides alone the policy is `fine`, which was trained with them. Asked for are 1.5 times the fewest.",
        charts.strides,
    ),
    "table9": Section(
        "Waypoints out of reach under load (Tables 9 and 10, Figs. 33 and 36)",
        eight.table9,
        "No policy ends where it was nearest: it goes on.",
        charts.workspaces,
    ),
    "table11": Section(
        "Curves under load (Table 11, Figs. 38 and 39)",
        eight.table11,
        "A mean of half the tolerance says no more than that the policy stops as soon as it is inside.",
        charts.curves,
    ),
    "fig40": Section(
        "Targets out of reach (Fig. 40)", eight.fig40, "Of the policy ≤ 1.2 cm and ≥ 95 % are asked for.", charts.beyond
    ),
    "fig41": Section("The gap behind the arm (Fig. 41)", eight.fig41, "", charts.gap),
    "table12": Section("Open and closed loop (Table 12, Fig. 43)", eight.table12, "", charts.loops),
}


def write(page: Path, only: Sequence[str], share: float, seed: int, say: Callable[[str], None] = print) -> None:
    """Writes the page with its pictures beside it, or renews some of its sections."""
    texts = {name: f"<!-- {name} -->\n## {section.head}\n\nNot run yet.\n" for name, section in SECTIONS.items()}
    if page.exists():
        texts |= {name: text for name, text in _sections(page.read_text(encoding="utf-8")).items() if name in texts}
    for name in only or SECTIONS:
        texts[name] = _section(name, SECTIONS[name], page.parent, share, seed)
        # What is done is kept, whatever happens to the rest.
        parts = [HEAD, _policies(), *texts.values(), "<!-- end -->", MISSED, bars.missed(texts), "", WORTH, ASSUMED]
        page.write_text("\n".join(parts), encoding="utf-8")
        say(f"{name} done")


def _section(name: str, section: Section, folder: Path, share: float, seed: int) -> str:
    begin, used = time.perf_counter(), time.process_time()
    parts = [f"<!-- {name} -->\n## {section.head}\n", section.tabulate(share, seed), ""]
    if section.note:
        parts += [section.note, ""]
    if section.draw is not None:
        file = folder / "pictures" / f"control_{name}.png"
        file.parent.mkdir(exist_ok=True)
        caption = section.draw(file, seed)
        parts += [f"![{caption}](pictures/{file.name})", "", f"*{caption}*", ""]
    passed, used = time.perf_counter() - begin, time.process_time() - used
    kept = f", {100 * share:g} % of the cases" if share != 1 else ""
    return "\n".join([*parts, f"Seed {seed}{kept}: {used:.0f} s of processor time, {passed:.0f} s altogether.\n"])


def _policies() -> str:
    """What the policies say of themselves."""
    rows = []
    for name in KEPT:
        about = Policy.kept(name).about
        share = f"{100 * about['validation_share']:.2f}"
        rows.append(
            f"| `{name}` | `{about['command']}` | {about['episodes']:,} | {about.get('processor_seconds', '–')} | {share} "
            f"| {about['validation_moves']:.2f} |"
        )
    head = "| policy | made by | episodes | s of processor time | validation pairs within 1.5 cm, % | moves |"
    return "\n".join([head, "|---|---|---:|---:|---:|---:|", *rows, ""])


def _sections(text: str) -> dict[str, str]:
    """Those of a page that was written before."""
    found = re.split(r"(?m)^(?=<!-- \w+ -->$)", text)
    named = {re.match(r"<!-- (\w+) -->", part): part for part in found}
    return {match.group(1): part.rstrip() + "\n" for match, part in named.items() if match is not None}
