#!/usr/bin/env python3
"""Two plane networks as geometrically exact rods in scikit-fem, beside what `pennate solve` finds: a beam-level reference.

Usage: validation/.venv/bin/python validation/high_fidelity/rods.py PENNATE, the path of the built program.

Reissner's rod, quadratic elements with two Gauss points: Gamma = (c x' + s y' - 1, -s x' + c y'), kappa = theta'. The rods
of both networks are shear-rigid; here they have a shear stiffness of 1e7 N, which moves results by less than 1e-6.
"""

import json
import pathlib
import subprocess
import sys
import tempfile
import time

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla
from skfem import Basis, ElementLineP2, MeshLine

RIGID = 1e7
# Silicone at 20 psi: modulus, alpha, outer radii of ends and middle, wall, length of an end.
MODULUS, ALPHA, RADII, WALL, END, PSI = 3.85, -7.788e-3, (7.05, 8.70), 2.0, 13.0, 20.0


def annulus(radius):
    inner = radius - WALL
    return MODULUS * np.pi * (radius**2 - inner**2), MODULUS * np.pi / 4 * (radius**4 - inner**4)


def muscle(length):
    """Segments: length, EA, EI, induced strain, elements."""
    end, middle = annulus(RADII[0]), annulus(RADII[1])
    return [(END, *end, 0.0, 8), (length - 2 * END, *middle, ALPHA * PSI, 32), (END, *end, 0.0, 8)]


def strip(length):
    width, height, modulus = 12.0, 1.2, 2200.0
    return [(length, modulus * width * height, modulus * width * height**3 / 12, 0.0, 32)]


class Network:
    """Unknowns x, y, theta of every point; members share those of the points where they meet."""

    def __init__(self, points, members, held):
        self.count = len(points)
        names = {name: i for i, name in enumerate(points)}
        self.rods = []
        for start, end, segments in members:
            a, b = np.array(points[start]), np.array(points[end])
            bounds = np.cumsum([0.0] + [segment[0] for segment in segments])
            pieces = [np.linspace(bounds[i], bounds[i + 1], s[4] + 1)[1:] for i, s in enumerate(segments)]
            mesh = MeshLine(np.concatenate([[0.0], *pieces]))
            basis = Basis(mesh, ElementLineP2(), intorder=3)
            own = np.arange(basis.N) + self.count
            self.count += basis.N
            place = basis.doflocs[0]
            for at, name in ((0.0, start), (bounds[-1], end)):
                own[np.argmin(np.abs(place - at))] = names[name]
            middle = mesh.p[0][mesh.t].mean(axis=0)
            data = np.array([segments[np.searchsorted(bounds, m) - 1][1:4] for m in middle])
            angle = np.arctan2(*(b - a)[::-1])
            functions = [basis.basis[i][0] for i in range(basis.Nbfun)]
            shape = basis.dx.shape
            value = np.stack([np.broadcast_to(f.value, shape) for f in functions], axis=-1)
            slope = np.stack([np.broadcast_to(f.grad[0], shape) for f in functions], axis=-1)
            self.rods.append((own[basis.element_dofs.T], value, slope, basis.dx, data, angle))
        fixed = {3 * names[name] + "xyt".index(c) for name, components in held.items() for c in components}
        # The ends of a rod are points: numbers that it had for them are nobody's.
        used = np.unique(np.concatenate([rod[0].ravel() for rod in self.rods]))
        self.free = np.array([3 * i + c for i in used for c in range(3) if 3 * i + c not in fixed])
        self.state = np.zeros(3 * self.count)
        self.iterations = 0

    def equations(self, state, part):
        residual = np.zeros(3 * self.count)
        rows, columns, entries = [], [], []
        for nodes, value, slope, weight, data, angle in self.rods:
            dofs = (3 * nodes[:, :, None] + np.arange(3)).reshape(len(nodes), -1)
            u = state[dofs].reshape(len(nodes), -1, 3)
            change = np.einsum("eqn,eni->eqi", slope, u)
            theta = angle + np.einsum("eqn,en->eq", value, u[:, :, 2])
            c, s = np.cos(theta), np.sin(theta)
            x, y = np.cos(angle) + change[..., 0], np.sin(angle) + change[..., 1]
            first, second = c * x + s * y, -s * x + c * y
            force = data[:, None, 0] * (first - 1.0 - part * data[:, None, 2])
            shear, moment = RIGID * second, data[:, None, 1] * change[..., 2]
            e, q, n = slope.shape
            operator = np.zeros((e, q, 3, n, 3))
            operator[:, :, 0, :, 0], operator[:, :, 0, :, 1] = c[..., None] * slope, s[..., None] * slope
            operator[:, :, 0, :, 2] = second[..., None] * value
            operator[:, :, 1, :, 0], operator[:, :, 1, :, 1] = -s[..., None] * slope, c[..., None] * slope
            operator[:, :, 1, :, 2] = -first[..., None] * value
            operator[:, :, 2, :, 2] = slope
            operator = operator.reshape(e, q, 3, 3 * n)
            stress = np.stack([force, shear, moment], axis=-1)
            np.add.at(residual, dofs, np.einsum("eq,eqkd,eqk->ed", weight, operator, stress))
            stiffness = np.stack(np.broadcast_arrays(data[:, None, 0], RIGID, data[:, None, 1] + 0 * force), axis=-1)
            block = np.einsum("eq,eqkd,eqk,eqkf->edf", weight, operator, stiffness, operator, optimize=True)
            across = np.zeros((e, q, n, 3, n, 3))
            for i, factor in ((0, -s * force - c * shear), (1, c * force - s * shear)):
                part_of = np.einsum("eq,eqn,eqm->eqnm", factor, slope, value)
                across[:, :, :, i, :, 2] += part_of
                across[:, :, :, 2, :, i] += np.swapaxes(part_of, 2, 3)
            across[:, :, :, 2, :, 2] += np.einsum("eq,eqn,eqm->eqnm", -first * force - second * shear, value, value)
            block += np.einsum("eq,eqnimj->enimj", weight, across).reshape(e, 3 * n, 3 * n)
            rows.append(np.repeat(dofs[:, :, None], 3 * n, axis=2).ravel())
            columns.append(np.repeat(dofs[:, None, :], 3 * n, axis=1).ravel())
            entries.append(block.ravel())
        place = (np.concatenate(rows), np.concatenate(columns))
        return residual, sp.csc_matrix((np.concatenate(entries), place), shape=(3 * self.count,) * 2)

    def solve(self, steps):
        for step in range(1, steps + 1):
            for _ in range(40):
                residual, tangent = self.equations(self.state, step / steps)
                change = spla.spsolve(tangent[self.free][:, self.free], -residual[self.free])
                self.state[self.free] += change
                self.iterations += 1
                if np.abs(change).max() < 1e-9:
                    break
            else:
                raise RuntimeError("no equilibrium found")


def dyad():
    angle = np.radians(26.0)
    width, height = 130 * np.cos(angle), 130 * np.sin(angle)
    points = {"A": (-width, 0), "B": (width, 0), "C": (0, height)}
    return Network(points, [("A", "C", muscle(130.0)), ("B", "C", muscle(130.0))], {"A": "xyt", "B": "xyt"})


def gripper():
    angle = np.radians(30.0)
    h = 130 * np.sin(angle)
    points = {"A": (130 * np.cos(angle), 0), "B": (0, h), "G": (35, h), "K": (35, h + 60), "T": (35, h + 140)}
    link = float(np.hypot(35, 60))
    members = [("A", "B", muscle(130.0)), ("G", "K", strip(60.0)), ("K", "T", strip(80.0)), ("B", "K", strip(link))]
    return Network(points, members, {"A": "xyt", "G": "xyt", "B": "xt"})


def pennate(program, scene, settings):
    arguments = [part for setting in settings for part in ("--set", setting)]
    text = subprocess.run([program, "scene", scene, *arguments], check=True, capture_output=True, text=True).stdout
    with tempfile.TemporaryDirectory() as folder:
        file = pathlib.Path(folder) / "network.toml"
        file.write_text(text)
        run = subprocess.run([program, "solve", str(file), "--json"], check=True, capture_output=True, text=True)
    found = json.loads(run.stdout)
    return found["steps"][-1], found["timing"]["solve_s"]


def main(program):
    print("| network | quantity | scikit-fem | pennate | difference | s, scikit-fem | ms, pennate |")
    print("|---|---|---:|---:|---:|---:|---:|")
    for name, build, scene, settings, wanted in (
        ("dyad, fixed joints, 26 degrees", dyad, "dyad", ["chi=26", "pressure=20"], {"C": (0, 1)}),
        ("compliant gripper, one half", gripper, "compliant_gripper", [], {"B": (1,), "T": (0, 1)}),
    ):
        network = build()
        begin = time.process_time()
        network.solve(40)
        took = time.process_time() - begin
        step, solved = pennate(program, scene, settings)
        order = {"dyad": "ABC", "compliant_gripper": "ABGKT"}[scene]
        scale = max(abs(x) for node in wanted for x in step["nodes"][node]["displacement"])
        for node, components in wanted.items():
            for c in components:
                here, there = network.state[3 * order.index(node) + c], step["nodes"][node]["displacement"][c]
                print(f"| {name} | u{'xy'[c]} of {node}, mm | {here:.6f} | {there:.6f} | {abs(here - there) / scale:.1e} "
                      f"| {took:.2f} | {1e3 * solved:.2f} |", flush=True)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    main(sys.argv[1])
