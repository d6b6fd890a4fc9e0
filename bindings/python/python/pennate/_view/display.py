"""What is shown of a network: its picture, the colours of a quantity, and what these mean."""

from __future__ import annotations

import pathlib
from typing import Any

import numpy as np
import viser

from .._look import fields
from .._look.fields import Scale
from .._look.shapes import Integers
from .._network import EDITED, Network
from . import names
from .panel import Panel
from .picture import Picture, line_values

UNITS = {"mm-N-MPa": ("mm", "N"), "m-N-Pa": ("m", "N")}


class Display:
    """The picture of one network, coloured as the panel asks for."""

    def __init__(self, server: viser.ViserServer, panel: Panel, network: Network, joined: Integers) -> None:
        self.server, self.panel, self.network = server, panel, network
        self.fields = panel.fields = offered(network)
        self.picture = Picture(server, network.nodes, network.members, joined, network.dimension == "plane")
        if not self.picture.with_names:
            panel.names.value = False
        self.scale: Scale | None = None
        # The drawing that is seen, and that of the network without loads.
        self.shown: tuple[dict[str, Any], dict[str, Any]] | None = None
        # Whether the page knows where names are.
        self.named = False

    def draw(self, drawing: dict[str, Any] | None, unloaded: dict[str, Any] | None) -> None:
        """Shows a state."""
        if drawing is None or unloaded is None:
            return
        self.shown = drawing, unloaded
        self.panel.show_places("[]")
        self.named = False
        values = line_values(drawing, self.panel.shown_field)
        self.scale = fields.scale_of(self.panel.shown_field, values, self.scale)
        self.picture.show(drawing, unloaded, values, self.scale)
        self.panel.show_legend(self.scale)
        self.server.flush()

    def name(self) -> None:
        """Lets the page say what the pointer is on; it is told at rest alone."""
        if self.shown is not None and not self.named:
            picture, drawing = self.picture, self.shown[0]
            text = names.places(
                drawing, picture.nodes, picture.members, picture.joined, self.panel.shown_field, picture.scaled
            )
            self.panel.show_places(text)
            self.named = True
            self.server.flush()

    def redraw(self) -> None:
        """Colours, names and loads as they are asked for now."""
        self.picture.with_ghost, self.picture.with_names = self.panel.ghost.value, self.panel.names.value
        self.picture.with_loads = self.panel.loads.value
        if self.shown is not None:
            self.draw(*self.shown)

    def clicked(self, event: Any) -> None:
        """Says all values of the member that was clicked."""
        member = self.picture.member_along(np.array(event.ray_origin), np.array(event.ray_direction))
        if member is not None and self.shown is not None:
            name = self.network.members[member]
            event.client.add_notification(name, "; ".join(self.values_of(member)), auto_close_seconds=8.0)

    def values_of(self, member: int) -> list[str]:
        """Every quantity of a member in words, those left out that are zero."""
        assert self.shown is not None
        drawing = self.shown[0]
        own = drawing["cell_data"]["member_id"] == member
        parts = []
        for field in self.fields.values():
            found = fields.values(drawing, field)[own]
            low, high = float(found.min()), float(found.max())
            if low == high == 0.0:
                continue
            parts.append(f"{field.words} {names.span(low, high, field.unit)}")
        return parts


def offered(network: Network) -> dict[str, fields.Field]:
    """What can be shown of a network, in its units."""
    return fields.fields(*UNITS[network.units], network.pressure_unit)


def named(network: Network) -> str:
    """What the page is called."""
    return network.title or file_name(network)


def described(network: Network) -> str:
    """The file and what it holds, in a line."""
    kind = "plane" if network.dimension == "plane" else "spatial"
    count = len(network.members)
    members = f"{count} {'member' if count == 1 else 'members'}"
    return f"{file_name(network)} · {kind}, {len(network.nodes)} nodes, {members}"


def file_name(network: Network) -> str:
    """Of the file that a network is of."""
    return pathlib.PurePath(network.name).name.removesuffix(EDITED)
