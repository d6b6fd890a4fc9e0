# %% [markdown]
# # A bistable arch
#
# Two strips of steel are hinged at their feet and at a shallow apex. Pressed down, they carry less and less from some point on, and
# under a dead weight they snap through. The arc length follows the path where no equilibrium under the load is near; let go on the
# other side, the arch stays by itself.

# %%
import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plots

import pennate

network = pennate.loads("""
    format = "pennate/1"
    title = "three-hinged arch"
    parameters = { a = 60, h = 3, load = 800 }
    nodes = { A = ["= -a", 0], B = ["= a", 0], C = [0, "= h"] }
    materials.steel = { youngs_modulus = "200 GPa", poissons_ratio = 0.3 }
    sections.strip = { rectangle = { width = 8, height = 3 } }
    members.left = { nodes = ["A", "C"], section = "strip", material = "steel", release = { start = "pin", end = "pin" } }
    members.right = { nodes = ["B", "C"], section = "strip", material = "steel", release = { start = "pin", end = "pin" } }
    supports = { A = "pinned", B = "pinned" }
    probes.down = { node = "C", displacement = [0, -1] }
    steps = [{ name = "press", force = { C = [0, "= -load"] } }]
""")

# %% [markdown]
# Under the load the step stops, and says where and why.

# %%
stopped = network.solve()
print(stopped.status, f"at {stopped.fraction[0]:.4f} of the load")
print(stopped.failures[0])

# %% [markdown]
# The arc length goes through: a path of equilibria, stable and not.

# %%
path = network.edit(steps={"press": {"method": "arc_length", "increments": 40}}).solve().raise_for_status()
press = path.history.of_step("press")
force = -press[next(name for name in press if name.startswith("force"))]
load = network.parameters["load"]
for point in path.to_dict()["steps"][0]["critical_points"]:
    print(f"{point['kind']} at {load * point['fraction']:.3f} N")

# %% [markdown]
# Let go on the other side, it stays there. The jump goes to the next stable equilibrium under the load, and the second step takes the
# load away.

# %%
other = network.edit(
    steps=[
        {"name": "press", "method": "jump", "force": {"C": [0, "= -load"]}},
        {"name": "let go", "force": {"C": [0, 0]}},
    ],
).solve().raise_for_status()
print(f"apex {other['down'][0]:.3f} mm down under the load, {other['down'][1]:.3f} mm without; stable: {other.stable[1]}")
assert other["down"][1] > 5.9 and other.stable[1]

# %%
figure, axes = plots.subplots(figsize=(5.5, 3.6), layout="constrained")
axes.plot(press["down"], force, marker=".")
axes.plot(stopped["down"], load * stopped.fraction, "o", label="a dead load stops here")
axes.set(xlabel="apex down, mm", ylabel="force, N")
axes.legend()
figure.savefig("bistable.png", dpi=120)
other.plot("unloaded", "press", "let go", output="bistable_arch.png")
