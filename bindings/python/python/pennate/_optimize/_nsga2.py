"""NSGA-II on arrays, by the operators of pymoo.

Deb, Pratap, Agarwal and Meyarivan, IEEE Transactions on Evolutionary Computation 6, 2002. pymoo keeps an object for every
design and asks each for its values one by one, which costs as much as solving the designs; here a population is a few arrays.
What is drawn, compared and sorted is the same in the same order, so that designs are those of pymoo's `NSGA2`, bit for bit.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Values = npt.NDArray[np.float64]
Places = npt.NDArray[np.intp]

# Those of pymoo's `NSGA2`: crossover of pairs and of their variables, mutation of designs, and how near children stay.
CROSSED, EXCHANGED, MUTATED = 0.9, 0.5, 0.9
CROSSOVER, MUTATION = 15.0, 20.0
# Designs nearer than this, in 0..1, are one; so often children are drawn until there are enough others.
SAME, DRAWS = 1e-16, 100


class Population(NamedTuple):
    """Designs in 0..1, and what came of them."""

    x: Values
    """(n, variables)"""
    cost: Values
    """(n, objectives), to be made least."""
    violation: Values
    """(n,), zero where all constraints are met."""
    crowding: Values
    """(n,), how far the neighbours on the front are; only of designs that meet all constraints."""

    def of(self, places: Places) -> Population:
        """Some of the designs."""
        return Population(*(column[places] for column in self))


class NSGA2:
    """Asks for designs in 0..1, and is told what came of them."""

    def __init__(self, size: int, variables: int, seed: int, first: Values | None = None) -> None:
        self.size, self.random = size, np.random.default_rng(seed)
        self.asked = _distinct(self.random.random((size, variables)) if first is None else first)
        self.population = Population(np.zeros((0, variables)), np.zeros((0, 0)), np.zeros(0), np.zeros(0))

    def ask(self) -> Values:
        """(n, variables), the next generation; empty where no design is left that is another one."""
        if len(self.population.x):
            self.asked = self._children()
        return self.asked

    def tell(self, cost: Values, violation: Values) -> None:
        """Takes (n, objectives) and (n,) of the designs that were asked for."""
        new = Population(self.asked, cost, violation, np.zeros(len(cost)))
        if not len(self.population.x):
            self.population = self._survivors(new, len(new.x))
            return
        both = Population(*(np.concatenate(columns) for columns in zip(self.population, new)))
        self.population = self._survivors(both, self.size)

    def _children(self) -> Values:
        parents = self.population.x
        children = np.zeros((0, parents.shape[1]))
        for _ in range(DRAWS):
            missing = self.size - len(children)
            if not missing:
                break
            drawn = self._mutated(self._crossed(parents[self._pairs(math.ceil(missing / 2))]))
            drawn = _distinct(drawn, parents, children)[:missing]
            children = np.concatenate([children, drawn])
        return children

    def _pairs(self, count: int) -> Places:
        """(count, 2), the winners of tournaments of two each."""
        designs = self.population
        rounds = math.ceil(4 * count / len(designs.x))
        order = np.concatenate([self.random.permutation(len(designs.x)) for _ in range(rounds)])
        a, b = order[: 4 * count].reshape(-1, 2).T
        # Least violation; else who dominates; else who has most room; else by lot.
        better = _sign(designs.violation[b], designs.violation[a])
        less = (designs.cost[a] < designs.cost[b]).any(1).astype(int)
        more = (designs.cost[a] > designs.cost[b]).any(1).astype(int)
        room = _sign(designs.crowding[a], designs.crowding[b])
        feasible = (designs.violation[a] <= 0.0) & (designs.violation[b] <= 0.0)
        better = np.where(feasible, np.where(less != more, less - more, room), better)
        won = np.where(better > 0, a, b)
        for place in np.flatnonzero(better == 0):
            won[place] = self.random.choice([a[place], b[place]])
        return won.reshape(count, 2)

    def _crossed(self, pairs: Values) -> Values:
        """Children of (n, 2, variables): all of the first parents, then all of the second ones."""
        from pymoo.operators.crossover.sbx import cross_sbx

        count, _, width = pairs.shape
        parents = np.swapaxes(pairs, 0, 1)
        crossed = np.less(self.random.random(count), CROSSED)
        children = parents.copy()
        if crossed.any():
            # pymoo draws whether variables are exchanged at all; they are.
            self.random.random((count, 1))
            low, high = np.zeros(width), np.ones(width)
            nearness, exchange = np.full((count, 1), CROSSOVER), np.full((count, 1), EXCHANGED)
            made: Any = cross_sbx(parents.copy(), low, high, nearness, exchange, exchange.copy(), random_state=self.random)
            children[:, crossed] = made[:, crossed]
        return children.reshape(-1, width)

    def _mutated(self, children: Values) -> Values:
        from pymoo.operators.mutation.pm import mut_pm

        count, width = children.shape
        part = np.full(count, min(0.5, 1.0 / width))
        nearness, low, high = np.full(count, MUTATION), np.zeros(width), np.ones(width)
        made: Any = mut_pm(children, low, high, nearness, part, False, random_state=self.random)
        kept = np.less_equal(self.random.random(count), MUTATED)
        return np.where(kept[:, None], made, children)

    def _survivors(self, designs: Population, count: int) -> Population:
        """The best of some designs: front by front, of the last one those with most room; then those that violate least."""
        feasible = np.flatnonzero(designs.violation <= 0.0)
        others = np.flatnonzero(designs.violation > 0.0)
        others = others[np.argsort(designs.violation[others])]
        kept: list[Places] = []
        left = min(len(feasible), count)
        for front in _fronts(designs.cost[feasible], left):
            room = _crowding(designs.cost[feasible[front]])
            designs.crowding[feasible[front]] = room
            if len(front) > left:
                lot = self.random.permutation(len(front))
                front = front[np.flip(lot[np.argsort(room[lot])])[:left]]
            kept.append(feasible[front])
            left -= len(front)
        return designs.of(np.concatenate([*kept, others[: max(count - len(feasible), 0)]]).astype(np.intp))


def _sign(a: Values, b: Values) -> npt.NDArray[np.int_]:
    """1 where a is larger, -1 where b is; infinities are equal."""
    found: npt.NDArray[np.int_] = (a > b).astype(int) - (a < b).astype(int)
    return found


def _distinct(x: Values, *others: Values) -> Values:
    """Designs that are no others, and of equal ones the first."""
    from scipy.spatial.distance import cdist

    apart = cdist(x, x)
    apart[np.triu_indices(len(x))] = np.inf
    x = x[~(apart <= SAME).any(1)]
    for other in others:
        if len(x) and len(other):
            x = x[~(cdist(x, other) <= SAME).any(1)]
    return x


def _fronts(cost: Values, count: int) -> list[Places]:
    """Designs by how many fronts are before theirs, until there are enough of them."""
    from pymoo.util.nds.non_dominated_sorting import NonDominatedSorting

    found: list[Places] = NonDominatedSorting().do(cost, n_stop_if_ranked=count)
    return found


def _crowding(cost: Values) -> Values:
    from pymoo.operators.survival.rank_and_crowding.metrics import calc_crowding_distance

    found: Values = calc_crowding_distance(cost) if len(cost) > 2 else np.full(len(cost), np.inf)
    return found
