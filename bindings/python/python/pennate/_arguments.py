"""Arguments as they are wanted, or what is wrong with them in words."""

from __future__ import annotations

import operator
from collections.abc import Iterable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

if TYPE_CHECKING:
    import concurrent.futures

Array = npt.NDArray[np.float64]

# Kinds of arrays that hold real numbers: truth values, whole numbers and floating ones.
REAL = "biuf"
# What is shown of a value that is wrong, in letters.
SHOWN = 60


def shown(value: object) -> str:
    """A value in a message."""
    if isinstance(value, np.number | np.str_):
        value = value.item()
    text = " ".join(repr(value).split())
    return text if len(text) <= SHOWN else text[: SHOWN - 1] + "…"


def accuracy(value: float) -> float:
    """A relative error."""
    number = real(value, "accuracy", "a number between 0 and 1, such as 1e-6,")
    if not 0.0 < number < 1.0:
        raise ValueError(f"accuracy: a number between 0 and 1 expected, such as 1e-6, not {shown(value)}")
    return number


def count(value: int, name: str, most: int | None = 1000) -> int:
    """A number of things, one at least."""
    limits = "one or more" if most is None else f"from 1 to {most}"
    wanted = f"a whole number, {limits},"
    number = real(value, name, wanted)
    if number != number // 1 or number < 1 or (most is not None and number > most):
        raise ValueError(f"{name}: {wanted} expected, not {shown(value)}")
    return int(value)


def whole(value: int, name: str) -> int:
    """A number of things, or none."""
    try:
        found = operator.index(value)
    except TypeError:
        raise TypeError(f"{name}: a whole number expected, not {shown(value)}") from None
    if found < 0:
        raise ValueError(f"{name}: a whole number, 0 or more, expected, not {shown(value)}")
    return found


def real(value: object, name: str, wanted: str = "a number") -> float:
    """A real number, which may be no finite one."""
    try:
        if isinstance(value, str | bytes | complex | np.complexfloating) or getattr(value, "ndim", None):
            raise TypeError
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError, OverflowError):
        raise TypeError(f"{name}: {wanted} expected, not {shown(value)}") from None


def names(given: Iterable[str], what: str) -> tuple[str, ...]:
    """Names, and not the letters of one."""
    wrong = TypeError(f"{what}: a list of names expected, not {shown(given)}")
    if isinstance(given, str | bytes):
        raise wrong
    try:
        found = tuple(given)
    except TypeError:
        raise wrong from None
    for place, name in enumerate(found):
        if not isinstance(name, str):
            raise TypeError(f"{what}[{place}]: a name expected, not {shown(name)}")
    return found


def text(given: str, name: str) -> str:
    """A text."""
    if not isinstance(given, str):
        raise TypeError(f"{name}: a text expected, not {shown(given)}")
    return given


def name_or_none(given: str | None, what: str) -> str | None:
    """A name, if one is given."""
    return None if given is None else text(given, what)


def table(given: Any, name: str) -> dict[str, Any]:
    """Values by names: a dictionary, or a table with columns."""
    if not isinstance(given, Mapping) and getattr(given, "columns", None) is None:
        raise TypeError(f"{name}: a dictionary expected, not {shown(given)}")
    return dict(given.items())


def executor(given: concurrent.futures.Executor) -> concurrent.futures.Executor:
    """What work is sent to."""
    if not callable(getattr(given, "submit", None)):
        wanted = "something with submit(), as those of concurrent.futures have it"
        raise TypeError(f"executor: {wanted}, expected, not {shown(given)}")
    return given


def listener(given: Any, name: str = "progress") -> Any:
    """What is called now and then; nothing where nobody listens."""
    if given is not None and not callable(given):
        raise TypeError(f"{name}: something that can be called expected, not {shown(given)}")
    return given


def numbers(given: npt.ArrayLike, what: str, columns: Sequence[str] = ()) -> Array:
    """An array of real numbers; `columns` are the names of its last axis, which messages say.

    A table or a labelled array that has these names along another axis is turned. What is masked is not a number.
    """
    if type(given) is np.ndarray and given.dtype == np.float64:
        return given
    given = _columns_last(given, what, columns)
    try:
        found = np.asarray(given)
    except ValueError:
        # Rows of unequal lengths.
        raise ValueError(f"{what}: rows of numbers expected, all of the same length, not {shown(given)}") from None
    if found.dtype.kind not in REAL:
        # Of a list the entries as they were given: one text makes texts of all of them.
        found = _converted(np.asarray(given, dtype=object), what, columns)
    found = found.astype(np.float64, copy=False)
    if isinstance(given, np.ma.MaskedArray):
        found = np.where(np.ma.getmaskarray(given), np.nan, found)
    return found


def _columns_last(given: Any, what: str, columns: Sequence[str]) -> Any:
    """A table or a labelled array with the names of columns along its last axis, if names stand along one; a row may have them too.

    They must be those expected, in order.
    """
    labels = _labels(given) if columns else []
    if not labels:
        return given
    names = set(columns)
    if set(labels[-1]) != names:
        others = [axis for axis, heads in enumerate(labels[:-1]) if names & set(heads)]
        if len(others) == 1 and set(labels[others[0]]) == names:
            given, labels = _last(given, others[0]), [*labels, labels[others[0]]]
        elif others:
            have = " and ".join(", ".join(labels[axis]) for axis in others)
            raise ValueError(f"{what} has the rows {have}, but {', '.join(columns)} are expected, as columns or as rows")
    if labels[-1] and labels[-1] != list(columns):
        raise ValueError(
            f"{what} has the columns {', '.join(labels[-1])}, but {', '.join(columns)} are expected, in this order"
        )
    return given


def _labels(given: Any) -> list[list[str]]:
    """Names along the axes of a table, of a row of one or of a labelled array; none along an axis whose labels are no texts."""
    if hasattr(given, "dims") and hasattr(given, "coords"):
        axes = [given.coords[dim].values if dim in given.coords else () for dim in given.dims]
    else:
        axes = [getattr(given, name, None) for name in ("index", "columns")]
        axes = [axis for axis in axes if axis is not None and not callable(axis)]
    return [[str(head) for head in heads] if all(isinstance(head, str) for head in heads) else [] for heads in axes]


def _last(given: Any, axis: int) -> Any:
    """A table or a labelled array with one of its axes behind all others."""
    if not hasattr(given, "dims"):
        return given.T
    dims = list(given.dims)
    return given.transpose(*dims[:axis], *dims[axis + 1 :], dims[axis])


def _converted(found: npt.NDArray[Any], what: str, columns: Sequence[str]) -> Array:
    """Numbers that came as objects, one by one; what is none is named."""
    converted = np.empty(found.shape, dtype=np.float64)
    for place, value in np.ndenumerate(found):
        try:
            # To NumPy nothing is not a number, and a text may be one.
            if value is None or isinstance(value, str | bytes | complex):
                raise TypeError
            converted[place] = value
        except (TypeError, ValueError):
            where = placed(place, columns)
            raise TypeError(f"{what}: numbers expected, not {shown(value)}{where}") from None
        except OverflowError:
            where = placed(place, columns)
            raise ValueError(f"{what}: finite numbers expected, not {shown(value)}{where}") from None
    return converted


def finite(found: Array, what: str, columns: Sequence[str] = ()) -> Array:
    """The array, which must have finite numbers alone."""
    wrong = ~np.isfinite(found)
    if wrong.any():
        place = tuple(int(index[0]) for index in np.nonzero(wrong))
        where = placed(place, columns)
        raise ValueError(f"{what}: finite numbers expected, not {found[place]}{where}")
    return found


def placed(place: tuple[int, ...], columns: Sequence[str]) -> str:
    """A place in an array, in words: the last index is that of a column, where these have names."""
    if not place:
        return ""
    if not columns or place[-1] >= len(columns):
        return f" at index {', '.join(map(str, place))}"
    row = f" in row {', '.join(map(str, place[:-1]))}" if len(place) > 1 else ""
    return f"{row} for '{columns[place[-1]]}'"
