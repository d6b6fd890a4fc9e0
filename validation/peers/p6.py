"""Writes the network P6, a tower of unit cells: p6_4.toml, p6_16.toml, p6_36.toml and p6_4_shear_rigid.toml.

    python p6.py

A cell is a zig-zag of eight HSIM members between two octagonal rings of radius 60, 80 apart. The members of one half
contract by 10 %; the base ring is clamped; every other ring is stiff. Node r4n0 is node 0 of ring 4, member c3m1
joins nodes 1 and 2 of the rings around cell 3. The measurements of other programs on this network name nodes and
members in the same order.
"""

import math
from pathlib import Path

HEADER = """\
# A tower of {cells} cells with stiff octagonal rings; half of its muscles contract by 10 % and bend it.
# Written by p6.py. Source: a geometrically exact frame by other means, meshed until converged.
format = "pennate/1"
title  = "Tower of {cells} cells"

[parameters]
R = 60                             # radius of a ring
pitch = 80                         # height of a cell
end = {end}            # length of a muscle's ends: a tenth of the muscle

[materials]
stiff = {{ youngs_modulus = 2200, shear_modulus = "= 2200 / 2.7" }}

[sections]
rod = {{ circle = {{ radius = 3 }}, shear = {shear} }}

[muscles.silicone]
diameter = 13
wall = 2
end_length = "= end"
pressure_unit = "psi"
shear = {shear}
table = [                          # constant values; at 25 psi the middle contracts by 25 x 0.004 = 0.1
  {{ pressure = 10, E = 3.6, alpha = -4e-3, R1 = 6.5, R2 = 8 }},
  {{ pressure = 25, E = 3.6, alpha = -4e-3, R1 = 6.5, R2 = 8 }},
]
"""


def network(cells: int, shear: bool) -> str:
    chord = 2 * 60 * math.sin(math.pi / 8)
    lines = [HEADER.format(cells=cells, end=repr(math.hypot(chord, 80) / 10), shear=str(shear).lower())]

    lines.append("[nodes]")
    for ring in range(cells + 1):
        for node in range(0, 8, 2) if ring == 0 else range(8):
            place = f'"= R * cos({45 * node})", "= R * sin({45 * node})", "= {ring} * pitch"'
            lines.append(f"r{ring}n{node} = [{place}]")

    lines.append("\n[members]")
    for ring in range(1, cells + 1):
        for node in range(8):
            ends = f'["r{ring}n{node}", "r{ring}n{(node + 1) % 8}"]'
            lines.append(f'r{ring}m{node} = {{ nodes = {ends}, section = "rod", material = "stiff" }}')
    for cell in range(cells):
        for side in range(8):
            ends = ", ".join(f'"{vertex(cell, node)}"' for node in (side, side + 1))
            contracts = math.cos((side + 0.5) * math.pi / 4) > 0
            group = ', group = "contracting"' if contracts else ""
            lines.append(f'c{cell}m{side} = {{ nodes = [{ends}], muscle = "silicone"{group} }}')

    lines.append("\n[supports]")
    lines += [f'r0n{node} = "clamped"' for node in range(0, 8, 2)]
    lines.append('\n[[steps]]\nname = "contract"\npressure = { contracting = 25 }')
    lines.append("\n[probes]")
    lines += [f'{c} = {{ node = "r{cells}n0", displacement = "u{c}" }}' for c in "xyz"]
    return "\n".join(lines) + "\n"


def vertex(cell: int, node: int) -> str:
    """Vertex of the zig-zag: on the lower ring where node + cell is even, on the upper one elsewhere."""
    ring = cell if (node + cell) % 2 == 0 else cell + 1
    return f"r{ring}n{node % 8}"


if __name__ == "__main__":
    folder = Path(__file__).parent
    for cells in (4, 16, 36):
        (folder / f"p6_{cells}.toml").write_text(network(cells, shear=True))
    (folder / "p6_4_shear_rigid.toml").write_text(network(4, shear=False))
