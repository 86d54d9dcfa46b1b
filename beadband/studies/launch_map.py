"""A map of launches: which bands, strains and half-angles never hit the finger, and which throw best.

The axes are the strain and the half-angle, for each band of the catalogue. The radius of the finger is no third one:
a band of given circumference closes around one finger only, (1 + strain) Cb = L (2 + tan(phi)(pi + 2 phi)) and
R = L tan(phi), so each point of the map has its R, which is reported. At the same strain and half-angle another R means
another circumference, and changes nothing but h/R and with it the part of bending.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import asdict, dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from beadband.model.bands import CATALOGUE
from beadband.model.scene import scene_of
from beadband.notices import notice
from beadband.runs import folder as files
from beadband.studies.launch_map_pictures import draw
from beadband.studies.pool import Failed, Progress, run_all

STRAINS = (0.1, 0.2, 0.3, 0.476, 0.7, 0.95, 1.2, 1.45)
HALF_ANGLES_DEG = (4.0, 8.0, 11.0, 14.0, 18.0, 23.0, 28.0)
QUICK_STRAINS = (0.2, 0.476, 0.9)
QUICK_HALF_ANGLES_DEG = (6.0, 14.0, 24.0)
BEADS, QUICK_BEADS = 240, 120
TABLE = "map.csv"


@dataclass(frozen=True)
class MapPoint:
    """One launch of the map; None where the launch gave no number, with the reason."""

    band: str
    strain: float
    half_angle_deg: float
    beads: int
    finger_radius_m: float | None = None
    thickness_over_radius: float | None = None
    finger_free_s: float | None = None
    rear_arrival_s: float | None = None
    pause_s: float | None = None
    """From the time when the string's finger is free, where the rear came before the measured one; mostly negative."""
    escape_speed_m_s: float | None = None
    """R over the pause: a scale of speed."""
    centre_of_mass_speed_m_s: float | None = None
    """When the finger becomes free."""
    efficiency: float | None = None
    """Of the throw, when the finger becomes free: that of a finger which clears."""
    touched: float | None = None
    """Impulse of later touches over the momentum; negative where the band was slowed down."""
    depth_over_thickness: float | None = None
    string_pause_s: float | None = None
    string_efficiency: float | None = None
    reason: str = ""
    reason_code: str = ""
    """Of an error (:mod:`beadband.errors`) or a notice (:mod:`beadband.notices`)."""


def launch_map(
    quick: bool = False,
    bands: Sequence[str] = tuple(CATALOGUE),
    follow: Progress | None = None,
    *,
    jobs: int | None = None,
    executor: Executor | None = None,
) -> list[MapPoint]:
    """Launch every point of the map; scenes that have no answer are in it with their reason.

    ``jobs`` processes run the launches (None for one per core), or the ``executor`` does; see
    :func:`beadband.studies.pool.run_tasks`. ``follow`` is called with the number of launches that are done, and of all.
    """
    strains, angles = (QUICK_STRAINS, QUICK_HALF_ANGLES_DEG) if quick else (STRAINS, HALF_ANGLES_DEG)
    points = [
        MapPoint(band, strain, angle, beads_of(band, quick)) for band in bands for strain in strains for angle in angles
    ]
    found = run_all(launch_point, points, jobs=jobs, executor=executor, progress=follow)
    return [
        replace(point, reason=outcome.reason, reason_code=outcome.code) if isinstance(outcome, Failed) else outcome
        for point, outcome in zip(points, found, strict=True)
    ]


def beads_of(band: str, quick: bool) -> int:
    """Beads for a band of the catalogue: more for a slender one, whose thickness is what grazes are measured by."""
    if quick:
        return QUICK_BEADS
    slenderness = CATALOGUE[band].circumference_m / CATALOGUE[band].thickness_m
    return 20 * round(min(max(BEADS, slenderness), 2 * BEADS) / 20)


def launch_point(point: MapPoint) -> MapPoint:
    """Launch one point of the map; UsageError when its scene has no answer, RunError when the launch failed."""
    from beadband.runs.launch import follow_launch

    values = {key: getattr(point, key) for key in ("band", "strain", "half_angle_deg", "beads")}
    scene = scene_of({**values, "until": "launch", "for": "speed"})
    plan, found, watch = follow_launch(scene)
    string, radius = plan.string, scene.wedge.finger_radius_m
    pause, arrival = found.pause_s, found.rear_arrival_s
    speed = efficiency = reason = None
    if found.last_load is not None:
        # Where the rear comes first the finger has not given all of its impulse: there is no throw.
        times, mass = watch.times_s(plan.timestep_s), scene.band.mass_per_length_kg_m * scene.band.circumference_m
        speed = float(np.interp(found.last_load.value, times, watch.momentum_n_s)) / mass
        efficiency = 0.5 * mass * speed**2 / float(watch.stretching_j[0] + watch.bending_j[0])
    if arrival is None:
        reason = notice("no-arrival", value=plan.cap_s)
    elif pause is None:
        pause = arrival - string.finger_free_s
        idle_s = plan.idle_steps * plan.timestep_s
        reason = notice("hit-before-free", value=-pause) if pause < 0.0 else notice("hit-before-idle", value=idle_s)
    return replace(
        point,
        finger_radius_m=radius,
        thickness_over_radius=scene.band.thickness_m / radius,
        finger_free_s=found.finger_free_s,
        rear_arrival_s=arrival,
        pause_s=pause,
        escape_speed_m_s=radius / pause if pause is not None and pause > 0.0 else None,
        centre_of_mass_speed_m_s=speed,
        efficiency=efficiency,
        touched=sum(touch.impulse_n_s for touch in found.touches) / found.momentum_n_s,
        depth_over_thickness=max(found.depth_m, 0.0) / scene.band.thickness_m,
        string_pause_s=string.pause_s,
        string_efficiency=string.efficiency,
        reason=reason.sentence if reason else "",
        reason_code=reason.code if reason else "",
    )


def as_csv(points: Sequence[MapPoint]) -> str:
    """The map as a table, SI units."""
    text = io.StringIO()
    names = [field.name for field in fields(MapPoint)]
    writer = csv.DictWriter(text, names, lineterminator="\n")
    writer.writeheader()
    for point in points:
        row = asdict(point)
        writer.writerow({name: f"{value:.6g}" if isinstance(value, float) else value for name, value in row.items()})
    return text.getvalue()


def write_map(points: Sequence[MapPoint], folder: Path) -> list[Path]:
    """Write map.csv, pause.png and efficiency.png into the folder; return their paths."""
    pauses: dict[str, dict[tuple[float, float], float | None]] = {}
    throws: dict[str, dict[tuple[float, float], float | None]] = {}
    for point in points:
        place = point.strain, point.half_angle_deg
        relative = None
        if point.pause_s is not None and point.rear_arrival_s is not None:
            relative = point.pause_s / (point.rear_arrival_s - point.pause_s)
        pauses.setdefault(point.band, {})[place] = relative
        throws.setdefault(point.band, {})[place] = point.efficiency
    files.write_text(folder / TABLE, as_csv(points))
    return [
        folder / TABLE,
        draw(pauses, folder / "pause.png", "pause over the time until the finger is free", diverging=True),
        draw(throws, folder / "efficiency.png", "efficiency of the throw"),
    ]


def summary(points: Sequence[MapPoint]) -> str:
    """The map in a line for each band: the best throw, the least R/pause, and how many hit."""
    lines = []
    for band in dict.fromkeys(point.band for point in points):
        own = [point for point in points if point.band == band]
        thrown = [point for point in own if point.efficiency is not None]
        hit = [point for point in own if point.pause_s is not None and point.pause_s <= 0.0]
        refused = [point for point in own if point.rear_arrival_s is None]
        text = f"band {band}: {len(own)} scenes, {len(hit)} hit before the finger is free, {len(refused)} refused"
        if thrown:
            best = max(thrown, key=lambda point: point.efficiency or 0.0)
            slow = min(thrown, key=lambda point: point.escape_speed_m_s or math.inf)
            text += (
                f"; best throw {best.efficiency:.1%} at strain {best.strain:g}, {best.half_angle_deg:g} deg"
                f"; least R/pause {slow.escape_speed_m_s or math.nan:.3g} m/s at strain {slow.strain:g}, "
                f"{slow.half_angle_deg:g} deg"
            )
        lines.append(text)
    return "\n".join(lines)


def rows(points: Sequence[MapPoint]) -> list[dict[str, Any]]:
    """The map for programs."""
    return [asdict(point) for point in points]
