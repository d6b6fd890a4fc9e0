"""Where the network came from: a file that is read again when it changes, or a network of Python."""

from __future__ import annotations

import os
import pathlib
from collections.abc import Mapping

from .._errors import Error
from .._network import Network, load
from .handles import Handle, moving


class Source:
    """A file with the settings that it is read with; without a path nothing ever changes."""

    def __init__(
        self, path: pathlib.Path | None, settings: Mapping[str, str], ranges: Mapping[str, tuple[float, float]]
    ) -> None:
        self.path, self.settings, self.ranges = path, dict(settings), dict(ranges)
        self.seen = self._stamp()

    def again(self) -> tuple[Network, list[Handle]] | str | None:
        """The network of a file that changed and what can be moved, or its mistake in words; nothing where it did not change."""
        stamp = self._stamp()
        if self.path is None or stamp is None or stamp == self.seen:
            return None
        self.seen = stamp
        try:
            network = load(self.path).set(**self.settings)
            network.check()
            return moving(network, self.ranges)
        except Error as error:
            return str(error).replace(str(self.path), self.path.name)
        except OSError:
            # It is being written.
            self.seen = None
            return None

    def _stamp(self) -> tuple[int, int] | None:
        if self.path is None:
            return None
        try:
            found = os.stat(self.path)
        except OSError:
            return None
        return found.st_mtime_ns, found.st_size
