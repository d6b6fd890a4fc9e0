# %% [markdown]
# # A sweep, and a map of it
#
# How far a dyad moves and how much it holds depends on the angle of its muscles and on their pressure. A sweep solves all
# combinations of some angles and some pressures; xarray keeps the answers with their coordinates.

# %%
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plots
import numpy as np

import pennate

network = pennate.scene("dyad")
print(network)

# %%
table = pennate.sweep(network, chi=np.linspace(14, 40, 27), pressure=np.linspace(12, 28, 17))
print(table)

# %% [markdown]
# Every design has its own estimated error, a verdict on its stability, and, where there is no answer, a reason: here the
# table of the muscle ends at 25 psi.

# %%
solved = table.status == "converged"
print(f"{int(solved.sum())} of {solved.size} converged, {int((table.stable == 1).sum())} are stable, largest error {float(table.error.max()):.1e}")
print("at 27 psi:", table.reason.sel(chi=20, pressure=27).item())

# %% [markdown]
# Coordinates are names, not numbers of columns: the angle that moves farthest at 15 psi, and what is between two grid lines.

# %%
at_15 = table.sel(pressure=15)
best = at_15.stroke.idxmax().item()
print(f"at 15 psi {best:g} degrees move farthest, by {at_15.stroke.max().item():.2f} mm")
print(f"at 21.3 degrees and 15.5 psi: {table.stroke.interp(chi=21.3, pressure=15.5).item():.2f} mm")

# %% [markdown]
# The map leaves white what has no answer.

# %%
figure, axes = plots.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
for place, name in zip(axes, network.probes):
    probe = table[name]
    drawn = place.contourf(table.chi, table.pressure, probe.T, 12)
    figure.colorbar(drawn, ax=place)
    place.set(xlabel="angle, deg", ylabel="pressure, psi", title=f"{name}, {probe.units}")
figure.savefig("sweep.png", dpi=120)
