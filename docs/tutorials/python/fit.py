# %% [markdown]
# # A fit to measurements
#
# A dyad was built, and its stroke measured at some pressures. Its muscles are known, its geometry only roughly: which length and
# which angle explain the measurements best, and how well are they known? The derivatives of a problem answer both.

# %%
import io

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plots
import numpy as np

import pennate

MEASURED = """\
pressure_psi,stroke_mm
10,-19.1
12,-22.9
14,-25.8
16,-28.2
18,-30.1
20,-31.6
22,-32.7
24,-33.5
"""
measured = np.genfromtxt(io.StringIO(MEASURED), delimiter=",", names=True)

network = pennate.loads("""
    format = "pennate/1"
    title = "dyad"
    parameters = { L = 120, beta = 25, pressure = 25 }
    muscles.silicone = { library = "silicone" }
    members.left = { nodes = ["A", "J"], muscle = "silicone" }
    members.right = { nodes = ["B", "J"], muscle = "silicone" }
    supports = { A = "clamped", B = "clamped" }
    steps = [{ name = "inflate", pressure = { all = "= pressure" } }]
    probes.stroke = { node = "J", displacement = "uy" }
    nodes = { A = ["= -L * cos(beta)", "= -L * sin(beta)"], B = ["= L * cos(beta)", "= -L * sin(beta)"], J = [0, 0] }
""")
problem = network.problem(["L", "beta", "pressure"], ["stroke"], accuracy=1e-6)

# %% [markdown]
# Gauss and Newton, with all pressures in one call.

# %%
pressures = measured["pressure_psi"]
unknown = problem.middle[:2]
for iteration in range(12):
    designs = np.column_stack([np.tile(unknown, (len(pressures), 1)), pressures])
    y, j = problem.gradient(designs)
    miss, slope = y[:, 0] - measured["stroke_mm"], j[:, 0, :2]
    step = np.linalg.lstsq(slope, -miss, rcond=None)[0]
    unknown = unknown + np.clip(step, -10, 10)
    print(f"{iteration:2}  L {unknown[0]:8.4f} mm  beta {unknown[1]:8.4f} deg  root mean square {np.sqrt(np.mean(miss**2)):.4f} mm")
    if np.abs(step).max() < 1e-8:
        break

# %% [markdown]
# The scatter of the measurements and the slopes say how well the two are known.

# %%
covariance = np.linalg.inv(slope.T @ slope) * (miss @ miss) / (len(miss) - 2)
for name, value, spread in zip(problem.parameters, unknown, np.sqrt(np.diag(covariance))):
    print(f"{name} = {value:.3f} ± {spread:.3f}")

# %%
fine = np.linspace(pressures[0], pressures[-1], 60)
curve = problem(np.column_stack([np.tile(unknown, (60, 1)), fine]))[:, 0]
figure, axes = plots.subplots(figsize=(5.5, 3.6), layout="constrained")
axes.plot(pressures, measured["stroke_mm"], "o", label="measured")
axes.plot(fine, curve, label=f"L = {unknown[0]:.1f} mm, beta = {unknown[1]:.1f} deg")
axes.set(xlabel="pressure, psi", ylabel="stroke, mm")
axes.legend()
figure.savefig("fit.png", dpi=120)
