"""The page of a run: one HTML file that needs nothing else, and that no network can reach.

Numbers go in as quantised arrays, words as JSON that is put on the page as text; the script in page.js draws them.
"""

from __future__ import annotations

import base64
import hashlib
import json
import os
import re
from collections.abc import Mapping
from dataclasses import asdict, replace
from importlib.resources import files as resources
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beadband.reporting import colour
from beadband.reporting.report_data import Chart, Curve, Finger, Story, read_story
from beadband.runs import folder as files

Array = NDArray[np.float64]

NAME = "report.html"
MOST_SAMPLES = 250_000
"""Beads times frames on a page: 8 bytes each, 2.7 MB once in base64. Beyond it beads or frames are left out."""
MOST_FRAMES = 241
MOST_POINTS = 2000
"""Points of a curve on a page."""
_LEVELS = 65535


def write(folder: str | os.PathLike[str], out: str | os.PathLike[str] | None = None) -> Path:
    """Write the page of a finished run, by default into its folder as report.html; return its path.

    UsageError when the folder is not that of a finished run or ``out`` can't be, RunError when the disk refuses.
    """
    files.require(folder, files.RESULTS)
    path = files.outfile(out if out is not None else Path(folder) / NAME)
    files.write_text(path, page(read_story(folder)))
    return path


def page(story: Story) -> str:
    """The page as text."""
    return filled("page", as_dict(story))


def filled(name: str, data: Mapping[str, Any]) -> str:
    """The template NAME.html with its style and script in it, and ``data`` for the script as JSON."""
    template, style, script = (
        resources("beadband.reporting").joinpath(f"{name}.{ending}").read_text(encoding="utf-8")
        for ending in ("html", "css", "js")
    )
    parts = {
        "style": style,
        "script": script,
        "style_hash": _digest(style),
        "script_hash": _digest(script),
        "data": embedded(data),
    }
    return re.sub(r"\{\{(\w+)\}\}", lambda found: parts[found[1]], template)


def _digest(text: str) -> str:
    """What the content security policy asks of an inline style or script."""
    return "sha256-" + base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()


def embedded(values: Mapping[str, Any]) -> str:
    """JSON that can stand between script tags: no ``<``, so that no string in it closes them or opens a comment."""
    text = json.dumps(values, allow_nan=False, separators=(",", ":"))
    for character in "<>&":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return text


def as_dict(story: Story) -> dict[str, Any]:
    """The story for the script; long ones thinned to what a page can carry."""
    frames = _thinned(story.frames, MOST_FRAMES)
    every = -(-len(frames) * story.beads // MOST_SAMPLES)
    beads = np.arange(0, story.beads, every)
    chosen = np.ix_(frames, beads)
    position, low, step = quantised_positions(story.positions_m[chosen])
    notes = list(story.notes)
    notes.append(f"Positions are kept to {0.5e6 * step:.2g} µm.")
    if every > 1:
        notes.append(f"One bead in {every} is drawn.")
    if len(frames) < story.frames:
        notes.append(f"{len(frames)} of {story.frames} frames are kept.")
    scales = {"stretch": (colour.stretch_scale(story.stretch), story.stretch)}
    if not story.open:
        bent = story.curvature_1_m
        scales["curvature"] = (colour.curvature_scale(bent, story.finger.radius_m), bent)
    return {
        "name": story.name,
        "title": story.title,
        "headline": story.headline,
        "times_s": _digits(story.times_s[frames]),
        "beads": len(beads),
        "open": story.open,
        "positions": {"low_m": low.tolist(), "step_m": step, "data": _packed(position)},
        "colours": [
            {
                "name": scale.name,
                "label": scale.label,
                "unit": scale.unit,
                "low": scale.low,
                "high": scale.high,
                "soft": scale.soft,
                "anchors": scale.anchors,
                "data": _packed(_quantised(values[chosen], scale.low, (scale.high - scale.low) / _LEVELS)),
            }
            for scale, values in scales.values()
        ],
        "thickness_m": story.thickness_m,
        "touches_m": [story.touches_m[frame].tolist() for frame in frames] if story.touches_m else [],
        "finger": _finger(story.finger, frames),
        "peg": _finger(story.peg, frames) if story.peg else None,
        "charts": [_chart(chart) for chart in story.charts],
        "results": [[_signs(name), _signs(text)] for name, text in story.results],
        "scene": story.scene,
        "versions": story.versions,
        "warnings": story.warnings,
        "notes": notes,
    }


def _signs(text: str) -> str:
    """The signs that a terminal spells out."""
    return text.replace("+/-", "±").replace("->", "→")


def quantised_positions(positions_m: Array) -> tuple[NDArray[np.uint16], Array, float]:
    """Positions as 16-bit numbers: values, the corner they count from (2,) and the step, m.

    The same step both ways, so that nothing is bent; the error is half a step.
    """
    low = positions_m.min(axis=(0, 1))
    step = float((positions_m.max(axis=(0, 1)) - low).max()) / _LEVELS
    return _quantised(positions_m, low, step), low, step


def _quantised(values: Array, low: Array | float, step: float) -> NDArray[np.uint16]:
    return np.rint((values - low) / step).clip(0, _LEVELS).astype("<u2")


def _packed(values: NDArray[np.uint16]) -> str:
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode()


def _thinned(count: int, most: int) -> NDArray[np.int64]:
    """Indices from the first to the last, at equal distances and no more than ``most``."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(np.int64))


def _finger(finger: Finger, frames: Any) -> dict[str, Any]:
    """A finger or a peg, its way at the frames that are kept."""
    way = None if finger.way_m is None else _digits(finger.way_m[frames])
    return {**asdict(replace(finger, way_m=None)), "way_m": way, "reach_m": finger.reach_m()}


def _digits(values: Array) -> list[float]:
    return [float(f"{value:.6g}") for value in values.tolist()]


def _chart(chart: Chart) -> dict[str, Any]:
    return {
        "key": chart.key,
        "title": chart.title,
        "unit": chart.unit,
        "window_s": chart.window_s,
        "window_name": chart.window_name,
        "logarithmic": chart.logarithmic,
        "stacked": chart.stacked,
        "curves": [_curve(curve) for curve in chart.curves],
    }


def _curve(curve: Curve) -> dict[str, Any]:
    kept = _thinned(len(curve.times_s), MOST_POINTS)
    return {
        "name": curve.name,
        "style": curve.style,
        "t_s": _digits(curve.times_s[kept]),
        "values": _digits(curve.values[kept]),
    }
