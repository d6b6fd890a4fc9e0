# %% [markdown]
# # A stage designed by its gradient
#
# A stage on three dyads is to rise and sink by 32 mm and to tilt by 8 degrees. Three numbers of it are free: the length of its
# muscles, their inclination, and the radius of the stage. A problem gives the derivatives of both wishes by all three, so that a few
# steps of Gauss and Newton, damped after Levenberg and Marquardt, find a design.

# %%
import numpy as np

import pennate

network = pennate.scene("stage")
problem = network.problem(["L", "beta", "rp"], ["stroke@high", "tilt@one_high"], accuracy=1e-5)
wanted = np.array([32.0, 8.0])
# What a step may change, and how much each wish counts.
scale, weight = np.array([130.0, 27.0, 30.0]), 1.0 / np.array([32.0, 8.0])
low, high = np.array([100.0, 20.0, 15.0]), np.array([160.0, 45.0, 60.0])

# %%
x, damping = problem.middle, 1e-2
y, j = problem.gradient(x)
miss = weight * (y - wanted)
for iteration in range(30):
    slope = weight[:, None] * j * scale
    step = np.linalg.solve(slope.T @ slope + damping * np.eye(3), -slope.T @ miss)
    trial = np.clip(x + scale * step, low, high)
    found, derivatives = problem.gradient(trial)
    better = weight * (found - wanted)
    if np.isfinite(derivatives).all() and better @ better < miss @ miss:
        x, y, j, miss, damping = trial, found, derivatives, better, damping / 3
    else:
        damping *= 4
    print(f"{iteration:2} L {x[0]:7.3f}  beta {x[1]:6.3f}  rp {x[2]:6.3f}   stroke {y[0]:7.3f} mm  tilt {y[1]:6.3f} deg")
    if np.abs(miss).max() < 1e-7:
        break

# %% [markdown]
# The design is solved once more by itself, with an estimate of its error, and drawn.

# %%
design = network.set(**dict(zip(problem.parameters, x)))
solution = design.solve(accuracy=1e-6).raise_for_status()
print(solution)
assert np.allclose([solution["stroke@high"], solution["tilt@one_high"]], wanted, rtol=1e-4)
solution.plot("low", "one_high", output="stage_design.png", view="-35,30")
