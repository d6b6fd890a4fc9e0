"""Solutions give what the program writes."""

from __future__ import annotations

import json
import pathlib
import pickle
import subprocess
import sys

import numpy as np
import pytest

import pennate
from conftest import DYAD


def test_probes_are_arrays_over_the_steps(solution: pennate.Solution) -> None:
    assert solution["stroke"].shape == (2,) and solution["stroke"].dtype == np.float64
    assert solution["stroke"][0] == pytest.approx(-36.5296, abs=1e-3)
    assert solution["stroke@inflate"] == solution.step("inflate")["stroke"] == solution["stroke"][0]
    assert 0.0 < solution.error["stroke"][0] < 1e-4
    with pytest.raises(KeyError, match="no probe 'strike'; there are 'stroke', 'holding'"):
        solution["strike"]


def test_arrays_have_the_steps_first(solution: pennate.Solution) -> None:
    assert solution.nodes == ("A", "B", "J") and solution.members == ("left", "right")
    assert solution.displacement.shape == solution.rotation.shape == (2, 3, 3)
    assert solution.reaction.shape == (2, 3, 6) and solution.end_forces.shape == (2, 2, 2, 6)
    left = solution.step("push back").member("left")
    # The support acts on the network as on the one member that ends there.
    np.testing.assert_allclose(left.end_forces[0], solution.reaction[1, 0], atol=1e-9)
    np.testing.assert_allclose(solution.reaction[1, :, :3].sum(axis=0), 0.0, atol=1e-9)
    assert solution.step(-1).node("J").reaction[1] == pytest.approx(solution["holding"][1])
    assert left.pressure == 25.0


def test_places_that_there_are_not_are_told(solution: pennate.Solution) -> None:
    with pytest.raises(IndexError, match="there is no step number 5; there are 2: 'inflate', 'push back'"):
        solution.step(5)
    with pytest.raises(IndexError, match="there is no node number -4; there are 3: 'A', 'B', 'J'"):
        solution.step(0).node(-4)  # type: ignore[arg-type]
    for wrong in (1.5, None, [0]):
        with pytest.raises(TypeError, match="step: a name or a number expected, not .*; there are 'inflate', 'push back'"):
            solution.step(wrong)  # type: ignore[arg-type]
    with pytest.raises(KeyError, match="there is no probe 0; there are 'stroke', 'holding'"):
        solution[0]  # type: ignore[index]
    with pytest.raises(KeyError, match="there is no step ''; there are 'inflate', 'push back'"):
        solution["stroke@"]
    assert solution["stroke @ inflate"] == solution["stroke@inflate"]


def test_what_is_given_away_may_be_changed(solution: pennate.Solution) -> None:
    def arrays() -> list[np.ndarray]:
        names = ("displacement", "rotation", "reaction", "end_forces", "length", "axial_force", "pressure", "energy", "spring_force")
        step = solution.step("inflate")
        parts = [step.displacement, step.node("J").displacement, step.member("left").end_forces]
        return [*(getattr(solution, name) for name in names), *parts, solution["stroke"], solution.history["stroke"]]

    before = [array.copy() for array in arrays()]
    for array in arrays():
        array += 1.0
    for array, old in zip(arrays(), before):
        np.testing.assert_array_equal(array, old)
    assert "stroke" in solution and "strike" not in solution and 0 not in solution


def test_the_dictionary_is_what_the_program_writes(solution: pennate.Solution, tmp_path: pathlib.Path) -> None:
    file = tmp_path / "dyad.toml"
    file.write_text(DYAD)
    command = [sys.executable, "-W", "error", "-m", "pennate", "solve", str(file), "--json", "-o", str(tmp_path)]
    printed = subprocess.run(command, capture_output=True, text=True, check=True)
    assert printed.stderr == ""
    found, ours = json.loads(printed.stdout), solution.to_dict()
    for each in (found, ours):
        del each["timing"], each["input"]["files"]
    assert found == ours
    rows = (tmp_path / "history.csv").read_text().splitlines()
    units = solution.history.units
    assert rows[0] == ",".join(["step", *(f"{name} ({unit})" if unit else name for name, unit in units.items())])
    assert len(rows) - 1 == len(solution.history.steps)
    last = [float(value) for value in rows[-1].split(",")[1:]]
    np.testing.assert_array_equal(last, [values[-1] for values in solution.history.values()])


def test_a_history_has_every_increment(dyad: pennate.Network) -> None:
    solution = dyad.edit(steps={"inflate": {"increments": 5}}).solve()
    inflate = solution.history.of_step("inflate")
    np.testing.assert_allclose(inflate["fraction"], solution.fractions("inflate"))
    assert len(inflate["stroke"]) >= 5 and (np.diff(inflate["pressure all"]) > 0).all()


def test_steps_that_fail_are_part_of_the_solution(snap: pennate.Network) -> None:
    solution = snap.solve()
    assert solution.status == "bifurcation" and 0.0 < solution.fraction[0] < 1.0
    with pytest.raises(pennate.SolveError, match="(?s)ends at a bifurcation.*help: ") as caught:
        solution.raise_for_status()
    assert caught.value.solution is solution and caught.value.errors[0].file == "snap.toml"
    assert np.isfinite(solution["down"][0]) and np.isfinite(solution.displacement[0]).all()
    assert np.isnan(solution["down"][1]) and np.isnan(solution.displacement[1]).all()
    assert solution.step("more").status == "not_reached" and solution.step("more").fraction == 0.0
    assert "press (bifurcation at" in repr(solution)


def test_solutions_are_pickled_whole(solution: pennate.Solution) -> None:
    again = pickle.loads(pickle.dumps(solution))
    assert repr(again) == repr(solution) and str(again) == str(solution) and again.to_dict() == solution.to_dict()
    for name in ("displacement", "rotation", "reaction", "end_forces", "energy", "axial_force", "spring_force"):
        np.testing.assert_array_equal(getattr(again, name), getattr(solution, name))
    for step in ("unloaded", 0, 1):
        ours, theirs = solution.drawing(step), again.drawing(step)
        np.testing.assert_array_equal(ours["points"], theirs["points"])
    assert pickle.loads(pickle.dumps(again))["stroke"][0] == solution["stroke"][0]
    assert again.network == solution.network


def test_results_do_not_depend_on_threads(dyad: pennate.Network, solution: pennate.Solution) -> None:
    np.testing.assert_array_equal(dyad.solve(threads=2, shapes=False).displacement, solution.displacement)


def test_shapes_may_be_left_out(dyad: pennate.Network) -> None:
    with pytest.raises(ValueError, match="shapes"):
        dyad.solve(shapes=False).drawing()


def test_a_solution_says_what_it_is(solution: pennate.Solution) -> None:
    assert repr(solution).startswith("<Solution 'pennate dyad': converged, steps inflate, push back, probes stroke")
    assert "rounding leaves" in str(solution)
    assert repr(solution.history) == "<History: 3 rows of fraction, pressure all, stroke, holding>"
    assert "stroke" in solution._ipython_key_completions_()


@pytest.mark.parametrize("wrong", [{"accuracy": 0.0}, {"accuracy": float("nan")}, {"threads": 0}, {"threads": 1.5}])
def test_options_are_checked(dyad: pennate.Network, wrong: dict[str, float]) -> None:
    with pytest.raises(ValueError, match=next(iter(wrong))):
        dyad.solve(**wrong)  # type: ignore[arg-type]
