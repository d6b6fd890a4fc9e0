"""An inflated fibre-reinforced tube: material, element kernels and Newton's iteration of the high-fidelity model.

scikit-fem gives meshes, mappings, basis functions and quadrature; what is added are the kernels of the finite strains,
written for all elements at once. Displacement Q2, pressure discontinuous and linear. Units: mm, N, MPa.

Rubber: W = C10 (I1 - 3) + C01 (I2 - 3) - (2 C10 + 4 C01) ln J + p (J - 1) - p^2/(2K).
Fibres: two families at +-30 degrees to the axis in the outer surface, kf/2 e^2 per area and family, e = (a.C a - 1)/2.
"""

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

DIAMETER, WALL = 13.0, 2.0
OUTER, INNER = 0.5 * DIAMETER, 0.5 * DIAMETER - WALL
ANGLE = np.radians(30.0)
PSI = 6.894757e-3
C10, C01, FIBRE = 0.1575, 0.0175, 27.0
BULK = 2000.0 * (C10 + C01)
EYE = np.eye(3)


class Values:
    """Values and gradients of a scalar basis at its quadrature points, as (element, point, ...)."""

    def __init__(self, basis):
        shape = basis.dx.shape
        functions = [basis.basis[i][0] for i in range(basis.Nbfun)]
        self.value = np.stack([np.broadcast_to(f.value, shape) for f in functions], axis=-1)
        dim = basis.mesh.dim()
        self.gradient = np.stack(
            [np.moveaxis(np.broadcast_to(f.grad, (dim, *shape)), 0, -1) for f in functions], axis=-2
        )
        self.weight = np.array(basis.dx)
        self.dofs = basis.element_dofs.T
        self.position = np.moveaxis(np.array(basis.global_coordinates().value), 0, -1)


class Linear:
    """Discontinuous pressure, linear in the coordinates of the reference element: no element shares it."""

    def __init__(self, basis):
        points = basis.quadrature[0]
        functions = np.vstack([np.ones_like(points[:1]), points - 0.5]).T
        elements = basis.element_dofs.shape[1]
        self.value = np.broadcast_to(functions, (elements, *functions.shape))
        self.dofs = np.arange(elements * functions.shape[1]).reshape(elements, -1)


def strain_operator(values, axisymmetric):
    """The derivative of F by the displacements of an element: (element, point, displacement, 9)."""
    e, q, nodes, dim = values.gradient.shape
    operator = np.zeros((e, q, nodes, dim, 3, 3))
    for i in range(dim):
        operator[:, :, :, i, i, :dim] = values.gradient
    if axisymmetric:
        operator[:, :, :, 1, 2, 2] = values.value / values.position[..., None, 1]
    return operator.reshape(e, q, nodes * dim, 9)


def inverse_transpose(f):
    return np.swapaxes(np.linalg.inv(f), -1, -2)


def rubber(f, p):
    """First Piola stress, its derivative by F, and cof F, whose product with dp is the rest of the change."""
    c = np.swapaxes(f, -1, -2) @ f
    i1 = np.trace(c, axis1=-2, axis2=-1)[..., None, None]
    j = np.linalg.det(f)[..., None, None]
    g = inverse_transpose(f)
    drop = 2 * C10 + 4 * C01
    fc = f @ c
    stress = 2 * C10 * f + 2 * C01 * (i1 * f - fc) - drop * g + (p[..., None, None] * j) * g
    identity = np.einsum("ik,JL->iJkL", EYE, EYE)
    ff = np.einsum("...iJ,...kL->...iJkL", f, f)
    tangent = (2 * C10 + 2 * C01 * i1[..., None, None]) * identity + 4 * C01 * ff
    # Of F C: dF C + F dF^T F + F F^T dF.
    tangent -= 2 * C01 * np.einsum("ik,...LJ->...iJkL", EYE, c)
    tangent -= 2 * C01 * np.einsum("...iL,...kJ->...iJkL", f, f)
    tangent -= 2 * C01 * np.einsum("...ik,JL->...iJkL", f @ np.swapaxes(f, -1, -2), EYE)
    cross = np.einsum("...iL,...kJ->...iJkL", g, g)
    pj = (p[..., None, None] * j)[..., None, None]
    tangent += (drop - pj) * cross + pj * np.einsum("...iJ,...kL->...iJkL", g, g)
    return stress, tangent, j * g, j[..., 0, 0]


def fibres(f, hoop):
    """Stress and tangent of the membrane, per reference area."""
    stress, tangent = 0.0, 0.0
    for sign in (1.0, -1.0):
        a = np.cos(ANGLE) * EYE[0] + sign * np.sin(ANGLE) * hoop
        fa = np.einsum("...iJ,...J->...i", f, np.broadcast_to(a, f.shape[:-1]))
        strain = 0.5 * (np.einsum("...i,...i->...", fa, fa) - 1.0)
        a = np.broadcast_to(a, fa.shape)
        dyad = np.einsum("...i,...J->...iJ", fa, a)
        stress = stress + FIBRE * strain[..., None, None] * dyad
        tangent = tangent + FIBRE * (
            np.einsum("...iJ,...kL->...iJkL", dyad, dyad)
            + strain[..., None, None, None, None] * np.einsum("ik,...J,...L->...iJkL", EYE, a, a)
        )
    return stress, tangent


def cofactor_change(f):
    """cof F and its derivative by F."""
    j = np.linalg.det(f)[..., None, None]
    g = inverse_transpose(f)
    change = np.einsum("...iJ,...kL->...iJkL", g, g) - np.einsum("...iL,...kJ->...iJkL", g, g)
    return j * g, j[..., None, None] * change


class Tube:
    """Residual and tangent of the tube without its cap, whose motion ties the nodes of the end face."""

    def __init__(self, volume, outer, inner, axisymmetric):
        self.axisymmetric = axisymmetric
        self.dim = volume.mesh.dim()
        self.nodes = volume.N
        self.volume, self.pressure = Values(volume), Linear(volume)
        self.size = self.dim * self.nodes + self.pressure.dofs.size
        self.outer, self.inner = Values(outer), Values(inner)
        self.normal = np.zeros((*self.inner.weight.shape, 3))
        self.normal[..., : self.dim] = np.moveaxis(np.array(inner.normals), 0, -1)
        self.operators = {v: strain_operator(v, axisymmetric) for v in (self.volume, self.outer, self.inner)}
        if axisymmetric:
            for values in (self.volume, self.outer, self.inner):
                values.weight = values.weight * 2 * np.pi * values.position[..., 1]
            self.hoop = np.broadcast_to(EYE[2], (*self.outer.weight.shape, 3))
        else:
            y, z = self.outer.position[..., 1], self.outer.position[..., 2]
            radius = np.hypot(y, z)
            self.hoop = np.stack([0 * y, -z / radius, y / radius], axis=-1)

    def displacement_dofs(self, values):
        return (self.dim * values.dofs[:, :, None] + np.arange(self.dim)).reshape(len(values.dofs), -1)

    def deformation(self, values, x):
        u = x[self.displacement_dofs(values)]
        return EYE + np.einsum("eqdk,ed->eqk", self.operators[values], u).reshape(*values.weight.shape, 3, 3)

    def assemble(self, x, inflation):
        residual = np.zeros(self.size)
        rows, columns, entries = [], [], []

        def add(dofs, other, block):
            rows.append(np.repeat(dofs[:, :, None], other.shape[1], axis=2).ravel())
            columns.append(np.repeat(other[:, None, :], dofs.shape[1], axis=1).ravel())
            entries.append(block.ravel())

        def add_stress(values, stress, tangent):
            operator, dofs = self.operators[values], self.displacement_dofs(values)
            weighted = values.weight[..., None, None] * operator
            shape = values.weight.shape
            np.add.at(residual, dofs, np.einsum("eqdk,eqk->ed", weighted, stress.reshape(*shape, 9)))
            block = weighted @ tangent.reshape(*shape, 9, 9) @ np.swapaxes(operator, -1, -2)
            add(dofs, dofs, block.sum(axis=1))

        v, offset = self.volume, self.dim * self.nodes
        pressure_dofs = self.pressure.dofs + offset
        p = np.einsum("eqn,en->eq", self.pressure.value, x[pressure_dofs])
        stress, tangent, cofactor, j = rubber(self.deformation(v, x), p)
        add_stress(v, stress, tangent)
        coupling = np.einsum(
            "eq,eqdk,eqk,eqn->edn", v.weight, self.operators[v], cofactor.reshape(*j.shape, 9), self.pressure.value
        )
        dofs = self.displacement_dofs(v)
        add(dofs, pressure_dofs, coupling)
        add(pressure_dofs, dofs, np.swapaxes(coupling, 1, 2))
        mass = np.einsum("eq,eqm,eqn->emn", v.weight, self.pressure.value, self.pressure.value)
        add(pressure_dofs, pressure_dofs, -mass / BULK)
        volume = np.einsum("eq,eqn,eq->en", v.weight, self.pressure.value, j - 1.0 - p / BULK)
        np.add.at(residual, pressure_dofs, volume)

        add_stress(self.outer, *fibres(self.deformation(self.outer, x), self.hoop))

        s = self.inner
        cofactor, change = cofactor_change(self.deformation(s, x))
        traction = inflation * np.einsum("eqiJ,eqJ->eqi", cofactor, self.normal)[..., : self.dim]
        push = np.einsum("eq,eqn,eqi->eni", s.weight, s.value, traction)
        dofs = self.displacement_dofs(s)
        np.add.at(residual, dofs, push.reshape(len(dofs), -1))
        slope = np.einsum("eqiJkL,eqJ->eqikL", change, self.normal)[:, :, : self.dim].reshape(*s.weight.shape, self.dim, 9)
        turned = inflation * np.einsum("eqik,eqdk->eqid", slope, self.operators[s])
        add(dofs, dofs, np.einsum("eq,eqn,eqid->enid", s.weight, s.value, turned).reshape(len(dofs), -1, len(dofs[0])))
        matrix = sp.csc_matrix(
            (np.concatenate(entries), (np.concatenate(rows), np.concatenate(columns))), shape=(self.size, self.size)
        )
        return residual, matrix


def newton(residual_and_tangent, state, tolerance=1e-8, most=25):
    """Brings the state to equilibrium; the number of iterations comes back with it."""
    for iteration in range(1, most + 1):
        residual, tangent = residual_and_tangent(state)
        change = spla.splu(tangent.tocsc()).solve(-residual)
        state = state + change
        if np.abs(change[: len(change)]).max() < tolerance * (1.0 + np.abs(state).max()):
            return state, iteration
        if not np.isfinite(change).all():
            break
    raise RuntimeError("no equilibrium found")
