"""Releases and launches through one interface: the scene, or the files in a folder, say which it is."""

from __future__ import annotations

import os
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from beadband.errors import UsageError, explain
from beadband.lammps.ranks import world
from beadband.model.scene import Scene
from beadband.runs import folder as files
from beadband.runs import release
from beadband.runs.release import Progress

if TYPE_CHECKING:
    from beadband.runs.finish import Reader
    from beadband.runs.results import Run

if TYPE_CHECKING:
    from beadband.planning.launch_plan import LaunchPlan
    from beadband.planning.plan import Plan

_LONGEST_S = 600.0
_MOST_BYTES = 2e9
"""Predicted time and disk space above which a run starts only when forced."""


def run(scene: Scene, out: str | os.PathLike[str] | None = None, progress: Progress | None = None) -> Run:
    """Release or launch a scene.

    With ``out`` everything about it is written into that new or empty folder, ``results.json`` last: where it is
    missing, the run did not finish. Without, the files last as long as the result. Returns a :class:`Run`, for a
    launch its extension :class:`Launch`; raises UsageError for a scene or folder that can't be used, RunError when
    LAMMPS fails or a bead breaks through the finger.
    """
    if scene.until != "launch":
        return release.run(scene, out, progress)
    if world().size > 1:
        raise _one_rank()
    from beadband.runs import launch

    return launch.run(scene, out, progress)


def help_along(scene: Scene) -> None:
    """The part of every rank but the first in a run under mpirun; UsageError for a launch, which needs one rank."""
    if scene.until == "launch":
        raise _one_rank()
    release.help_along()


def _one_rank() -> UsageError:
    return UsageError(explain("a launch runs on one rank", world().size, "one", "start it without mpirun"))


def refuse_absurd(planned: Plan | LaunchPlan, frames: int | None) -> None:
    """UsageError for a run predicted to take too long or, with all frames asked for, too much disk.

    The plan may write fewer frames, one for each step at most; the request is refused before anything starts.
    """
    from beadband.planning import error_curves

    seconds, size = planned.seconds, planned.disk_bytes
    asked = error_curves.disk_bytes(planned.beads, frames or 0, 0)
    if seconds <= _LONGEST_S and max(size, asked) <= _MOST_BYTES:
        return
    run = f"{planned.steps} steps of {planned.beads} beads"
    if asked > size:
        wrong, given = "so many frames would take too much disk space", f"{frames} frames, {asked / 1e9:.2g} GB"
        allowed, advice = f"{_MOST_BYTES / 1e9:g} GB, and one frame for each step ({run})", "lower --frames"
    else:
        wrong = "the run is predicted to take too long or too much disk space"
        given = f"{duration(seconds)} and {size / 1e9:.2g} GB for {run}"
        allowed = f"{duration(_LONGEST_S)} and {_MOST_BYTES / 1e9:g} GB"
        advice = "use fewer --beads or --frames or a smaller --loss-time"
    raise UsageError(explain(wrong, given, allowed, f"{advice}, or add --force"), code="absurd-run")


def duration(seconds: float) -> str:
    """A time as a person says it: "6.9 h"."""
    for size, unit in ((86400.0, "days"), (3600.0, "h"), (60.0, "min")):
        if seconds >= 2.0 * size:
            return f"{seconds / size:.2g} {unit}"
    return f"{seconds:.2g} s"


def analyze(folder: str | os.PathLike[str]) -> Run:
    """Measure a run again from the files in its folder alone, read through MDAnalysis in double precision.

    The coarse run from which the error of discretisation is judged is taken from results.json, and left out where
    that is missing; nothing is written. UsageError when the folder is not that of a whole run, or when a file is not
    the one from which the results were made.
    """
    from beadband.analysis.readers import read_mdanalysis

    return remeasure(folder, read_mdanalysis)


def remeasure(folder: str | os.PathLike[str], reader: Reader | None = None) -> Run:
    """As :func:`analyze`, with beadband's own faster reader or another."""
    from beadband.analysis.readers import read

    if not (Path(folder) / files.LAUNCH_SCRIPT).is_file():
        from beadband.runs import finish

        return finish.remeasure(folder, reader or read)
    from beadband.runs import launch

    return launch.remeasure(folder, reader or read)


def load(folder: str | os.PathLike[str]) -> Run:
    """A finished run from its folder: speed, curvature, energies, and ``ring`` with the whole band over time.

    UsageError when the folder is not that of a finished run, or when a file has changed since.
    """
    path = files.require(folder, files.RESULTS)
    done, stored = remeasure(path), files.stored_results(path) or {}
    version = (stored.get("versions") or {}).get("lammps", done.lammps_version)
    return replace(done, wall_s=stored.get("wall_s") or done.wall_s, lammps_version=version)
