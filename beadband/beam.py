"""Closed forms of the released beam kink: Eq. 7 of the paper, and the linear beam released at rest."""

from __future__ import annotations

import math
from typing import Any


def eq7_curvature(time_s: Any, half_angle_rad: float, diffusivity_m2_s: float) -> Any:
    """Tip curvature of the paper's Eq. 7, (pi - 2 phi)/sqrt(2 pi) / sqrt(a_b t), 1/m; float or array of times."""
    return (math.pi - 2.0 * half_angle_rad) / (2.0 * math.pi * diffusivity_m2_s * time_s) ** 0.5


def at_rest_curvature(time_s: Any, half_angle_rad: float, diffusivity_m2_s: float) -> Any:
    """Tip curvature of a linear beam kink released at rest: exactly half of Eq. 7, 1/m."""
    return 0.5 * eq7_curvature(time_s, half_angle_rad, diffusivity_m2_s)
