"""The flight of a thrown band to the ground: gravity, and air that drags with the square of the speed.

With p the slope of the path and w its horizontal speed, drag |v| v/L and gravity g give dp/dt = -g/w and

    1/w^2 = 1/w0^2 + 2 [F(p0) - F(p)]/(g L),   F(p) = (p sqrt(1 + p^2) + asinh p)/2,

after Johann Bernoulli (1719); time, way and height are integrals over p. L = 2 M/(air density x drag area) is the
length over which drag takes the speed down to 1/e. With p = sinh(q) all of it stays smooth, however steep the path.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from beadband.model.bands import Band
from beadband.model.roots import root

GRAVITY_M_S2 = 9.80665
ROUND, FLAT = 1.2, 2.0
"""Drag coefficients across the flow at Reynolds numbers of some 1000: a circular cylinder, and a plate or a square."""
COEFFICIENT_ERROR = 0.15
"""Relative error of them: a rectangle 2/3 as deep as high has 2.6 (Nakaguchi, Hashimoto and Muto, 1968)."""
CIRCLE = 4.0 / (3.0 * math.pi)
"""Share of its circumference that a circle has across its flight in its own plane, by the cube of the cosine."""
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(80)


@dataclass(frozen=True)
class Flight:
    """A flight from the hand to the ground."""

    range_m: float
    time_s: float
    top_m: float
    """Highest point above the ground."""
    landing_speed_m_s: float


def fly(speed_m_s: float, elevation_rad: float, height_m: float = 0.0, drag_length_m: float = math.inf) -> Flight:
    """The flight of a body thrown at an elevation above the horizontal, from a height above the ground.

    ``drag_length_m`` is L of the module's text; without air it is infinite.
    """
    start = math.asinh(math.tan(elevation_rad))
    slow = 1.0 / (speed_m_s * math.cos(elevation_rad)) ** 2

    def along(end: float) -> tuple[float, float, float]:
        """Time, way and climb down to the slope sinh(end)."""
        q = 0.5 * (start + end) + 0.5 * (start - end) * _NODES
        dp = 0.5 * (start - end) * _WEIGHTS * np.cosh(q)
        w = 1.0 / np.sqrt(slow + _drop(start, q) / drag_length_m)
        sums = w @ dp, w**2 @ dp, (w**2 * np.sinh(q)) @ dp
        return tuple(float(each) / GRAVITY_M_S2 for each in sums)  # type: ignore[return-value]

    end = min(start, 0.0)
    top = height_m + along(end)[2]
    if top > 0.0:
        low = end - 1.0
        while height_m + along(low)[2] > 0.0:
            low -= 1.0
        end = root(lambda q: height_m + along(q)[2], low, end)
    time, way, _ = along(end)
    landing = math.cosh(end) / math.sqrt(slow + float(_drop(start, np.array(end))) / drag_length_m)
    return Flight(way, time, top, landing)


def _drop(start: float, q: np.ndarray) -> np.ndarray:
    """2 [F(p0) - F(p)]/g."""
    return np.asarray((0.5 * (math.sinh(2.0 * start) - np.sinh(2.0 * q)) + start - q) / GRAVITY_M_S2)


@dataclass(frozen=True)
class DragAreas:
    """Drag coefficient times the area across the flow, m2, for the ways in which a band can fly."""

    tumbling: float
    """All attitudes alike: what a range is computed with."""
    in_plane: float
    """Along its own plane, as it leaves the finger."""
    broadside: float
    """Along the axis of its ring."""

    @property
    def error(self) -> float:
        """Standard error of the first: attitudes between the extremes, and that of the coefficient."""
        spread = max(self.in_plane, self.broadside, self.tumbling) - min(self.in_plane, self.broadside, self.tumbling)
        return math.hypot(spread / math.sqrt(12.0), COEFFICIENT_ERROR * self.tumbling)


def drag_areas_m2(band: Band, coefficient: float | None = None, across: float = CIRCLE) -> DragAreas:
    """Drag areas of a band by the flow across its sides.

    ``across`` is the share of the circumference that the band has across its flight in the plane (:data:`CIRCLE`;
    that of a run comes from :func:`beadband.analysis.drag.cross_flow_m3_s2`). A flat side of the width b whose normal
    stands at the angle a to the flight has Cd b |cos a|^3 for each length, 1/4 in the mean over all attitudes; a round
    one, whose tangent stands at the angle c, Cd d sin(c)^3, 3 pi/16 in the mean.
    """
    thickness = band.thickness_m
    width = thickness if band.width_m is None else band.width_m
    round_section = band.section.kind in ("circle", "tube")
    drag = (ROUND if round_section else FLAT) if coefficient is None else coefficient
    mean = 3.0 * math.pi / 16.0 * thickness if round_section else 0.25 * (width + thickness)
    length = drag * band.circumference_m
    return DragAreas(length * mean, length * width * across, length * thickness)
