"""The charts: every run on the same axes, error against seconds, and what a second core is worth."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from beadband.pareto.cores import WAYS, Timing, pays_from
from beadband.pareto.frontier import frontier
from beadband.pareto.judgement import BLEW_UP, ELSEWHERE, UNSETTLED, Row
from beadband.pareto.reference import Reference
from beadband.scene import Scene

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
_TITLES = {
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
_TOP, _BOTTOM = 1.0, 2e-5
"""Errors drawn, as shares; greater ones and blow-ups stand on the upper edge."""


def draw(rows: Sequence[Row], reference: Reference, times: Sequence[Timing], folder: Path, scene: Scene) -> list[Path]:
    """Write pareto, pareto-curvature, pareto-methods and pareto-cores as PNG and SVG; return their paths."""
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams.update({"font.size": 10, "axes.grid": True, "grid.alpha": 0.2, "svg.hashsalt": "beadband"})
    what = f"band {scene.band.name}, strain {scene.strain:g}, {scene.half_angle_deg:g}°, {scene.law}"
    written = _speed(rows, reference, folder, what)
    written += _methods(rows, reference, folder, what)
    if math.isfinite(reference.values[1]):
        written += _curvature(rows, reference, folder, what)
    return written + _cores(times, folder)


def _figure(columns: int, lines: int, width: float, height: float, share: bool = False) -> tuple[Any, list[Any]]:
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(
        lines, columns, figsize=(width, height), layout="constrained", squeeze=False, sharex=share, sharey=share
    )
    return figure, list(axes.flat)


def _save(figure: Any, folder: Path, name: str) -> list[Path]:
    from matplotlib import pyplot

    paths = [folder / f"{name}.{ending}" for ending in ("png", "svg")]
    figure.savefig(paths[0], dpi=110)
    figure.savefig(paths[1], metadata={"Date": None})
    pyplot.close(figure)
    return paths


def _height(row: Row, index: int) -> float:
    """Error as it is drawn."""
    error = row.errors[index]
    return min(max(error, _BOTTOM), _TOP) if math.isfinite(error) else _TOP


def _cost(row: Row, blown_at: float) -> float:
    """Milliseconds; of a run that left none, those at which it would have stood beside the others."""
    return 1e3 * row.median_s if row.integrate_s else blown_at


def _mark(row: Row) -> str:
    return {BLEW_UP: "x", ELSEWHERE: "s", UNSETTLED: "D"}.get(row.status, "o")


def _points(axis: Any, rows: Sequence[Row], index: int, size: float, faint: bool = False) -> None:
    """Runs as marks, the spread of their repeats as bars."""
    pace = _pace(rows)
    groups: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        if row.family != "plan":
            groups.setdefault((row.family, _mark(row)), []).append(row)
    for (family, mark), those in groups.items():
        colour = "#cfcfcf" if faint else COLOURS[family]
        costs = [_cost(row, 1e3 * row.bead_steps * pace) for row in those]
        heights = [_height(row, index) for row in those]
        hollow = mark in ("s", "D")
        face = {"facecolors": "none", "edgecolors": colour} if hollow else {"color": colour}
        axis.scatter(costs, heights, s=size, marker=mark, linewidths=0.9, zorder=1 if faint else 3, **face)
        if not faint:
            timed = [row for row in those if row.integrate_s]
            least = [1e3 * min(row.integrate_s) for row in timed]
            most = [1e3 * max(row.integrate_s) for row in timed]
            axis.hlines([_height(row, index) for row in timed], least, most, color=colour, lw=0.5, alpha=0.35, zorder=2)


def _pace(rows: Sequence[Row]) -> float:
    """Seconds a bead and step of the production runs, for those that ended before a clock was read."""
    known = sorted(row.median_s / row.bead_steps for row in rows if row.family == "beads" and row.integrate_s)
    return known[len(known) // 2] if known else 1e-7


def _front(axis: Any, rows: Sequence[Row], index: int, reference: Reference, label: str | None) -> None:
    """The frontier as steps, and the uncertainty of the reference as ground."""
    floor = reference.relative(index)
    front = frontier(rows, index, floor)
    axis.axhspan(_BOTTOM / 10.0, floor, color="#eeeeee", zorder=0)
    x = [1e3 * row.median_s for row in front]
    y = [max(row.sure_errors[index], floor) for row in front]
    if front:
        x, y = [*x, 1e3 * max(row.median_s for row in rows if row.integrate_s)], [*y, y[-1]]
    axis.step(x, y, where="post", color="black", lw=1.8, zorder=4, label=label)


def _stars(axis: Any, rows: Sequence[Row], index: int, purposes: Sequence[str], names: bool) -> None:
    for row in rows:
        purpose = row.variant.split()[0]
        if row.family != "plan" or purpose not in purposes or row.answer is None:
            continue
        x, y = 1e3 * row.median_s, _height(row, index)
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


def _axes(axis: Any) -> None:
    axis.set_xscale("log")
    axis.set_yscale("log")
    axis.set_ylim(0.5 * _BOTTOM, 1.6 * _TOP)
    axis.set_yticks([1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0])
    axis.set_yticklabels(["0.001 %", "0.01 %", "0.1 %", "1 %", "10 %", "100 %"])
    axis.minorticks_off()


def _plain_time(axis: Any) -> None:
    axis.set_xlabel("integration, ms (median of the repeats; bars: all of them)")
    axis.set_xticks([0.1, 1.0, 10.0, 100.0, 1000.0, 10000.0])
    axis.set_xticklabels(["0.1", "1", "10", "100", "1000", "10 000"])


def _legend(axis: Any, purposes: Sequence[str], families: bool) -> None:
    from matplotlib.lines import Line2D

    def dot(colour: str, mark: str, hollow: bool = False) -> Any:
        face = "none" if hollow else colour
        return Line2D([], [], ls="", marker=mark, color=colour, markerfacecolor=face, ms=6)

    handles, labels = [], []
    if families:
        for family, title in _TITLES.items():
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


def _speed(rows: Sequence[Row], reference: Reference, folder: Path, what: str) -> list[Path]:
    figure, (axis,) = _figure(1, 1, 9.6, 5.8)
    _axes(axis)
    _points(axis, rows, 0, 15.0)
    _front(axis, rows, 0, reference, None)
    _stars(axis, rows, 0, ("speed", "curvature"), True)
    _line(axis, [row for row in rows if row.family == "beads"], 0)
    _callouts(axis, rows, 0)
    _plain_time(axis)
    axis.set_ylabel("error of the rebound speed V")
    axis.set_title(f"Every method, V: {what}", fontsize=10.5, loc="left")
    _legend(axis, ("speed", "curvature"), True)
    return _save(figure, folder, "pareto")


def _line(axis: Any, rows: Sequence[Row], index: int) -> None:
    """A variant from coarse to fine, with some of its bead counts."""
    good = sorted((row for row in rows if row.integrate_s), key=lambda row: row.level)
    if not good:
        return
    x, y = [1e3 * row.median_s for row in good], [_height(row, index) for row in good]
    axis.plot(x, y, color=COLOURS[good[0].family], lw=0.9, alpha=0.7, zorder=2)
    if good[0].family == "beads":
        for n in range(0, len(good), 2):
            axis.annotate(
                f"{good[n].beads}", (x[n], y[n]), xytext=(0, 6), textcoords="offset points", fontsize=7.5, ha="center"
            )


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
        x, y = [1e3 * row.median_s for row in those], [_height(row, index) for row in those]
        axis.plot(x, y, color=COLOURS[family], lw=0.8, ls=":", zorder=2)
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
            color=COLOURS[family],
            zorder=5,
            bbox={"facecolor": "white", "edgecolor": "none", "alpha": 0.8, "pad": 0.5},
        )


def _curvature(rows: Sequence[Row], reference: Reference, folder: Path, what: str) -> list[Path]:
    figure, axes = _figure(2, 1, 12.4, 5.6, share=True)
    for axis, index, when in ((axes[0], 1, "0.1"), (axes[1], 2, "0.3")):
        _axes(axis)
        axis.set_ylim(0.5e-4, 1.6)
        _points(axis, rows, index, 13.0)
        _front(axis, rows, index, reference, None)
        _stars(axis, rows, index, ("curvature",), True)
        _line(axis, [row for row in rows if row.family == "beads"], index)
        _callouts(axis, rows, index)
        _plain_time(axis)
        axis.set_title(f"tip curvature around {when} of the front's arrival", fontsize=10.5, loc="left")
    axes[0].set_ylabel("error of the windowed tip curvature")
    figure.suptitle(f"Every method, κ: {what}", fontsize=10.5, x=0.01, ha="left")
    _legend(axes[1], ("curvature",), True)
    return _save(figure, folder, "pareto-curvature")


def _methods(rows: Sequence[Row], reference: Reference, folder: Path, what: str) -> list[Path]:
    """One panel for each family before all others in grey, each variant with its name at its finest run."""
    families = [family for family in _TITLES if family != "beads" and any(row.family == family for row in rows)]
    figure, axes = _figure(2, math.ceil(len(families) / 2), 12.0, 3.5 * math.ceil(len(families) / 2), share=True)
    for axis, family in zip(axes, families, strict=False):
        _axes(axis)
        _points(axis, [row for row in rows if row.family != family], 0, 5.0, faint=True)
        of_family = [row for row in rows if row.family == family]
        _points(axis, of_family, 0, 14.0)
        _front(axis, rows, 0, reference, None)
        variants = sorted({row.variant for row in of_family})
        shades = _shades(len(variants))
        ends = []
        for variant, shade in zip(variants, shades, strict=True):
            good = sorted(
                (row for row in of_family if row.variant == variant and row.integrate_s), key=lambda row: row.level
            )
            if not good:
                continue
            x, y = [1e3 * row.median_s for row in good], [_height(row, 0) for row in good]
            axis.plot(x, y, color=shade, lw=1.1, zorder=3)
            axis.scatter(x, y, color=shade, s=12, zorder=4)
            ends.append((math.log10(y[-1]), x[-1], variant, shade))
        _names(axis, ends)
        axis.set_title(_TITLES[family], fontsize=10.5, loc="left", color=COLOURS[family], weight="bold")
    for axis in axes[len(families) :]:
        axis.set_visible(False)
    for axis in axes:
        _plain_time(axis)
        axis.set_xlim(0.1, 3e5)
    figure.suptitle(
        f"V by family, all others in grey, frontier in black; cross: blew up, square: something else. {what}",
        fontsize=10.5,
        x=0.01,
        ha="left",
    )
    return _save(figure, folder, "pareto-methods")


def _shades(count: int) -> list[Any]:
    from matplotlib import colormaps

    return [colormaps["turbo"](0.05 + 0.9 * i / max(count - 1, 1)) for i in range(count)]


def _names(axis: Any, ends: list[tuple[float, float, str, Any]]) -> None:
    """Names in a column at the right, in the order of the ends and apart from each other."""
    if not ends:
        return
    ends = sorted(ends)
    apart, top, bottom = 0.30, math.log10(_TOP), math.log10(_BOTTOM)
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
    figure, axes = _figure(2, 1, 11.0, 4.4)
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
        says = f"{way}: pay from {start:.1e} beads" if start else f"{way}: never pay here"
        axes[1].annotate(
            says,
            (good[-1].beads, gain[-1]),
            xytext=(-6, 8),
            textcoords="offset points",
            color=colours[way],
            fontsize=9,
            ha="right",
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
    return _save(figure, folder, "pareto-cores")
