"""The files that LAMMPS reads and writes: their names, and how a file comes to stand there whole or not at all."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from beadband.errors import RunError, explain

DATA = "band.data"
TABLE = "bond.table"
ANGLE_TABLE = "angle.table"
SCRIPT = "release.in"
LAUNCH_SCRIPT = "launch.in"
LEG_SCRIPT = "legs.in"
TRAJECTORY = "trajectory.lammpstrj"
REAR = "rear.lammpstrj"
PATH = "rear.dat"
ENERGY = "energy.dat"
FINGER = "finger.dat"
TOUCH = "touch.dat"
HAND = "hand.dat"
HELD = "held.dat"
LOG = "log.lammps"


@contextmanager
def scratch() -> Iterator[Path]:
    """A folder for the time of a run."""
    with tempfile.TemporaryDirectory(prefix="beadband-") as place:
        yield Path(place)


def write_text(path: Path, text: str, durable: bool = False) -> None:
    """Write a file so that it is there whole or not at all; RunError (``disk``) when the disk refuses.

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
        raise refused(path, error) from error


def refused(path: Path, error: OSError) -> RunError:
    """What to raise where a file can't be written."""
    return RunError(
        explain("a file could not be written", f"{str(path)!r} ({error.strerror})", "a disk with room", "free some"),
        "disk",
    )
