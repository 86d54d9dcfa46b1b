"""What the rear tip does: its speed, and the curvature of the band there."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Measured(NamedTuple):
    """A value with its standard error, in the same unit."""

    value: float
    error: float


def slope(times_s: Array, values: Array, start_s: float, end_s: float) -> Measured:
    """Slope of a straight line through the values (frames,) from ``start_s`` to ``end_s``, by least squares.

    The error is that of the fit, with the number of independent residuals taken from their lag-1 correlation, for
    the residuals of a ringing tip are anything but independent. Raises ValueError below four points.
    """
    chosen = (times_s >= start_s) & (times_s <= end_s)
    t, v = times_s[chosen], values[chosen]
    if len(t) < 4:
        raise ValueError(f"{len(t)} frames between {start_s:.3g} and {end_s:.3g} s: a slope needs 4")
    mean = t.mean()
    spread = float(np.sum((t - mean) ** 2))
    rate = float(np.sum((t - mean) * v) / spread)
    residual = v - v.mean() - rate * (t - mean)
    variance = float(np.sum(residual**2)) / (len(t) - 2)
    power = float(np.sum(residual**2))
    lag = float(np.sum(residual[1:] * residual[:-1])) / power if power > 0.0 else 0.0
    inflation = (1.0 + max(lag, 0.0)) / (1.0 - min(lag, 1.0 - 1.0 / len(t)))
    return Measured(rate, math.sqrt(variance / spread * inflation))


def speeds(times_s: Array, positions_m: Array) -> Array:
    """Speed over time (frames,), by central differences."""
    return np.asarray(np.gradient(positions_m, times_s), dtype=np.float64)


def curvatures(before_m: Array, tip_m: Array, after_m: Array, spacing_m: float) -> Array:
    """Curvature at a bead, turning angle over reference spacing, 1/m; positions of shape (frames, 2)."""
    first, second = tip_m - before_m, after_m - tip_m
    cross = first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0]
    dot = np.sum(first * second, axis=1)
    angles: Array = np.abs(np.arctan2(cross, dot))
    return angles / spacing_m


def hann_mean(times_s: Array, values: Array, centre_s: float, half_width_s: float) -> float:
    """Mean of the values (frames,) under a Hann window around ``centre_s``; ValueError without frames in it."""
    near = np.abs(times_s - centre_s) < half_width_s
    weight = np.where(near, np.cos(0.5 * math.pi * (times_s - centre_s) / half_width_s) ** 2, 0.0)
    if not weight.sum() > 0.0:
        raise ValueError(f"no frame within {half_width_s:.3g} s of {centre_s:.3g} s")
    return float(np.sum(weight * values) / weight.sum())


@dataclass(frozen=True)
class Decay:
    """How the tip curvature falls inside a window."""

    exponent: Measured
    """Power of time; -1/2 for a self-similar beam."""
    eq7_ratio: Measured
    """Curvature over that of Eq. 7, mean over the window and standard deviation of that mean."""


def decay(times_s: Array, curvatures_1_m: Array, eq7_1_m: Array, start_s: float, end_s: float) -> Decay:
    """Exponent and prefactor of the curvature (frames,) between ``start_s`` and ``end_s``.

    Raises ValueError below four frames in the window, or when the curvature vanishes in it.
    """
    chosen = (times_s >= start_s) & (times_s <= end_s)
    t, kappa, eq7 = times_s[chosen], curvatures_1_m[chosen], eq7_1_m[chosen]
    if len(t) < 4:
        raise ValueError(f"{len(t)} frames in the window from {start_s:.3g} to {end_s:.3g} s: a fit needs 4")
    if not kappa.min() > 0.0:
        raise ValueError("the tip curvature vanishes inside the window")
    exponent = slope(np.log(t), np.log(kappa), math.log(start_s), math.log(end_s))
    ratio = kappa / eq7
    # Neighbouring frames ring together: count one independent value for each quarter of the window.
    return Decay(exponent, Measured(float(ratio.mean()), float(ratio.std(ddof=1)) / 2.0))
