"""Pictures of networks: `plot` and `animate` of solutions, and what `pennate plot` draws. Needs `pennate[view]`.

A picture passes through these modules in turn:

* `results` takes a solution, or reads `results.json` and the `.vtu` files of a folder,
* `scene` makes of one state what there is to draw: rods, joints, bodies, supports, loads,
* `colours` chooses colours for a field, or says in words that there is but one value,
* `view` turns places in space into places on paper, and `surfaces` rods into surfaces, which `render` lights,
* `states` chooses the states of a figure and their places on `paper`,
* `symbols`, `naming` (with `labels`) and `legend` put supports, loads, names, scale and legend over that,
* `figure` does all of it for one network, `sheet` for many, and `film` for one that moves.
"""

from .api import animate, options, plot, png
from .results import PictureError

__all__ = ["PictureError", "animate", "options", "plot", "png"]
