"""The reference of imperfect_strut.toml: the buckled equilibrium of a bent cantilever, by shooting from its clamp.

    python imperfect_strut.py           (needs scipy)

Planar Reissner rod with initial curvature k under the dead load (-P, 0) at its tip, angle t of the section to x:
    N = -P cos t,  Q = P sin t,   r' = (1 + N/EA) (cos t, sin t) + Q/GA (-sin t, cos t),
    t' = k + M/EI,   M' = -P y',   t = 0 at the clamp and M = 0 at the tip.
"""

import math

from scipy.integrate import solve_ivp
from scipy.optimize import brentq

L, RADIUS, E, NU, K = 100.0, 2.0, 2000.0, 0.3, 2e-5
EA = E * math.pi * RADIUS**2
GA = 0.9 * EA / (2 * (1 + NU))
EI = E * math.pi * RADIUS**4 / 4
P = 3.65 * math.pi**2 * EI / (4 * L**2)


def slopes(_, state):
    _, _, angle, moment = state
    cos, sin = math.cos(angle), math.sin(angle)
    stretch, shear = 1 - P * cos / EA, P * sin / GA
    y = stretch * sin + shear * cos
    return [stretch * cos - shear * sin, y, K + moment / EI, -P * y]


def shoot(moment):
    return solve_ivp(slopes, (0, L), [0, 0, 0, moment], method="DOP853", rtol=1e-13, atol=1e-13).y[:, -1]


# The root of largest moment is the buckled state; near zero lie the almost straight ones, unstable.
moment = brentq(lambda m: shoot(m)[3], 0.3 * P * L, 1.2 * P * L, xtol=1e-12, rtol=1e-15)
x, y, angle, _ = shoot(moment)
start = math.sin(K * L) / K, 2 * math.sin(K * L / 2) ** 2 / K
print("load", P)
print("displacement", [float(x - start[0]), float(y - start[1])])
print("rotation", float(angle - K * L))
print("reaction_force", [P, 0.0])
print("reaction_moment", -moment)
