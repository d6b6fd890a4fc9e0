"""What the command lines of the package have in common."""

from __future__ import annotations

import argparse


def setting(text: str) -> tuple[str, str]:
    """NAME=VALUE."""
    name, equals, value = text.partition("=")
    if not (equals and name.strip() and value.strip()):
        raise argparse.ArgumentTypeError("NAME=VALUE expected, such as beta=30")
    return name.strip(), value.strip()
