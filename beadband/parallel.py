"""Whether this process is one of several under mpirun, and which."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import cache
from typing import Any

from beadband.errors import RunError, explain

_SIZES = ("PMI_SIZE", "OMPI_COMM_WORLD_SIZE", "PMIX_SIZE", "MPI_LOCALNRANKS")
"""Where launchers tell their processes how many they are."""


@dataclass(frozen=True)
class World:
    """The ranks that were started together; a single one without mpirun."""

    rank: int
    size: int
    comm: Any
    """mpi4py's communicator of all ranks; None for a single one."""


@cache
def world() -> World:
    """The ranks of this run; RunError when there are several and mpi4py is missing."""
    sizes = [os.environ.get(name, "") for name in _SIZES]
    if not any(size.isdigit() and int(size) > 1 for size in sizes):
        return World(0, 1, None)
    from beadband.engine import load_mpi

    load_mpi()
    try:
        from mpi4py import MPI
    except ImportError as error:
        raise RunError(
            explain("several ranks need mpi4py", str(error), "the mpi4py package", "pip install 'beadband[mpi]'")
        ) from error
    comm = MPI.COMM_WORLD
    return World(comm.Get_rank(), comm.Get_size(), comm if comm.Get_size() > 1 else None)


def alone() -> Any:
    """A communicator of this rank only, or None where there is but one."""
    if world().size == 1:
        return None
    from mpi4py import MPI

    return MPI.COMM_SELF
