"""Designs in 0..1 in, answers out: constraints before and after solving, tolerances, and what was solved before."""

from __future__ import annotations

import concurrent.futures
import math
import time
from collections import Counter
from collections.abc import Sequence

import numpy as np

from ._expression import Expression
from ._reader import StudyError
from ._solve import Answers, Solver
from ._study import Study, Values, in_file
from ._table import UNSOLVED, Design, Table

# Part of a range by which expressions of known values are differenced: half of the digits of a double.
NEAR = 1e-6
# Designs that the mesh is made for, and random ones among which those that meet what needs no solution are looked for.
SAMPLE, DRAWN = 8, 4096


class Spent(Exception):
    """The next batch would go beyond the budget: the search ends before it."""


class Evaluator:
    """Answers for designs in 0..1, each solved once; a batch that an interrupt cut is solved again as a whole.

    Answers of designs that are solved side by side may differ in rounding from those solved in other company, so that a
    batch keeps its company.
    """

    def __init__(
        self,
        study: Study,
        table: Table,
        threads: int | None = None,
        budget: float = float("inf"),
        executor: concurrent.futures.Executor | None = None,
    ) -> None:
        self.study, self.table, self.budget = study, table, budget
        self.low = np.array([each.low for each in study.variables])
        self.span = np.array([each.high - each.low for each in study.variables])
        self.parameters = study.network.parameters
        names = [each.name for each in study.variables]
        # What may be off besides the variables.
        self.beside = [name for name, _ in study.tolerances if name not in names]
        self.names = [*names, *self.beside]
        threads = 1 if threads is None and executor is not None else threads
        self.threads = threads
        """Of this process; one for each core where it is `None`."""
        probes = list(study.probes) or None
        sample = self._sample()
        problem = study.network.problem(self.names, probes, accuracy=study.accuracy, sample=sample, threads=threads)
        self.solver = Solver(problem, executor)
        self.batch = 0
        """Batches that were asked for."""
        self.solved = 0
        """Designs that were solved now."""
        self.asked = 0
        """Designs of the batches that were asked for."""
        self.failures: Counter[str] = Counter()
        """Those of them without an answer, by its kind."""
        self.end = time.monotonic() + 60.0 * study.stop.get("minutes", math.inf)
        self.progress: list[dict[str, float]] = []

    def _sample(self) -> Values:
        """(n, names), designs that the mesh is to serve: from all over the ranges, and of those that the search begins with."""
        first = self.study.first
        first = first[np.linspace(0, len(first) - 1, min(len(first), SAMPLE)).round().astype(int)]
        x = self.values(np.random.default_rng(self.study.seed).random((DRAWN, len(self.span))))
        x = np.vstack([x[self.violation(x, before=True) == 0.0][:SAMPLE], first.reshape(-1, len(self.span))])
        return np.column_stack([x, *(np.full(len(x), self.parameters[name]) for name in self.beside)])

    @property
    def designs(self) -> list[Design]:
        """Those that were asked for, in order: what stands behind them in the table belongs to a longer search."""
        return [design for design in self.table.order if design.batch < self.batch]

    def values(self, scaled: Values) -> Values:
        """Designs in their units."""
        found: Values = self.low + np.clip(scaled, 0.0, 1.0) * self.span
        return found

    def violation(self, x: Values, before: bool, probes: Values | None = None, rates: Values | None = None) -> Values:
        """The sum of what constraints are violated by, each over its scale; in the worst case where there are tolerances."""
        total = np.zeros(len(x))
        for each in self.study.constraints:
            if each.before == before:
                value = self.value(each.value, x, probes)
                off = self.spread(each.value, x, probes, rates) if rates is not None and probes is not None else 0.0
                with np.errstate(all="ignore"):
                    beyond = np.maximum(np.maximum(each.least - value + off, value + off - each.most), 0.0) / each.scale
                    total += np.where(np.isfinite(beyond) & np.isfinite(value), beyond, UNSOLVED)
        return total

    def value(self, expression: Expression, x: Values, probes: Values | None) -> Values:
        """(n,), an expression of some designs; `x` may hold what may be off behind the variables."""
        return np.broadcast_to(expression(known(self.study, self.names[: x.shape[1]], x, probes)), (len(x),))

    def slopes(self, expression: Expression, x: Values, probes: Values, rates: Values) -> Values:
        """(n, variables), derivatives of an expression by the variables, each over its range; `rates` are those of the probes."""
        found = np.empty((len(x), len(self.span)))
        for k, span in enumerate(self.span):
            step = NEAR * span
            ahead, behind = x.copy(), x.copy()
            ahead[:, k] += step
            behind[:, k] -= step
            moved = rates[:, :, k] * step
            rise = self.value(expression, ahead, probes + moved) - self.value(expression, behind, probes - moved)
            found[:, k] = rise / (2.0 * NEAR)
        return found

    def spread(self, expression: Expression, x: Values, probes: Values, rates: Values) -> Values:
        """(n,), how much an expression may be off where parameters are, each as far as it may be; probes by their derivatives."""
        full = np.column_stack([x, *(np.full(len(x), self.parameters[name]) for name in self.beside)])
        middle = self.value(expression, full, probes)
        total = np.zeros(len(x))
        for name, size in self.study.tolerances:
            k = self.names.index(name)
            largest = np.zeros(len(x))
            for step in (size, -size):
                moved = full.copy()
                moved[:, k] += step
                largest = np.maximum(largest, np.abs(self.value(expression, moved, probes + rates[:, :, k] * step) - middle))
            total += largest
        return total

    def __call__(self, scaled: Values, anyway: bool = False, slopes: bool = False) -> list[Design]:
        """Designs of a batch in the order asked for.

        Those that violate what needs no solution are not solved, unless `anyway`; with `slopes` they have derivatives.

        Raises:
            Spent: There are more of them than the budget has left. None is solved: a batch keeps its company.
            StudyError: The same, before anything was solved.
        """
        x = self.values(np.atleast_2d(scaled))
        before = self.violation(x, before=True)
        rows = [tuple(row) for row in x.tolist()]
        wanted: dict[tuple[float, ...], int] = {}
        for index, row in enumerate(rows):
            if (anyway or before[index] == 0.0) and row not in wanted:
                stored = self.table.known.get(row)
                if stored is None or slopes and not stored.slopes:
                    wanted[row] = index
        self._check_budget(len(wanted))
        batch, self.batch = self.batch, self.batch + 1
        if [design.x for design in self.table.batches.get(batch, [])] != list(wanted):
            if self.table.order and self.table.order[-1].batch >= batch:
                self.table.drop_from(batch)
            if wanted:
                places = list(wanted.values())
                self.table.add(self._solve(batch, x[places], before[places], slopes))
                self.solved += len(wanted)
        designs = self.table.take(batch)
        self.asked += len(designs)
        self.failures.update(design.status for design in designs if design.status != "solved")
        nothing = (float("nan"),) * len(self.study.wanted)
        return [
            self.table.known.get(row)
            or Design(0, batch, row, "geometry", None, (), nothing, (), 1.0 + float(before[index]), "violates a constraint")
            for index, row in enumerate(rows)
        ]

    def _check_budget(self, count: int) -> None:
        """Refuses a batch that goes beyond the budget."""
        if self.asked + count <= self.budget:
            return
        if self.asked:
            raise Spent
        what = f"error: the budget of {self.budget:g} is less than the first batch of {count} designs"
        raise StudyError(f"{what}\nhelp: allow {count} or more, or write a smaller population or screen in the study")

    def _solve(self, batch: int, x: Values, before: Values, slopes: bool) -> list[Design]:
        beside = [np.full(len(x), self.parameters[name]) for name in self.beside]
        answers = self.solver(np.column_stack([x, *beside]), slopes or bool(self.study.tolerances))
        # A problem without probes of its own has all of the network.
        count = len(self.study.probes)
        y, all_rates = answers.values[:, :count], None if answers.slopes is None else answers.slopes[:, :count]
        rates = all_rates if self.study.tolerances else None
        after = self.violation(x, False, y, rates) + before
        wanted = np.column_stack([self.value(each.value, x, y) for each in self.study.wanted])
        spread: Values = np.zeros((len(x), 0))
        if rates is not None:
            spread = np.column_stack([self.spread(each.value, x, y, rates) for each in self.study.wanted])
            wanted = wanted + spread * np.array([each.sign for each in self.study.objectives])
        kept = all_rates.reshape(len(x), -1).tolist() if slopes and all_rates is not None else [()] * len(x)
        status, reason = self._verdicts(answers, wanted)
        numbers = range(len(self.table.order) + 1, len(self.table.order) + 1 + len(x))
        violation = [float(after[k]) if word == "solved" else UNSOLVED for k, word in enumerate(status)]
        points, probes, found, spreads = x.tolist(), y.tolist(), wanted.tolist(), spread.tolist()
        return [
            Design(
                *(numbers[k], batch, tuple(points[k]), status[k], answers.stable[k], tuple(probes[k]), tuple(found[k])),
                *(tuple(spreads[k]), violation[k], reason[k], tuple(kept[k])),
            )
            for k in range(len(x))
        ]

    def _verdicts(self, answers: Answers, wanted: Values) -> tuple[list[str], list[str]]:
        """Whether designs are solved, and why they are not."""
        status, reasons = [], []
        known = [bool(row.all()) for row in np.isfinite(wanted)]
        for reason, stable, finite in zip(answers.reasons, answers.stable, known):
            # Values without derivatives are values, as long as nothing is made of the derivatives.
            if reason is not None and not (finite and reason.kind in ("no_derivative", "inexact", "singular")):
                word, text = reason.kind, str(reason)
            elif stable is False:
                word, text = "unstable", "the end of a step is unstable"
            elif not finite:
                word, text = "no_value", "an objective or target is no number there"
            else:
                word, text = "solved", ""
            status.append(word)
            reasons.append(text)
        return status, reasons

    def is_spent(self) -> bool:
        """Whether no more designs are to be solved."""
        spent = self.asked >= min(self.budget, self.study.stop.get("evaluations", np.inf))
        return spent or time.monotonic() > self.end


def known(study: Study, names: Sequence[str], x: Values, probes: Values | None) -> dict[str, Values | float]:
    """What expressions may refer to: parameters, those of them that are columns of `x`, and probes.

    Parameters are in the units of the file there, as in the expressions of network files.
    """
    scales = study.network._scales
    found: dict[str, Values | float] = in_file(study.network)
    found.update({name: x[:, k] * scales[name] for k, name in enumerate(names)})
    for name, made in study.derived:
        found[name] = made(found)
    if probes is not None:
        found.update({name: probes[:, k] for k, name in enumerate(study.probes)})
    return found


def error(study: Study, designs: Sequence[Design]) -> Values:
    """(n,), the root mean square of what designs miss their targets by; infinite where there is no answer."""
    values = np.array([design.wanted for design in designs]).reshape(len(designs), len(study.targets))
    wanted = np.array([each.wanted for each in study.targets])
    weights = np.array([each.weight for each in study.targets])
    found: Values = np.sqrt((weights * (values - wanted) ** 2).sum(1) / weights.sum())
    return np.where(np.isfinite(found), found, np.inf)
