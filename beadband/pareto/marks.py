"""What the charts are made of: axes, marks, the frontier's line, the plan's stars and the legend."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from beadband.pareto.frontier import frontier
from beadband.pareto.judgement import BLEW_UP, ELSEWHERE, UNSETTLED, Row
from beadband.pareto.reference import Reference

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
_STARS = {"speed": "#e8b400", "curvature": "#f07f13"}
TOP, BOTTOM = 1.0, 2e-5
"""Errors drawn, as shares; greater ones and blow-ups stand on the upper edge."""


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


def _cost(row: Row, blown_at: float) -> float:
    """Milliseconds; of a run that left none, those at which it would have stood beside the others."""
    return 1e3 * row.median_s if row.integrate_s else blown_at


def _mark(row: Row) -> str:
    return {BLEW_UP: "x", ELSEWHERE: "s", UNSETTLED: "D"}.get(row.status, "o")


def points(axis: Any, rows: Sequence[Row], index: int, size: float, faint: bool = False) -> None:
    """Runs as marks, the spread of their repeats as bars."""
    pace = _pace(rows)
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        if row.family != "plan":
            groups.setdefault((row.family, _mark(row)), []).append(row)
    for (family, mark), those in groups.items():
        colour = "#cfcfcf" if faint else COLOURS[family]
        costs = [_cost(row, 1e3 * row.bead_steps * pace) for row in those]
        heights = [height_of(row, index) for row in those]
        hollow = mark in ("s", "D")
        face = {"facecolors": "none", "edgecolors": colour} if hollow else {"color": colour}
        axis.scatter(costs, heights, s=size, marker=mark, linewidths=0.9, zorder=1 if faint else 3, **face)
        if not faint:
            timed = [row for row in those if row.integrate_s]
            least = [1e3 * min(row.integrate_s) for row in timed]
            most = [1e3 * max(row.integrate_s) for row in timed]
            axis.hlines(
                [height_of(row, index) for row in timed], least, most, color=colour, lw=0.5, alpha=0.35, zorder=2
            )


def _pace(rows: Sequence[Row]) -> float:
    """Seconds a bead and step of the production runs, for those that ended before a clock was read."""
    known = sorted(row.median_s / row.bead_steps for row in rows if row.family == "beads" and row.integrate_s)
    return known[len(known) // 2] if known else 1e-7


def front_line(axis: Any, rows: Sequence[Row], index: int, reference: Reference, label: str | None) -> None:
    """The frontier as steps, and the uncertainty of the reference as ground."""
    floor = reference.relative(index)
    front = frontier(rows, index, floor)
    axis.axhspan(BOTTOM / 10.0, floor, color="#eeeeee", zorder=0)
    x = [1e3 * row.median_s for row in front]
    y = [max(row.sure_errors[index], floor) for row in front]
    if front:
        x, y = [*x, 1e3 * max(row.median_s for row in rows if row.integrate_s)], [*y, y[-1]]
    axis.step(x, y, where="post", color="black", lw=1.8, zorder=4, label=label)


def stars(axis: Any, rows: Sequence[Row], index: int, purposes: Sequence[str], names: bool) -> None:
    for row in rows:
        purpose = row.variant.split()[0]
        if row.family != "plan" or purpose not in purposes or row.answer is None:
            continue
        x, y = 1e3 * row.median_s, height_of(row, index)
        axis.scatter([x], [y], marker="*", s=190, color=_STARS[purpose], edgecolors="black", linewidths=0.8, zorder=6)
        if names:
            shift, side = ((-8, 8), "right") if purpose == "speed" else ((8, 6), "left")
            axis.annotate(
                f"{100.0 * row.notes['tolerance']:g} %",
                (x, y),
                xytext=shift,
                textcoords="offset points",
                ha=side,
                fontsize=9,
                weight="bold",
                color="#6b5200" if purpose == "speed" else "#8a3f00",
                zorder=7,
                bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.5},
            )


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


def legend(axis: Any, purposes: Sequence[str], families: bool) -> None:
    from matplotlib.lines import Line2D

    def dot(colour: str, mark: str, hollow: bool = False) -> Any:
        face = "none" if hollow else colour
        return Line2D([], [], ls="", marker=mark, color=colour, markerfacecolor=face, ms=6)

    handles, labels = [], []
    if families:
        for family, title in TITLES.items():
            handles.append(dot(COLOURS[family], "o"))
            labels.append(title)
    handles += [dot("#444444", "x"), dot("#444444", "s", True), dot("#444444", "D", True)]
    labels += ["blew up", "converges to something else", "does not converge"]
    handles.append(Line2D([], [], color="black", lw=1.8))
    labels.append("frontier (errors to rely on)")
    for purpose in purposes:
        handles.append(
            Line2D(
                [], [], ls="", marker="*", ms=13, color=_STARS[purpose], markeredgecolor="black", markeredgewidth=0.8
            )
        )
        labels.append(f"the plan for {purpose}, by tolerance")
    axis.legend(handles, labels, fontsize=8, loc="upper left", bbox_to_anchor=(1.005, 1.0), frameon=False)


def ladder(axis: Any, rows: Sequence[Row], index: int) -> None:
    """A variant from coarse to fine, with some of its bead counts."""
    good = sorted((row for row in rows if row.integrate_s), key=lambda row: row.level)
    if not good:
        return
    x, y = [1e3 * row.median_s for row in good], [height_of(row, index) for row in good]
    axis.plot(x, y, color=COLOURS[good[0].family], lw=0.9, alpha=0.7, zorder=2)
    if good[0].family == "beads":
        for n in range(0, len(good), 2):
            axis.annotate(
                f"{good[n].beads}", (x[n], y[n]), xytext=(0, 6), textcoords="offset points", fontsize=7.5, ha="center"
            )
