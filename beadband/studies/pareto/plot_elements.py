"""Parts of the charts: axes, points of runs, the frontier's line, the points of the plans, and the legends."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

from beadband.studies.pareto.convergence import Row
from beadband.studies.pareto.frontier import frontier
from beadband.studies.pareto.outcomes import HOLLOW, OK, mark_of, name_of
from beadband.studies.pareto.reference import Reference

COLOURS = {
    "beads": "#222222",
    "pair": "#8a3d8f",
    "step": "#8c8c8c",
    "bond": "#1f5fa8",
    "angle": "#2c7d4f",
    "loss": "#c8601a",
    "integrator": "#b8322a",
    "model": "#16909c",
    "output": "#b08d2e",
}
TITLES = {
    "beads": "beads (production)",
    "pair": "Richardson pairs",
    "step": "step",
    "bond": "bond",
    "angle": "angle",
    "loss": "loss",
    "integrator": "rRESPA",
    "model": "model",
    "output": "output",
}
_PLAN_COLOURS = {"speed": "#e8b400", "curvature": "#f07f13"}
TOP, BOTTOM = 1.0, 2e-5
"""Errors drawn, as shares; larger ones and failed runs stand on the upper edge."""


def new_figure(columns: int, lines: int, width: float, height: float, share: bool = False) -> tuple[Any, list[Any]]:
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(
        lines, columns, figsize=(width, height), layout="constrained", squeeze=False, sharex=share, sharey=share
    )
    return figure, list(axes.flat)


def save(figure: Any, folder: Path, name: str) -> list[Path]:
    from matplotlib import pyplot

    paths = [folder / f"{name}.{ending}" for ending in ("png", "svg")]
    figure.savefig(paths[0], dpi=100)
    figure.savefig(paths[1], metadata={"Date": None})
    pyplot.close(figure)
    return paths


def height_of(row: Row, index: int) -> float:
    """Error as it is drawn."""
    error = row.errors[index]
    return min(max(error, BOTTOM), TOP) if math.isfinite(error) else TOP


def points(axis: Any, rows: Sequence[Row], index: int, size: float, rate: float, faint: bool = False) -> None:
    """Runs as points with the mark of their outcome, the spread of their repeats as bars.

    A failed run has no cost: it stands where its beads and steps would at ``rate``, in seconds a bead and step.
    """
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        if row.family != "plan":
            groups.setdefault((row.family, row.outcome.code), []).append(row)
    for (family, code), those in groups.items():
        colour = "#cfcfcf" if faint else COLOURS[family]
        costs = [1e3 * (row.median_s if row.integrate_s else row.bead_steps * rate) for row in those]
        heights = [height_of(row, index) for row in those]
        face = {"facecolors": "none", "edgecolors": colour} if code in HOLLOW else {"color": colour}
        axis.scatter(costs, heights, s=size, marker=mark_of(code), linewidths=0.9, zorder=1 if faint else 3, **face)
        if not faint:
            timed = [row for row in those if row.integrate_s]
            least = [1e3 * min(row.integrate_s) for row in timed]
            most = [1e3 * max(row.integrate_s) for row in timed]
            axis.hlines(
                [height_of(row, index) for row in timed], least, most, color=colour, lw=0.5, alpha=0.35, zorder=2
            )


def seconds_per_bead_step(rows: Sequence[Row]) -> float:
    """Median of the production runs."""
    known = [row.median_s / row.bead_steps for row in rows if row.family == "beads" and row.integrate_s]
    return median(known) if known else 1e-7


def front_line(axis: Any, rows: Sequence[Row], index: int, reference: Reference) -> None:
    """The frontier as steps, and errors below the uncertainty of the reference shaded."""
    floor = reference.relative(index)
    front = frontier(rows, index, floor)
    axis.axhspan(BOTTOM / 10.0, floor, color="#eeeeee", zorder=0)
    x = [1e3 * row.median_s for row in front]
    y = [max(row.error_bounds[index], floor) for row in front]
    if front:
        x, y = [*x, 1e3 * max(row.median_s for row in rows if row.integrate_s)], [*y, y[-1]]
    axis.step(x, y, where="post", color="black", lw=1.8, zorder=4)


def plan_points(axis: Any, rows: Sequence[Row], index: int, purposes: Sequence[str]) -> None:
    """The plans as stars, each with its tolerance."""
    for row in rows:
        purpose = row.variant.split()[0]
        if row.family != "plan" or purpose not in purposes or row.answer is None:
            continue
        x, y = 1e3 * row.median_s, height_of(row, index)
        colour = _PLAN_COLOURS[purpose]
        axis.scatter([x], [y], marker="*", s=190, color=colour, edgecolors="black", linewidths=0.8, zorder=6)
        shift, side = ((-8, 8), "right") if purpose == "speed" else ((8, 6), "left")
        dark = "#6b5200" if purpose == "speed" else "#8a3f00"
        text = f"{100.0 * row.notes['tolerance']:g} %"
        label(axis, text, (x, y), shift, 9, ha=side, weight="bold", color=dark, zorder=7)


def label(
    axis: Any, text: str, place: tuple[float, float], shift: tuple[float, float], size: float, **style: Any
) -> None:
    """A text on white beside a place; ``shift`` and ``size`` in points."""
    box = {"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5}
    axis.annotate(text, place, xytext=shift, textcoords="offset points", fontsize=size, bbox=box, **style)


def error_axis(axis: Any) -> None:
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_ylim(0.5 * BOTTOM, 1.6 * TOP)
    axis.set_yticks([1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0])
    axis.set_yticklabels(["0.001 %", "0.01 %", "0.1 %", "1 %", "10 %", "100 %"])
    axis.minorticks_off()


def cost_axis(axis: Any) -> None:
    axis.set_xlabel("integration, ms (median of the repeats; bars: all of them)")
    axis.set_xticks([0.1, 1.0, 10.0, 100.0, 1000.0, 10000.0])
    axis.set_xticklabels(["0.1", "1", "10", "100", "1000", "10 000"])


def legend(axis: Any, rows: Sequence[Row], purposes: Sequence[str]) -> None:
    """Families, the outcomes that occur, the frontier and the plans, to the right of the chart."""
    from matplotlib.lines import Line2D

    entries = [(_dot(COLOURS[family], "o"), title) for family, title in TITLES.items()]
    entries += _outcomes(rows)
    entries.append((Line2D([], [], color="black", lw=1.8), "frontier (error bounds)"))
    for purpose in purposes:
        star = _dot(_PLAN_COLOURS[purpose], "*", ms=13, markeredgecolor="black", markeredgewidth=0.8)
        entries.append((star, f"the plan for {purpose}, by tolerance"))
    axis.legend(*zip(*entries, strict=True), fontsize=8, loc="upper left", bbox_to_anchor=(1.005, 1.0), frameon=False)


def outcome_legend(axis: Any, rows: Sequence[Row]) -> None:
    """The outcomes that occur, inside a panel."""
    entries = _outcomes(rows)
    if entries:
        axis.legend(*zip(*entries, strict=True), fontsize=7.5, loc="lower left")


def _outcomes(rows: Sequence[Row]) -> list[tuple[Any, str]]:
    """Marks and names of the outcomes other than ``ok``."""
    codes = dict.fromkeys(row.outcome.code for row in rows if row.outcome.code != OK)
    return [(_dot("#444444", mark_of(code), hollow=code in HOLLOW), name_of(code)) for code in codes]


def _dot(colour: str, mark: str, hollow: bool = False, **style: Any) -> Any:
    from matplotlib.lines import Line2D

    face = "none" if hollow else colour
    return Line2D([], [], ls="", marker=mark, color=colour, **{"markerfacecolor": face, "ms": 6, **style})


def production_line(axis: Any, rows: Sequence[Row], index: int) -> None:
    """The production runs from coarse to fine, with some of their bead counts."""
    good = sorted((row for row in rows if row.family == "beads" and row.integrate_s), key=lambda row: row.level)
    x, y = [1e3 * row.median_s for row in good], [height_of(row, index) for row in good]
    axis.plot(x, y, color=COLOURS["beads"], lw=0.9, alpha=0.7, zorder=2)
    for n in range(0, len(good), 2):
        label(axis, f"{good[n].beads}", (x[n], y[n]), (0, 6), 7.5, ha="center")
