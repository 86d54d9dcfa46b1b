"""The charts: error against cost of every run on the same axes, and the cost of a bead and step on two cores."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

from beadband.model.scene import Scene
from beadband.studies.pareto import plot_elements as elements
from beadband.studies.pareto.convergence import Row
from beadband.studies.pareto.cores import WAYS, Timing, speedups
from beadband.studies.pareto.findings import second_core
from beadband.studies.pareto.findings_text import second_core_gain
from beadband.studies.pareto.outcomes import OTHER_LIMIT
from beadband.studies.pareto.reference import Reference


def draw(rows: Sequence[Row], reference: Reference, times: Sequence[Timing], folder: Path, scene: Scene) -> list[Path]:
    """Write pareto, pareto-curvature, pareto-methods and pareto-cores as PNG and SVG; return their paths."""
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams.update({"font.size": 10, "axes.grid": True, "grid.alpha": 0.2, "svg.hashsalt": "beadband"})
    what = f"band {scene.band.name}, strain {scene.strain:g}, {scene.half_angle_deg:g}°, {scene.law}"
    written = _speed(rows, reference, folder, what)
    written += _methods(rows, reference, folder, what)
    if any(map(math.isfinite, reference.values[1:])):
        written += _curvature(rows, reference, folder, what)
    return written + _cores(times, folder)


def _speed(rows: Sequence[Row], reference: Reference, folder: Path, what: str) -> list[Path]:
    figure, (axis,) = elements.new_figure(1, 1, 9.6, 5.8)
    elements.error_axis(axis)
    elements.points(axis, rows, 0, 15.0, elements.seconds_per_bead_step(rows))
    elements.front_line(axis, rows, 0, reference)
    elements.plan_points(axis, rows, 0, ("speed", "curvature"))
    elements.production_line(axis, rows, 0)
    _callouts(axis, rows, 0)
    elements.cost_axis(axis)
    axis.set_ylabel("error of the rebound speed V")
    axis.set_title(f"Every method, V: {what}", fontsize=10.5, loc="left")
    elements.legend(axis, rows, ("speed", "curvature"))
    return elements.save(figure, folder, "pareto")


_SHORT_NAMES = {
    "harmonic": "linear law",
    "spline of linear law": "linear law",
    "physical": "material loss",
    "leg without bending": "no bending",
    "lepton": "law as expression",
    "rod": "angle as expression",
    "numpy, step by step": "from Python",
}
_COSTLY = 4.0
"""Cost over that of production at as many beads from which a variant is named in the chart."""


def _callouts(axis: Any, rows: Sequence[Row], index: int) -> None:
    """Names and lines for the variants that cost much more than production, or converge to another limit."""
    production = {row.beads: row.median_s for row in rows if row.family == "beads" and row.integrate_s}
    variants: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        if row.integrate_s and row.family not in ("beads", "pair", "plan", "step"):
            variants.setdefault((row.family, row.variant), []).append(row)
    taken: list[tuple[float, float]] = []
    for (family, variant), those in variants.items():
        those.sort(key=lambda row: row.level)
        ratios = [row.median_s / production[row.beads] for row in those if row.beads in production]
        costly = bool(ratios) and median(ratios) > _COSTLY
        if not costly and those[-1].outcome.code != OTHER_LIMIT:
            continue
        x, y = [1e3 * row.median_s for row in those], [elements.height_of(row, index) for row in those]
        axis.plot(x, y, color=elements.COLOURS[family], lw=0.8, ls=":", zorder=2)
        place = (math.log10(x[-1]), math.log10(y[-1]))
        if any(abs(place[0] - a) < 1.0 and abs(place[1] - b) < 0.17 for a, b in taken):
            continue
        taken.append(place)
        colour = elements.COLOURS[family]
        elements.label(axis, _SHORT_NAMES.get(variant, variant), (x[-1], y[-1]), (7, 5), 8, color=colour, zorder=5)


def _curvature(rows: Sequence[Row], reference: Reference, folder: Path, what: str) -> list[Path]:
    figure, axes = elements.new_figure(2, 1, 12.4, 5.6, share=True)
    for axis, index, when in ((axes[0], 1, "0.1"), (axes[1], 2, "0.3")):
        elements.error_axis(axis)
        axis.set_ylim(0.5e-4, 1.6)
        if not math.isfinite(reference.values[index]):
            axis.set_title(f"tip curvature around {when} t_f: too uncertain", fontsize=10.5, loc="left")
            continue
        elements.points(axis, rows, index, 13.0, elements.seconds_per_bead_step(rows))
        elements.front_line(axis, rows, index, reference)
        elements.plan_points(axis, rows, index, ("curvature",))
        elements.production_line(axis, rows, index)
        _callouts(axis, rows, index)
        elements.cost_axis(axis)
        axis.set_title(f"tip curvature around {when} of the front's arrival", fontsize=10.5, loc="left")
    axes[0].set_ylabel("error of the windowed tip curvature")
    figure.suptitle(f"Every method, κ: {what}", fontsize=10.5, x=0.01, ha="left")
    elements.legend(axes[1], rows, ("curvature",))
    return elements.save(figure, folder, "pareto-curvature")


def _methods(rows: Sequence[Row], reference: Reference, folder: Path, what: str) -> list[Path]:
    """One panel for each family, all others in grey, each variant named at its finest run."""
    families = [family for family in elements.TITLES if family != "beads" and any(row.family == family for row in rows)]
    figure, axes = elements.new_figure(
        2, math.ceil(len(families) / 2), 12.0, 3.5 * math.ceil(len(families) / 2), share=True
    )
    rate = elements.seconds_per_bead_step(rows)
    for axis, family in zip(axes, families, strict=False):
        elements.error_axis(axis)
        elements.points(axis, [row for row in rows if row.family != family], 0, 5.0, rate, faint=True)
        of_family = [row for row in rows if row.family == family]
        elements.points(axis, of_family, 0, 14.0, rate)
        elements.front_line(axis, rows, 0, reference)
        variants = sorted({row.variant for row in of_family})
        shades = _shades(len(variants))
        ends = []
        for variant, shade in zip(variants, shades, strict=True):
            good = sorted(
                (row for row in of_family if row.variant == variant and row.integrate_s), key=lambda row: row.level
            )
            if not good:
                continue
            x, y = [1e3 * row.median_s for row in good], [elements.height_of(row, 0) for row in good]
            axis.plot(x, y, color=shade, lw=1.1, zorder=3)
            axis.scatter(x, y, color=shade, s=12, zorder=4)
            ends.append((math.log10(y[-1]), x[-1], variant, shade))
        _names(axis, ends)
        axis.set_title(
            elements.TITLES[family], fontsize=10.5, loc="left", color=elements.COLOURS[family], weight="bold"
        )
    for axis in axes[len(families) :]:
        axis.set_visible(False)
    elements.outcome_legend(axes[len(families) - 1], rows)
    for axis in axes:
        elements.cost_axis(axis)
        axis.set_xlim(0.1, 3e5)
    figure.suptitle(
        f"V by family: all others in grey, the frontier in black, marks as in the legend. {what}",
        fontsize=10.5,
        x=0.01,
        ha="left",
    )
    return elements.save(figure, folder, "pareto-methods")


def _shades(count: int) -> list[Any]:
    from matplotlib import colormaps

    return [colormaps["turbo"](0.05 + 0.9 * i / max(count - 1, 1)) for i in range(count)]


def _names(axis: Any, ends: list[tuple[float, float, str, Any]]) -> None:
    """Names in a column at the right, in the order of the ends and apart from each other."""
    if not ends:
        return
    ends = sorted(ends)
    apart, top, bottom = 0.30, math.log10(elements.TOP), math.log10(elements.BOTTOM)
    places = [end[0] for end in ends]
    for i in range(1, len(places)):
        places[i] = max(places[i], places[i - 1] + apart)
    over = max(0.0, places[-1] - top)
    places = [place - over for place in places]
    for i in range(len(places) - 2, -1, -1):
        places[i] = min(places[i], places[i + 1] - apart)
    lift = max(0.0, bottom - places[0])
    for (height, x, name, shade), place in zip(ends, places, strict=True):
        axis.annotate(
            name,
            (x, 10.0**height),
            xytext=(7e3, 10.0 ** (place + lift)),
            fontsize=7.5,
            color="#222222",
            va="center",
            arrowprops={"arrowstyle": "-", "color": shade, "lw": 0.6, "alpha": 0.7},
            zorder=5,
        )


def _cores(times: Sequence[Timing], folder: Path) -> list[Path]:
    figure, axes = elements.new_figure(2, 1, 11.0, 4.4)
    colours = dict(zip(WAYS, ("#222222", "#1f5fa8", "#c8601a"), strict=True))
    for way in WAYS:
        good = [t for t in times if t.way == way and t.seconds]
        if not good:
            continue
        sizes = [t.beads for t in good]
        least = [t.least_ns for t in good]
        axes[0].plot(sizes, least, "o-", color=colours[way], ms=4)
        axes[0].vlines(sizes, least, [t.median_ns for t in good], color=colours[way], lw=0.8, alpha=0.5)
        elements.label(axes[0], way, (sizes[0], least[0]), (-4, 6), 9, color=colours[way])
    for way in WAYS[1:]:
        gains = speedups(times, way)
        if not gains:
            continue
        axes[1].plot(list(gains), list(gains.values()), "o-", color=colours[way], ms=4)
        text, shift = second_core_gain(second_core(times, way).values), (-6, 12 if way == WAYS[1] else -16)
        elements.label(axes[1], text, list(gains.items())[-1], shift, 9, color=colours[way], ha="right")
    axes[1].axhline(1.0, color="#444444", lw=0.8)
    axes[1].axhline(2.0, color="#444444", lw=0.8, ls=":")
    axes[0].set_ylabel("ns a bead and step (quickest; bar to the median)")
    axes[1].set_ylabel("speed over that of one core")
    axes[0].set_yscale("log")
    for axis in axes:
        axis.set_xscale("log")
        axis.set_xlabel("beads of the leg")
    axes[0].set_title("Cost of a bead and step", fontsize=10.5, loc="left")
    axes[1].set_title("Speed-up by a second core", fontsize=10.5, loc="left")
    return elements.save(figure, folder, "pareto-cores")
