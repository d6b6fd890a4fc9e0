"""Studies: the same designs whatever happens on the way, and studies that are wrong."""

from __future__ import annotations

import concurrent.futures
import csv
import dataclasses
import json
import multiprocessing
import os
import signal
import subprocess
import sys
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import pennate

NETWORK = """
format = "pennate/1"
dimension = "plane"
parameters = { L = 100, d = 1.5, F = 1, long = "= 100 * max(1, d, F)" }
nodes = { A = [0, 0], B = ["= L", 0] }
materials.steel = { youngs_modulus = "200 GPa", poissons_ratio = 0.3 }
sections.wire = { circle = { radius = "= d / 2" }, shear = false }
members.wire = { nodes = ["A", "B"], section = "wire", material = "steel" }
supports = { A = "clamped" }
steps = [{ name = "push", force = { B = [0, "= -F"] } }]
[probes]
drop = { node = "B", displacement = [0, -1] }
"""

VARIABLES = """
format = "pennate-study/1"
network = "wire.toml"
seed = 3
[variables]
L = { from = 50, to = 200 }
d = { from = 1, to = 2 }
"""

FRONT = (
    VARIABLES
    + """
[constraints]
slender = { value = "= L / d", most = 150 }
[objectives]
drop = { maximize = "= drop@push" }
lightness = { maximize = "= 1000 - L * d^2" }
[search]
population = 12
generations = 4
"""
)

TARGET = (
    VARIABLES
    + """
[targets]
drop = { value = "= drop", is = 5 }
[search]
screen = 6
stop = { error = 1e-3 }
"""
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "wire.toml").write_text(NETWORK)
    return tmp_path


def study(folder: Path, text: str) -> Path:
    path = folder / "study.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("text", [FRONT, TARGET], ids=["front", "targets"])
def test_designs_are_the_same_bytes_for_any_number_of_threads_and_after_any_interrupt(folder: Path, text: str) -> None:
    pytest.importorskip("pymoo")
    path = study(folder, text)
    pennate.optimize(path, folder / "one", threads=1, draw=False)
    pennate.optimize(path, folder / "two", threads=2, draw=False)
    whole = (folder / "one" / "designs.csv").read_bytes()
    assert (folder / "two" / "designs.csv").read_bytes() == whole
    for part in (0.0, 0.05, 0.3, 0.7, 0.999):
        (folder / "two" / "designs.csv").write_bytes(whole[: int(part * len(whole))])
        outcome = pennate.optimize(path, folder / "two", threads=2, draw=False)
        assert (folder / "two" / "designs.csv").read_bytes() == whole
        assert outcome.solved > 0
    assert pennate.optimize(path, folder / "two").solved == 0


@pytest.mark.parametrize("text", [FRONT, TARGET], ids=["front", "targets"])
def test_workers_of_an_executor_write_the_same_bytes(folder: Path, text: str) -> None:
    pytest.importorskip("pymoo")
    path = study(folder, text)
    pennate.optimize(path, folder / "here", draw=False)
    with concurrent.futures.ProcessPoolExecutor(2, multiprocessing.get_context("spawn")) as executor:
        pennate.optimize(path, folder / "there", executor=executor, draw=False)
    assert (folder / "there" / "designs.csv").read_bytes() == (folder / "here" / "designs.csv").read_bytes()


def test_a_search_that_is_killed_twice_goes_on_to_the_same_bytes(folder: Path) -> None:
    pytest.importorskip("pymoo")
    path = study(folder, FRONT.replace("generations = 4", "generations = 60"))
    pennate.optimize(path, folder / "whole", draw=False)
    whole = (folder / "whole" / "designs.csv").read_bytes()
    command = [sys.executable, "-m", "pennate", "optimize", str(path), "-o", str(folder / "killed"), "--threads", "1"]
    table = folder / "killed" / "designs.csv"
    for part in (0.2, 0.6):
        with subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as search:
            while search.poll() is None and (not table.exists() or table.stat().st_size < part * len(whole)):
                time.sleep(0.002)
            search.send_signal(signal.SIGKILL)
        assert whole.startswith(table.read_bytes())
    again = pennate.optimize(path, folder / "killed")
    assert table.read_bytes() == whole and 0 < again.solved < len(again.designs)


def test_an_interrupt_keeps_whole_batches_and_writes_what_was_found(folder: Path) -> None:
    pytest.importorskip("pymoo")
    path = study(folder, FRONT)

    def interrupt(entry: dict[str, float]) -> None:
        if entry["batch"] == 2:
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        pennate.optimize(path, folder / "out", progress=interrupt)
    names = {each.name for each in (folder / "out").iterdir()}
    assert {"designs.csv", "front.csv", "progress.csv", "picks.json", "pick_1.toml"} <= names
    cut = (folder / "out" / "designs.csv").read_bytes()
    pennate.optimize(path, folder / "out")
    whole = (folder / "out" / "designs.csv").read_bytes()
    assert whole.startswith(cut) and len(whole) > len(cut)


def test_front_has_no_design_that_another_one_beats(folder: Path) -> None:
    pytest.importorskip("pymoo")
    outcome = pennate.optimize(study(folder, FRONT), folder / "out")
    assert len(outcome.best) > 1
    for one in outcome.best:
        assert one.violation == 0.0 and one.x[0] / one.x[1] <= 150
        assert not any(all(b > a for a, b in zip(one.wanted, other.wanted)) for other in outcome.designs if other.violation == 0)


def test_targets_are_met_and_the_pick_is_that_design(folder: Path) -> None:
    pytest.importorskip("scipy")
    outcome = pennate.optimize(study(folder, TARGET), folder / "out")
    assert abs(outcome.best[0].wanted[0] - 5) < 1e-3
    pick = pennate.load(folder / "out" / "pick_1.toml")
    assert abs(pick.solve()["drop"] - 5) < 2e-3
    # The file of the study's network with two other numbers.
    lines = zip((folder / "out" / "pick_1.toml").read_text().splitlines(), (folder / "wire.toml").read_text().splitlines())
    assert [old[:12] for new, old in lines if new != old] == ["parameters ="]


def test_targets_out_of_reach_end_at_the_bound_where_a_table_ends(tmp_path: Path) -> None:
    pytest.importorskip("scipy")
    dyad = pennate.scene("dyad")
    far = 1.2 * dyad.set(pressure=25).solve()["stroke"][0]
    text = f"""
format = "pennate-study/1"
network = {{ scene = "dyad" }}
[variables]
pressure = {{ from = 12, to = 25 }}
[targets]
stroke = {{ value = "= stroke", is = {far} }}
[search]
screen = 3
"""
    outcome = pennate.optimize(study(tmp_path, text), tmp_path / "out", draw=False)
    assert outcome.best[0].x[0] == pytest.approx(25, abs=1e-6)
    assert {design.status for design in outcome.designs} == {"solved"}


def test_one_objective_goes_to_its_bound(folder: Path) -> None:
    pytest.importorskip("cma")
    text = VARIABLES + '[objectives]\ndrop = { minimize = "= drop" }\n[search]\ngenerations = 40\n'
    outcome = pennate.optimize(study(folder, text), folder / "out")
    length, diameter = outcome.best[0].x
    assert length == pytest.approx(50, abs=1) and diameter == pytest.approx(2, abs=0.02)


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ("seed = 3", "sede = 3", 4, "no key 'sede'"),
        ("from = 50", "from = 500", 6, "goes from 500 to 200"),
        ("d = { from", "e = { from", 7, "no parameter 'e'"),
        ("= L / d", "= L / sinn(d)", 10, "no function 'sinn'"),
        ("drop@push", "drob@push", 12, "refers to 'drob@push'"),
        ("[search]", '[search]\nmethod = "nsga3"', 15, "no method 'nsga3'"),
        ("most = 150", "scale = 1", 10, "needs a value, and least or most"),
        ('network = "wire.toml"', 'network = "wires.toml"', 3, "no network file"),
        ('network = "wire.toml"', 'network = { scene = "nix" }', 3, "no such scene"),
        ("from = 50", "from = 50, start = 900", 6, "starts at 900, beyond 200"),
        ("most = 150", "most = 150, least = 200", 10, "at least 200 and at most 150"),
        ("population = 12", "population = 2.5", 15, "'population' is 2.5"),
        ("= L / d", "= " + "(" * 101 + "L" + ")" * 101, 10, "nested too deeply"),
        ("= L / d", "= acos(L, d)", 10, "'acos' takes 1 value(s), not 2"),
        ("from = 50", 'from = "= 20 * d"', 6, "refers to 'd', which is a variable"),
        ("to = 200", 'to = "= long"', 6, "refers to 'long', which follows 'd'"),
        ("to = 200", 'to = "= drop"', 6, "refers to 'drop', which is a probe"),
        ("[search]", '[tolerances]\nF = "= L"\n[search]', 15, "refers to 'L', which is a variable"),
        ("[search]", "[tolerances]\nX = 1\n[search]", 15, "no parameter 'X' that could be off"),
        ("[search]", "[tolerances]\nL = -1\n[search]", 15, "tolerance 'L' is -1"),
        ("[search]", "[parameters]\nF = true\n[search]", 15, "'F' cannot be True"),
        ("[search]", '[pick]\nspread = "five"\n[search]', 15, "'spread' is 'five'"),
        ("[search]", "[search]\nreference = { foo = 1 }", 15, "no objective 'foo'"),
        ("[search]", '[search]\nfirst = "no.csv"', 15, "cannot be read"),
        ("to = 200", "to = nan", 6, "'to' is nan"),
        ("most = 150", "most = nan", 10, "'most' is nan"),
        ("seed = 3", "title = 3", 4, "'title' is 3"),
        ("population = 12", "population = 0", 15, "'population' is 0"),
        ("generations = 4", "generations = 0", 16, "'generations' is 0"),
        ("= drop@push", "= drop@push^", 12, "no expression"),
    ],
)
def test_wrong_studies_are_refused_with_their_line(folder: Path, old: str, new: str, line: int, message: str) -> None:
    assert old in FRONT
    with pytest.raises(pennate.StudyError) as raised:
        pennate.optimize(study(folder, FRONT.replace(old, new, 1)), folder / "out")
    finding = raised.value.errors[0]
    assert message in finding.message and finding.line == line and finding.help


@pytest.mark.parametrize(
    ("settings", "message"),
    [({"L": 100.0}, "'L' is looked for"), ({"F": float("nan")}, "cannot be set to nan"), ({"G": 1.0}, "no parameter 'G' to set")],
)
def test_wrong_settings_are_refused(folder: Path, settings: dict[str, float], message: str) -> None:
    with pytest.raises(pennate.StudyError, match=message):
        pennate.optimize(study(folder, FRONT), folder / "out", settings=settings)


def test_probes_after_a_step_bind_closer_than_operators(folder: Path) -> None:
    pytest.importorskip("pymoo")
    text = FRONT.replace('"= drop@push"', '"= -2 * drop@push^2 + drop"')
    design = pennate.optimize(study(folder, text), folder / "out").designs[0]
    drop = dict(zip(("drop", "drop@push"), design.probes))
    assert design.wanted[0] == pytest.approx(-2 * drop["drop@push"] ** 2 + drop["drop"])


def test_ranges_may_have_units(folder: Path) -> None:
    (folder / "wire.toml").write_text(NETWORK.replace("L = 100", 'L = "10 cm"'))
    text = FRONT.replace("from = 50", 'from = "5 cm", start = "70 mm"').replace("to = 200", "to = 20")
    variable = pennate.read_study(study(folder, text)).variables[0]
    # Numbers are in the unit of the parameter.
    assert (variable.low, variable.start, variable.high) == pytest.approx((5.0, 7.0, 20.0))


def test_files_of_somebody_else_are_left_alone(folder: Path) -> None:
    pytest.importorskip("pymoo")
    out = folder / "out"
    out.mkdir()
    (out / "front.csv").write_text("mine")
    with pytest.raises(pennate.StudyError, match=r"front\.csv is no file of a search"):
        pennate.optimize(study(folder, FRONT), out)
    assert [each.name for each in out.iterdir()] == ["front.csv"] and (out / "front.csv").read_text() == "mine"
    (out / "front.csv").rename(out / "pick_mine.toml")
    pennate.optimize(study(folder, FRONT), out)
    assert (out / "pick_mine.toml").read_text() == "mine" and (out / "pick_1.toml").exists()


def test_a_search_ends_after_its_minutes(folder: Path) -> None:
    pytest.importorskip("pymoo")
    text = FRONT.replace("generations = 4", "generations = 4\nstop = { minutes = 1e-9 }")
    assert pennate.optimize(study(folder, text), folder / "out").progress == []


def test_kinds_of_failures_are_counted_batch_by_batch(folder: Path) -> None:
    pytest.importorskip("pymoo")
    text = FRONT.replace('"= drop@push"', '"= sqrt(drop@push - 1)"')
    outcome = pennate.optimize(study(folder, text), folder / "out")
    failed = sum(design.status == "no_value" for design in outcome.designs)
    head, *lines = (folder / "out" / "progress.csv").read_text().splitlines()
    assert failed > 0 and head.split(",")[-1] == "no_value" and lines[-1].split(",")[-1] == str(failed)


def test_a_directory_of_another_study_is_left_alone(folder: Path) -> None:
    pytest.importorskip("scipy")
    pennate.optimize(study(folder, TARGET), folder / "out")
    before = (folder / "out" / "designs.csv").read_bytes()
    with pytest.raises(pennate.StudyError, match="other variables"):
        pennate.optimize(study(folder, TARGET.replace("to = 200", "to = 190")), folder / "out")
    with pytest.raises(pennate.StudyError, match="another seed"):
        pennate.optimize(study(folder, TARGET), folder / "out", seed=4)
    assert (folder / "out" / "designs.csv").read_bytes() == before


def test_tolerances_make_objectives_the_worst_that_may_be(folder: Path) -> None:
    pytest.importorskip("pymoo")
    text = FRONT.replace("[search]", '[tolerances]\nL = 0.5\nF = "= 0.02 * F"\n[search]')
    outcome = pennate.optimize(study(folder, text), folder / "out")
    network = outcome.study.network
    for design in outcome.best[::4]:
        values = dict(zip(("L", "d"), design.x))

        def drop(**off: float) -> float:
            return float(network.set(**{**values, **off}).solve(accuracy=1e-4)["drop"][0])

        spread = abs(drop(L=values["L"] + 0.5) - drop(L=values["L"] - 0.5)) / 2 + abs(drop(F=1.02) - drop(F=0.98)) / 2
        assert design.spread[0] == pytest.approx(spread, rel=2e-2)
        assert design.wanted[0] == pytest.approx(drop() - spread, rel=1e-3)
        assert design.spread[1] == pytest.approx(0.5 * values["d"] ** 2)
    head = (folder / "out" / "front.csv").read_text().splitlines()[0].split(",")
    assert head[6:8] == ["drop_spread", "lightness_spread"]


def test_a_search_begins_with_the_designs_of_a_table(folder: Path) -> None:
    pytest.importorskip("pymoo")
    (folder / "first.csv").write_text("d,number,L\n1.25,1,120.0\n1.5,2,60.0\n")
    outcome = pennate.optimize(study(folder, FRONT), folder / "out", first=folder / "first.csv")
    assert [design.x for design in outcome.designs[:2]] == [(120.0, 1.25), (60.0, 1.5)]
    with pytest.raises(pennate.StudyError, match="no table of designs"):
        (folder / "first.csv").write_text("d,number\n1.25,1\n")
        pennate.optimize(study(folder, FRONT), folder / "other", first=folder / "first.csv")


@pytest.mark.parametrize(
    ("cell", "message"),
    [
        ("nan", "row 2 of .*first.csv has nan for 'L', which goes from 50 to 200"),
        ("-inf", "row 2 of .*first.csv has -inf for 'L', which goes from 50 to 200"),
        ("200.1", "row 2 of .*first.csv has 200.1 for 'L', which goes from 50 to 200"),
        ("", "no table of designs"),
    ],
)
def test_designs_beyond_the_ranges_are_none_to_begin_with(folder: Path, cell: str, message: str) -> None:
    (folder / "first.csv").write_text(f"L,d\n200.0000000000001,1\n{cell},1.5\n")
    with pytest.raises(pennate.StudyError, match=message) as raised:
        pennate.optimize(study(folder, FRONT.replace("[search]", '[search]\nfirst = "first.csv"')), folder / "out")
    assert [finding.line for finding in raised.value.errors] == [15]


def test_parameters_that_the_network_makes_of_others_follow_them(folder: Path) -> None:
    pytest.importorskip("pymoo")
    text = NETWORK.replace("F = 1,", 'F = 1, area = "= pi * d^2 / 4", weight = "= area * L",')
    (folder / "wire.toml").write_text(text)
    path = study(folder, FRONT.replace("= 1000 - L * d^2", "= 1000 - weight").replace("= L / d", "= weight / area / d"))
    outcome = pennate.optimize(path, folder / "out")
    for design in outcome.best:
        length, diameter = design.x
        assert design.wanted[1] == pytest.approx(1000 - np.pi / 4 * diameter**2 * length) and length / diameter <= 150


def test_three_objectives_have_a_front_and_a_hypervolume(folder: Path) -> None:
    pytest.importorskip("pymoo")
    text = FRONT.replace("[search]", 'thin = { minimize = "= d" }\n[search]\nreference = { thin = 2 }')
    outcome = pennate.optimize(study(folder, text), folder / "out")
    values = np.array([design.wanted for design in outcome.best]) * [-1, -1, 1]
    for k, row in enumerate(values):
        assert not any((other <= row).all() for other in np.delete(values, k, axis=0))
    assert outcome.progress[-1]["hypervolume"] > 0.0


def test_designs_that_end_unstable_count_as_failed(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pymoo")
    monkeypatch.setattr(pennate.Problem, "stable", property(lambda problem: [k % 2 == 0 for k in range(len(problem.reasons))]))
    outcome = pennate.optimize(study(folder, FRONT), folder / "out")
    assert {design.status for design in outcome.designs} == {"solved", "unstable"}
    assert all(design.stable for design in outcome.best)


def test_the_command_tells_of_its_progress_and_prints_json(folder: Path) -> None:
    pytest.importorskip("pymoo")
    path, out = study(folder, FRONT), folder / "out"
    command = [sys.executable, "-m", "pennate", "optimize", str(path), "-o", str(out), "--live", "--json"]
    done = subprocess.run(command, capture_output=True, text=True, check=True, env={**os.environ, "PYTHONWARNINGS": "error"})
    assert "batch 4 of 4" in done.stderr and "hypervolume" in done.stderr
    found = json.loads(done.stdout)
    assert found["designs"] == found["solved_now"] and found["best"][0]["stable"] is True


def test_the_picture_shows_the_front(folder: Path) -> None:
    pytest.importorskip("pymoo")
    pytest.importorskip("matplotlib")
    pennate.optimize(study(folder, FRONT), folder / "out")
    picture = (folder / "out" / "front.svg").read_text()
    assert "drop, mm (greatest is best)" in picture and "lightness (greatest is best)" in picture and "picks" in picture
    assert "designs within limits" in picture and picture.rstrip().endswith("</svg>")
    assert not list((folder / "out").glob("*.new"))


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("most = 150", "most = 1", "meets the constraints that need no solution"),
        ("most = 150", "most = 1", "of 10,000 random designs 10,000 violate 'slender'"),
        ("[objectives]", 'far = { value = "= drop", least = 1e6 }\n[objectives]', "of 48 designs with an answer 48 violate 'far'"),
        ('"= drop@push"', '"= sqrt(-drop@push)"', "48 designs have no answer: an objective or target is no number"),
    ],
)
def test_the_command_says_why_there_is_nothing_to_show(
    folder: Path, capsys: pytest.CaptureFixture[str], old: str, new: str, message: str
) -> None:
    pytest.importorskip("pymoo")
    from pennate.__main__ import main

    path = study(folder, FRONT.replace(old, new).replace("most = 150", "most = 1000"))
    assert main(["optimize", str(path), "-o", str(folder / "out")]) == 1
    assert message in capsys.readouterr().err


def muscle_study(folder: Path) -> Path:
    """A study of the dyad with a muscle that stands in a file of its own."""
    muscle = """
diameter = 13
wall = 2.0
pressure_unit = "psi"
table = [{ pressure = 15, E = 3.66, alpha = -8.526e-3, R1 = 6.95, R2 = 8.35 }]
"""
    (folder / "muscles").mkdir()
    (folder / "muscles" / "own.toml").write_text(muscle)
    network = """
format = "pennate/1"
dimension = "plane"
parameters = { beta = 22 }
nodes = { A = ["= -100 * cos(beta)", "= -100 * sin(beta)"], B = ["= 100 * cos(beta)", "= -100 * sin(beta)"], J = [0, 0] }
muscles = { own = { file = "muscles/own.toml" } }
members = { left = { nodes = ["A", "J"], muscle = "own" }, right = { nodes = ["B", "J"], muscle = "own" } }
supports = { A = "clamped", B = "clamped" }
steps = [{ name = "inflate", pressure = { all = 15 } }]
probes = { stroke = { node = "J", displacement = "uy" } }
"""
    (folder / "dyad.toml").write_text(network)
    text = """
format = "pennate-study/1"
network = "dyad.toml"
variables = { beta = { from = 15, to = 40 } }
targets = { stroke = { value = "= stroke", is = -20 } }
search = { screen = 3, starts = 1 }
"""
    return study(folder, text)


def test_designs_of_another_muscle_file_are_left_alone(tmp_path: Path) -> None:
    pytest.importorskip("scipy")
    path = muscle_study(tmp_path)
    pennate.optimize(path, tmp_path / "out", draw=False)
    assert pennate.optimize(path, tmp_path / "out", draw=False).solved == 0
    muscle = tmp_path / "muscles" / "own.toml"
    muscle.write_text(muscle.read_text().replace("E = 3.66", "E = 7.32"))
    with pytest.raises(pennate.StudyError, match="was solved with another network"):
        pennate.optimize(path, tmp_path / "out", draw=False)


def test_picks_of_a_network_with_a_muscle_file_can_be_solved(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("scipy")
    muscle_study(tmp_path)
    monkeypatch.chdir(tmp_path)
    outcome = pennate.optimize("study.toml", "out", draw=False)
    monkeypatch.chdir(tmp_path.parent)
    assert pennate.load(tmp_path / "out" / "pick_1.toml").solve()["stroke"] == pytest.approx(outcome.best[0].wanted[0], rel=1e-3)


@pytest.mark.parametrize("scale", ["1", "1e9", "-1e-9"])
def test_the_scale_of_an_objective_changes_nothing_of_a_search(folder: Path, scale: str) -> None:
    pytest.importorskip("cma")
    objective = f'[objectives]\nfar = {{ minimize = "= {scale} * ((L - 60)^2 / 1e4 + (d - 1)^2 + 1)" }}\n'
    objective = objective.replace("minimize", "maximize") if scale.startswith("-") else objective
    limits = '[constraints]\nlong = { value = "= L", least = 80 }\n[search]\ngenerations = 60\n'
    outcome = pennate.optimize(study(folder, VARIABLES + objective + limits), folder / "out", draw=False)
    # A design that violates the limit is never taken for a better one.
    assert outcome.best[0].x == pytest.approx((80, 1), abs=0.1)


def test_designs_are_ranked_by_feasibility_before_cost() -> None:
    from pennate._optimize._search import ranks

    value = np.array([5e12, 3.0, np.inf, 1.0, 3.0, -7.0])
    violation = np.array([0.0, 0.0, np.inf, 2.0, 0.0, 0.5])
    assert ranks(value, violation).tolist() == [1, 0, 4, 3, 0, 2]


@pytest.mark.parametrize("value", ["= drop / 0", "= -drop / 0", "= 0 * drop / 0", "= drop * 1e308 * 1e308"])
def test_a_constraint_without_a_value_is_violated_and_the_search_goes_on(folder: Path, value: str) -> None:
    pytest.importorskip("pymoo")
    text = FRONT.replace("[objectives]", f'ratio = {{ value = "{value}", most = 5 }}\n[objectives]')
    first = pennate.optimize(study(folder, text), folder / "out", draw=False)
    assert first.solved > 0 and not first.best and {design.violation for design in first.designs} == {np.inf}
    again = pennate.optimize(study(folder, text), folder / "out", draw=False)
    assert again.solved == 0
    assert repr(again.designs) == repr(first.designs)


def test_a_shorter_search_in_the_directory_of_a_longer_one_writes_what_it_writes_alone(folder: Path) -> None:
    pytest.importorskip("cma")
    text = VARIABLES + '[targets]\ndrop = { value = "= drop", is = 5 }\n[search]\nmethod = "cma-es"\ngenerations = 30\n'
    pennate.optimize(study(folder, text), folder / "out", draw=False)
    longer = (folder / "out" / "designs.csv").read_bytes()
    path = study(folder, text.replace("generations = 30", "generations = 2"))
    after = pennate.optimize(path, folder / "out", draw=False)
    alone = pennate.optimize(path, folder / "alone", draw=False)
    for name in ("best.csv", "progress.csv", "picks.json", "pick_1.toml"):
        assert (folder / "out" / name).read_bytes() == (folder / "alone" / name).read_bytes()
    assert (folder / "out" / "designs.csv").read_bytes() == longer and len(after.designs) == len(alone.designs)


@pytest.mark.parametrize(("text", "budgets"), [(FRONT, (12, 13, 30)), (TARGET, (6, 7, 9))], ids=["front", "targets"])
def test_no_more_designs_are_solved_than_the_budget_has(folder: Path, text: str, budgets: tuple[int, ...]) -> None:
    pytest.importorskip("pymoo")
    path = study(folder, text.replace("stop = { error = 1e-3 }", "stop = { error = 1e-9 }"))
    pennate.optimize(path, folder / "whole", draw=False)
    whole = (folder / "whole" / "designs.csv").read_bytes()
    for budget in budgets:
        outcome = pennate.optimize(path, folder / "out", budget=budget, draw=False)
        assert 0 < len(outcome.designs) <= budget
        assert whole.startswith((folder / "out" / "designs.csv").read_bytes())
    pennate.optimize(path, folder / "out", draw=False)
    assert (folder / "out" / "designs.csv").read_bytes() == whole


def test_a_budget_below_the_first_batch_is_refused(folder: Path) -> None:
    pytest.importorskip("pymoo")
    with pytest.raises(pennate.StudyError, match="the budget of 11 is less than the first batch of 12 designs"):
        pennate.optimize(study(folder, FRONT), folder / "out", budget=11, draw=False)
    for budget in (0, float("nan")):
        with pytest.raises(ValueError, match="budget"):
            pennate.optimize(study(folder, FRONT), folder / "other", budget=budget, draw=False)


@pytest.mark.parametrize("stop", ["error = 1e9", "evaluations = 1", "minutes = 1e-9"])
def test_least_squares_may_end_with_the_designs_that_are_solved_first(folder: Path, stop: str) -> None:
    pytest.importorskip("scipy")
    outcome = pennate.optimize(study(folder, TARGET.replace("error = 1e-3", stop)), folder / "out", draw=False)
    assert len(outcome.designs) == 6 and len(outcome.best) == 1


def test_two_searches_in_one_directory_are_kept_apart(folder: Path) -> None:
    pytest.importorskip("pymoo")
    path = study(folder, FRONT)
    seen: list[str] = []

    def another(entry: dict[str, float]) -> None:
        with pytest.raises(pennate.StudyError) as raised:
            pennate.optimize(path, folder / "out", draw=False)
        seen.append(str(raised.value))
        command = [sys.executable, "-m", "pennate", "optimize", str(path), "-o", str(folder / "out")]
        if len(seen) == 1:
            done = subprocess.run(command, capture_output=True, text=True, check=False)
            assert done.returncode == 2 and "another search is at work" in done.stderr and str(os.getpid()) in done.stderr

    outcome = pennate.optimize(path, folder / "out", draw=False, progress=another)
    assert len(seen) == 4 and f"process {os.getpid()}" in seen[0]
    rows = (folder / "out" / "designs.csv").read_text().splitlines()[1:]
    assert len(rows) == len(outcome.designs) == len(set(rows))
    assert pennate.optimize(path, folder / "out", draw=False).solved == 0


@pytest.mark.skipif(not hasattr(os, "fork"), reason="workers are forked")
def test_a_search_that_died_keeps_nobody_out_by_its_workers(tmp_path: Path) -> None:
    code = """
import os, pathlib, sys, time
from pennate._optimize._lock import locked
with locked(pathlib.Path(sys.argv[1])):
    if os.fork() == 0:
        print("forked", flush=True)
        time.sleep(60)
    else:
        time.sleep(60)
"""
    with subprocess.Popen([sys.executable, "-c", code, str(tmp_path)], stdout=subprocess.PIPE, start_new_session=True) as search:
        assert search.stdout is not None
        search.stdout.readline()
        from pennate._optimize._lock import locked

        with pytest.raises(pennate.StudyError, match="another search"), locked(tmp_path):
            pass
        search.kill()
        search.wait()
        with locked(tmp_path):
            pass
        os.killpg(search.pid, signal.SIGKILL)


def table(path: Path) -> list[dict[str, str]]:
    """The rows of a table by their columns."""
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


@pytest.mark.parametrize(("text", "name"), [(FRONT, "front.csv"), (TARGET, "best.csv")], ids=["front", "targets"])
def test_the_best_designs_are_solved_once_more_each_by_itself(folder: Path, text: str, name: str) -> None:
    pytest.importorskip("pymoo")
    outcome = pennate.optimize(study(folder, 'accuracy = 1e-2\n' + text.lstrip()), folder / "out", draw=False)
    assert len(outcome.checked) == len(outcome.best)
    for row, design, other in zip(table(folder / "out" / name), outcome.best, outcome.checked):
        alone = outcome.study.network.set(**dict(zip(("L", "d"), design.x))).solve(accuracy=1e-4)
        assert other is not None and other.status == row["checked"] == alone.status == "converged"
        assert row["checked_stable"] == "true" and float(row["drop_checked"]) == other.wanted[0] == alone["drop"][-1]
        assert design.wanted[0] == pytest.approx(other.wanted[0], rel=1e-2)


def test_the_mesh_serves_designs_all_over_the_ranges(folder: Path) -> None:
    pytest.importorskip("pymoo")
    text = FRONT.replace("d = { from = 1, to = 2 }", "F = { from = 0.001, to = 30, start = 0.001 }")
    text = text.replace("L / d", "L / 10").replace("L * d^2", "L")
    x = [[190.0, 29.0], [60.0, 15.0]]
    read = pennate.read_study(study(folder, text))
    for (length, force), design in zip(x, pennate._optimize.evaluate(read, np.array(x))):
        alone = read.network.set(L=length, F=force).solve(accuracy=1e-8)
        assert design.wanted[0] == pytest.approx(alone["drop"][-1], rel=1e-4)


def test_designs_of_the_front_that_do_not_hold_by_themselves_are_told(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("pymoo")
    from pennate.__main__ import main
    from pennate._optimize import _check
    from pennate._sweep._alone import Row

    solved = _check.solved_alone

    def doubtful(network: pennate.Network, names: list[str], x: tuple[float, ...], *others: Any) -> Row:
        row = solved(network, names, x, *others)
        if x[0] < 80:
            return Row([float("nan")] * len(row.values), "bifurcation", None)
        if x[0] < 100:
            return dataclasses.replace(row, stable=False)
        return dataclasses.replace(row, values=[0.9 * value for value in row.values]) if x[0] > 150 else row

    monkeypatch.setattr(_check, "solved_alone", doubtful)
    path = study(folder, FRONT.replace("generations = 4", "generations = 12"))
    assert main(["optimize", str(path), "-o", str(folder / "out")]) == 0
    lengths = [float(row["L"]) for row in table(folder / "out" / "front.csv")]
    counts = [sum(low <= length < high for length in lengths) for low, high in ((0, 80), (80, 100), (150, 999))]
    told = capsys.readouterr().out
    assert min(counts) > 0
    assert f"the {len(lengths)} designs of the front, solved once more at 1e-06" in told
    assert f"{counts[0]} with the end 'bifurcation'" in told and f"{counts[1]} with the end 'unstable'" in told
    assert f"{counts[2]} off by more than 0.0001 of the largest value, by up to 0.1 " in told
    assert "help: a search with accuracy = 1e-05 in the study has a finer mesh" in told
    monkeypatch.setattr(pennate.Solution, "status", property(lambda solution: "limit_point"))
    assert main(["optimize", str(path), "-o", str(folder / "out"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out, parse_constant=pytest.fail)
    assert [each["checked"]["status"] for each in found["best"]].count("bifurcation") == counts[0]
    assert {pick["status"] for pick in found["picks"]} == {"limit_point"}


def test_of_very_many_designs_some_along_the_front_are_solved_once_more(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("pymoo")
    from pennate._optimize import _check

    monkeypatch.setattr(_check, "MOST", 3)
    outcome = pennate.optimize(study(folder, FRONT), folder / "out", draw=False)
    looked_at = [place for place, each in enumerate(outcome.checked) if each]
    assert len(looked_at) == 3 < len(outcome.best) and looked_at[0] == 0 and looked_at[-1] == len(outcome.best) - 1
    assert [bool(row["checked"]) for row in table(folder / "out" / "front.csv")].count(True) == 3


def by_the_network(text: str) -> float:
    """The value of an expression as network files have it, of a = 7 and b = 2.5."""
    escaped = text.replace('"', '\\"')
    old = 'L = 100, d = 1.5, F = 1, long = "= 100 * max(1, d, F)"'
    return pennate.loads(NETWORK.replace(old, f'{old}, a = 7, b = 2.5, c = "= {escaped}"')).parameters["c"]


def by_the_study(text: str) -> float:
    """The same as studies have it, for the first of two designs."""
    from pennate._optimize._expression import Expression

    found = Expression(f"= {text}")({"a": np.array([7.0, 1.0]), "b": 2.5})
    return float(np.broadcast_to(found, 2)[0])


@pytest.mark.parametrize(
    "text",
    [
        *("1 + 2 * 3 - -4", "-2^2", "2^-1", "2^3^2", "2 * -3^2", "8 / 4 / 2", "1 − 2 · 3 × 4", "--2", "5. + .5e1", "pi"),
        *("max(1) - min(3, 2, 5)", "sin(30) + sin(150)", "cos(90) + sin(180)", "sin(-360)", "tan(45)", "atan2(1, -1)"),
        *("asin(0.3) * acos(-0.3) + atan(7)", "sqrt(a) + abs(-b) + exp(a / 9) + ln(b)", "cos(200.7 * a)", "'a' + \"b\""),
        *("+".join(["a"] * 3000), "(" * 100 + "a" + ")" * 100, "-" * 100 + "a"),
    ],
)
def test_expressions_of_studies_are_those_of_network_files(text: str) -> None:
    assert by_the_study(text) == pytest.approx(by_the_network(text), rel=1e-14, abs=0.0)


@pytest.mark.parametrize(
    "text",
    ["acos(2)", "1 / 0", "min(1 / 0, a)", "(0 / 0)^0", "1^(1 / 0)", "sqrt(-1)", "ln(0)", "tan(90)", "1e200 * 1e200", "1e999"],
)
def test_expressions_without_a_value_have_none_in_studies_either(text: str) -> None:
    with pytest.raises(pennate.NetworkError):
        by_the_network(text)
    assert np.isnan(by_the_study(text))


@pytest.mark.parametrize(
    "text",
    [
        *("", "1 +", "1_000", "0x10", "2**3", "1e", "(1", "1)", "min()", "atan2(1)", "sin(1, 2)", "foo(1)", "a b", "a@", "'a", "²"),
        "(" * 101 + "a" + ")" * 101,
    ],
)
def test_what_is_no_expression_in_network_files_is_none_in_studies(text: str) -> None:
    with pytest.raises(pennate.NetworkError):
        by_the_network(text)
    with pytest.raises(ValueError, match="no expression"):
        by_the_study(text)
