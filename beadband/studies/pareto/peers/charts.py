"""The charts of the comparison: medians over the scenes of a kind first, then scene by scene."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from typing import Any

from beadband.studies.pareto import plot_elements as elements
from beadband.studies.pareto.frontier import non_dominated
from beadband.studies.pareto.outcomes import OK
from beadband.studies.pareto.peers.comparison import ASK, OURS, PLAN, Comparison, Point, tools
from beadband.studies.pareto.peers.registry import INSTALL

_OWN = {OURS: ("#0072B2", "o"), PLAN: ("#E69F00", "*"), ASK: ("#D55E00", "D")}
_DARK = {PLAN: "#7a5400", ASK: "#a34700"}
_PEER_COLOURS = ("#999999", "#56B4E9", "#009E73", "#CC79A7", "#8c6d1f", "#4b4b8f")
_PEER_MARKS = ("^", "s", "v", "P", "X", "<")
"""Of Okabe and Ito: told apart with any kind of colour vision, and by their marks in black and white."""
_LEFT, _RIGHT = 0.08, 1.2e4
_FLOOR = 1e-5
_FIRST_QUANTITY = "error of the rebound speed V"


def draw(compared: Comparison, folder: Path) -> list[Path]:
    """Write pareto-peers, pareto-peers-scenes and pareto-peers-curvature as PNG and SVG; return their paths."""
    import matplotlib

    matplotlib.use("Agg")
    matplotlib.rcParams.update({"font.size": 10, "axes.grid": True, "grid.alpha": 0.2, "svg.hashsalt": "beadband"})
    written = _summary(compared, 0, _FIRST_QUANTITY, folder, "pareto-peers")
    written += _scenes(compared, folder)
    return written + _summary(
        compared, 1, "error of the tip curvature around 0.1 t_f", folder, "pareto-peers-curvature"
    )


def kinds(compared: Comparison) -> dict[str, list[str]]:
    """The scenes whose law unloads with a shock and those without: not every program has a law for the first."""
    found: dict[str, list[str]] = {}
    for name, scene in compared.scenes.items():
        found.setdefault(scene.law, []).append(name)
    return {f"{law} law, {len(names)} scene" + "s" * (len(names) > 1): names for law, names in found.items()}


def medians(points: Sequence[Point], tool: str, scenes: Sequence[str], index: int) -> list[dict[str, Any]]:
    """Time and error of a tool at each of its levels, over the scenes on which that level gave an answer."""
    levels: dict[Any, list[Point]] = {}
    for point in points:
        if point.tool == tool and point.scene in scenes and math.isfinite(point.errors[index]):
            if tool == PLAN and ("plan: speed" in point.variant) != (index == 0):
                continue
            levels.setdefault(point.level, []).append(point)
    return [
        {
            "level": level,
            "ms": 1e3 * median(point.whole_s for point in those),
            "error": median(point.errors[index] for point in those),
            "least": min(point.errors[index] for point in those),
            "most": max(point.errors[index] for point in those),
        }
        for level, those in sorted(levels.items(), reverse=tool in (PLAN, ASK))
    ]


def frontier(points: Sequence[Point], scene: str, index: int) -> list[tuple[float, float]]:
    """Time in ms and error bound of the runs of beadband that none of its other runs beats in both; no plans."""
    own = [point for point in points if point.scene == scene and point.status == OK and _is_method(point)]
    pairs = [(1e3 * point.whole_s, point.bounds[index]) for point in own]
    return [pairs[i] for i in non_dominated(pairs)]


def _is_method(point: Point) -> bool:
    return ":" in point.variant and point.tool != PLAN


def median_frontier(points: Sequence[Point], scenes: Sequence[str], index: int) -> list[tuple[float, float]]:
    """The error of more than half of the scenes is within a bound after this time; from slow to quick."""
    fronts = [front for scene in scenes if (front := frontier(points, scene, index))]
    found = []
    for bound in sorted({error for front in fronts for _, error in front}):
        times = [min((ms for ms, error in front if error <= bound), default=math.inf) for front in fronts]
        middle = sorted(times)[len(times) // 2] if times else math.inf
        if math.isfinite(middle):
            found.append((middle, bound))
    return found


def _summary(compared: Comparison, index: int, ylabel: str, folder: Path, name: str) -> list[Path]:
    groups = kinds(compared)
    figure, axes = elements.new_figure(len(groups), 1, 6.4 * len(groups) + 1.2, 5.6, share=True)
    styles = _styles(compared)
    for axis, (title, scenes) in zip(axes, groups.items(), strict=True):
        _axis(axis)
        front = median_frontier(compared.points, scenes, index)
        if front:
            axis.step(*zip(*front, strict=True), where="post", color="black", lw=1.6, zorder=4)
        for tool, (colour, mark) in styles.items():
            levels = medians(compared.points, tool, scenes, index)
            _curve(axis, levels, tool, colour, mark, bars=True)
            if tool in (PLAN, ASK):
                _tolerances(axis, levels, _DARK[tool], (8, -4) if tool == ASK else (-8, -4), tool == PLAN)
        floor = median(compared.references[name].relative(index) for name in scenes)
        if math.isfinite(floor):
            axis.axhspan(_FLOOR / 10.0, floor, color="#eeeeee", zorder=0)
        axis.set_title(title, loc="left", fontsize=10.5)
        axis.set_xlabel("time of the whole answer in a warm process, set-up included, ms")
    axes[0].set_ylabel(f"{ylabel}, median of the scenes")
    asked = index == 0
    _legend(figure, compared, {tool: style for tool, style in styles.items() if asked or tool != ASK})
    return elements.save(figure, folder, name)


def _tolerances(axis: Any, levels: list[dict[str, Any]], colour: str, shift: tuple[float, float], left: bool) -> None:
    """The tolerances beside the points, one text for points that lie on each other."""
    places: list[tuple[float, float, list[str]]] = []
    for one in levels:
        x, y, text = one["ms"], max(one["error"], _FLOOR), f"{100.0 * one['level']:g}"
        near = [place for place in places if abs(math.log(place[0] / x)) < 0.9 and abs(math.log(place[1] / y)) < 0.4]
        if near:
            near[0][2].append(text)
        else:
            places.append((x, y, [text]))
    for x, y, texts in places:
        elements.label(
            axis,
            ", ".join(texts) + " %",
            (x, y),
            shift,
            8.5,
            ha="right" if left else "left",
            color=colour,
            weight="bold",
            zorder=8,
        )


def _scenes(compared: Comparison, folder: Path) -> list[Path]:
    """One panel for each scene: all of beadband's methods in grey behind the tools."""
    lines = math.ceil(len(compared.scenes) / 3)
    columns = min(3, len(compared.scenes))
    figure, axes = elements.new_figure(columns, lines, 4.6 * columns + 0.6, 4.0 * lines + 0.4, share=True)
    styles = _styles(compared)
    for axis, (name, scene) in zip(axes, compared.scenes.items(), strict=False):
        _axis(axis)
        axis.axhspan(_FLOOR / 10.0, compared.references[name].relative(0), color="#eeeeee", zorder=0)
        rest = [p for p in compared.points if p.scene == name and _is_method(p) and p.tool != OURS]
        rest = [p for p in rest if math.isfinite(p.errors[0])]
        axis.scatter(
            [1e3 * p.whole_s for p in rest], [max(p.errors[0], _FLOOR) for p in rest], s=7, color="#d0d0d0", zorder=1
        )
        front = frontier(compared.points, name, 0)
        if front:
            axis.step(*zip(*front, strict=True), where="post", color="black", lw=1.3, zorder=4)
        for tool, (colour, mark) in styles.items():
            _curve(axis, medians(compared.points, tool, [name], 0), tool, colour, mark, bars=False)
        title = f"{name}: band {scene.band.name}, h {1e3 * scene.band.thickness_m:g} mm, "
        axis.set_title(f"{title}{scene.strain:g}, {scene.half_angle_deg:g}°", loc="left", fontsize=9)
    for axis in axes[len(compared.scenes) :]:
        axis.set_visible(False)
    for axis in axes[-columns:]:
        axis.set_xlabel("time of the whole answer, ms")
    for axis in axes[::columns]:
        axis.set_ylabel("error of V")
    _legend(figure, compared, styles, ("#d0d0d0", "other methods of beadband"))
    return elements.save(figure, folder, "pareto-peers-scenes")


def _styles(compared: Comparison) -> dict[str, tuple[str, str]]:
    named = [peer.name for peer in compared.peers]
    looks = [(colour, mark) for colour, mark in zip(_PEER_COLOURS, _PEER_MARKS, strict=True)]
    present = tools(compared.points)
    peers = {name: looks[i % len(looks)] for i, name in enumerate(named) if name in present}
    return {**peers, **_OWN}


def _axis(axis: Any) -> None:
    elements.error_axis(axis)
    axis.set_ylim(_FLOOR, 0.5)
    axis.set_xlim(_LEFT, _RIGHT)
    axis.set_xticks([0.1, 1.0, 10.0, 100.0, 1000.0, 10000.0])
    axis.set_xticklabels(["0.1", "1", "10", "100", "1000", "10 000"])
    axis.minorticks_off()


def _curve(axis: Any, levels: list[dict[str, Any]], tool: str, colour: str, mark: str, bars: bool) -> None:
    if not levels:
        return
    x = [one["ms"] for one in levels]
    y = [max(one["error"], _FLOOR) for one in levels]
    joined = tool not in (PLAN, ASK)
    front = tool in _OWN
    if joined:
        axis.plot(x, y, color=colour, lw=1.8 if tool == OURS else 1.3, zorder=5 if front else 3)
    if bars:
        low, high = [max(one["least"], _FLOOR) for one in levels], [max(one["most"], _FLOOR) for one in levels]
        axis.vlines(x, low, high, color=colour, lw=1.0, alpha=0.45, zorder=2)
    size = {PLAN: 170, ASK: 55}.get(tool, 28)
    edge = {"edgecolors": "black", "linewidths": 0.7} if not joined else {"linewidths": 0.0}
    axis.scatter(x, y, s=size, color=colour, marker=mark, zorder=7 if not joined else 5, **edge)


def _legend(
    figure: Any, compared: Comparison, styles: dict[str, tuple[str, str]], grey: tuple[str, str] | None = None
) -> None:
    """Below the panels, so that nothing is covered."""
    from matplotlib.lines import Line2D

    laws = {peer.name: peer.laws for peer in compared.peers}
    entries = []
    for tool, (colour, mark) in sorted(styles.items(), key=lambda one: one[0] not in _OWN):
        line = "-" if tool not in (PLAN, ASK) else ""
        edge: dict[str, Any] = {"markeredgecolor": "black", "markeredgewidth": 0.7} if not line else {}
        handle = Line2D([], [], ls=line, color=colour, marker=mark, ms=11 if tool == PLAN else 6, **edge)
        text = {
            OURS: "beadband, one leg, by beads",
            PLAN: "its plan, by tolerance",
            ASK: "beadband ask, by tolerance",
        }.get(tool, tool)
        own_laws = laws.get(tool)
        entries.append((handle, text + (f" ({', '.join(own_laws)} law alone)" if own_laws else "")))
    entries.append((Line2D([], [], color="black", lw=1.6), "frontier of beadband's methods"))
    if grey:
        entries.append((Line2D([], [], ls="", marker="o", color=grey[0], ms=4), grey[1]))
    entries += [(Line2D([], [], ls=""), f"{name}: not installed, {INSTALL}") for name in compared.absent]
    figure.legend(*zip(*entries, strict=True), fontsize=9, loc="outside lower center", ncols=4, frameon=False)
