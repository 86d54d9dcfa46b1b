"""Rung ``string``: whole releases with next to no bending against the exact string wedge."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from beadband.model.bands import laws_of
from beadband.model.scene import scene_of
from beadband.planning.plan import plan_of
from beadband.studies.verification.check import Check
from beadband.studies.verification.releases import Released, release
from beadband.studies.verification.specimen import Array

_WEDGES = ((0.2, 25.0), (0.476, 14.0), (0.8, 10.0), (1.0, 20.0), (1.4, 5.0))
"""Strains and half-angles (degrees)."""
_BENDING_SCALE = 1e-4
_BEADS = 600


def string() -> list[Check]:
    """Residual strain, V, front and kink of five wedges for either law, from frames of the whole ring.

    Exact for EI -> 0 (``model.wedge``): the strain e1 behind the front, the speed V of the rear, the front at
    S = c t and the kink at S = sqrt(stress1/(density stretch1)) t, S in reference length. The front is where the
    stretch is halfway, the kink where a sharp one would have the turning that the beads spread over several bonds:
    the integral of the turned angle over S, divided by that angle. The bending that is left is a ten thousandth of
    the band's.
    """
    checks = []
    for law in laws_of("III"):
        for strain, angle in _WEDGES:
            scene = scene_of(
                {
                    "law": law,
                    "strain": strain,
                    "half_angle_deg": angle,
                    "bending_scale": _BENDING_SCALE,
                    "beads": _BEADS,
                }
            )
            done = release(plan_of(scene))
            limit, found = done.plan.string, _measured(done)
            name = f"{law} {strain:g}, {angle:g} deg: "
            kink = _kink_speed_m_s(done)
            checks += [
                Check("string", name + "V (m/s)", found.speed_m_s, limit.rear_speed_m_s, 1.5e-3),
                Check("string", name + "residual strain", found.residual_strain, limit.residual_strain, 1e-2),
                Check("string", name + "front speed (m/s)", found.front_m_s, limit.front_speed_m_s, 1e-3),
                Check("string", name + "kink speed (m/s)", found.kink_m_s, kink, 1.5e-2),
            ]
    return checks


@dataclass(frozen=True)
class _Wedge:
    speed_m_s: float
    residual_strain: float
    front_m_s: float
    kink_m_s: float


def _kink_speed_m_s(done: Released) -> float:
    """Exact speed of the kink in reference length."""
    limit = done.plan.string
    return math.sqrt(limit.residual_stress_pa / (done.plan.scene.band.density_kg_m3 * (1.0 + limit.residual_strain)))


def _measured(done: Released) -> _Wedge:
    """Speeds as slopes over frames from 0.4 to 0.85 of the front's arrival; the strain as a mean over them."""
    plan, limit = done.plan, done.plan.string
    times = done.frames.times_s(plan.timestep_s)
    chosen = np.flatnonzero((times > 0.4 * plan.front_arrival_s) & (times < 0.85 * plan.front_arrival_s))
    spacing = plan.scene.strand(plan.beads).spacing_m
    half = plan.beads // 2
    bonds = np.diff(done.frames.positions_m[chosen, : half + 1], axis=1)
    stretch = np.hypot(bonds[:, :, 0], bonds[:, :, 1]) / spacing
    direction = np.arctan2(bonds[:, :, 1], bonds[:, :, 0])
    middles = np.asarray(spacing * (np.arange(half) + 0.5), dtype=np.float64)

    halfway = 1.0 + 0.5 * (plan.scene.strain + limit.residual_strain)
    fronts = np.array([_crossing(row, halfway, middles) for row in stretch])
    # Behind the front and ahead of the kink: the middle half of what lies between.
    reach = limit.front_speed_m_s * times[chosen]
    behind = _kink_speed_m_s(done) * times[chosen]
    between = [
        row[(middles > 0.75 * low + 0.25 * high) & (middles < 0.25 * low + 0.75 * high)].mean()
        for row, low, high in zip(stretch, behind, reach, strict=True)
    ]
    turned = direction - plan.scene.half_angle_rad
    kinks = [
        spacing * row[middles < 0.5 * (low + high)].sum() / (0.5 * math.pi - plan.scene.half_angle_rad)
        for row, low, high in zip(turned, behind, reach, strict=True)
    ]
    return _Wedge(
        speed_m_s=done.measurement.fitted_speed_m_s.value,
        residual_strain=float(np.mean(between)) - 1.0,
        front_m_s=_slope(times[chosen], fronts),
        kink_m_s=_slope(times[chosen], np.array(kinks)),
    )


def _slope(times_s: Array, values: Array) -> float:
    """Slope of a line through all values, NaN where one of them is."""
    return float(np.polyfit(times_s, values, 1)[0]) if np.isfinite(values).all() else math.nan


def _crossing(values: Array, level: float, places: Array) -> float:
    """Where values first rise through a level, between the places around; NaN where they do not."""
    above = np.flatnonzero((values[1:] >= level) & (values[:-1] < level))
    if not len(above):
        return math.nan
    i = int(above[0])
    share = (level - values[i]) / (values[i + 1] - values[i])
    return float(places[i] + share * (places[i + 1] - places[i]))
