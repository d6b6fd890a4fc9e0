#!/usr/bin/env python3
"""Free stroke and blocked force of the muscle by an axisymmetric scikit-fem model, beside validation/hifi/cross_checks.csv.

Usage: validation/.venv/bin/python validation/high_fidelity/axisymmetric.py [--length 130] [--elements 65]
"""

import argparse
import csv
import pathlib
import time

import numpy as np
import scipy.sparse as sp
from skfem import Basis, ElementQuad2, FacetBasis, MeshQuad

import tube

RECORDS = pathlib.Path(__file__).parent.parent / "hifi" / "cross_checks.csv"


class Muscle:
    """Unknowns: displacements (x, r) and pressures that are free, and the motion of the cap, the last one."""

    def __init__(self, length, along, through):
        mesh = MeshQuad.init_tensor(np.linspace(0, length, along + 1), np.linspace(tube.INNER, tube.OUTER, through + 1))
        volume = Basis(mesh, ElementQuad2(), intorder=5)
        facets = {name: mesh.facets_satisfying(lambda x, r=r: np.isclose(x[1], r), boundaries_only=True)
                  for name, r in (("outer", tube.OUTER), ("inner", tube.INNER))}
        surface = {name: FacetBasis(mesh, ElementQuad2(), facets=found, intorder=3) for name, found in facets.items()}
        self.tube = tube.Tube(volume, surface["outer"], surface["inner"], True)
        x = volume.doflocs[0]
        start, end = np.isclose(x, 0), np.isclose(x, length)
        held = np.zeros(self.tube.size, dtype=bool)
        nodes = 2 * self.tube.nodes
        held[0:nodes:2] = start
        held[1:nodes:2] = start | end
        self.cap = np.zeros(self.tube.size)
        self.cap[0:nodes:2] = end
        free = np.flatnonzero(~held & (self.cap == 0))
        ones = sp.csc_matrix((np.ones(len(free)), (free, np.arange(len(free)))), shape=(self.tube.size, len(free)))
        self.ties = sp.hstack([ones, sp.csc_matrix(self.cap[:, None])]).tocsc()
        self.state = np.zeros(len(free) + 1)

    def push(self, inflation):
        """What the pressure does on the cap."""
        return inflation * np.pi * tube.INNER**2

    def solve(self, inflation, blocked):
        count = len(self.state) - (1 if blocked else 0)

        def equations(state):
            residual, tangent = self.tube.assemble(self.ties @ state, inflation)
            residual, tangent = self.ties.T @ residual, self.ties.T @ tangent @ self.ties
            residual[-1] -= self.push(inflation)
            return residual, tangent

        if blocked:
            # A held cap: its equation is what it pulls with.
            def held(part):
                residual, tangent = equations(np.append(part, 0.0))
                return residual[:count], tangent[:count, :count]

            found, iterations = tube.newton(held, self.state[:count])
            self.state = np.append(found, 0.0)
        else:
            self.state, iterations = tube.newton(equations, self.state)
        return equations(self.state)[0][-1], iterations


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--length", type=float, default=130.0)
    parser.add_argument("--elements", type=int, default=65, help="along the axis")
    parser.add_argument("--through", type=int, default=2, help="through the wall")
    arguments = parser.parse_args()
    with RECORDS.open() as file:
        records = {(row["quantity"], float(row["pressure_psi"])): row for row in csv.DictReader(file)}
    print("| quantity | psi | this model | record | difference | iterations | s |")
    print("|---|---:|---:|---:|---:|---:|---:|")
    for quantity, blocked in (("free stroke", False), ("blocked force", True)):
        muscle = Muscle(arguments.length, arguments.elements, arguments.through)
        for psi in (2.5, 5.0, 7.5, 10.0, 12.5, 15.0, 17.5, 20.0, 22.5, 25.0):
            begin = time.process_time()
            force, iterations = muscle.solve(psi * tube.PSI, blocked)
            took = time.process_time() - begin
            value = force if blocked else -muscle.state[-1]
            record = records.get((quantity, psi)) if arguments.length == 130 else None
            if record:
                known = float(record["skfem_axisymmetric"])
                print(f"| {quantity} | {psi:g} | {value:.4f} | {known:.3f} | {100 * (value / known - 1):+.3f} % "
                      f"| {iterations} | {took:.1f} |", flush=True)
            elif arguments.length != 130 and psi in (10, 15, 20, 25):
                print(f"| {quantity} | {psi:g} | {value:.4f} | | | {iterations} | {took:.1f} |", flush=True)


if __name__ == "__main__":
    main()
