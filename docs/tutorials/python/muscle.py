# %% [markdown]
# # A muscle from load cases
#
# [`pennate fit`](../../fit.md) makes the table of a muscle from load cases of a clamped one. The same by the derivatives of a
# problem takes fifty lines. It takes more time, and what may be measured, and what is unknown, is whatever a network file can say:
# a muscle in a mechanism, say, or a wall that nobody measured. Here it is what `pennate fit` does, so that the two can be compared.

# %%
import pathlib

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plots
import numpy as np

import pennate

DATA = pathlib.Path(__file__).parents[3] / "validation" / "hifi" / "load_cases.csv"
LENGTH, PRESSURE, DIAMETER = 130.0, 20.0, 13.0

rows = np.genfromtxt(DATA, delimiter=",", names=True, dtype=None, encoding="utf-8")
ours = (rows["variant"] == "A") & (rows["L_mm"] == LENGTH) & (rows["pressure_psi"] == PRESSURE) & (rows["converged"] == 1)
free = rows[ours & (rows["test"] == "inflate")][0]
cases = rows[ours & np.isin(rows["test"], ["axial+", "bend"])]

# %% [markdown]
# The contraction follows from the free stroke alone. Radii and modulus are what is unknown, the loads are what differs from case to
# case; all of them are parameters of one network.

# %%
alpha = (free["tip_x_mm"] - LENGTH) / (PRESSURE * (LENGTH - 2 * DIAMETER))
network = pennate.loads(f"""
    format = "pennate/1"
    parameters = {{ R1 = {DIAMETER / 2}, R2 = {DIAMETER / 2}, E = 1, Fx = 0, Fy = 0, Mz = 0 }}
    nodes = {{ root = [0, 0], tip = [{LENGTH}, 0] }}
    members.muscle = {{ nodes = ["root", "tip"], muscle = "made" }}
    supports.root = "clamped"

    [muscles.made]
    diameter = {DIAMETER}
    wall = 2
    pressure_unit = "psi"
    table = [{{ pressure = {PRESSURE}, E = "= E", alpha = {alpha}, R1 = "= R1", R2 = "= R2" }}]

    [[steps]]
    name = "inflate"
    pressure.muscle = {PRESSURE}

    [[steps]]
    name = "load"
    force.tip = ["= Fx", "= Fy"]
    moment.tip = [0, 0, "= Mz"]

    [probes]
    x = {{ node = "tip", position = "x" }}
    y = {{ node = "tip", position = "y" }}
    slope = {{ node = "tip", rotation = "rz" }}
""")
problem = network.problem(["R1", "R2", "E", "Fx", "Fy", "Mz"], ["x", "y", "slope"], accuracy=1e-5)

# %% [markdown]
# A pull tells of the motion along the axis, a load across it of deflection and slope; each is measured by the largest of its kind.
# Steps are taken in the logarithms of the unknowns, which are positive and of unknown size, a third at most; they are damped where
# they lead uphill (Levenberg and Marquardt).

# %%
loads = np.column_stack([cases["Fx_N"], cases["Fy_N"], cases["Mz_Nmm"]])
measured = np.column_stack([cases["tip_x_mm"], cases["tip_y_mm"], cases["tip_theta_deg"]])
along = (loads[:, 1] == 0) & (loads[:, 2] == 0)
counts = np.column_stack([along, ~along, ~along])
sizes = np.where(counts, np.abs(measured - [LENGTH, 0, 0]), 0).max(0)


def differences(logarithms):
    """What the model misses by, and its derivatives by the logarithms of the unknowns."""
    unknown = np.exp(logarithms)
    y, j = problem.gradient(np.column_stack([np.tile(unknown, (len(cases), 1)), loads]))
    return ((y - measured) / sizes)[counts], (j[:, :, :3] * unknown / sizes[:, None])[counts]


place, damping = np.log(problem.middle[:3]), 1e-2
miss, slope = differences(place)
for iteration in range(50):
    normal = slope.T @ slope
    step = np.clip(np.linalg.solve(normal + damping * np.diag(np.diag(normal)), -slope.T @ miss), -0.3, 0.3)
    if np.abs(step).max() < 1e-7:
        break
    found, rates = differences(place + step)
    if np.isfinite(found).all() and found @ found <= miss @ miss:
        place, miss, slope, damping = place + step, found, rates, damping / 10
    else:
        damping *= 10

# %% [markdown]
# The derivatives at the optimum say how well each of the unknowns is known.

# %%
unknown = np.exp(place)
covariance = np.linalg.inv(slope.T @ slope) * (miss @ miss) / (len(miss) - 3)
for name, value, spread in zip(problem.parameters, unknown, unknown * np.sqrt(np.diag(covariance))):
    print(f"{name} = {value:.4f} ± {spread:.4f}")
y = problem(np.column_stack([np.tile(unknown, (len(cases), 1)), loads]))
for name, column, which in (("axial", 0, along), ("bending", 1, ~along), ("slope", 2, ~along)):
    print(f"{name}: {np.abs(y - measured)[which, column].mean():.3f} on the average")

# %%
figure, axes = plots.subplots(figsize=(5.5, 3.6), layout="constrained")
order = np.argsort(loads[~along, 1])
axes.plot(loads[~along, 1][order], measured[~along, 1][order], "o", label="load cases")
axes.plot(loads[~along, 1][order], y[~along, 1][order], label="fitted muscle")
axes.set(xlabel="force across the axis, N", ylabel="deflection, mm")
axes.legend()
figure.savefig("muscle_fit.png", dpi=120)
