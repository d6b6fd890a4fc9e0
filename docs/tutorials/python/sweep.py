# %% [markdown]
# # A sweep, and a map of it
#
# How far a dyad moves and how much it holds depends on the angle of its muscles and on their pressure. A problem answers
# for a grid of both at once; xarray keeps the answers with their coordinates.

# %%
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plots
import numpy as np
import xarray

import pennate

network = pennate.scene("dyad")
print(network)

# %% [markdown]
# The problem is compiled once: its mesh also has to serve the corners of the grid.

# %%
angles, pressures = np.linspace(14, 40, 27), np.linspace(12, 20, 17)
grid = np.stack(np.meshgrid(angles, pressures, indexing="ij"), axis=-1).reshape(-1, 2)
corners = [[angles[a], pressures[p]] for a in (0, -1) for p in (0, -1)]
problem = network.problem(["chi", "pressure"], accuracy=1e-6, sample=corners)
print(problem, "errors", dict(zip(problem.probes, problem.error)))

# %%
y = problem(grid)
silent = [reason for reason in problem.reasons if reason is not None]
print(f"{len(grid)} designs, {len(silent)} without an answer", *set(silent), sep="\n  ")

table = xarray.Dataset(
    {name: (("angle", "pressure"), y[:, column].reshape(27, 17)) for column, name in enumerate(problem.probes)},
    coords={"angle": ("angle", angles, {"units": "deg"}), "pressure": ("pressure", pressures, {"units": "psi"})},
    attrs={"title": network.title, "accuracy": problem.accuracy},
)
print(table)

# %%
first, second = list(table.data_vars)[:2]
figure, axes = plots.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
for place, name in zip(axes, (first, second)):
    drawn = place.contourf(table.angle, table.pressure, table[name].T, 12)
    figure.colorbar(drawn, ax=place)
    place.set(xlabel="angle, deg", ylabel="pressure, psi", title=f"{name}, {network.probes[name.split('@')[0]]}")
figure.savefig("sweep.png", dpi=120)
