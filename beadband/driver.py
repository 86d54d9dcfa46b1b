"""Releases and launches by one door: the scene, or the files in a folder, say which it is."""

from __future__ import annotations

import os
from pathlib import Path

from beadband import release
from beadband.analysis import launch_pictures, pictures
from beadband.analysis.trajectory import Trajectory
from beadband.errors import UsageError, explain
from beadband.folder import LAUNCH_SCRIPT
from beadband.launching import launch
from beadband.launching.results import Launch
from beadband.parallel import world
from beadband.release import Progress
from beadband.results import Run
from beadband.scene import Scene


def run(scene: Scene, out: str | os.PathLike[str], progress: Progress | None = None) -> Run | Launch:
    """Release or launch a scene into the new or empty folder ``out``; see ``release.run`` and ``launch.run``."""
    if scene.until == "launch":
        if world().size > 1:
            raise UsageError(explain("a launch runs on one rank", f"{world().size}", "one", "start it without mpirun"))
        return launch.run(scene, out, progress)
    return release.run(scene, out, progress)


def help_along(scene: Scene) -> None:
    """The part of every rank but the first in a run under mpirun; UsageError for a launch, which wants one rank."""
    if scene.until == "launch":
        raise UsageError(explain("a launch runs on one rank", "several", "one", "start it without mpirun"))
    release.help_along()


def analyze(folder: str | os.PathLike[str]) -> Run | Launch:
    """Measure a run again, from the files in its folder alone."""
    return launch.analyze(folder) if _launched(folder) else release.analyze(folder)


def plot(folder: str | os.PathLike[str]) -> list[Path]:
    """Draw the pictures of a run into its folder; return their paths."""
    if _launched(folder):
        return launch_pictures.draw(launch.remeasure(folder), launch.frames(folder), folder)
    return pictures.draw(release.remeasure(folder), release.frames(folder), folder)


def followed(folder: str | os.PathLike[str]) -> tuple[Run, Trajectory]:
    """A run measured again, and the whole ring over time; UsageError where the folder is not that of a whole run."""
    if _launched(folder):
        return launch.remeasure(folder).run, launch.frames(folder)
    return release.remeasure(folder), release.frames(folder)


def _launched(folder: str | os.PathLike[str]) -> bool:
    return (Path(folder) / LAUNCH_SCRIPT).is_file()
