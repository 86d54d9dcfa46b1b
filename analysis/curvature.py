"""Curvature of a chain of beads, and how that of the rear tip decays."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from beadband.analysis.fits import Array, Measured, path_mean, slope


def curvatures(before_m: Array, tip_m: Array, after_m: Array, spacing_m: float) -> Array:
    """Curvature at a bead, 1/m, shape (frames,): turning angle over reference spacing, without sign.

    The bead and its neighbours have positions of shape (frames, 2).
    """
    return np.abs(_turning_angles(tip_m - before_m, after_m - tip_m)) / spacing_m


def ring_curvature(positions_m: Array, spacing_m: float) -> Array:
    """Curvature at each bead of a closed chain, 1/m, shape (frames, beads), from positions (frames, beads, 2).

    Turning angle over reference spacing, positive on the finger, whichever way the beads are counted.
    """
    after = np.roll(positions_m, -1, axis=1) - positions_m
    angles = _turning_angles(np.roll(after, 1, axis=1), after)
    return np.asarray(np.sign(angles[0].sum()) * angles / spacing_m, dtype=np.float64)


def bond_stretch(positions_m: Array, spacing_m: float, closed: bool = True) -> Array:
    """Stretch of the bond from each bead to the next, shape (frames, beads), of positions (frames, beads, 2).

    An open chain has a bond less than beads.
    """
    bonds = np.roll(positions_m, -1, axis=1) - positions_m if closed else np.diff(positions_m, axis=1)
    return np.asarray(np.hypot(bonds[..., 0], bonds[..., 1]) / spacing_m, dtype=np.float64)


def _turning_angles(first: Array, second: Array) -> Array:
    cross = first[..., 0] * second[..., 1] - first[..., 1] * second[..., 0]
    return np.asarray(np.arctan2(cross, np.sum(first * second, axis=-1)), dtype=np.float64)


@dataclass(frozen=True)
class Decay:
    """How the tip curvature falls inside a window; errors are those of the fits."""

    exponent: Measured
    """Power of time; -1/2 for a self-similar beam."""
    eq7_ratio: Measured
    """Curvature over that of Eq. 7, mean over the window and standard deviation of that mean."""


def decay(times_s: Array, curvatures_1_m: Array, eq7_1_m: Array, start_s: float, end_s: float) -> Decay:
    """Exponent and prefactor of a curvature between ``start_s`` and ``end_s``; arrays of shape (frames,).

    ValueError for fewer than four frames in the window, or when the curvature vanishes in it.
    """
    chosen = (times_s >= start_s) & (times_s <= end_s)
    t, kappa, eq7 = times_s[chosen], curvatures_1_m[chosen], eq7_1_m[chosen]
    if len(t) < 4:
        raise ValueError(f"{len(t)} frames in the window from {start_s:.3g} to {end_s:.3g} s: a fit needs 4")
    if not kappa.min() > 0.0:
        raise ValueError("the tip curvature vanishes inside the window")
    exponent = slope(np.log(t), np.log(kappa), math.log(start_s), math.log(end_s))
    ratio = kappa / eq7
    # Neighbouring frames are correlated: one independent value is counted for each quarter of the window.
    over_time = path_mean(times_s, curvatures_1_m / eq7_1_m, start_s, end_s)
    return Decay(exponent, Measured(over_time, float(ratio.std(ddof=1)) / 2.0))
