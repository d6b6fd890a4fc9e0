"""Sweeps on any executor: threads, processes, dask, MPI, Slurm.

`_plan` says which designs there are, `_job` what a worker does with a chunk of them, `_send` brings chunks to workers and answers
back, and `_table` keeps what is known on disk.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import concurrent.futures
    import os

    import numpy.typing as npt
    import xarray

    from .._network import Network

__all__ = ["sweep"]


@dataclasses.dataclass(frozen=True)
class Wanted:
    """The arguments of `sweep` by their names."""

    probes: Sequence[str] | None
    accuracy: float
    method: str
    executor: concurrent.futures.Executor | None
    threads: int | None
    chunk: int | None
    retries: int
    timeout: float | None
    output: str | os.PathLike[str] | None
    overwrite: bool
    progress: Callable[[int, int], object] | None


def sweep(
    network: Network,
    vary: Mapping[str, npt.ArrayLike] | None = None,
    /,
    *,
    designs: Mapping[str, npt.ArrayLike] | None = None,
    probes: Sequence[str] | None = None,
    accuracy: float = 1e-6,
    method: str = "solve",
    executor: concurrent.futures.Executor | None = None,
    threads: int | None = None,
    chunk: int | None = None,
    retries: int = 3,
    timeout: float | None = None,
    output: str | os.PathLike[str] | None = None,
    overwrite: bool = False,
    progress: Callable[[int, int], object] | None = None,
    **values: npt.ArrayLike,
) -> xarray.Dataset:
    """Solves a network for many values of its parameters, on one machine or on many.

        table = pennate.sweep(network, beta=range(10, 61, 2), pressure=[10, 15, 20])
        table["stroke"].sel(beta=30, pressure=15)

    Needs the extra `pennate[study]`.

    Args:
        network: Sent once to each worker.
        vary: Parameters with their values, in the place of keywords: for names that are no words of Python, or that are
            arguments of this function.
        designs: A list in the place of all combinations: as many values of each parameter as there are designs.
        probes: `probe@step`, or `probe` at the end of the last step; all at the ends of all steps by default.
        accuracy: Discretization error asked for, relative to the largest value of its kind.
        method: `"solve"` solves each design by itself on a mesh of its own, as `Network.solve` does, and knows its error and
            its stability. The program's `pennate sweep` solves eight designs at a time: its rows are the same but for
            rounding, some 1e-12 of the largest values. `"problem"` compiles the network once, and solves eight designs side by side on
            a common mesh: faster by 1.6 (spatial stage) to 9 times (dyad), and errors are those of the middle and the corners.
        executor: Any of `concurrent.futures`, such as `dask.distributed.Client.get_executor()` or
            `mpi4py.futures.MPIPoolExecutor`; threads of this process by default. It is not shut down.
        threads: Of this process, where there is no executor; one for each core by default.
        chunk: Designs that are sent to a worker at a time; rounded up to a multiple of eight. No answer depends on it.
        retries: So many times a chunk is sent again whose worker was lost.
        timeout: Seconds without any answer after which all chunks that are out are sent again.
        output: A directory for `sweep.csv`, which grows as chunks are answered. Rows that it has are not solved again.
        overwrite: Whether the table of another sweep there may go.
        progress: Called with the number of designs that are known, and with that of all.
        values: Parameters with their values, numbers as they may stand in the file. All combinations are solved.

    Returns:
        Probes, `error`, `stable`, `status` and `reason` over the parameters, or over `design` for a list.

    Raises:
        NetworkError: A parameter or a probe that there is not.
        WorkerError: Designs that no worker answered; its attribute `table` has the others, and so has the directory.
        KeyboardInterrupt: Ctrl-C; the same call with the same directory goes on.
    """
    from .. import _arguments

    # Who does not sweep does not wait for what sweeps need.
    from ._run import run

    vary = {} if vary is None else _arguments.table(vary, "vary")
    designs = None if designs is None else _arguments.table(designs, "designs")
    if both := set(vary) & set(values):
        raise ValueError(f"'{min(both)}' is given values twice")
    wanted = Wanted(probes, accuracy, method, executor, threads, chunk, retries, timeout, output, overwrite, progress)
    return run(network, {**vary, **values}, designs, wanted)
