"""What the live page and the report have in common: the shapes of states, colours of fields, and words. NumPy alone.

* `shapes` takes a drawing of a solution apart into cells, bodies, supports and loads, and carries it to other places of the nodes,
* `fields` says which quantities can be shown, and in which colours,
* `words` puts verdicts and findings into plain sentences,
* `finer` solves a network once more with enough increments to show the way.
"""
