"""A table as an `xarray.Dataset`."""

from __future__ import annotations

import dataclasses
import json
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from .. import _core
from .._network import Network
from ._plan import DESIGN, TAKEN
from ._table import Rows

if TYPE_CHECKING:
    import xarray

Array = npt.NDArray[np.float64]


def library() -> Any:
    """xarray, or what has to be installed."""
    try:
        import xarray
    except ImportError:
        raise ImportError("a sweep needs xarray: pip install 'pennate[study]'") from None
    return xarray


@dataclasses.dataclass(frozen=True)
class Made:
    """How a table was made."""

    accuracy: float
    method: str
    errors: Array | None
    """(m,), of the common mesh, where there is one."""
    losses: list[str]


def dataset(network: Network, rows: Rows, probes: tuple[str, ...], made: Made) -> xarray.Dataset:
    """All that is known, over the parameters, or over the designs of a list."""
    plan = rows.plan
    dims = plan.parameters if plan.axes is not None else (DESIGN,)
    variables: dict[str, Any] = {}
    taken = {*plan.parameters, DESIGN, *TAKEN}
    for column, probe in enumerate(probes):
        attributes: dict[str, Any] = {"units": network.probes[probe.partition("@")[0]]}
        if made.errors is not None:
            attributes["error"] = float(made.errors[column])
        values = rows.values[:, column].reshape(plan.shape)
        variables[f"{probe} (probe)" if probe in taken else probe] = (dims, values, attributes)
    stable = {"long_name": "whether the ends of all steps are stable", "flag_values": [-1, 0, 1]}
    stable["flag_meanings"] = "not_known unstable stable"
    error = {"long_name": "estimated discretization error relative to the largest value of its kind", "units": "1"}
    for name, entries, attributes in (
        ("error", rows.error, error),
        ("stable", rows.stable, stable),
        ("status", rows.status, {"long_name": "how the design ended"}),
        ("reason", rows.reason, {"long_name": "why there is no answer, or not all of it"}),
    ):
        variables[name] = (dims, entries.reshape(plan.shape), attributes)
    found: xarray.Dataset = library().Dataset(variables, _coordinates(rows), _attributes(network, rows, made))
    return found


def _coordinates(rows: Rows) -> dict[str, Any]:
    plan = rows.plan
    if plan.axes is not None:
        return dict(zip(plan.parameters, plan.axes))
    numbers = np.arange(plan.count)
    columns = plan.rows(numbers).T
    return {DESIGN: numbers + 1, **{name: (DESIGN, column) for name, column in zip(plan.parameters, columns)}}


def _attributes(network: Network, rows: Rows, made: Made) -> dict[str, Any]:
    others = {name: value for name, value in network.parameters.items() if name not in rows.plan.parameters}
    return {
        "title": network.title or network.name,
        "network": network.text,
        "parameters": json.dumps(others),
        "units": network.units,
        "accuracy": made.accuracy,
        "method": made.method,
        "pennate": _core.__version__,
        "losses": made.losses,
    }
