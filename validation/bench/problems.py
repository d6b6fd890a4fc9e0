"""The seven problems of examples/formulations.rs, as frames of straight two-node elements for other programs.

A problem is a `Frame`: nodes, elements, sections, clamped nodes, and a list of `Stage`s. A stage gives the values
reached at its end: the factor on every element's contraction strain `eps0` (axial law N = EA (l/l0 - 1 - strain eps0))
and the factor on the dead loads. All sections are round, or bend alike about both axes.

`references` holds the displacement of the watched node for programs with shear and for those without.
"""

import json
import math
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

VALIDATION = Path(__file__).resolve().parent.parent


@dataclass(frozen=True)
class Section:
    E: float
    G: float
    A: float
    I: float
    J: float
    As: float  # area for shear


@dataclass
class Stage:
    strain: float = 0.0
    load: float = 0.0


@dataclass
class Frame:
    X: np.ndarray  # (n, 3) nodes
    conn: np.ndarray  # (m, 2)
    sec: list
    sec_of: np.ndarray  # (m,) index into `sec`
    eps0: np.ndarray  # (m,) contraction strain
    up: np.ndarray  # (m, 3) a vector in the plane of local axes x and y
    clamped: list
    loads: dict  # node -> force and moment
    stages: list
    watch: int
    planar: bool
    references: dict = field(default_factory=dict)  # "shear", "rigid": displacement of the watched node


def annulus(E, G, R, t):
    r = R - t
    A = math.pi * (R * R - r * r)
    I = math.pi / 4 * (R**4 - r**4)
    return Section(E, G, A, I, 2 * I, 0.5 * A)


def solid_round(E, G, R):
    A = math.pi * R * R
    I = math.pi / 4 * R**4
    return Section(E, G, A, I, 2 * I, 0.9 * A)


HSIM = [annulus(3.6, 1.2, 6.5, 2.0), annulus(3.6, 1.2, 8.0, 2.0)]
CONTRACTION = -0.172


def hsim_points(p, q, per):
    """Nodes of one HSIM member, a tenth, eight tenths and a tenth of its length, `per` elements each; their sections."""
    s = np.r_[np.linspace(0, 0.1, per + 1), np.linspace(0.1, 0.9, per + 1)[1:], np.linspace(0.9, 1, per + 1)[1:]]
    p, q = np.asarray(p, float), np.asarray(q, float)
    return p + s[:, None] * (q - p), np.r_[np.zeros(per, int), np.ones(per, int), np.zeros(per, int)]


def cantilever(points, sec, load, planar, stages=None, sec_of=None):
    m = len(points) - 1
    sec_of = np.zeros(m, int) if sec_of is None else sec_of
    eps0 = np.where(sec_of == 1, CONTRACTION, 0.0)
    conn = np.array([[i, i + 1] for i in range(m)])
    up = np.tile([0.0, 0.0, 1.0], (m, 1))
    stages = stages or [Stage(load=1.0)]
    return Frame(np.asarray(points, float), conn, sec, sec_of, eps0, up, [0], {m: np.asarray(load, float)}, stages, m, planar)


def roll_up(n):
    """An end moment bends a cantilever into three quarters of a circle."""
    section = Section(E=1e4, G=5e3, A=1.0, I=1e-2, J=2e-2, As=1.0)
    points = np.linspace([0, 0, 0], [10, 0, 0], n + 1)
    frame = cantilever(points, [section], [0, 0, 0, 0, 0, 0.75 * 2 * math.pi * 100 / 10], True)
    angle = 1.5 * math.pi
    tip = [10 * math.sin(angle) / angle - 10, 10 * (1 - math.cos(angle)) / angle, 0]
    frame.references = {"shear": tip, "rigid": tip}
    return frame


def elastica(n):
    """A dead load P L^2/EI = 10 across a slender cantilever, EA = GA = 1e7, EI = 100: its own reference, not Euler's."""
    section = Section(E=1e7, G=1e7, A=1.0, I=1e-5, J=1e-5, As=1.0)
    frame = cantilever(np.linspace([0, 0, 0], [10, 0, 0], n + 1), [section], [0, 10, 0, 0, 0, 0], True)
    frame.references = stored("elastica")
    return frame


def bend(n):
    """The bend of 45 degrees, radius 100, one by one square, a load of 600 out of its plane; GJ is twice GI."""
    a = np.linspace(0, math.pi / 4, n + 1)
    points = np.c_[100 * np.sin(a), 100 * (1 - np.cos(a)), 0 * a]
    section = Section(E=1e7, G=5e6, A=1.0, I=1 / 12, J=1 / 6, As=1.0)
    frame = cantilever(points, [section], [0, 0, 600, 0, 0, 0], False)
    frame.references = stored("bend")
    return frame


def hsim(per):
    points, sec_of = hsim_points([0, 0, 0], [130, 0, 0], per)
    stages = [Stage(strain=1.0), Stage(strain=1.0, load=1.0)]
    frame = cantilever(points, HSIM, [0, -0.5, 0, 0, 0, 0], True, stages, sec_of)
    frame.references = stored("hsim")
    return frame


def dyad(per):
    """Two HSIM members at 22 degrees to the line of their clamped feet contract."""
    length, t = 130.0, math.radians(22)
    joint = np.array([0.0, 0.0, 0.0])
    a, sec = hsim_points([-length * math.cos(t), -length * math.sin(t), 0], joint, per)
    b, _ = hsim_points(joint, [length * math.cos(t), -length * math.sin(t), 0], per)
    frame = cantilever(np.vstack([a, b[1:]]), HSIM, np.zeros(6), True, [Stage(strain=1.0)], np.r_[sec, sec])
    frame.clamped, frame.loads, frame.watch = [0, len(frame.conn)], {}, len(a) - 1
    frame.references = stored("dyad")
    return frame


def tripod(per):
    """Three HSIM members carry a plate, here a star of bars a million times as stiff, and contract under a load."""
    r, length = 34.64101615137755, 130.0
    X, conn, sec_of, up, clamped = [np.zeros(3)], [], [], [], []
    for azimuth in map(math.radians, (90, 210, 330)):
        radial = np.array([math.cos(azimuth), math.sin(azimuth), 0])
        corner = r * radial
        ground = (r + length * math.cos(math.radians(30))) * radial - [0, 0, length / 2]
        points, sec = hsim_points(ground, corner, per)
        first = len(X)
        X.extend(points)
        clamped.append(first)
        across = np.array([-radial[1], radial[0], 0])
        for k, s in enumerate(sec):
            conn.append((first + k, first + k + 1)), sec_of.append(s), up.append(across)
        conn.append((0, len(X) - 1)), sec_of.append(2), up.append([0, 0, 1.0])
    stiff = Section(E=1e9, G=4e8, A=100.0, I=30.0, J=60.0, As=90.0)
    sec_of = np.array(sec_of)
    load = np.array([4 / 3, -2 / 3, -4 / 3, 0, 0, 0])
    stages = [Stage(strain=1.0), Stage(strain=1.0, load=1.0)]
    eps0 = np.where(sec_of == 1, CONTRACTION, 0.0)
    frame = Frame(np.array(X), np.array(conn), [*HSIM, stiff], sec_of, eps0, np.array(up, float), clamped, {0: load}, stages, 0, False)
    frame.references = stored("tripod")
    return frame


def tower(per, cells=16):
    """The tower P6: zig-zags of eight HSIM members between stiff rings; half of them contract by a tenth."""
    radius, pitch = 60.0, 80.0
    angles = np.arange(8) * math.pi / 4
    rings = [np.c_[radius * np.cos(angles), radius * np.sin(angles), 0 * angles + k * pitch] for k in range(cells + 1)]
    X = list(np.vstack(rings))
    conn, sec_of, eps, up = [], [], [], []
    for k in range(1, cells + 1):
        for j in range(8):
            p, q = 8 * k + j, 8 * k + (j + 1) % 8
            ids = [p, *range(len(X), len(X) + per - 1), q]
            X.extend(np.linspace(X[p], X[q], per + 1)[1:-1])
            for i in range(per):
                conn.append((ids[i], ids[i + 1]))
                sec_of.append(2), eps.append(0.0), up.append((0, 0, 1.0))
    for k in range(cells):
        for j in range(8):
            end = lambda v: 8 * (k if (v + k) % 2 == 0 else k + 1) + v % 8
            p, q = end(j), end(j + 1 if j < 7 else 8)
            points, sec = hsim_points(X[p], X[q], per)
            ids = [p, *range(len(X), len(X) + len(points) - 2), q]
            X.extend(points[1:-1])
            middle = (j + 0.5) * math.pi / 4
            strain = -0.1 if math.cos(middle) > 0 else 0.0
            for i, s in enumerate(sec):
                conn.append((ids[i], ids[i + 1])), sec_of.append(s)
                eps.append(strain if s == 1 else 0.0), up.append([math.cos(middle), math.sin(middle), 0])
    sections = [*HSIM, solid_round(2200.0, 2200.0 / 2.7, 3.0)]
    frame = Frame(np.array(X), np.array(conn), sections, np.array(sec_of), np.array(eps), np.array(up, float), list(range(8)), {}, [Stage(strain=1.0)], 8 * cells, False)
    frame.references = stored("tower")
    return frame


def stored(name):
    return json.loads((Path(__file__).parent / "references.json").read_text())[name]


# Name in examples/formulations.rs, what makes the frame, and elements (of a segment, where there are several).
PROBLEMS = {
    "roll-up, 3/4 turn": (roll_up, [8, 16, 32, 64, 128, 256]),
    "elastica, k = 10": (elastica, [8, 16, 32, 64, 128, 256]),
    "45-degree bend": (bend, [8, 16, 32, 64, 128, 256]),
    "HSIM cantilever": (hsim, [2, 4, 8, 16, 32, 64]),
    "dyad": (dyad, [2, 4, 8, 16, 32, 64]),
    "tripod": (tripod, [2, 4, 8, 16, 32]),
    "P6, 16 cells": (tower, [1, 2, 4]),
}
