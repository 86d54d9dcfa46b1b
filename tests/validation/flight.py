"""How far does a band fly for how much stretch? Launches of the catalogue's bands against a classroom's measurements.

    python tests/validation/flight.py [--beads 240] [--picture docs/flight.png]

The distances are those of docs/data/elastic-band.csv: three sets with one band and one ruler, neither of which is
described. What is compared is the exponent n of distance ~ stretch^n, by least squares on logarithms. Of the launches,
the throw's speed over the strain is computed; the length of the band at rest, which turns strains into stretches, is
fitted to the widest set for each elevation, with air and without. An exponent in air stands between those of the drag
area less and more its error.
"""

from __future__ import annotations

import argparse
import csv
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from beadband.model.bands import Band
from beadband.model.flight import drag_areas_m2, fly
from beadband.model.scene import scene_of
from beadband.runs.launch import follow_launch

Array = NDArray[np.float64]
DATA = Path(__file__).parents[2] / "docs" / "data" / "elastic-band.csv"
HALF_ANGLE_DEG = 8.0
AIR = 1.2
STRAINS = np.geomspace(0.06, 0.9, 9)
BANDS = ("II", "III", "IV")
THROWS = {"3 deg": (3.0, 0.0), "10 deg": (10.0, 0.0), "45 deg": (45.0, 0.0), "level, 0.2 m high": (0.0, 0.2)}


def measured() -> dict[str, tuple[Array, Array]]:
    """Stretch in mm and distance in m of each set."""
    lines = [line for line in DATA.read_text().splitlines() if not line.startswith("#")]
    sets: dict[str, list[tuple[float, float]]] = {}
    for row in csv.DictReader(lines):
        sets.setdefault(row["set"], []).append((float(row["stretch_mm"]), 0.01 * float(row["distance_cm"])))
    return {name: tuple(np.array(rows).T) for name, rows in sets.items()}  # type: ignore[misc]


def exponent(stretch: Array, distance: Array) -> tuple[float, float, float]:
    """Exponent, its standard error, and the scatter of the logarithms."""
    x, y = np.log(stretch), np.log(distance)
    slope, offset = np.polyfit(x, y, 1)
    scatter = math.sqrt(float(np.sum((y - slope * x - offset) ** 2)) / (len(x) - 2))
    return float(slope), scatter / math.sqrt(float(np.sum((x - x.mean()) ** 2))), scatter


@dataclass(frozen=True)
class Thrower:
    """A band of the catalogue and the speeds at which its launches throw it."""

    band: Band
    speeds_m_s: Array

    def distances_m(self, strains: Array, area_m2: float, elevation_deg: float, height_m: float) -> Array:
        speeds = np.exp(np.interp(np.log(strains), np.log(STRAINS), np.log(self.speeds_m_s)))
        length = 2.0 * self.band.mass_kg / (AIR * area_m2) if area_m2 > 0.0 else math.inf
        return np.array([fly(v, math.radians(elevation_deg), height_m, length).range_m for v in speeds.tolist()])

    def fitted(self, stretch: Array, distance: Array, area_m2: float, throw: str) -> tuple[float, Array, float]:
        """The length at rest, mm, for which the distances fit best; those distances, and the scatter about them."""

        def way(length: float) -> Array:
            return self.distances_m(stretch / length, area_m2, *THROWS[throw])

        def misfit(length: float) -> float:
            return float(np.sum(np.log(way(length) / distance) ** 2))

        ends = stretch.max() / STRAINS[-1], stretch.min() / STRAINS[0]
        best = minimize_scalar(misfit, bounds=ends, method="bounded")
        return float(best.x), way(best.x), math.sqrt(best.fun / (len(stretch) - 1))

    def areas_m2(self) -> tuple[float, float, float, float]:
        """None, then that of the tumbling band and its ends."""
        areas = drag_areas_m2(self.band)
        return 0.0, areas.tumbling, max(areas.tumbling - areas.error, 0.0), areas.tumbling + areas.error


def thrower(name: str, beads: int) -> Thrower:
    """Launch a band at all strains."""
    given = {"band": name, "half_angle_deg": HALF_ANGLE_DEG, "for": "speed", "until": "launch", "finger": "clears"}
    scenes = [scene_of({**given, "strain": strain, "beads": beads}) for strain in STRAINS.tolist()]
    return Thrower(scenes[0].band, np.array([follow_launch(scene)[1].centre_of_mass_speed_m_s for scene in scenes]))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--beads", type=int, default=240)
    parser.add_argument("--picture", type=Path)
    given = parser.parse_args()
    sets = measured()
    for name, (stretch, distance) in sets.items():
        n, error, scatter = exponent(stretch, distance)
        print(f"{name}: {len(stretch)} throws, {stretch.min():g} to {stretch.max():g} mm, n = {n:.2f} +/- {error:.2f}, "
              f"scatter {scatter:.1%}")  # fmt: skip
    stretch, distance = sets["elastic2"]
    throwers = {name: thrower(name, given.beads) for name in BANDS}
    for name, one in throwers.items():
        local = np.gradient(np.log(one.speeds_m_s), np.log(STRAINS))
        drag_length = 2.0 * one.band.mass_kg / (AIR * one.areas_m2()[1])
        print(f"{name}: throws of {one.speeds_m_s[0]:.2f} to {one.speeds_m_s[-1]:.2f} m/s, n of the speed "
              f"{local[0]:.2f} to {local[-1]:.2f}, L = {drag_length:.1f} m")  # fmt: skip
        for throw in THROWS:
            fits = [one.fitted(stretch, distance, area, throw) for area in one.areas_m2()]
            n = [exponent(stretch, far)[0] for _, far, _ in fits]
            print(f"  {throw}: without air n = {n[0]:.2f}, {fits[0][0]:.0f} mm, scatter {fits[0][2]:.1%}; in air n = "
                  f"{n[1]:.2f} ({n[3]:.2f} to {n[2]:.2f}), {fits[1][0]:.0f} mm, scatter {fits[1][2]:.1%}")  # fmt: skip
    if given.picture:
        draw(given.picture, sets, throwers)


def draw(path: Path, sets: dict[str, tuple[Array, Array]], throwers: dict[str, Thrower]) -> None:
    """The measured distances, and the launches of two bands through the widest set."""
    from matplotlib import pyplot

    figure, axes = pyplot.subplots(figsize=(7.4, 4.4), layout="constrained")
    for (name, (stretch, distance)), mark in zip(sets.items(), "osD", strict=True):
        n, error, _ = exponent(stretch, distance)
        axes.loglog(stretch, distance, mark, color="#6b6b6b", markersize=5, alpha=0.8,
                    label=f"{name}: n = {n:.2f} ± {error:.2f}")  # fmt: skip
    stretch, distance = sets["elastic2"]
    dense = np.linspace(stretch.min(), stretch.max(), 30)
    for name, colour in (("II", "#1f5fa8"), ("III", "#c8601a")):
        one, throw = throwers[name], "10 deg"
        curves = []
        for area in one.areas_m2():
            length, far, _ = one.fitted(stretch, distance, area, throw)
            curves.append(one.distances_m(dense / length, area, *THROWS[throw]))
            if len(curves) < 3:
                word, style = ("in air", "-") if area else ("without air", "--")
                axes.loglog(dense, curves[-1], style, color=colour, linewidth=1.3,
                            label=f"band {name}, {word}: n = {exponent(stretch, far)[0]:.2f}")  # fmt: skip
        axes.fill_between(dense, curves[2], curves[3], color=colour, alpha=0.12, linewidth=0.0)
    axes.set(xlabel="stretch (mm)", ylabel="distance (m)", title="thrown at 10°, the length at rest fitted")
    axes.set_xticks([30, 40, 50, 60], ["30", "40", "50", "60"])
    axes.set_yticks([0.7, 1, 2, 3], ["0.7", "1", "2", "3"])
    axes.minorticks_off()
    axes.legend(fontsize=8, frameon=False, loc="center left", bbox_to_anchor=(1.0, 0.5))
    figure.savefig(path, dpi=120)


if __name__ == "__main__":
    main()
