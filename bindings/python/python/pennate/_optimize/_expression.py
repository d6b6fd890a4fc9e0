"""Expressions of a study: parameters and probes, angles in degrees, for many designs at once."""

from __future__ import annotations

import ast
import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import numpy.typing as npt

Values = npt.NDArray[np.float64]

# Stands for the @ of a probe after a step: a letter that names do not have.
STEP = "ˑ"

FUNCTIONS: dict[str, tuple[int, Callable[..., Any]]] = {
    "sqrt": (1, np.sqrt),
    "abs": (1, np.abs),
    "exp": (1, np.exp),
    "ln": (1, np.log),
    "sin": (1, lambda a: np.sin(np.radians(a))),
    "cos": (1, lambda a: np.cos(np.radians(a))),
    "tan": (1, lambda a: np.tan(np.radians(a))),
    "asin": (1, lambda a: np.degrees(np.arcsin(a))),
    "acos": (1, lambda a: np.degrees(np.arccos(np.clip(a, -1.0, 1.0)))),
    "atan": (1, lambda a: np.degrees(np.arctan(a))),
    "atan2": (2, lambda a, b: np.degrees(np.arctan2(a, b))),
    "min": (2, np.minimum),
    "max": (2, np.maximum),
}
OPERATORS: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: np.add,
    ast.Sub: np.subtract,
    ast.Mult: np.multiply,
    ast.Div: np.divide,
    ast.Pow: np.power,
}


class Expression:
    """An expression such as `"= min(y@free, y@blocked) - L * sin(beta)"`; a bare number is one as well.

    Raises:
        ValueError: What is wrong, in words.
    """

    __slots__ = ("_tree", "names", "text")

    def __init__(self, written: str | float) -> None:
        self.text = str(written)
        body = self.text.strip()
        if isinstance(written, str):
            if not body.startswith("="):
                raise ValueError(f"'{body}' is no expression: it begins with '=', such as \"= {body}\"")
            body = body[1:].strip()
        try:
            # A probe after a step binds closer than any operator of Python.
            marked = re.sub(r"([^\W\d]\w*)\s*@\s*([^\W\d]\w*)", rf"\1{STEP}\2", body.replace("^", "**"))
            self._tree: ast.expr = ast.parse(marked, mode="eval").body
            names = _names(self._tree)
        except SyntaxError as error:
            raise ValueError(f"'{body}' is no expression: {error.msg}") from None
        except (RecursionError, MemoryError):
            raise ValueError(f"'{body[:40]}…' is too long an expression") from None
        self.names: frozenset[str] = frozenset(names)
        """Parameters, and probes such as `u` or `u@free`."""

    def __call__(self, values: Mapping[str, Values | float]) -> Values:
        """The values for many designs at once."""
        with np.errstate(all="ignore"):
            return np.asarray(_value(self._tree, values), dtype=np.float64)


def _probe(node: ast.AST) -> str | None:
    """The name of a probe after a step, `probe@step`, or of a parameter."""
    return node.id.replace(STEP, "@") if isinstance(node, ast.Name) else None


def _names(node: ast.expr) -> list[str]:
    name = _probe(node)
    if name is not None:
        return [] if name == "pi" else [name]
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)) and not isinstance(node.value, bool):
        return []
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.UAdd, ast.USub)):
        return _names(node.operand)
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
        return _names(node.left) + _names(node.right)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
        known = FUNCTIONS.get(node.func.id)
        if known is None:
            raise ValueError(f"there is no function '{node.func.id}'; known are {', '.join(FUNCTIONS)}")
        if node.keywords or len(node.args) != known[0]:
            raise ValueError(f"'{node.func.id}' takes {known[0]} value(s), not {len(node.args)}")
        return [name for each in node.args for name in _names(each)]
    text = ast.unparse(node).replace(STEP, "@").replace("**", "^")
    raise ValueError(f"'{text}' is no part of an expression")


def _value(node: ast.expr, values: Mapping[str, Values | float]) -> Any:
    name = _probe(node)
    if name is not None:
        return np.pi if name == "pi" else values[name]
    if isinstance(node, ast.Constant):
        return float(node.value)  # type: ignore[arg-type]
    if isinstance(node, ast.UnaryOp):
        inner = _value(node.operand, values)
        return -inner if isinstance(node.op, ast.USub) else inner
    if isinstance(node, ast.BinOp):
        return OPERATORS[type(node.op)](_value(node.left, values), _value(node.right, values))
    assert isinstance(node, ast.Call) and isinstance(node.func, ast.Name)
    return FUNCTIONS[node.func.id][1](*(_value(each, values) for each in node.args))
