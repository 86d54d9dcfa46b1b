"""Design studies for people: their tables, and the picture of the indices."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from beadband.analysis.fits import Measured
from beadband.reporting.style import SCREEN, Style
from beadband.reporting.summary import aligned
from beadband.studies.design.optimum import Design
from beadband.studies.design.sensitivity import CONFIDENCE, Sensitivity
from beadband.studies.design.values import NAMES
from beadband.studies.palette import PALETTE


def sensitivity(found: Sensitivity) -> str:
    """The indices as a table, the largest total order first."""
    rows = found.rows()
    unit = f" {found.quantity.unit}" if found.quantity.unit else ""
    low, high = found.interval_95
    lines = [
        f"{found.quantity.sentence}: mean {found.mean:.5g}{unit}, standard deviation {found.deviation:.3g}{unit}, "
        f"95 % between {low:.4g} and {high:.4g}{unit}",
        f"  {found.scenes} scenes in {found.seconds:.2g} s, {found.runs} of them by runs; largest error of a value "
        f"{found.error:.2g}{unit}",
        "",
    ]
    interval = f"{100.0 * CONFIDENCE:.0f} %"
    table = [("input", "range", "first order", interval, "total order", interval)]
    for at in _order(found):
        row = rows[at]
        cells = []
        for name in ("first_order", "total_order"):
            low, high = row[f"{name}_low"], row[f"{name}_high"]
            cells += [_share(row[name]), f"{_share(low)} to {_share(high)}"]
        table.append((found.ranges[at].option, row["range"], *cells))
    return "\n".join([*lines, *aligned(table), f"sum of the first orders {found.indices.first.sum():.3f}"])


def design(found: Design) -> str:
    """The best scene: its goal, its inputs, what is kept, and the closed forms of it."""
    unit = f" {found.unit}" if found.unit else ""
    text = str(Measured(found.value, found.error)) if found.error else f"{found.value:.6g}"
    lines = [f"{found.goal.sentence}  {text}{unit}, the {'least' if found.least else 'largest'} in these ranges"]
    if found.confirmed is not None:
        lines.append(f"  by a run of it  {found.confirmed}{unit}")
    lines += [
        f"  {found.evaluations} scenes in {found.seconds:.2g} s, {found.runs} of them by runs",
        *(f"  kept: {one}" for one in found.kept),
        "",
    ]
    rows = [("input", "range", "best", "d ln goal/d ln input")]
    for one in found.ranges:
        value, slope = found.values[one.key], found.slopes.get(one.key)
        rows.append((one.option, str(one), one.shown(value), "" if slope is None else f"{slope:.4f}"))
    figures = [(key, value) for key, value in found.figures.items() if value is not None]
    return "\n".join([*lines, *aligned(rows), "", *_figures(figures), "", f"as options: {found.options}"])


def _figures(figures: list[tuple[str, float]]) -> list[str]:
    known = {one.key: one for one in NAMES.values()}
    rows = [
        (known[key].name, known[key].sentence, f"{value:.4g} {known[key].unit}".rstrip())
        for key, value in figures
        if key in known
    ]
    return aligned(rows)


def _share(value: float) -> str:
    return f"{value:.3f}".replace("-0.000", "0.000")


def _order(found: Sensitivity) -> list[int]:
    """Places of the inputs by their total order, the largest first."""
    return np.argsort(-found.indices.total, kind="stable").tolist()  # type: ignore[no-any-return]


def draw_sensitivity(found: Sensitivity, folder: Path, style: Style = SCREEN) -> Path:
    """Write sensitivity.png (or the style's format): bars of both orders for each input, with their intervals."""
    order, rows = _order(found), found.rows()
    with style.applied() as pyplot:
        size = style.size_in(7.6, 1.3 + 0.55 * len(order))
        figure, axes = pyplot.subplots(figsize=size, layout="constrained")
        for number, (name, label) in enumerate((("total_order", "total order"), ("first_order", "first order"))):
            values = np.array([rows[at][name] for at in order])
            ends = np.array([[rows[at][f"{name}_low"], rows[at][f"{name}_high"]] for at in order]).T
            places = np.arange(len(order)) + (0.19 if number == 0 else -0.19)
            axes.barh(places, values, 0.36, color=PALETTE[0 if number else 5], label=label)
            # A percentile interval need not hold the estimate; bars of errors have no negative lengths.
            lengths = np.maximum([values - ends[0], ends[1] - values], 0.0)
            axes.errorbar(values, places, xerr=lengths, fmt="none", ecolor="#202020", elinewidth=0.9, capsize=2)
        names = [f"{found.ranges[at].option}\n{found.ranges[at]}" for at in order]
        axes.set_yticks(np.arange(len(order)), names, fontsize="small")
        axes.invert_yaxis()
        axes.set_xlabel(f"share of the variance of the {found.quantity.sentence}, {100.0 * CONFIDENCE:.0f} % intervals")
        axes.axvline(0.0, color="#8a8a8a", linewidth=0.8)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, loc="lower right")
        path = style.save(figure, folder / "sensitivity.png")
        pyplot.close(figure)
    return path
