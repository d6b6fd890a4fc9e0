"""The live page: a network that is followed while sliders move. Needs `pennate[view]`.

* `server` lets in nobody but those who have the address,
* `handles` says what can be moved, `follow` follows the equilibrium, and `way` has the states between the ends of steps,
* `picture` shows it in space, and `panel` has the controls and the numbers,
* `session` ties these together and watches the file, and `save` makes files for whoever looks.
"""

from .session import Session

__all__ = ["Session"]
