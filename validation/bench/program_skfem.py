"""scikit-fem: Reissner's rod in the plane, elements of order 3 with three Gauss points, on problems that are one chain of rods.

scikit-fem has no rods: its forms are written here, Gamma = (c x' + s y' - 1, -s x' + c y') and kappa = theta'. It assembles,
SciPy's SuperLU solves.
"""

import time

import numpy as np
import scipy.sparse.linalg as spla
from skfem import Basis, BilinearForm, ElementLineP0, ElementLinePp, ElementVector, LinearForm, MeshLine

THEORY = "shear"
PACKAGE = "scikit-fem"
ORDER = 3


def serves(frame):
    chain = np.arange(len(frame.conn))
    return frame.planar and np.array_equal(frame.conn, np.stack([chain, chain + 1], axis=1))


def measures(w):
    """Strains and the director, at the quadrature points."""
    state = w["state"]
    angle = w["angle"] + state[2]
    c, s = np.cos(angle), np.sin(angle)
    x, y = np.cos(w["angle"]) + state.grad[0, 0], np.sin(w["angle"]) + state.grad[1, 0]
    return c, s, c * x + s * y, -s * x + c * y, state.grad[2, 0]


def stresses(w, first, second, curvature):
    return w["EA"] * (first - 1 - w["strain"]), w["GA"] * second, w["EI"] * curvature


def variations(v, c, s, first, second):
    along, across = c * v.grad[0, 0] + s * v.grad[1, 0], -s * v.grad[0, 0] + c * v.grad[1, 0]
    return along + second * v[2], across - first * v[2], v.grad[2, 0]


@LinearForm
def inner_force(v, w):
    c, s, first, second, curvature = measures(w)
    n, q, m = stresses(w, first, second, curvature)
    d1, d2, d3 = variations(v, c, s, first, second)
    return n * d1 + q * d2 + m * d3


@BilinearForm
def tangent(u, v, w):
    c, s, first, second, curvature = measures(w)
    n, q, _ = stresses(w, first, second, curvature)
    a, b = (variations(x, c, s, first, second) for x in (u, v))
    material = w["EA"] * a[0] * b[0] + w["GA"] * a[1] * b[1] + w["EI"] * a[2] * b[2]
    p, r = ([c * x.grad[0, 0] + s * x.grad[1, 0], -s * x.grad[0, 0] + c * x.grad[1, 0]] for x in (u, v))
    turned = n * (p[1] * v[2] + r[1] * u[2] - first * u[2] * v[2])
    return material + turned - q * (p[0] * v[2] + r[0] * u[2] + second * u[2] * v[2])


def solve(frame, steps, tolerance=1e-8, iterations=60):
    if not serves(frame):
        raise ValueError("not one chain of rods in the plane")
    along = np.diff(frame.X[:, :2], axis=0)
    lengths = np.linalg.norm(along, axis=1)
    mesh = MeshLine(np.concatenate([[0.0], np.cumsum(lengths)]))
    basis = Basis(mesh, ElementVector(ElementLinePp(ORDER), 3), intorder=2 * ORDER - 1)
    constant = basis.with_element(ElementLineP0())
    per_element = lambda values: constant.interpolate(np.asarray(values, float))  # noqa: E731
    sections = [frame.sec[k] for k in frame.sec_of]
    data = {
        "angle": per_element(np.arctan2(along[:, 1], along[:, 0])),
        "EA": per_element([s.E * s.A for s in sections]),
        "GA": per_element([s.G * s.As for s in sections]),
        "EI": per_element([s.E * s.I for s in sections]),
    }
    nodes = basis.nodal_dofs
    free = np.setdiff1d(np.arange(basis.N), nodes[:, frame.clamped])
    dead = np.zeros(basis.N)
    for k, values in frame.loads.items():
        dead[nodes[:, k]] += np.array(values)[[0, 1, 5]]
    state = np.zeros(basis.N)
    strain = load = 0.0
    begin = time.process_time()
    for stage in frame.stages:
        for step in range(1, steps + 1):
            part = step / steps
            now, force = strain + part * (stage.strain - strain), load + part * (stage.load - load)
            fields = {**data, "strain": per_element(now * frame.eps0)}
            for _ in range(iterations):
                fields["state"] = basis.interpolate(state)
                residual = inner_force.assemble(basis, **fields) - force * dead
                matrix = tangent.assemble(basis, **fields).tocsc()
                change = spla.spsolve(matrix[free][:, free], -residual[free])
                state[free] += change
                if np.abs(change).max() < tolerance:
                    break
            else:
                raise RuntimeError(f"step {step} of {steps} failed")
        strain, load = stage.strain, stage.load
    seconds = time.process_time() - begin
    return [*map(float, state[nodes[:2, frame.watch]]), 0.0], seconds
