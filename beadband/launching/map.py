"""A map of launches: which band, pulled how, never hits the finger, and which throws best.

The axes are the strain and the half-angle, for each band of the catalogue. The radius of the finger is no third one:
a band of given circumference closes around one finger only, (1 + strain) Cb = L (2 + tan(phi)(pi + 2 phi)) and
R = L tan(phi), so each point of the map has its R, which is reported. At the same strain and half-angle another R means
another circumference, and changes nothing but h/R and with it the part of bending.
"""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Callable, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, fields
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np

from beadband import folder as files
from beadband.band import CATALOGUE
from beadband.errors import BeadbandError
from beadband.scene import Scene, scene_of

STRAINS = (0.1, 0.2, 0.3, 0.476, 0.7, 0.95, 1.2, 1.45)
HALF_ANGLES_DEG = (4.0, 8.0, 11.0, 14.0, 18.0, 23.0, 28.0)
QUICK_STRAINS = (0.2, 0.476, 0.9)
QUICK_HALF_ANGLES_DEG = (6.0, 14.0, 24.0)
BEADS, QUICK_BEADS = 240, 120
PROCESSES = 2
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
    """From the string's time of freedom, and mostly negative, where the rear came before the finger was seen free."""
    escape_speed_m_s: float | None = None
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


def launch_map(
    quick: bool = False, bands: Sequence[str] = tuple(CATALOGUE), follow: Callable[[int, int], None] | None = None
) -> list[MapPoint]:
    """Launch every point of the map on two processes; scenes that have no answer are in it with their reason."""
    strains, angles = (QUICK_STRAINS, QUICK_HALF_ANGLES_DEG) if quick else (STRAINS, HALF_ANGLES_DEG)
    points = [
        MapPoint(band, strain, angle, beads_of(band, quick)) for band in bands for strain in strains for angle in angles
    ]
    done: dict[int, MapPoint] = {}
    # Spawned, for LAMMPS and MPI do not survive a fork.
    with ProcessPoolExecutor(PROCESSES, mp_context=get_context("spawn")) as pool:
        try:
            waiting = {pool.submit(launch_point, point): number for number, point in enumerate(points)}
            for future in as_completed(waiting):
                done[waiting[future]] = future.result()
                if follow:
                    follow(len(done), len(points))
        except BaseException:
            pool.shutdown(cancel_futures=True)
            raise
    return [done[number] for number in range(len(points))]


def beads_of(band: str, quick: bool) -> int:
    """Beads for a band of the catalogue: more for a slender one, whose thickness is what grazes are measured by."""
    if quick:
        return QUICK_BEADS
    slenderness = CATALOGUE[band].circumference_m / CATALOGUE[band].thickness_m
    return 20 * round(min(max(BEADS, slenderness), 2 * BEADS) / 20)


def launch_point(point: MapPoint) -> MapPoint:
    """Launch one point of the map."""
    values = {key: getattr(point, key) for key in ("band", "strain", "half_angle_deg", "beads")}
    try:
        return _launched(point, scene_of({**values, "until": "launch", "for": "speed"}))
    except BeadbandError as error:
        return MapPoint(**values, reason=str(error))


def _launched(point: MapPoint, scene: Scene) -> MapPoint:
    from beadband.launching.launch import follow_launch

    plan, found, watch = follow_launch(scene)
    string, radius = plan.string, scene.wedge.finger_radius_m
    pause, arrival = found.pause_s, found.rear_arrival_s
    speed = efficiency = None
    if found.free is not None:
        # Where the rear comes first the finger has not given all of its impulse: there is no throw to speak of.
        times, mass = watch.times_s(plan.timestep_s), scene.band.mass_per_length_kg_m * scene.band.circumference_m
        speed = float(np.interp(sum(found.free), times, watch.momentum_n_s)) / mass
        efficiency = 0.5 * mass * speed**2 / float(watch.stretching_j[0] + watch.bending_j[0])
    reason = ""
    if arrival is None:
        reason = "the rear did not arrive"
    elif pause is None:
        pause = arrival - string.finger_free_s
        reason = "hit before the finger was free" if pause < 0.0 else "hit before the finger had been idle for a while"
    return MapPoint(
        point.band,
        point.strain,
        point.half_angle_deg,
        point.beads,
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
        reason=reason,
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
    files.write_text(folder / TABLE, as_csv(points))
    return [
        folder / TABLE,
        _picture(points, folder / "pause.png", "pause over the time until the finger is free", _relative_pause, "RdBu"),
        _picture(
            points, folder / "efficiency.png", "efficiency of the throw", lambda point: point.efficiency, "viridis"
        ),
    ]


def _relative_pause(point: MapPoint) -> float | None:
    if point.pause_s is None or point.rear_arrival_s is None:
        return None
    return point.pause_s / (point.rear_arrival_s - point.pause_s)


def _picture(
    points: Sequence[MapPoint], path: Path, title: str, value: Callable[[MapPoint], float | None], shades: str
) -> Path:
    """One panel for each band: half-angle across, strain up, the value as colour and as a number."""
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    bands = list(dict.fromkeys(point.band for point in points))
    size = 3.4 * len(bands), 4.2
    figure, panels = pyplot.subplots(1, len(bands), figsize=size, layout="constrained", squeeze=False)
    known = [number for number in map(value, points) if number is not None]
    most = max((abs(number) for number in known), default=1.0)
    low, high = (-min(most, 1.0), min(most, 1.0)) if shades == "RdBu" else (min(known, default=0.0), most)
    image = None
    for axes, band in zip(panels[0], bands, strict=True):
        own = [point for point in points if point.band == band]
        strains = sorted({point.strain for point in own})
        angles = sorted({point.half_angle_deg for point in own})
        grid = np.full((len(strains), len(angles)), math.nan)
        for point in own:
            number = value(point)
            place = strains.index(point.strain), angles.index(point.half_angle_deg)
            if number is not None:
                dark = abs(number) > 0.6 if shades == "RdBu" else number < 0.5 * (low + high)
                ink = "#ffffff" if dark else "#202020"
                grid[place] = number
                axes.text(place[1], place[0], f"{number:.2f}", ha="center", va="center", fontsize=7, color=ink)
            else:
                axes.text(place[1], place[0], "–", ha="center", va="center", fontsize=7, color="#6b6b6b")
        image = axes.imshow(grid, origin="lower", aspect="auto", cmap=shades, vmin=low, vmax=high)
        axes.set_xticks(range(len(angles)), [f"{angle:g}" for angle in angles])
        axes.set_yticks(range(len(strains)), [f"{strain:g}" for strain in strains])
        axes.set(title=f"band {band}", xlabel="half-angle (deg)")
    panels[0][0].set_ylabel("strain")
    figure.suptitle(title)
    if image is not None:
        figure.colorbar(image, ax=panels.ravel().tolist(), shrink=0.8)
    figure.savefig(path, dpi=110)
    pyplot.close(figure)
    return path


def summary(points: Sequence[MapPoint]) -> str:
    """The map in a line for each band: which scene throws best, which pauses longest, which hit."""
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
                f"; easiest escape {slow.escape_speed_m_s or math.nan:.3g} m/s at strain {slow.strain:g}, "
                f"{slow.half_angle_deg:g} deg"
            )
        lines.append(text)
    return "\n".join(lines)


def rows(points: Sequence[MapPoint]) -> list[dict[str, Any]]:
    """The map for programs."""
    return [asdict(point) for point in points]
