"""The rear tip over time: path, speed and curvature."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from beadband.analysis.curvature import curvatures
from beadband.analysis.fits import Array


@dataclass(frozen=True)
class Rear:
    """The rear tip over time; arrays of shape (frames,)."""

    times_s: Array
    tip_x_m: Array
    tip_speed_m_s: Array
    tip_curvature_1_m: Array
    tip_y_m: Array
    """Distance from the axis of symmetry, with sign."""

    @property
    def asymmetry_m(self) -> float:
        """Largest distance of the tip from the axis of symmetry."""
        return self.aside_m(np.inf)

    def aside_m(self, until_s: float) -> float:
        """Largest distance of the tip from the axis up to a time."""
        return float(np.abs(self.tip_y_m[self.times_s <= until_s]).max())


def rear_of(times_s: Array, before_m: Array, tip_m: Array, after_m: Array, spacing_m: float) -> Rear:
    """The tip's path, speed (central differences) and curvature.

    The tip and its neighbours have positions of shape (frames, 2), of which x is along the axis of symmetry;
    ``spacing_m`` is the reference distance of the beads.
    """
    return Rear(
        times_s=times_s,
        tip_x_m=tip_m[:, 0],
        tip_speed_m_s=np.asarray(np.gradient(tip_m[:, 0], times_s), dtype=np.float64),
        tip_curvature_1_m=curvatures(before_m, tip_m, after_m, spacing_m),
        tip_y_m=tip_m[:, 1],
    )
