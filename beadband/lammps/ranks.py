"""Whether this process is one of several under mpirun, and which."""

from __future__ import annotations

import ctypes
import os
import sys
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from beadband.errors import RunError, explain

_SIZES = ("PMI_SIZE", "OMPI_COMM_WORLD_SIZE", "PMIX_SIZE", "MPI_LOCALNRANKS")
"""Where launchers tell their processes how many they are."""

_MPI = "libmpi.so.12"

CHECK_FAILED = 3
"""Exit code of a run that is whole, though a physics check failed."""


@dataclass(frozen=True)
class World:
    """The ranks that were started together; a single one without mpirun."""

    rank: int
    size: int
    comm: Any
    """mpi4py's communicator of all ranks; None for a single one."""


def launched() -> bool:
    """Whether a launcher has started several processes, of which this is one."""
    sizes = [os.environ.get(name, "") for name in _SIZES]
    return any(size.isdigit() and int(size) > 1 for size in sizes)


@cache
def world() -> World:
    """The ranks of this run; RunError when there are several and mpi4py is missing."""
    if not launched():
        return World(0, 1, None)
    load_mpi()
    try:
        from mpi4py import MPI
    except ImportError as error:
        raise RunError(
            explain("several ranks need mpi4py", str(error), "the mpi4py package", "pip install 'beadband[mpi]'")
        ) from error
    comm = MPI.COMM_WORLD
    return World(comm.Get_rank(), comm.Get_size(), comm if comm.Get_size() > 1 else None)


def load_mpi() -> None:
    """Load the MPI library of the mpich package, for everybody in this process."""
    usual = Path(sys.prefix) / "lib" / _MPI
    try:
        path = usual if usual.is_file() else _of_package()
        if path is not None:
            ctypes.CDLL(str(path), ctypes.RTLD_GLOBAL)
    except OSError:
        pass  # a LAMMPS built against another MPI, or against none, loads by itself


def _of_package() -> Path | None:
    """The library in the mpich package, wherever that was put."""
    from importlib import metadata

    try:
        files = metadata.files("mpich") or ()
    except metadata.PackageNotFoundError:
        return None
    return next((Path(str(file.locate())) for file in files if file.name == _MPI), None)


def stop_others(code: int) -> None:
    """End all ranks with this exit code when one has failed: the others would wait for it for ever."""
    if world().comm is not None and code != CHECK_FAILED:
        sys.stderr.flush()
        world().comm.Abort(code)


def alone() -> Any:
    """A communicator of this rank only, or None where there is but one."""
    if world().size == 1:
        return None
    from mpi4py import MPI

    return MPI.COMM_SELF
