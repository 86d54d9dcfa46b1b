"""LAMMPS as a library: found, loaded, run on a script, and closed whatever happens."""

from __future__ import annotations

import atexit
import os
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, nullcontext
from pathlib import Path
from typing import Any

from beadband.lammps.failures import failure
from beadband.lammps.files import LOG
from beadband.lammps.library import load, no_lammps, program, without_mpi4py
from beadband.lammps.ranks import alone
from beadband.lammps.scripts import assignments

__all__ = ["Session", "load", "program", "run_script"]

Progress = Callable[[int], None]
"""Called at intervals with the number of steps done."""

_POLL_S = 0.2


def run_script(
    folder: Path,
    name: str,
    progress: Progress | None = None,
    comm: Any = None,
    meanwhile: Callable[[], object] | None = None,
) -> str:
    """Run the script ``name`` in ``folder`` and return LAMMPS' version; RunError with its complaint if it fails.

    With the communicator ``comm`` its ranks share the work, and all of them must call; this one works alone without.
    ``meanwhile`` is called once while LAMMPS works: for what is needed afterwards and has nothing to do with LAMMPS.
    The working directory is changed for the time of the run, so that no path ever reaches LAMMPS' parser. LAMMPS
    runs on a thread of its own: the caller's can report progress and answer Ctrl-C.
    """
    package = load()
    before = Path.cwd()
    os.chdir(folder)
    try:
        instance = _open(package, ["-screen", "none", "-log", LOG, "-nocite"], comm or alone())
        try:
            _watch(instance, name, progress, meanwhile)
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
        self._kept: tuple[str, dict[Any, int]] | None = None
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
        self._kept = None
        if self._instance is not None:
            self._instance.close()
            self._instance = None

    def run(self, text: str, variables: Mapping[str, int | float | str]) -> str:
        """Run a script's text in the folder, its variables set before; return LAMMPS' version.

        RunError with LAMMPS' complaint when it fails; the next run starts with a fresh instance then.
        """
        self._kept = None
        return self._run("clear\n" + assignments(variables, again=True) + text)

    def begin(self, text: str) -> dict[Any, int]:
        """Run the beginning of a script, its variables in it, unless the instance holds what it has made.

        Returns what the caller has noted of that: empty after a beginning, and the same dictionary until the next one.
        """
        if self._kept is None or self._kept[0] != text:
            self._kept = None
            self._run("clear\n" + text)
            self._kept = (text, {})
        return self._kept[1]

    def forget(self) -> None:
        """Let the next :meth:`begin` begin anew."""
        self._kept = None

    def go_on(self, text: str, variables: Mapping[str, int | float | str]) -> str:
        """Run the rest of a script in what :meth:`begin` has made; otherwise like :meth:`run`."""
        return self._run(assignments(variables, again=True) + text)

    def _run(self, commands: str) -> str:
        start = time.perf_counter()
        before = Path.cwd()
        os.chdir(self.folder)
        try:
            if self._instance is None:
                self._instance = _open(load(), ["-screen", "none", "-log", "none", "-nocite"], alone())
            try:
                self._instance.commands_string(commands)
            except Exception as error:
                self._drop()
                raise failure(str(error)) from error
            return str(self._instance.version())
        finally:
            os.chdir(before)
            self.runs_s += time.perf_counter() - start


_lock = threading.Lock()
_kept: list[tuple[int, Session]] = []


@contextmanager
def kept_session() -> Iterator[Session]:
    """The one session that a process keeps for its questions, opened with the first; another where it is in use."""
    if not _lock.acquire(blocking=False):
        with Session() as own:
            yield own
        return
    try:
        # A fork has a session of its own: that of its parent is not to be touched.
        if not _kept or _kept[0][0] != os.getpid():
            _kept[:] = [(os.getpid(), Session())]
            atexit.register(_kept[0][1].close)
        yield _kept[0][1]
    finally:
        _lock.release()


def _open(package: Any, arguments: list[str], comm: Any = None) -> Any:
    try:
        with nullcontext() if comm else without_mpi4py():
            return package.lammps(cmdargs=arguments, comm=comm)
    except (OSError, RuntimeError, AttributeError) as error:
        raise no_lammps(error) from error


def _watch(instance: Any, name: str, progress: Progress | None, meanwhile: Callable[[], object] | None = None) -> None:
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
        if meanwhile:
            meanwhile()
        while not finished.wait(_POLL_S):
            if progress:
                progress(int(instance.extract_global("ntimestep")))
    except BaseException:
        # Ctrl-C: a soft stop at the next step, so that the instance can be closed.
        while not finished.is_set():
            instance.force_timeout()
            finished.wait(_POLL_S)
        raise
    if failures:
        raise failure(str(failures[0]), instance) from failures[0]
