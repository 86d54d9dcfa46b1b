"""A map of launches over the mass and the spring of the hand: which hands are hit, and how fast.

Beside the grid the line between hit and not hit is found: for each spring the mass on it, by halving the interval of
the grid in which it lies.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, fields, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from beadband import parameters
from beadband.errors import UsageError, explain
from beadband.model.scene import scene_of
from beadband.runs import folder as files
from beadband.studies.pool import Failed, Progress, run_all

BEADS, QUICK_BEADS = 240, 120
HALVINGS = 5
"""Halvings, in the logarithm of the mass, of the interval that the line crosses."""
MOST = 400
TABLE, LINE, PICTURE = "hand-map.csv", "hand-line.csv", "hand-map.png"
DIGIT_KG = (0.005, 0.1)
"""Effective masses from the tip of a finger to a part of the hand that moves with it, for the picture."""


@dataclass(frozen=True)
class HandPoint:
    """One launch of the map; None where it gave no number, with the reason."""

    band: str
    mass_kg: float
    stiffness_n_m: float
    beads: int
    hit: bool | None = None
    hit_s: float | None = None
    hit_speed_m_s: float | None = None
    peak_force_n: float | None = None
    impulse_n_s: float | None = None
    displacement_m: float | None = None
    reason: str = ""
    reason_code: str = ""


@dataclass(frozen=True)
class LinePoint:
    """The line between hit and not hit at one spring: it lies between these masses."""

    band: str
    stiffness_n_m: float
    not_hit_kg: float
    hit_kg: float

    @property
    def mass_kg(self) -> float:
        return math.sqrt(self.not_hit_kg * self.hit_kg)


def values_of(key: str, text: str) -> tuple[float, ...]:
    """Values of an axis: A,B,C or FIRST:LAST:COUNT, even in the logarithm where it begins above 0; UsageError."""
    pieces = text.split(":")
    if len(pieces) == 1:
        return tuple(dict.fromkeys(float(parameters.parsed(key, piece.strip())) for piece in text.split(",")))
    low, high = (float(parameters.parsed(key, piece)) for piece in pieces[:2])
    if len(pieces) != 3 or not pieces[2].isdecimal() or not 1 <= int(pieces[2]) <= MOST:
        flag = parameters.TABLE[key].flag
        allowed = f"FIRST:LAST:COUNT, COUNT from 1 to {MOST}"
        raise UsageError(explain(f"{flag} is not a range", repr(text), allowed, f"change {flag}"))
    spaced = np.geomspace if min(low, high) > 0.0 else np.linspace
    return tuple(float(f"{value:.12g}") for value in spaced(low, high, int(pieces[2])))


def hand_map(
    masses_kg: Sequence[float],
    stiffnesses_n_m: Sequence[float] = (0.0,),
    band: str = "III",
    quick: bool = False,
    follow: Progress | None = None,
    *,
    jobs: int | None = None,
    executor: Executor | None = None,
) -> tuple[list[HandPoint], list[LinePoint]]:
    """Launch a band with every hand; the points, and the line between hit and not hit where the grid crosses it.

    ``jobs``, ``executor`` and ``follow`` as :func:`beadband.studies.launch_map.launch_map` takes them. UsageError for
    too many hands.
    """
    if len(masses_kg) * len(stiffnesses_n_m) > MOST:
        given = f"{len(masses_kg)} masses and {len(stiffnesses_n_m)} springs"
        raise UsageError(explain("the map is too large", given, f"at most {MOST} hands", "give fewer values"))
    scene_of({"band": band})
    beads = QUICK_BEADS if quick else BEADS
    grid = [HandPoint(band, mass, spring, beads) for spring in stiffnesses_n_m for mass in sorted(masses_kg)]
    found = run_all(hand_point, grid, jobs=jobs, executor=executor, progress=follow)
    points = [
        replace(point, reason=outcome.reason, reason_code=outcome.code) if isinstance(outcome, Failed) else outcome
        for point, outcome in zip(grid, found, strict=True)
    ]
    # The lightest hand that is hit whose lighter neighbour is not: a light one may be thrown back by its spring.
    edges = [
        (one, other)
        for one, other in pairwise(points)
        if one.stiffness_n_m == other.stiffness_n_m and one.hit is False and other.hit
    ]
    lines = run_all(_between, edges, jobs=jobs, executor=executor)
    return points, [one for one in lines if isinstance(one, LinePoint)]


def hand_point(point: HandPoint) -> HandPoint:
    """Launch one hand of the map; UsageError when its scene has no answer, RunError when the launch failed."""
    from beadband.runs.launch import follow_hand

    values = {"hand_mass_kg": point.mass_kg, "hand_stiffness_n_m": point.stiffness_n_m, "band": point.band}
    scene = scene_of({**values, "beads": point.beads, "until": "launch", "for": "speed"})
    felt = asdict(follow_hand(scene)[3].found)
    return replace(point, **{one.name: felt[one.name] for one in fields(HandPoint) if one.name in felt})


def _between(edge: tuple[HandPoint, HandPoint]) -> LinePoint:
    """Halve the interval of masses between a hand that is not hit and a heavier one that is."""
    light, heavy = edge
    for _ in range(HALVINGS):
        middle = hand_point(replace(light, mass_kg=math.sqrt(light.mass_kg * heavy.mass_kg)))
        light, heavy = (light, middle) if middle.hit else (middle, heavy)
    return LinePoint(light.band, light.stiffness_n_m, light.mass_kg, heavy.mass_kg)


def write_hand_map(points: Sequence[HandPoint], line: Sequence[LinePoint], folder: Path) -> list[Path]:
    """Write hand-map.csv, hand-line.csv and hand-map.png into the folder; return their paths."""
    files.write_text(folder / TABLE, _csv(HandPoint, points))
    files.write_text(folder / LINE, _csv(LinePoint, line))
    return [folder / TABLE, folder / LINE, draw(points, line, folder / PICTURE)]


def _csv(kind: type[HandPoint] | type[LinePoint], points: Sequence[Any]) -> str:
    text = io.StringIO()
    writer = csv.DictWriter(text, [one.name for one in fields(kind)], lineterminator="\n")
    writer.writeheader()
    for point in points:
        row = asdict(point)
        writer.writerow({name: f"{value:.6g}" if isinstance(value, float) else value for name, value in row.items()})
    return text.getvalue()


def draw(points: Sequence[HandPoint], line: Sequence[LinePoint], path: Path) -> Path:
    """Write the picture: mass across, spring up, the speed of the hit as colour and number, the line drawn in."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    masses, springs = (sorted({getattr(one, name) for one in points}) for name in ("mass_kg", "stiffness_n_m"))
    figure, axes = pyplot.subplots(figsize=(2.2 + 0.62 * len(masses), 1.8 + 0.45 * len(springs)), layout="constrained")
    grid = np.full((len(springs), len(masses)), math.nan)
    fastest = max((one.hit_speed_m_s or 0.0 for one in points), default=0.0)
    for one in points:
        row, column = springs.index(one.stiffness_n_m), masses.index(one.mass_kg)
        text = "–" if one.hit is None else "not hit"
        if one.hit_speed_m_s is not None:
            grid[row, column] = one.hit_speed_m_s
            text = f"{one.hit_speed_m_s:.1f}"
        dark = one.hit_speed_m_s is not None and one.hit_speed_m_s < 0.5 * fastest
        axes.text(column, row, text, ha="center", va="center", fontsize=7, color="#ffffff" if dark else "#202020")
    image = axes.imshow(grid, origin="lower", aspect="auto", cmap="viridis", vmin=0.0)
    places = np.log(masses)

    def across(mass: float) -> float:
        return float(np.interp(math.log(mass), places, np.arange(len(masses)), left=-0.5, right=len(masses) - 0.5))

    for row, spring in enumerate(springs):
        for edge in (each for each in line if each.stiffness_n_m == spring):
            axes.plot([across(edge.mass_kg)] * 2, [row - 0.5, row + 0.5], color="#D55E00", linewidth=2.5)
    low, high = (across(mass) for mass in DIGIT_KG)
    if high > low:
        axes.annotate("", (low, len(springs) - 0.4), (high, len(springs) - 0.4), annotation_clip=False,
                      arrowprops={"arrowstyle": "<->", "color": "#D55E00"})  # fmt: skip
        axes.text(0.5 * (low + high), len(springs) - 0.25, "real fingers", ha="center", color="#D55E00", fontsize=8)
    axes.set_xticks(range(len(masses)), [f"{1e3 * mass:.3g}" for mass in masses])
    axes.set_yticks(range(len(springs)), [f"{spring:g}" for spring in springs])
    axes.set(xlabel="mass of the hand (g)", ylabel="its spring (N/m)", ylim=(-0.5, len(springs) + 0.1))
    figure.colorbar(image, label="speed of the hit (m/s)")
    figure.savefig(path, dpi=110)
    pyplot.close(figure)
    return path


def summary(points: Sequence[HandPoint], line: Sequence[LinePoint]) -> str:
    """The map in a line for each spring."""
    lines = []
    for spring in dict.fromkeys(point.stiffness_n_m for point in points):
        own = [point for point in points if point.stiffness_n_m == spring]
        hits = [point.hit_speed_m_s for point in own if point.hit_speed_m_s is not None]
        text = f"band {own[0].band}, {spring:g} N/m: {len(hits)} of {len(own)} hands are hit"
        text += f", at {min(hits):.3g} to {max(hits):.3g} m/s" if hits else ""
        edge = [one for one in line if one.stiffness_n_m == spring]
        text += "".join(f"; from {1e3 * one.mass_kg:.3g} g (+/- {one.hit_kg / one.mass_kg - 1.0:.1%})" for one in edge)
        lines.append(text)
    return "\n".join(lines)


def rows(points: Sequence[HandPoint], line: Sequence[LinePoint]) -> dict[str, Any]:
    """The map for programs."""
    return {"points": [asdict(one) for one in points], "line": [asdict(one) for one in line]}
