"""Values with errors, and the fits that give them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_ROUNDING = 1e-9
"""Share of an interval by which times may be off through rounding."""


class Measured(NamedTuple):
    """A value with its standard error, in the same unit.

    ``f"{speed:.2f}"`` formats both numbers ("17.32 +/- 0.02"); ``str(speed)`` rounds both to the second digit of the
    error.
    """

    value: float
    error: float

    def __str__(self) -> str:
        if not 0.0 < self.error < math.inf:
            return f"{self.value:.6g} +/- {self.error:g}"
        return format(self, f".{max(0, 1 - math.floor(math.log10(self.error)))}f")

    def __format__(self, form: str) -> str:
        return f"{self.value:{form}} +/- {self.error:{form}}" if form else str(self)

    def scaled(self, factor: float) -> Measured:
        """The same in another unit."""
        return Measured(self.value * factor, self.error * abs(factor))


def slope(times_s: Array, values: Array, start_s: float, end_s: float, degree: int = 1) -> Measured:
    """Slope of a straight line through values (frames,) from ``start_s`` to ``end_s``, by least squares.

    Residuals are those of the line, or of a polynomial of this ``degree`` where values are known to bend smoothly.

    Its standard error takes the number of independent residuals from their lag-1 correlation, since those of a
    ringing tip are strongly correlated. ValueError for fewer than four points.
    """
    # A frame at an end of the interval belongs to it, whichever way its time was rounded.
    slack = _ROUNDING * (end_s - start_s)
    chosen = (times_s >= start_s - slack) & (times_s <= end_s + slack)
    t, v = times_s[chosen], values[chosen]
    if len(t) < 4:
        raise ValueError(f"{len(t)} frames between {start_s:.3g} and {end_s:.3g} s: a slope needs 4")
    mean = t.mean()
    spread = float(np.sum((t - mean) ** 2))
    rate = float(np.sum((t - mean) * v) / spread)
    residual = v - v.mean() - rate * (t - mean)
    if degree > 1:
        place = (t - mean) / (t[-1] - t[0])
        residual = residual - np.polyval(np.polyfit(place, residual, degree), place)
    power = float(np.sum(residual**2))
    variance = power / (len(t) - 2)
    lag = float(np.sum(residual[1:] * residual[:-1])) / power if power > 0.0 else 0.0
    inflation = (1.0 + max(lag, 0.0)) / (1.0 - min(lag, 1.0 - 1.0 / len(t)))
    return Measured(rate, math.sqrt(variance / spread * inflation))


def path_slope(times_s: Array, values: Array, start_s: float, end_s: float) -> float:
    """Slope of the straight line through a path between two times, by least squares over the time between them.

    The path is linear between its points (frames,), so the slope changes smoothly with them: which frames happen to
    lie in the window does not matter. ValueError where the path does not reach over the window, or has fewer than
    two points in it.
    """
    t, v = _between(times_s, values, start_s, end_s)
    middle = t - 0.5 * (start_s + end_s)
    # Integral of (t - middle of the window) x value over each piece, both linear in t.
    left, right, below, above = middle[:-1], middle[1:], v[:-1], v[1:]
    moment = float(np.sum((right - left) * (2.0 * (left * below + right * above) + left * above + right * below))) / 6.0
    return 12.0 * moment / (end_s - start_s) ** 3


def path_mean(times_s: Array, values: Array, start_s: float, end_s: float) -> float:
    """Mean of a path between two times, taken as linear between its points; ValueError as :func:`path_slope`."""
    t, v = _between(times_s, values, start_s, end_s)
    return float(np.sum(0.5 * (v[1:] + v[:-1]) * np.diff(t))) / (end_s - start_s)


def _between(times_s: Array, values: Array, start_s: float, end_s: float) -> tuple[Array, Array]:
    """The points of a path between two times, and its ends there: means of intervals end half of one too early."""
    inside = (times_s > start_s) & (times_s < end_s)
    short = end_s - float(times_s[-1])
    if inside.sum() < 2 or times_s[0] > start_s or short > times_s[-1] - times_s[-2]:
        raise ValueError(
            f"frames from {times_s[0]:.3g} to {times_s[-1]:.3g} s do not cover {start_s:.3g} to {end_s:.3g} s"
        )
    first, last = np.interp([start_s, end_s], times_s, values)
    if short > 0.0:
        last += short * (values[-1] - values[-2]) / (times_s[-1] - times_s[-2])
    return np.concatenate([[start_s], times_s[inside], [end_s]]), np.concatenate([[first], values[inside], [last]])


def hann_mean(times_s: Array, values: Array, centre_s: float, half_width_s: float) -> float:
    """Mean of values (frames,) under a Hann window around ``centre_s``; ValueError without frames in it."""
    near = np.abs(times_s - centre_s) < half_width_s
    weight = np.where(near, np.cos(0.5 * math.pi * (times_s - centre_s) / half_width_s) ** 2, 0.0)
    if not weight.sum() > 0.0:
        raise ValueError(f"no frame within {half_width_s:.3g} s of {centre_s:.3g} s")
    return float(np.sum(weight * values) / weight.sum())
