"""What is asked for is read off the tables of the page, and what is missed is said."""

from __future__ import annotations

from pennate.control import Policy
from pennate.control._judge import worth
from pennate.control._policy import KEPT
from pennate.control.trials import bars

FIG41 = """\
| by | within 1.5 cm, % | moves |
|---|---:|---:|
| prototype, DDPG | 100 | 4.3 |
| DDPG | {share} | {moves} |
"""
FIG40 = """\
|  | beyond the closest reachable point, cm | this below the perturbation, % | moves |
|---|---:|---:|---:|
| DDPG, closest of the run | 1.12 ± 1.13 | 96.00 | 15.0 |
| with restarts | {over} | 100.00 | 15.0 |
"""


def test_figures_that_miss_their_bars_are_printed_beside_them() -> None:
    good = bars.missed({"fig41": FIG41.format(share="99.00", moves="5.00"), "fig40": FIG40.format(over="0.10 ± 9.00")})
    assert good == "5 of 5 figures are reached."
    bad = bars.missed({"fig41": FIG41.format(share="98.99", moves="5.01"), "fig40": FIG40.format(over="0.11 ± 0.00")})
    assert bad.startswith("2 of 5 figures are reached.")
    assert "| fig41 | DDPG | within 1.5 cm, % | 98.99 | ≥ 99 |" in bad
    assert "| fig41 | DDPG | moves | 5.01 | ≤ 5 |" in bad
    assert "| fig40 | with restarts | beyond the closest reachable point, cm | 0.11 ± 0.00 | ≤ 0.1 |" in bad


def test_a_figure_may_be_asked_to_be_below_that_of_another_row() -> None:
    text = "| load | by | within 1.5 cm, % | error, cm | moves |\n|---|---:|---:|---:|---:|\n"
    for load in (0, 3, 6, 9):
        hybrid = 2.7 if load == 9 else 2.2
        for way, moves in (("DDPG", 2.6), ("Gauss–Newton", 3.2), ("hybrid", hybrid), ("hybrid without policy", 1.0)):
            text += f"| {load} g | {way} | 100.00 | 0.70 | {moves:.2f} |\n"
    printed = bars.missed({"three": text})
    assert printed.startswith("23 of 24 figures are reached.")
    assert "| three | 9 g, hybrid | moves | 2.70 | below 2.60, 9 g, DDPG |" in printed


def test_sections_that_were_not_run_have_no_bars() -> None:
    assert bars.missed({"fig41": "Not run yet."}) == ""


def test_kept_policies_are_the_checkpoints_that_their_histories_prefer() -> None:
    for name in KEPT:
        about = Policy.kept(name).about
        marks = [mark for row in about["history"] for mark in (tuple(row[4:7]), tuple(row[7:10]))]
        kept = (about["validation_share"], about["validation_moves"], about["validation_error"])
        assert max(marks, key=lambda mark: worth(*mark)) == kept
