"""NSGA-II on arrays asks for the designs that pymoo's own asks for."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

Values = npt.NDArray[np.float64]


def answers(x: Values, objectives: int, step: float) -> tuple[Values, Values]:
    """A front of two or three objectives with ties where they are rounded to steps; designs off limits, and some without an answer."""
    rest = 1.0 + x[:, 1:].sum(1)
    cost = np.stack([x[:, 0], rest * (1.0 - np.sqrt(x[:, 0] / rest)), x[:, -1] - x[:, 0]], axis=1)[:, :objectives]
    violation = np.where(x[:, -1] > 0.8, 1e9, np.maximum(x[:, 0] - 0.9, 0.0))
    return (np.round(cost / step) * step if step else cost), violation


@pytest.mark.parametrize(
    ("population", "variables", "objectives", "step", "seed"),
    [(100, 5, 2, 0.0, 1), (30, 4, 3, 0.0, 2), (12, 2, 2, 0.1, 3), (7, 3, 2, 0.5, 4), (2, 2, 2, 0.0, 0)],
)
def test_designs_are_those_of_pymoo_bit_for_bit(population: int, variables: int, objectives: int, step: float, seed: int) -> None:
    pytest.importorskip("pymoo")
    from pymoo.algorithms.moo.nsga2 import NSGA2 as Pymoo
    from pymoo.core.evaluator import Evaluator
    from pymoo.core.problem import Problem
    from pymoo.problems.static import StaticProblem

    from pennate._optimize._nsga2 import NSGA2

    space: Any = Problem(n_var=variables, n_obj=objectives, n_ieq_constr=1, xl=0.0, xu=1.0)
    theirs: Any = Pymoo(pop_size=population)
    theirs.setup(space, termination=("n_gen", 50), seed=seed, verbose=False)
    ours = NSGA2(population, variables, seed)
    for _ in range(50):
        asked, x = theirs.ask(), ours.ask()
        np.testing.assert_array_equal(asked.get("X"), x)
        cost, violation = answers(x, objectives, step)
        Evaluator().eval(StaticProblem(space, F=cost, G=violation[:, None]), asked)
        theirs.tell(infills=asked)
        ours.tell(cost, violation)
        np.testing.assert_array_equal(theirs.pop.get("X"), ours.population.x)


def test_no_design_is_asked_for_twice() -> None:
    pytest.importorskip("pymoo")
    from pennate._optimize._nsga2 import NSGA2

    search = NSGA2(4, 1, seed=1, first=np.zeros((4, 1)))
    assert len(search.ask()) == 1
    search.tell(np.zeros((1, 2)), np.zeros(1))
    for _ in range(20):
        asked = search.ask()
        assert len(asked) <= 4 and len(np.unique(asked)) == len(asked) and 0.0 not in asked
        search.tell(np.zeros((len(asked), 2)), np.zeros(len(asked)))
