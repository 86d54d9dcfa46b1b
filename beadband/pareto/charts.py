"""The charts: every run on the same axes, error against seconds, and what a second core is worth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from beadband.pareto import marks
from beadband.pareto.cores import WAYS, Timing, pays_from
from beadband.pareto.judgement import ELSEWHERE, Row
from beadband.pareto.reference import Reference
from beadband.scene import Scene


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
    figure, (axis,) = marks.new_figure(1, 1, 9.6, 5.8)
    marks.error_axis(axis)
    marks.points(axis, rows, 0, 15.0)
    marks.front_line(axis, rows, 0, reference, None)
    marks.stars(axis, rows, 0, ("speed", "curvature"), True)
    marks.ladder(axis, [row for row in rows if row.family == "beads"], 0)
    _callouts(axis, rows, 0)
    marks.cost_axis(axis)
    axis.set_ylabel("error of the rebound speed V")
    axis.set_title(f"Every method, V: {what}", fontsize=10.5, loc="left")
    marks.legend(axis, ("speed", "curvature"), True)
    return marks.save(figure, folder, "pareto")


_CALLS = {
    "harmonic": "linear law",
    "spline of linear law": "linear law",
    "physical": "material loss",
    "leg without bending": "no bending",
    "lepton": "law as expression",
    "rod": "angle as expression",
    "numpy, step by step": "from Python",
}
_DEAR = 4.0
"""Times the cost of production at as many beads from which a variant is named in the chart."""


def _callouts(axis: Any, rows: Sequence[Row], index: int) -> None:
    """Names and lines for the variants that cost much more than production, or go elsewhere."""
    production = {row.beads: row.median_s for row in rows if row.family == "beads" and row.integrate_s}
    variants: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        if row.integrate_s and row.family not in ("beads", "pair", "plan", "step"):
            variants.setdefault((row.family, row.variant), []).append(row)
    taken: list[tuple[float, float]] = []
    for (family, variant), those in variants.items():
        those.sort(key=lambda row: row.level)
        ratios = sorted(row.median_s / production[row.beads] for row in those if row.beads in production)
        dear = bool(ratios) and ratios[len(ratios) // 2] > _DEAR
        if not dear and those[-1].status != ELSEWHERE:
            continue
        x, y = [1e3 * row.median_s for row in those], [marks.height_of(row, index) for row in those]
        axis.plot(x, y, color=marks.COLOURS[family], lw=0.8, ls=":", zorder=2)
        place = (math.log10(x[-1]), math.log10(y[-1]))
        if any(abs(place[0] - a) < 1.0 and abs(place[1] - b) < 0.17 for a, b in taken):
            continue
        taken.append(place)
        axis.annotate(
            _CALLS.get(variant, variant),
            (x[-1], y[-1]),
            xytext=(7, 5),
            textcoords="offset points",
            fontsize=8,
            color=marks.COLOURS[family],
            zorder=5,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
        )


def _curvature(rows: Sequence[Row], reference: Reference, folder: Path, what: str) -> list[Path]:
    figure, axes = marks.new_figure(2, 1, 12.4, 5.6, share=True)
    for axis, index, when in ((axes[0], 1, "0.1"), (axes[1], 2, "0.3")):
        marks.error_axis(axis)
        axis.set_ylim(0.5e-4, 1.6)
        if not math.isfinite(reference.values[index]):
            axis.set_title(f"tip curvature around {when} t_f: not known well enough", fontsize=10.5, loc="left")
            continue
        marks.points(axis, rows, index, 13.0)
        marks.front_line(axis, rows, index, reference, None)
        marks.stars(axis, rows, index, ("curvature",), True)
        marks.ladder(axis, [row for row in rows if row.family == "beads"], index)
        _callouts(axis, rows, index)
        marks.cost_axis(axis)
        axis.set_title(f"tip curvature around {when} of the front's arrival", fontsize=10.5, loc="left")
    axes[0].set_ylabel("error of the windowed tip curvature")
    figure.suptitle(f"Every method, κ: {what}", fontsize=10.5, x=0.01, ha="left")
    marks.legend(axes[1], ("curvature",), True)
    return marks.save(figure, folder, "pareto-curvature")


def _methods(rows: Sequence[Row], reference: Reference, folder: Path, what: str) -> list[Path]:
    """One panel for each family before all others in grey, each variant with its name at its finest run."""
    families = [family for family in marks.TITLES if family != "beads" and any(row.family == family for row in rows)]
    figure, axes = marks.new_figure(
        2, math.ceil(len(families) / 2), 12.0, 3.5 * math.ceil(len(families) / 2), share=True
    )
    for axis, family in zip(axes, families, strict=False):
        marks.error_axis(axis)
        marks.points(axis, [row for row in rows if row.family != family], 0, 5.0, faint=True)
        of_family = [row for row in rows if row.family == family]
        marks.points(axis, of_family, 0, 14.0)
        marks.front_line(axis, rows, 0, reference, None)
        variants = sorted({row.variant for row in of_family})
        shades = _shades(len(variants))
        ends = []
        for variant, shade in zip(variants, shades, strict=True):
            good = sorted(
                (row for row in of_family if row.variant == variant and row.integrate_s), key=lambda row: row.level
            )
            if not good:
                continue
            x, y = [1e3 * row.median_s for row in good], [marks.height_of(row, 0) for row in good]
            axis.plot(x, y, color=shade, lw=1.1, zorder=3)
            axis.scatter(x, y, color=shade, s=12, zorder=4)
            ends.append((math.log10(y[-1]), x[-1], variant, shade))
        _names(axis, ends)
        axis.set_title(marks.TITLES[family], fontsize=10.5, loc="left", color=marks.COLOURS[family], weight="bold")
    for axis in axes[len(families) :]:
        axis.set_visible(False)
    for axis in axes:
        marks.cost_axis(axis)
        axis.set_xlim(0.1, 3e5)
    figure.suptitle(
        f"V by family, all others in grey, frontier in black; cross: blew up, square: something else. {what}",
        fontsize=10.5,
        x=0.01,
        ha="left",
    )
    return marks.save(figure, folder, "pareto-methods")


def _shades(count: int) -> list[Any]:
    from matplotlib import colormaps

    return [colormaps["turbo"](0.05 + 0.9 * i / max(count - 1, 1)) for i in range(count)]


def _names(axis: Any, ends: list[tuple[float, float, str, Any]]) -> None:
    """Names in a column at the right, in the order of the ends and apart from each other."""
    if not ends:
        return
    ends = sorted(ends)
    apart, top, bottom = 0.30, math.log10(marks.TOP), math.log10(marks.BOTTOM)
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
    figure, axes = marks.new_figure(2, 1, 11.0, 4.4)
    colours = dict(zip(WAYS, ("#222222", "#1f5fa8", "#c8601a"), strict=True))
    for way in WAYS:
        good = [t for t in times if t.way == way and t.seconds]
        if not good:
            continue
        sizes = [t.beads for t in good]
        least = [t.least_ns for t in good]
        axes[0].plot(sizes, least, "o-", color=colours[way], ms=4)
        axes[0].vlines(sizes, least, [t.median_ns for t in good], color=colours[way], lw=0.8, alpha=0.5)
        axes[0].annotate(
            way, (sizes[0], least[0]), xytext=(-4, 6), textcoords="offset points", color=colours[way], fontsize=9
        )
    alone = {t.beads: t.least_ns for t in times if t.way == WAYS[0] and t.seconds}
    for way in WAYS[1:]:
        good = [t for t in times if t.way == way and t.seconds and t.beads in alone]
        if not good:
            continue
        gain = [alone[t.beads] / t.least_ns for t in good]
        axes[1].plot([t.beads for t in good], gain, "o-", color=colours[way], ms=4)
        start = pays_from(list(times), way)
        says = f"{way}: pay from about {start:.0e} beads" if start else f"{way}: never pay here"
        axes[1].annotate(
            says,
            (good[-1].beads, gain[-1]),
            xytext=(-6, 12 if way == WAYS[1] else -16),
            textcoords="offset points",
            color=colours[way],
            fontsize=9,
            ha="right",
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
        )
    axes[1].axhline(1.0, color="#444444", lw=0.8)
    axes[1].axhline(2.0, color="#444444", lw=0.8, ls=":")
    axes[0].set_ylabel("ns a bead and step (quickest; bar to the median)")
    axes[1].set_ylabel("times as fast as one core")
    axes[0].set_yscale("log")
    for axis in axes:
        axis.set_xscale("log")
        axis.set_xlabel("beads of the leg")
    axes[0].set_title("Cost of a bead and step", fontsize=10.5, loc="left")
    axes[1].set_title("What a second core is worth", fontsize=10.5, loc="left")
    return marks.save(figure, folder, "pareto-cores")
