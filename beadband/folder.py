"""A run's folder: which files stand in it, and how they come there whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from beadband.errors import RunError, UsageError, explain

SCENE = "scene.toml"
DATA = "band.data"
TABLE = "bond.table"
SCRIPT = "release.in"
LAUNCH_SCRIPT = "launch.in"
TRAJECTORY = "trajectory.lammpstrj"
REAR = "rear.lammpstrj"
LEG_SCRIPT = "leg.in"
PATH = "rear.dat"
ENERGY = "energy.dat"
FINGER = "finger.dat"
RESULTS = "results.json"
LOG = "log.lammps"


def create(out: str | os.PathLike[str]) -> Path:
    """Make the folder, or take an empty one; UsageError when something stands there or it can't be written."""
    folder = Path(out)
    try:
        folder.mkdir(parents=True, exist_ok=True)
        found = sorted(entry.name for entry in folder.iterdir())
        if not found:
            probe = folder / f".{SCENE}.tmp"
            probe.touch()
            probe.unlink()
    except OSError as error:
        raise UsageError(
            explain(
                "the output folder can't be used",
                f"{str(out)!r} ({error.strerror})",
                "a folder that can be made and written",
                "choose another with --out",
            )
        ) from error
    if not found:
        return folder
    if RESULTS in found:
        state = "a finished run"
    elif SCENE in found:
        state = "a run that did not finish"
    else:
        state = f"{len(found)} other file{'s' if len(found) > 1 else ''}"
    raise UsageError(
        explain(
            "the output folder is not empty",
            f"{str(out)!r} with {state}",
            "a new or empty folder",
            "choose another with --out, or remove it first",
        )
    )


def claim(folder: Path, text: str) -> None:
    """Put scene.toml into a folder that has none: of two runs that found it empty, one gets it.

    UsageError for the other, RunError when the disk refuses.
    """
    try:
        handle = os.open(folder / SCENE, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o666)
    except FileExistsError as error:
        raise UsageError(
            explain(
                "another run has just taken the output folder",
                f"{str(folder)!r} with a {SCENE}",
                "a folder for each run",
                "choose another with --out",
            )
        ) from error
    except OSError as error:
        raise _refused(folder / SCENE, error) from error
    os.close(handle)
    write_text(folder / SCENE, text)


def _refused(path: Path, error: OSError) -> RunError:
    return RunError(
        explain("a file could not be written", f"{str(path)!r} ({error.strerror})", "a disk with room", "free some")
    )


def next_free(name: str) -> Path:
    """``name`` in the current folder, with -2, -3 ... behind it when something stands there already."""
    path, number = Path(name), 1
    while path.exists():
        number += 1
        path = Path(f"{name}-{number}")
    return path


def require(folder: str | os.PathLike[str], *names: str) -> Path:
    """The folder as a path; UsageError when it lacks one of the files."""
    path = Path(folder)
    missing = [name for name in names if not (path / name).is_file()]
    if missing:
        raise UsageError(
            explain(
                "not the folder of a run",
                f"{str(folder)!r} without {', '.join(missing)}",
                "a folder that 'beadband run' wrote",
                "check the path",
            )
        )
    return path


def outfile(out: str | os.PathLike[str]) -> Path:
    """The path of a file to be written; UsageError when its folder is missing or something else stands there."""
    path = Path(out)
    if not path.parent.is_dir() or path.is_dir():
        raise UsageError(
            explain(
                "the output file can't be used",
                repr(str(out)),
                "a file in a folder that is there",
                "choose another with --out",
            )
        )
    return path


@contextmanager
def scratch() -> Iterator[Path]:
    """A folder for the time of a run."""
    with tempfile.TemporaryDirectory(prefix="beadband-") as place:
        yield Path(place)


def write_text(path: Path, text: str, durable: bool = False) -> None:
    """Write a file so that it is there whole or not at all; RunError when the disk refuses.

    ``durable`` waits for the disk: for what says that a run is finished, not for what a run can write again.
    """
    partial = path.with_name(f".{path.name}.tmp")
    try:
        with open(partial, "w", encoding="utf-8") as handle:
            handle.write(text)
            if durable:
                handle.flush()
                os.fsync(handle.fileno())
        os.replace(partial, path)
    except OSError as error:
        raise _refused(path, error) from error
