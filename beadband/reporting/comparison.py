"""Runs side by side: what differs between their scenes and results, and their curves on the same axes."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from beadband import observables
from beadband.errors import UsageError, explain
from beadband.parameters import TABLE
from beadband.reporting.plots import Panels, draw_panels
from beadband.reporting.style import SCREEN, Style, line_of
from beadband.runs.dispatch import load
from beadband.runs.results import Run

MOST_RUNS = 28
"""Colours times dashes: more lines can't be told apart."""


@dataclass(frozen=True)
class Comparison:
    """Several finished runs; the first is the one to which the others are compared."""

    names: tuple[str, ...]
    runs: tuple[Run, ...]

    @property
    def scene(self) -> dict[str, list[Any]]:
        """Parameters that differ, with their value in each run; None where a run has none."""
        scenes = [run.scene.as_dict() for run in self.runs]
        return _differing({key: [scene.get(key) for scene in scenes] for key in TABLE})

    @property
    def results(self) -> dict[str, list[str | None]]:
        """Numbers that differ, as texts by what they are called; those of a sweep's columns, and the labelled ones."""
        values = [run.as_dict() for run in self.runs]
        return _differing(
            {
                one.label or one.sentence: [_text(one, each) for each in values]
                for one in observables.table()
                if one.kind == "number" and (one.label or one.column or one.key.startswith("energy."))
            }
        )

    @property
    def speeds(self) -> list[dict[str, float]]:
        """Rebound speed of each run, its difference to that of the first, and this in units of both errors."""
        first, found = self.runs[0].speed, []
        for run in self.runs:
            value, error = run.speed
            apart, bar = value - first.value, math.hypot(error, first.error)
            bars = {"bars": apart / bar} if bar > 0.0 and run is not self.runs[0] else {}
            found.append({"value_m_s": value, "error_m_s": error, "relative_difference": apart / first.value, **bars})
        return found

    def as_dict(self) -> dict[str, Any]:
        """The comparison as JSON takes it."""
        return {"runs": list(self.names), "scene": self.scene, "results": self.results, "speeds": self.speeds}


def compare(folders: Sequence[str | os.PathLike[str]]) -> Comparison:
    """Load the runs of some folders; UsageError for fewer than two, too many, or a folder without a finished run."""
    if not 2 <= len(folders) <= MOST_RUNS:
        raise UsageError(
            explain("a comparison takes several runs", len(folders), f"2 to {MOST_RUNS}", "name that many folders")
        )
    paths = [Path(folder) for folder in folders]
    if len({path.resolve() for path in paths}) < len(paths):
        raise UsageError(
            explain("a run is named twice", ", ".join(map(str, paths)), "different folders", "remove one of them")
        )
    return Comparison(_short(paths), tuple(load(path) for path in paths))


def _text(one: observables.Observable, values: Mapping[str, Any]) -> str | None:
    value = observables.get(values, one.key)
    return None if value is None else one.text(value, observables.get(values, observables.error_key(one.key)))


def _differing(table: Mapping[str, list[Any]]) -> dict[str, list[Any]]:
    """Rows whose cells are not all the same."""
    return {name: row for name, row in table.items() if any(cell != row[0] for cell in row)}


def _short(paths: Sequence[Path]) -> tuple[str, ...]:
    """The folders' names, or their whole paths where names are the same."""
    names = [path.resolve().name for path in paths]
    return tuple(names if len(set(names)) == len(names) else map(str, paths))


def table(found: Comparison) -> str:
    """The comparison for a person: a column for each run."""
    blocks = [("scene", {key: [_cell(value) for value in row] for key, row in found.scene.items()})]
    changes = [
        "" if "bars" not in one else f"{one['relative_difference']:+.2%}, {one['bars']:+.1f} bars"
        for one in found.speeds
    ]
    results = {name: [_cell(text) for text in row] for name, row in found.results.items()}
    speed = next(one.label for one in observables.table() if one.key == "rebound_speed_m_s")
    ordered = {}
    for name, row in results.items():
        ordered[name] = row
        if name == speed:
            ordered["  to the first"] = changes
    blocks.append(("results", ordered))
    rows = [["", *found.names]]
    for title, block in blocks:
        rows.append([title, *("" if block else "the same" for _ in found.names)])
        rows += [[f"  {name}", *cells] for name, cells in block.items()]
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    lines = ["  ".join(cell.ljust(width) for cell, width in zip(row, widths, strict=True)).rstrip() for row in rows]
    return "\n".join(lines)


def _cell(value: Any) -> str:
    if value is None:
        return "-"
    return f"{value:.6g}" if isinstance(value, float) else str(value)


def draw(found: Comparison, folder: str | os.PathLike[str], style: Style = SCREEN) -> list[Path]:
    """Write speed, path, curvature and kinetic energy of all runs, and comparison, into a folder; return the paths."""
    Path(folder).mkdir(parents=True, exist_ok=True)
    panels: Panels = {
        name: partial(_panel, found, *about)
        for name, about in {
            "speed": (_speed, "speed (m/s)", "speed of the rear tip"),
            "path": (_path, "x (mm)", "path of the rear tip"),
            "curvature": (_curvature, "curvature (1/m)", "curvature at the rear tip"),
            "kinetic": (_kinetic, "share of the stored energy", "kinetic energy"),
        }.items()
        if not (name == "curvature" and any(run.scene.is_strip for run in found.runs))
    }
    return draw_panels(panels, "", folder, style, "comparison")


Curve = Callable[[Run], tuple[Any, Any]]


def _panel(found: Comparison, curve: Curve, label: str, title: str, axes: Any) -> None:
    for number, (name, run) in enumerate(zip(found.names, found.runs, strict=True)):
        times, values = curve(run)
        axes.plot(times * 1e3, values, label=name.replace("$", r"\$"), linewidth=1.1, **line_of(number))
    if curve is _curvature:
        axes.set(xscale="log", yscale="log")
    else:
        axes.set_xlim(0.0)
    axes.set(xlabel="time (ms)", ylabel=label, title=title)
    axes.legend(frameon=False, fontsize=7)


def _speed(run: Run) -> tuple[Any, Any]:
    return run.rear.times_s, run.rear.tip_speed_m_s


def _path(run: Run) -> tuple[Any, Any]:
    return run.rear.times_s, run.rear.tip_x_m * 1e3


def _curvature(run: Run) -> tuple[Any, Any]:
    later = run.rear.times_s > 0.0
    return run.rear.times_s[later], np.asarray(run.rear.tip_curvature_1_m)[later]


def _kinetic(run: Run) -> tuple[Any, Any]:
    return run.energy.times_s, run.energy.kinetic_j / run.energy.stored_j
