"""Networks as TOML with the values that their parameters have: comments and the order of a file stay."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ._network import Network


def toml_of(network: Network) -> str:
    """The text of a network's file with its present parameters written in; of one that is no TOML, what it holds."""
    import tomlkit
    import tomlkit.exceptions

    tree = network.to_dict()
    try:
        tomlkit.parse(network.text)
    except tomlkit.exceptions.TOMLKitError:
        return tomlkit.dumps(tree)
    return with_parameters(network.text, tree.get("parameters", {}))


def with_parameters(text: str, values: Mapping[str, Any]) -> str:
    """A TOML text with other values of some of its parameters; what is as it was keeps its digits."""
    import tomlkit

    document = tomlkit.parse(text)
    parameters = document.get("parameters", {})
    for name, value in values.items():
        if name in parameters and parameters[name] != value:
            parameters[name] = value
    return tomlkit.dumps(document)
