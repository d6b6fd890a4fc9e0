"""Studies: the same designs whatever happens on the way, and studies that are wrong."""

from __future__ import annotations

import concurrent.futures
from pathlib import Path

import pytest

import pennate

NETWORK = """
format = "pennate/1"
dimension = "plane"
parameters = { L = 100, d = 1.5, F = 1 }
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


def test_designs_are_the_same_bytes_for_any_number_of_threads_and_after_any_interrupt(folder: Path) -> None:
    pytest.importorskip("pymoo")
    path = study(folder, FRONT)
    pennate.optimize(path, folder / "one", threads=1)
    pennate.optimize(path, folder / "two", threads=2)
    whole = (folder / "one" / "designs.csv").read_bytes()
    assert (folder / "two" / "designs.csv").read_bytes() == whole
    for part in (0.0, 0.05, 0.3, 0.7, 0.999):
        (folder / "two" / "designs.csv").write_bytes(whole[: int(part * len(whole))])
        outcome = pennate.optimize(path, folder / "two", threads=2)
        assert (folder / "two" / "designs.csv").read_bytes() == whole
        assert outcome.solved > 0
    assert pennate.optimize(path, folder / "two").solved == 0


def test_an_executor_gives_the_same_bytes(folder: Path) -> None:
    path = study(folder, TARGET)
    pennate.optimize(path, folder / "one", threads=1)
    with concurrent.futures.ThreadPoolExecutor(2) as executor:
        pennate.optimize(path, folder / "two", executor=executor)
    assert (folder / "two" / "designs.csv").read_bytes() == (folder / "one" / "designs.csv").read_bytes()


def test_front_has_no_design_that_another_one_beats(folder: Path) -> None:
    pytest.importorskip("pymoo")
    outcome = pennate.optimize(study(folder, FRONT), folder / "out")
    assert len(outcome.best) > 1
    for one in outcome.best:
        assert one.violation == 0.0 and one.x[0] / one.x[1] <= 150
        assert not any(all(b > a for a, b in zip(one.wanted, other.wanted)) for other in outcome.designs if other.violation == 0)


def test_targets_are_met_and_the_pick_is_that_design(folder: Path) -> None:
    outcome = pennate.optimize(study(folder, TARGET), folder / "out")
    assert abs(outcome.best[0].wanted[0] - 5) < 1e-3
    pick = pennate.load(folder / "out" / "pick_1.json")
    assert abs(pick.solve()["drop"] - 5) < 2e-3


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
    ],
)
def test_wrong_studies_are_refused_with_their_line(folder: Path, old: str, new: str, line: int, message: str) -> None:
    assert old in FRONT
    with pytest.raises(pennate.StudyError) as raised:
        pennate.optimize(study(folder, FRONT.replace(old, new, 1)), folder / "out")
    finding = raised.value.errors[0]
    assert message in finding.message and finding.line == line and finding.help


def test_a_directory_of_another_study_is_left_alone(folder: Path) -> None:
    pennate.optimize(study(folder, TARGET), folder / "out")
    before = (folder / "out" / "designs.csv").read_bytes()
    with pytest.raises(pennate.StudyError, match="other variables"):
        pennate.optimize(study(folder, TARGET.replace("to = 200", "to = 190")), folder / "out")
    with pytest.raises(pennate.StudyError, match="another seed"):
        pennate.optimize(study(folder, TARGET), folder / "out", seed=4)
    assert (folder / "out" / "designs.csv").read_bytes() == before
