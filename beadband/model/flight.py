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
from numpy.typing import NDArray

from beadband.model.bands import Band
from beadband.model.roots import root

Array = NDArray[np.float64]

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
    curve = _Curve(speed_m_s, elevation_rad, drag_length_m)
    end = curve.landing(height_m)
    time, way, _ = curve.along(end)
    landing = math.cosh(end) * float(curve.horizontal_m_s(np.array(end)))
    return Flight(way, time, height_m + curve.along(min(curve.start, 0.0))[2], landing)


def path_m(
    speed_m_s: float, elevation_rad: float, height_m: float = 0.0, drag_length_m: float = math.inf, points: int = 81
) -> Array:
    """Places (points, 2) along that flight: the way along the ground, and the height above it."""
    curve = _Curve(speed_m_s, elevation_rad, drag_length_m)
    ends = np.linspace(curve.start, curve.landing(height_m), points)
    places = [curve.along(end)[1:] for end in ends.tolist()]
    return np.asarray(np.array(places) + np.array([0.0, height_m]), dtype=np.float64)


@dataclass(frozen=True)
class _Curve:
    """A path by the variable q of its slope p = sinh(q), which falls from ``start`` on."""

    speed_m_s: float
    elevation_rad: float
    drag_length_m: float

    @property
    def start(self) -> float:
        return math.asinh(math.tan(self.elevation_rad))

    def horizontal_m_s(self, q: Array) -> Array:
        """Horizontal speed w."""
        dropped = 0.5 * (math.sinh(2.0 * self.start) - np.sinh(2.0 * q)) + self.start - q  # 2 [F(p0) - F(p)]
        slow = 1.0 / (self.speed_m_s * math.cos(self.elevation_rad)) ** 2
        return np.asarray(1.0 / np.sqrt(slow + dropped / (GRAVITY_M_S2 * self.drag_length_m)))

    def along(self, end: float) -> tuple[float, float, float]:
        """Time, way and climb down to the slope sinh(end)."""
        half = 0.5 * (self.start - end)
        q = end + half * (1.0 + _NODES)
        dp, w = half * _WEIGHTS * np.cosh(q) / GRAVITY_M_S2, self.horizontal_m_s(q)
        return float(w @ dp), float(w**2 @ dp), float((w**2 * np.sinh(q)) @ dp)

    def landing(self, height_m: float) -> float:
        """The q at the ground."""
        low = min(self.start, 0.0)
        if height_m + self.along(low)[2] <= 0.0:
            return low
        high = low
        while height_m + self.along(low)[2] > 0.0:
            low -= 1.0
        return root(lambda q: height_m + self.along(q)[2], low, high)


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
