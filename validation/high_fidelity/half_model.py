#!/usr/bin/env python3
"""Tip of the muscle under a load across it by a 3D scikit-fem half model, beside validation/hifi/cross_checks.csv.

Usage: validation/.venv/bin/python validation/high_fidelity/half_model.py [--around 4] [--along 64] [--psi 25 --force 1.5]

The plane z = 0 is one of symmetry: the +-30 degree fibres make no twist. Hexahedra of 27 nodes follow the round of the tube.
"""

import argparse
import csv
import pathlib
import time

import numpy as np
import scipy.sparse as sp
from skfem import Basis, ElementHex2, FacetBasis, MeshHex, MeshHex2

import tube

RECORDS = pathlib.Path(__file__).parent.parent / "hifi" / "cross_checks.csv"


def half_tube(length, through, around, along):
    """The mesh, its facets on the outer surface and those on the inner one."""
    flat = MeshHex.init_tensor(
        np.linspace(0, length, along + 1),
        np.linspace(tube.INNER, tube.OUTER, through + 1),
        np.linspace(0, np.pi, around + 1),
    )
    radius = flat.p[1][flat.facets]
    outer = np.flatnonzero(np.isclose(radius, tube.OUTER).all(axis=0))
    inner = np.flatnonzero(np.isclose(radius, tube.INNER).all(axis=0))
    curved = MeshHex2.from_mesh(flat)
    x, r, angle = curved.doflocs
    mesh = MeshHex2(np.array([x, r * np.cos(angle), r * np.sin(angle)]), curved.t)
    assert (np.sort(mesh.facets, axis=0) == np.sort(flat.facets, axis=0)).all(), "facets keep their numbers"
    return mesh, outer, inner


class Muscle:
    """Unknowns: displacements and pressures that are free, then the motion Ux, Uy, angle of the cap."""

    def __init__(self, length, through, around, along):
        mesh, outer, inner = half_tube(length, through, around, along)
        self.length = length
        volume = Basis(mesh, ElementHex2(), intorder=5)
        self.tube = tube.Tube(
            volume,
            FacetBasis(mesh, ElementHex2(), facets=outer, intorder=3),
            FacetBasis(mesh, ElementHex2(), facets=inner, intorder=4),
            False,
        )
        x, self.y, z = volume.doflocs
        start, self.end = np.isclose(x, 0), np.isclose(x, length)
        held = np.zeros(self.tube.size, dtype=bool)
        nodes = 3 * self.tube.nodes
        for component in range(3):
            held[component:nodes:3] = start | self.end
        held[2:nodes:3] |= np.isclose(z, 0)
        free = np.flatnonzero(~held)
        self.free = sp.csc_matrix((np.ones(len(free)), (free, np.arange(len(free)))), shape=(self.tube.size, len(free)))
        self.state = np.zeros(len(free) + 3)
        self.iterations = 0

    def field(self, x, y):
        """Nodal displacements of the end face as a vector of all unknowns."""
        vector = np.zeros(self.tube.size)
        nodes = 3 * self.tube.nodes
        vector[0:nodes:3] = np.where(self.end, x, 0.0)
        vector[1:nodes:3] = np.where(self.end, y, 0.0)
        return vector

    def solve(self, inflation, force):
        """Equilibrium at a pressure and dead loads Fx, Fy of the whole tube."""
        disc = 0.5 * inflation * np.pi * tube.INNER**2

        def equations(state):
            ux, uy, angle = state[-3:]
            s, c = np.sin(angle), np.cos(angle)
            x = self.free @ state[:-3] + self.field(ux - self.y * s, uy + self.y * (c - 1.0))
            residual, tangent = self.tube.assemble(x, inflation)
            columns = [self.field(1.0, 0.0), self.field(0.0, 1.0), self.field(-self.y * c, -self.y * s)]
            ties = sp.hstack([self.free, sp.csc_matrix(np.array(columns).T)]).tocsc()
            bend = residual @ self.field(self.y * s, -self.y * c)
            residual, tangent = ties.T @ residual, (ties.T @ tangent @ ties).tolil()
            residual[-3] -= disc * c + 0.5 * force[0]
            residual[-2] -= disc * s + 0.5 * force[1]
            tangent[-1, -1] += bend
            tangent[-3, -1] += disc * s
            tangent[-2, -1] -= disc * c
            return residual, tangent

        self.state, iterations = tube.newton(equations, self.state)
        self.iterations += iterations

    def tip(self):
        ux, uy, angle = self.state[-3:]
        return self.length + ux, uy, np.degrees(angle)


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--length", type=float, default=130.0)
    parser.add_argument("--through", type=int, default=1, help="elements through the wall")
    parser.add_argument("--around", type=int, default=4, help="over the half circumference")
    parser.add_argument("--along", type=int, default=64)
    parser.add_argument("--psi", type=float, default=25.0)
    parser.add_argument("--force", type=float, default=1.5, help="across the muscle, N")
    arguments = parser.parse_args()
    muscle = Muscle(arguments.length, arguments.through, arguments.around, arguments.along)
    begin, wall = time.process_time(), time.time()
    for psi in np.linspace(0, arguments.psi, int(np.ceil(arguments.psi / 5)) + 1)[1:]:
        muscle.solve(psi * tube.PSI, (0.0, 0.0))
    stroke = arguments.length - muscle.tip()[0]
    for part in (0.25, 0.5, 0.75, 1.0):
        muscle.solve(arguments.psi * tube.PSI, (0.0, part * arguments.force))
    took = f"{time.process_time() - begin:.1f} s of CPU, {time.time() - wall:.1f} s"
    size = 3 * muscle.tube.nodes
    print(f"{size} displacement unknowns, {muscle.iterations} iterations, {took}; free stroke {stroke:.4f} mm")
    print("| quantity | this model | record | difference |")
    print("|---|---:|---:|---:|")
    with RECORDS.open() as file:
        rows = list(csv.DictReader(file))
    for quantity, value in zip(("tip x", "tip y", "tip slope"), muscle.tip()):
        here = (row for row in rows if row["quantity"] == quantity and arguments.length == 130
                and float(row["pressure_psi"]) == arguments.psi and float(row["Fy_N"]) == arguments.force)
        row = next(here, None)
        if row is None:
            print(f"| {quantity} | {value:.4f} | | |")
        else:
            known = float(row["tube3d_numpy"])
            print(f"| {quantity} | {value:.4f} | {known:.3f} | {100 * (value / known - 1):+.2f} % |")


if __name__ == "__main__":
    main()
