"""Modes of vibration and of buckling."""

from __future__ import annotations

import functools
import json
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


class Spectrum:
    """What modes of vibration and of buckling have in common."""

    def __init__(self, text: str, report: str) -> None:
        self._text, self._report = text, report

    @functools.cached_property
    def _found(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self._text)
        return found

    def _column(self, key: str) -> Array:
        values = [mode.get(key) for mode in self._found["modes"]]
        return np.array([np.nan if value is None else value for value in values], dtype=np.float64)

    @property
    def nodes(self) -> tuple[str, ...]:
        """Names of the nodes, in the order of the shapes."""
        modes = self._found["modes"]
        return tuple(modes[0]["nodes"]) if modes else ()

    @functools.cached_property
    def shapes(self) -> Array:
        """(modes, nodes, 6), displacement and rotation vector of the nodes in each mode."""
        modes = self._found["modes"]
        motions = [
            [[*node["displacement"], *node["rotation_vector"]] for node in mode["nodes"].values()] for mode in modes
        ]
        return np.array(motions, dtype=np.float64).reshape(len(modes), len(self.nodes), 6)

    @property
    def error(self) -> Array:
        """(modes,), estimated discretization error of the frequency or factor, relative to it."""
        return self._column("error")

    @property
    def families(self) -> tuple[str, ...]:
        """Whether each motion is in `"space"`, `"in_plane"` or `"out_of_plane"`."""
        return tuple(mode["family"] for mode in self._found["modes"])

    @property
    def notes(self) -> list[str]:
        """What a reader must know besides, a sentence each."""
        return list(self._found["notes"])

    def to_dict(self) -> dict[str, Any]:
        """What `modes.json` or `buckling.json` holds."""
        found: dict[str, Any] = json.loads(self._text)
        return found

    def __len__(self) -> int:
        return len(self._found["modes"])

    def __str__(self) -> str:
        return self._report


class Modes(Spectrum):
    """Natural frequencies and modes; modes have the modal mass 1."""

    @property
    def frequency(self) -> Array:
        """(modes,), Hz; not a number where the state is unstable in the motion."""
        return self._column("frequency_hz")

    @property
    def eigenvalue(self) -> Array:
        """(modes,), square of the angular frequency, 1/s²; negative where the state is unstable in the motion."""
        return self._column("eigenvalue")

    def __repr__(self) -> str:
        values = " ".join(f"{value:.5g}" for value in self.frequency)
        return f"<Modes {self._found['title']!r}: {len(self)} modes, {values} Hz>"


class Buckling(Spectrum):
    """Critical factors and modes; modes have a largest component of 1."""

    @property
    def factor(self) -> Array:
        """(modes,), critical factors of the ramp, or of the loads that are present."""
        return self._column("factor")

    @property
    def reversed(self) -> float | None:
        """The nearest factor of the ramp the other way, where there is one."""
        value = self._found.get("reversed")
        return None if value is None else float(value)

    @property
    def reversed_error(self) -> float | None:
        """Estimated error of `reversed`, relative to it; None where there is none."""
        value = self._found.get("reversed_error")
        return None if value is None else float(value)

    def __repr__(self) -> str:
        values = " ".join(f"{value:.5g}" for value in self.factor)
        return f"<Buckling {self._found['title']!r}: {len(self)} modes, factors {values}>"
