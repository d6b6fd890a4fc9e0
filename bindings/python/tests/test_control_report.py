"""The page of all tests: sections are renewed one by one, and the others stay as they are."""

from __future__ import annotations

import pathlib

import numpy as np
import pytest

from pennate.control import __main__, br2
from pennate.control.trials import eight, report, whole
from pennate.control.trials.ways import policy_along, reach_along


def test_sections_are_renewed_one_by_one(tmp_path: pathlib.Path, monkeypatch: pytest.MonkeyPatch) -> None:
    made = report.Section("A test", lambda share, seed: f"| {share} | {seed} |", "A note.")
    monkeypatch.setattr(report, "SECTIONS", {"first": made, "second": made})
    page = tmp_path / "page.md"
    report.write(page, ["first"], 0.1, 1, say=lambda _: None)
    assert "| 0.1 | 1 |" in page.read_text() and "Not run yet." in page.read_text()
    report.write(page, ["second"], 1.0, 2, say=lambda _: None)
    text = page.read_text()
    assert text.count("| 0.1 | 1 |") == 1 and text.count("| 1.0 | 2 |") == 1 and "Not run yet." not in text
    assert text.count("## Assumptions") == 1 and text.count("<!-- second -->") == 1
    assert "`python -m pennate.control train dqn --steps" in text


def test_the_command_draws_beside_the_page_and_names_what_is_missing(
    tmp_path: pathlib.Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    pytest.importorskip("matplotlib")
    page = tmp_path / "page.md"
    assert __main__.main(["report", str(page), "--only", "table9", "fig41", "--quick"]) == 0
    assert "| 2, 12 g | 2.18 | 2.17 | no |" in page.read_text()
    assert (tmp_path / "pictures" / "control_fig41.png").stat().st_size > 10_000
    assert __main__.main(["report", str(page), "--only", "fig99"]) == 2
    assert "there is no section 'fig99'" in capsys.readouterr().err
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    assert __main__.main(["report", str(page)]) == 2
    assert "pip install 'pennate[view]'" in capsys.readouterr().err


def test_out_of_reach_the_policy_comes_as_near_as_is_asked_for() -> None:
    # The fourth and the fifth cell are the closest reachable error and the closest of the run.
    rows = [[cell.strip() for cell in line.split("|")[1:-1]] for line in eight.table9(1.0, 1).splitlines()[4:]]
    beyond = [float(row[4]) - float(row[2]) for row in rows if row[3] == "no"]
    assert len(beyond) == 4 and max(beyond) <= 0.35


def test_waypoints_are_gone_to_from_where_the_last_one_was_left() -> None:
    arm, start = whole(0), np.array([br2.BENDING / 2, 0.0, 0.0])
    first = arm.tip(np.array([[100.0, 40.0, 10.0]]))[0]
    for found in (
        policy_along(arm, np.array([first, first]), start),
        reach_along(arm, np.array([first] * 2), start, 1.0),
    ):
        assert found.moves[0] > 0 and found.moves[1] == 0 and found.errors[0] == found.errors[1]
