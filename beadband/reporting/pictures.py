"""The pictures of a run, whichever it is: of a folder, or of a result."""

from __future__ import annotations

import os
from pathlib import Path

from beadband.reporting import launch_plots, plots, strip_plots
from beadband.reporting.style import SCREEN, Style
from beadband.runs.dispatch import remeasure
from beadband.runs.launch_results import Launch
from beadband.runs.rear_run import reading_users_files
from beadband.runs.results import Run
from beadband.runs.strip_results import StripRun


def draw_folder(folder: str | os.PathLike[str], style: Style = SCREEN) -> list[Path]:
    """Draw the pictures of the run in a folder; UsageError when it is not that of a whole run."""
    return draw_result(remeasure(folder), folder, style)


def draw_result(run: Run, folder: str | os.PathLike[str], style: Style = SCREEN) -> list[Path]:
    """Draw the pictures of a release or launch into a folder; return their paths."""
    Path(folder).mkdir(parents=True, exist_ok=True)
    if isinstance(run, StripRun):
        with reading_users_files():
            return strip_plots.draw(run, folder, style)
    with reading_users_files():
        ring = run.ring.trajectory
    if isinstance(run, Launch):
        return launch_plots.draw(run, ring, folder, style)
    return plots.draw(run, ring, folder, style)
