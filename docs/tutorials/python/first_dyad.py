# %% [markdown]
# # A first dyad
#
# Two muscles meet at a joint. Inflated, they contract and pull it down; then it is pushed back, and what that takes is the
# force that the dyad can hold. Lengths are in mm, forces in N, pressures in psi.

# %%
import numpy as np

import pennate

network = pennate.loads("""
    format = "pennate/1"
    title = "pennate dyad"
    parameters = { L = 130, beta = 22, pressure = 25 }
    muscles.silicone = { library = "silicone" }
    members.left = { nodes = ["A", "J"], muscle = "silicone" }
    members.right = { nodes = ["B", "J"], muscle = "silicone" }
    supports = { A = "clamped", B = "clamped" }
    probes.stroke = { node = "J", displacement = "uy" }
    probes.holding = { node = "J", reaction = "uy" }

    [nodes]
    A = ["= -L * cos(beta)", "= -L * sin(beta)"]
    B = ["= L * cos(beta)", "= -L * sin(beta)"]
    J = [0, 0]

    [[steps]]
    name = "inflate"
    pressure = { all = "= pressure" }

    [[steps]]
    name = "push back"
    displacement = { J = { uy = 0 } }
""")
print(network)

# %%
solution = network.solve(accuracy=1e-6).raise_for_status()
print(solution)
print(f"stroke {solution['stroke@inflate']:.3f} mm, wrong by {solution.error['stroke'][0]:.1e} mm at most")

# %% [markdown]
# The two supports carry what holds the joint: forces are in balance.

# %%
back = solution.step("push back")
print(back.member("left").end_forces)
assert np.allclose(back.reaction[:, :3].sum(axis=0), 0.0, atol=1e-9)

# %% [markdown]
# Another pressure is another network. How the stroke grows with it is in the history, increment by increment.

# %%
slow = network.edit(steps={"inflate": {"increments": 10}}).solve()
inflate = slow.history.of_step("inflate")
for pressure, stroke in zip(inflate["pressure all"], inflate["stroke"]):
    print(f"{pressure:5.1f} psi {stroke:8.3f} mm")

# %%
solution.plot(output="first_dyad.png")
