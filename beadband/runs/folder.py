"""A run's folder: which files stand in it, and who may take it."""

from __future__ import annotations

import json
import os
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from beadband.errors import UsageError, explain
from beadband.lammps.files import (
    DATA,
    ENERGY,
    FINGER,
    HAND,
    HELD,
    LAUNCH_SCRIPT,
    LEG_SCRIPT,
    LOG,
    PATH,
    REAR,
    SCRIPT,
    TABLE,
    TOUCH,
    TRAJECTORY,
    refused,
    scratch,
    write_text,
)

SCENE = "scene.toml"
RESULTS = "results.json"
MEASURED = (SCENE, DATA, REAR, ENERGY, FINGER, HAND, HELD, TOUCH, TRAJECTORY)
"""Files from which results are made, as far as a run has them."""

__all__ = ["DATA", "ENERGY", "FINGER", "HAND", "HELD", "LAUNCH_SCRIPT", "LEG_SCRIPT", "LOG", "PATH", "REAR", "SCRIPT"]
__all__ += ["TABLE", "TOUCH", "TRAJECTORY", "scratch", "write_text"]


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
    others = f"{len(found)} other file{'s' if len(found) > 1 else ''}"
    state = "a run that did not finish" if SCENE in found else others
    raise UsageError(
        explain(
            "the output folder is not empty",
            f"{str(out)!r} with {'a finished run' if RESULTS in found else state}",
            "a new or empty folder",
            "choose another with --out, or remove it first",
        )
    )


def create_or_scratch(out: str | os.PathLike[str] | None) -> tuple[Path, tempfile.TemporaryDirectory[str] | None]:
    """The folder ``out``, made or taken; without one a temporary folder, which goes with the object returned."""
    if out is not None:
        return create(out), None
    place = tempfile.TemporaryDirectory(prefix="beadband-")
    return Path(place.name), place


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
        raise refused(folder / SCENE, error) from error
    os.close(handle)
    write_text(folder / SCENE, text)


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
    missing = ", ".join(name for name in names if not (path / name).is_file())
    if missing:
        given = f"{str(folder)!r} without {missing}"
        raise UsageError(
            explain("not the folder of a run", given, "a folder that 'beadband run' wrote", "check the path")
        )
    return path


def fingerprints(folder: Path) -> dict[str, dict[str, Any]]:
    """Size and SHA-256 of each file from which results are made."""
    import hashlib

    found = {}
    for path in (folder / name for name in MEASURED):
        if path.is_file():
            with open(path, "rb") as handle:
                digest = hashlib.file_digest(handle, "sha256").hexdigest()
            found[path.name] = {"bytes": path.stat().st_size, "sha256": digest}
    return found


def stored_results(folder: Path) -> dict[str, Any] | None:
    """What results.json holds, None where there is none; UsageError when it is damaged."""
    path = folder / RESULTS
    if not path.is_file():
        return None
    try:
        values = json.loads(path.read_text(encoding="utf-8"))
        if not isinstance(values, dict):
            raise ValueError("not a JSON object")
    except (OSError, ValueError) as error:
        raise UsageError(
            explain("the results of the run can't be read", f"{str(path)!r} ({error})", "JSON", "run it again"),
            "unreadable-file",
        ) from error
    return values


def require_unchanged(folder: Path, results: Mapping[str, Any]) -> dict[str, Any]:
    """The fingerprints of the files; UsageError when one is not that from which the results were made."""
    found, noted = fingerprints(folder), results.get("fingerprints") or {}
    for name in found.keys() & noted.keys():
        if found[name] == noted[name]:
            continue
        size, expected = found[name]["bytes"], noted[name]["bytes"]
        short = size < expected and name not in (SCENE, DATA)
        raise UsageError(
            explain(
                f"{name} {'is cut short' if short else 'has changed since the run'}",
                f"{str(folder / name)!r}" + (f" with {size} bytes" if short else ""),
                f"{expected} bytes" if short else f"the file from which {RESULTS} was made",
                "run it again" if name != SCENE else f"restore it, or start a new run with --scene {folder / SCENE}",
            ),
            "cut-short" if short else "changed-file",
        )
    return found


def outfile(out: str | os.PathLike[str]) -> Path:
    """The path of a file to be written; UsageError when its folder is missing or something else stands there."""
    path = Path(out)
    if not path.parent.is_dir() or path.is_dir():
        allowed = "a file in a folder that exists"
        raise UsageError(explain("the output file can't be used", repr(str(out)), allowed, "choose another with --out"))
    return path
