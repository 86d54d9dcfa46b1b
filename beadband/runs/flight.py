"""What becomes of a launched band: its flight to the ground, from the speed and the shape that the run ends with."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from beadband.analysis.drag import cross_flow_m3_s2
from beadband.analysis.fits import Measured
from beadband.model.flight import GRAVITY_M_S2, DragAreas, Flight, drag_areas_m2, fly

if TYPE_CHECKING:
    from beadband.runs.launch_results import Launch


@dataclass(frozen=True)
class Throw:
    """The flight of a launch, in air and without."""

    speed_m_s: float
    """Of the centre of mass, with which the flight begins."""
    flight: Flight
    range: Measured
    """With the errors of the throw, of the attitude in flight and of the drag coefficient."""
    vacuum: Flight
    areas: DragAreas
    drag_length_m: float | None
    """Over which drag takes the speed down to 1/e; None without air."""
    terminal_speed_m_s: float | None
    across: float
    """Share of the circumference that lies across the flight in the plane, mean from the finger's freedom on."""
    launch_drag: float
    """Momentum that the air takes until the end of the run, over that of the band: it is left out of the launch."""


def throw_of(done: Launch) -> Throw | None:
    """The flight of a launch; None where none is asked for, or where the finger never became free."""
    scene, free = done.scene, done.found.finger_free_s
    if scene.elevation_deg is None or free is None:
        return None
    band, air, elevation = scene.band, scene.air_density_kg_m3, math.radians(scene.elevation_deg)
    times, positions = done.ring.times_s, done.ring.positions_m
    flow, interval = cross_flow_m3_s2(times, positions)[:, 0], np.diff(times)
    found = done.figures["centre_of_mass_speed_m_s"]
    speed = found if isinstance(found, Measured) else Measured(float(found or 0.0), 0.0)
    flying = times[1:] > free
    across = float(np.mean(flow[flying])) / (speed.value**2 * band.circumference_m)
    areas = drag_areas_m2(band, scene.drag_coefficient, across)

    def reach(speed_m_s: float, area_m2: float) -> Flight:
        return fly(speed_m_s, elevation, scene.height_m, length(area_m2))

    def length(area_m2: float) -> float:
        return 2.0 * band.mass_kg / (air * area_m2) if air * area_m2 > 0.0 else math.inf

    flight, drag_length = reach(speed.value, areas.tumbling), length(areas.tumbling)
    step = 1e-3 * speed.value
    by_speed = (reach(speed.value + step, areas.tumbling).range_m - flight.range_m) / step * speed.error
    ends = (reach(speed.value, max(areas.tumbling + sign * areas.error, 0.0)).range_m for sign in (-1.0, 1.0))
    by_air = 0.5 * abs(next(ends) - next(ends))
    in_plane = areas.in_plane / (band.circumference_m * across)  # coefficient times width
    air_momentum = 0.5 * air * in_plane * float(np.sum(flow * interval))
    return Throw(
        speed_m_s=speed.value,
        flight=flight,
        range=Measured(flight.range_m, math.hypot(by_speed, by_air)),
        vacuum=reach(speed.value, 0.0),
        areas=areas,
        drag_length_m=drag_length if math.isfinite(drag_length) else None,
        terminal_speed_m_s=math.sqrt(GRAVITY_M_S2 * drag_length) if math.isfinite(drag_length) else None,
        across=across,
        launch_drag=air_momentum / done.found.momentum_n_s,
    )
