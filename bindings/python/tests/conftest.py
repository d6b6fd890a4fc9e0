"""The networks that the tests ask about."""

from __future__ import annotations

import pytest

import pennate

DYAD = """\
format = "pennate/1"
title = "pennate dyad"

[parameters]
L = 130
beta = 22
pressure = 25

[nodes]
A = ["= -L * cos(beta)", "= -L * sin(beta)"]
B = ["=  L * cos(beta)", "= -L * sin(beta)"]
J = [0, 0]

[muscles.silicone]
diameter = 13
wall = 2.0
pressure_unit = "psi"
density = 1.1e-9
table = [
  { pressure = 10, E = 3.60, alpha = -9.135e-3, R1 = 6.80, R2 = 7.90 },
  { pressure = 15, E = 3.66, alpha = -8.526e-3, R1 = 6.95, R2 = 8.35 },
  { pressure = 20, E = 3.85, alpha = -7.788e-3, R1 = 7.05, R2 = 8.70 },
  { pressure = 25, E = 4.25, alpha = -6.885e-3, R1 = 7.15, R2 = 8.90 },
]

[members]
left = { nodes = ["A", "J"], muscle = "silicone" }
right = { nodes = ["B", "J"], muscle = "silicone" }

[supports]
A = "clamped"
B = "clamped"

[[steps]]
name = "inflate"
pressure = { all = "= pressure" }

[[steps]]
name = "push back"
displacement = { J = { uy = 0.0 } }

[probes]
stroke = { node = "J", displacement = "uy" }
holding = { node = "J", reaction = "uy" }
"""

STRUT = """\
format = "pennate/1"
nodes = { A = [0, 0], B = [100, 0] }
materials.steel = { youngs_modulus = 200000, poissons_ratio = 0.3, density = 7.8e-9 }
sections.wire = { circle = { radius = 0.75 } }
members.wire = { nodes = ["A", "B"], section = "wire", material = "steel" }
supports = { A = "clamped" }
probes.shortening = { node = "B", displacement = "ux" }
[[steps]]
name = "press"
force = { B = [-40, 0] }
"""

# Two strips that snap through: the step ends where they lose their stability.
SNAP = """\
format = "pennate/1"
nodes = { A = [-100, 0], B = [100, 0], C = [0, 10] }
materials.steel = { youngs_modulus = 200000, poissons_ratio = 0.3 }
sections.strip = { rectangle = { width = 10, height = 1 } }
members.left = { nodes = ["A", "C"], section = "strip", material = "steel" }
members.right = { nodes = ["B", "C"], section = "strip", material = "steel" }
supports = { A = "clamped", B = "clamped" }
probes.down = { node = "C", displacement = "uy" }
dimension = "plane"
[[steps]]
name = "press"
force = { C = [0, -1000] }
[[steps]]
name = "more"
force = { C = [0, -2000] }
"""


# A rigid body on a spring, and a node on another one: no member at all.
LOOSE = """\
format = "pennate/1"
nodes = { A = [0, 0], B = [100, 0], C = [100, 50], D = [0, 50] }
rigid_bodies.plate = { nodes = ["A", "B", "C"], mass = 1e-3 }
springs.k = { node = "A", stiffness = { ux = 1, uy = 1, rz = 1000 } }
springs.l = { nodes = ["A", "D"], stiffness = { ux = 1, uy = 1, rz = 1000 } }
[[steps]]
name = "push"
force = { B = [0, -1] }
"""


@pytest.fixture(scope="session")
def loose() -> pennate.Network:
    """A network without members."""
    return pennate.loads(LOOSE, name="loose.toml")


@pytest.fixture(scope="session")
def dyad() -> pennate.Network:
    """Two muscles that pull a joint down, inflated, then pushed back."""
    return pennate.loads(DYAD, name="dyad.toml")


@pytest.fixture(scope="session")
def solution(dyad: pennate.Network) -> pennate.Solution:
    """The same, solved."""
    return dyad.solve()


@pytest.fixture(scope="session")
def strut() -> pennate.Network:
    """A strut that is pressed beyond its critical load."""
    return pennate.loads(STRUT, name="strut.toml")


@pytest.fixture(scope="session")
def snap() -> pennate.Network:
    """Two strips that snap through."""
    return pennate.loads(SNAP, name="snap.toml")
