"""What a learner remembers, written in place. Needs `pennate[train]`."""

from __future__ import annotations

from typing import Any

import numpy as np
from skrl.memories.jax import RandomMemory


class Replay(RandomMemory):  # type: ignore[misc]
    """The memory of skrl in arrays of NumPy: those of JAX are copied whole at each move."""

    memory_index: int
    filled: bool

    def create_tensor(self, name: str, *, size: Any, dtype: Any = None, keep_dimensions: bool = False) -> bool:
        made: bool = super().create_tensor(name, size=size, dtype=dtype, keep_dimensions=keep_dimensions)
        if made:
            self.tensors[name] = np.zeros(self.tensors[name].shape, self.tensors[name].dtype)
            # Views of the base class would keep arrays of JAX.
            self.tensors_view.clear()
        return made

    def add_samples(self, **tensors: Any) -> None:
        """One move of all arms."""
        for name, tensor in tensors.items():
            if name in self.tensors:
                self.tensors[name][self.memory_index] = np.asarray(tensor)
        self.memory_index += 1
        if self.memory_index == self.memory_size:
            self.memory_index, self.filled = 0, True
