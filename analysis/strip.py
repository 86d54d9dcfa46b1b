"""A strip released at one end: the path of its front, and the impulse of the end that is held."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from beadband.analysis.fits import Array, Measured, slope
from beadband.analysis.readers import Pull


class Front(NamedTuple):
    """The front over a window of time; errors are those of the fits."""

    speed_m_s: Measured
    """In reference length."""
    arrival_s: Measured
    """When its path, carried on, reaches the end of the strip."""


def crossings(stretch: Array, level: float, spacing_m: float) -> Array:
    """Where the stretch last rises through a level, m in reference length, shape (frames,); NaN where it does not.

    ``stretch`` of the bonds from the released end on, shape (frames, bonds), straight between their middles.
    """
    below = stretch < level
    last = below.shape[1] - 1 - np.argmax(below[:, ::-1], axis=1)
    frames = np.arange(len(stretch))
    following = np.minimum(last + 1, below.shape[1] - 1)
    low, high = stretch[frames, last], stretch[frames, following]
    rises = below.any(axis=1) & (following > last)
    share = np.where(rises, (level - low) / np.where(rises, high - low, 1.0), np.nan)
    return np.asarray(spacing_m * (last + 0.5 + share), dtype=np.float64)


def front(times_s: Array, path_m: Array, length_m: float, start_s: float, end_s: float) -> Front:
    """Speed of a front and its arrival at the end of the strip, from its path (frames,) between two times.

    ValueError where fewer than four frames show it.
    """
    seen = np.isfinite(path_m)
    times, path = times_s[seen], path_m[seen]
    speed = slope(times, path, start_s, end_s)
    chosen = (times >= start_s) & (times <= end_s)
    middle, place = float(times[chosen].mean()), float(path[chosen].mean())
    ahead = length_m - place
    arrival = middle + ahead / speed.value
    # The middle of the line is known better than its slope by the spread of the times.
    spread = float(times[chosen].std())
    at_middle = speed.error * spread
    return Front(speed, Measured(arrival, math.hypot(at_middle, ahead / speed.value * speed.error) / speed.value))


def impulse(pull: Pull, timestep_s: float) -> Array:
    """Impulse of the held end on the strip since the release, N s, shape (lines,), by the rule of velocity Verlet.

    Each step adds half of the force at its beginning and half of that at its end.
    """
    intervals: NDArray[np.int64] = np.diff(pull.steps, prepend=0)
    whole = np.cumsum(pull.mean_force_n * intervals)
    return np.asarray(-timestep_s * (whole + 0.5 * (pull.force_n[0] - pull.force_n)), dtype=np.float64)
