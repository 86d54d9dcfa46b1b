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


def slope(times_s: Array, values: Array, start_s: float, end_s: float) -> Measured:
    """Slope of a straight line through values (frames,) from ``start_s`` to ``end_s``, by least squares.

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
    power = float(np.sum(residual**2))
    variance = power / (len(t) - 2)
    lag = float(np.sum(residual[1:] * residual[:-1])) / power if power > 0.0 else 0.0
    inflation = (1.0 + max(lag, 0.0)) / (1.0 - min(lag, 1.0 - 1.0 / len(t)))
    return Measured(rate, math.sqrt(variance / spread * inflation))


def hann_mean(times_s: Array, values: Array, centre_s: float, half_width_s: float) -> float:
    """Mean of values (frames,) under a Hann window around ``centre_s``; ValueError without frames in it."""
    near = np.abs(times_s - centre_s) < half_width_s
    weight = np.where(near, np.cos(0.5 * math.pi * (times_s - centre_s) / half_width_s) ** 2, 0.0)
    if not weight.sum() > 0.0:
        raise ValueError(f"no frame within {half_width_s:.3g} s of {centre_s:.3g} s")
    return float(np.sum(weight * values) / weight.sum())
