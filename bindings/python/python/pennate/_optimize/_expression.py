"""Expressions of a study, which are those of network files: parameters and probes, angles in degrees, for many designs at once.

As there, an operation without a finite result makes the whole expression one without a value: not a number.
"""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

Values = npt.NDArray[np.float64]

# Parentheses and signs within each other, as many as network files may have.
DEEPEST = 100
NUMBER = re.compile(r"(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][+-]?[0-9]+)?")
SIGNS = {"−": "-", "–": "-", "·": "*", "×": "*", **{sign: sign for sign in "+-*/^(),@"}}


def _sine(degrees: Any) -> Any:
    """Exact at whole multiples of 30 degrees where its value is a short decimal."""
    turned = np.mod(degrees, 360.0)
    half = np.where(turned >= 180.0, turned - 180.0, turned)
    folded = np.where(half > 90.0, 180.0 - half, half)
    value = np.where(folded == 30.0, 0.5, np.where(folded == 90.0, 1.0, np.sin(np.radians(folded))))
    return np.where(turned >= 180.0, -value, value)


def _cosine(degrees: Any) -> Any:
    return _sine(degrees + 90.0)


def _power(a: Any, b: Any) -> Any:
    # To NumPy one to any power is one, and anything to the power of zero.
    return np.where(np.isnan(a) | np.isnan(b), np.nan, np.power(a, b))


def _of_all(function: Callable[[Any, Any], Any]) -> Callable[..., Any]:
    """A function of two values for one or more of them."""
    return lambda *values: functools.reduce(function, values)


# The number of values; nothing for any number of them.
FUNCTIONS: dict[str, tuple[int | None, Callable[..., Any]]] = {
    "sqrt": (1, np.sqrt),
    "abs": (1, np.abs),
    "min": (None, _of_all(np.minimum)),
    "max": (None, _of_all(np.maximum)),
    "exp": (1, np.exp),
    "ln": (1, np.log),
    "sin": (1, _sine),
    "cos": (1, _cosine),
    "tan": (1, lambda a: _sine(a) / _cosine(a)),
    "asin": (1, lambda a: np.degrees(np.arcsin(a))),
    "acos": (1, lambda a: np.degrees(np.arccos(a))),
    "atan": (1, lambda a: np.degrees(np.arctan(a))),
    "atan2": (2, lambda a, b: np.degrees(np.arctan2(a, b))),
}
# How firmly operators of two values bind, and a sign before a value: −2^2 = −4, and 2^−1 = 0.5.
OPERATORS: dict[str, tuple[int, Callable[[Any, Any], Any]]] = {
    "+": (1, np.add),
    "-": (1, np.subtract),
    "*": (2, np.multiply),
    "/": (2, np.divide),
    "^": (4, _power),
}
SIGNED = 3


class Number(NamedTuple):
    value: float


class Name(NamedTuple):
    """A parameter, or a probe such as `u` or `u@free`."""

    text: str


class Call(NamedTuple):
    """A function of the last so many values."""

    function: Callable[..., Any]
    width: int


class Expression:
    """An expression such as `"= min(y@free, y@blocked) - L * sin(beta)"`; a bare number is one as well.

    Raises:
        ValueError: What is wrong, in words.
    """

    __slots__ = ("_operations", "names", "text")

    def __init__(self, written: str | float) -> None:
        self.text = str(written)
        self._operations: list[Number | Name | Call] = []
        """In the order in which they are done, each with the results of those before it."""
        if isinstance(written, str):
            body = self.text.strip()
            if not body.startswith("="):
                raise ValueError(f"'{body}' is no expression: it begins with '=', such as \"= {body}\"")
            try:
                self._operations = _Parser(body[1:]).parsed()
            except (ValueError, RecursionError) as error:
                raise ValueError(f"'{_short(body[1:].strip())}' is no expression: {error}") from None
        else:
            self._operations = [Number(float(written))]
        self.names: frozenset[str] = frozenset(each.text for each in self._operations if isinstance(each, Name))
        """Parameters, and probes such as `u` or `u@free`."""

    def __call__(self, values: Mapping[str, Values | float]) -> Values:
        """The values for many designs at once; not a number where there is none."""
        results: list[Values | float] = []
        with np.errstate(all="ignore"):
            for each in self._operations:
                if isinstance(each, Number):
                    result: Values | float = each.value
                elif isinstance(each, Name):
                    result = values[each.text]
                else:
                    result = each.function(*results[-each.width :])
                    del results[-each.width :]
                known = np.isfinite(result)
                results.append(result if known.all() else np.where(known, result, np.nan))
        return np.asarray(results[-1], dtype=np.float64)


def _short(text: str, most: int = 60) -> str:
    return text if len(text) <= most else text[: most - 1] + "…"


class _Word(NamedTuple):
    """A name, or that of a function."""

    text: str


_Token = float | _Word | str
"""A number, a word, or a sign."""


def _tokens(text: str) -> list[_Token]:
    found: list[_Token] = []
    place = 0
    while place < len(text):
        letter = text[place]
        end = place + 1
        if letter.isspace():
            pass
        elif number := NUMBER.match(text, place):
            end = number.end()
            found.append(float(number[0]))
        elif letter.isalpha() or letter == "_":
            while end < len(text) and (text[end].isalnum() or text[end] == "_"):
                end += 1
            found.append(_Word(text[place:end]))
        elif letter in "'\"":
            closed = text.find(letter, end)
            if closed < 0:
                raise ValueError("a quote is not closed")
            found.append(_Word(text[end:closed]))
            end = closed + 1
        elif letter in SIGNS:
            found.append(SIGNS[letter])
        else:
            raise ValueError(f"'{letter}' is not expected there")
        place = end
    return found


class _Parser:
    """From a text to its operations."""

    def __init__(self, text: str) -> None:
        self.left = _tokens(text)[::-1]
        """What is not read yet, the next at the end."""
        self.depth = 0
        self.out: list[Number | Name | Call] = []

    def parsed(self) -> list[Number | Name | Call]:
        self.value(0)
        if self.left:
            raise ValueError(f"'{_told(self.left[-1])}' is not expected there")
        return self.out

    def take(self, *signs: str) -> str | None:
        """The next sign, if it is one of some."""
        if self.left and isinstance(self.left[-1], str) and self.left[-1] in signs:
            return str(self.left.pop())
        return None

    def value(self, least: int) -> None:
        """A value, and operators behind it that bind at least so firmly."""
        if sign := self.take("+", "-"):
            self.inner(SIGNED)
            if sign == "-":
                self.out.append(Call(np.negative, 1))
        else:
            self.atom()
        while self.left and isinstance(operator := self.left[-1], str) and operator in OPERATORS:
            firmness, function = OPERATORS[operator]
            if firmness < least:
                break
            self.left.pop()
            if operator == "^":
                # Powers are taken from the right, and their exponents may have a sign.
                self.inner(SIGNED)
            else:
                self.value(firmness + 1)
            self.out.append(Call(function, 2))

    def inner(self, least: int = 0) -> None:
        """A value within another one."""
        self.depth += 1
        if self.depth > DEEPEST:
            raise ValueError("it is nested too deeply")
        self.value(least)
        self.depth -= 1

    def atom(self) -> None:
        if not self.left:
            raise ValueError("it is not complete")
        token = self.left.pop()
        if isinstance(token, float):
            self.out.append(Number(token))
        elif isinstance(token, _Word):
            self.word(token.text)
        elif token == "(":
            self.inner()
            self.close()
        else:
            raise ValueError(f"'{token}' is not expected there")

    def word(self, word: str) -> None:
        if self.take("("):
            self.call(word)
        elif word == "pi":
            self.out.append(Number(np.pi))
        elif self.take("@"):
            step = self.left.pop() if self.left else None
            if not isinstance(step, _Word):
                raise ValueError("behind '@' the name of a step is expected")
            self.out.append(Name(f"{word}@{step.text}"))
        else:
            self.out.append(Name(word))

    def call(self, word: str) -> None:
        if word not in FUNCTIONS:
            raise ValueError(f"there is no function '{word}'; known are {', '.join(FUNCTIONS)}")
        wanted, function = FUNCTIONS[word]
        self.inner()
        count = 1
        while self.take(","):
            self.inner()
            count += 1
        self.close()
        if wanted not in (None, count):
            raise ValueError(f"'{word}' takes {wanted} value(s), not {count}")
        self.out.append(Call(function, count))

    def close(self) -> None:
        if not self.take(")"):
            raise ValueError("a parenthesis is not closed")


def _told(token: _Token) -> str:
    if isinstance(token, _Word):
        return token.text
    return f"{token:g}" if isinstance(token, float) else token
