"""A fine ring from a coarse one: its bonds' directions and stretches, interpolated along the band.

Newton's method and the search for the contact begin next to the answer then, so that the work for a long ring is
proportional to its beads.
"""

from __future__ import annotations

import numpy as np

from beadband.statics.chain import Array

_MIRRORED = 6
"""Bonds beyond each end of the half that the mirror image gives to the interpolation."""


def refined_half(coarse: Array, spacing_m: float, bonds: float, count: int) -> Array:
    """Positions of the upper half of a finer ring, shape (count, 2), finger's centre at the origin.

    Parameters
    ----------
    coarse
        Positions of the upper half of the coarse ring, shape (coarse beads, 2), the first on the mirror axis and an
        even number of beads in the ring: the last lies on the axis too.
    spacing_m
        Bead distance of the fine ring.
    bonds
        Bonds of half of the fine ring; a crossing bond counts half.
    """
    from scipy.interpolate import CubicSpline

    bond = np.diff(coarse, axis=0)
    length = np.hypot(bond[:, 0], bond[:, 1]) * (len(bond) / bonds)
    direction = np.unwrap(np.arctan2(bond[:, 1], bond[:, 0]))
    place = (np.arange(-_MIRRORED, len(bond) + _MIRRORED) + 0.5) / len(bond)
    # The directions are odd about both ends, where the band crosses the axis at a right angle; stretches are even.
    turned = [np.pi - direction[:_MIRRORED][::-1], direction, -np.pi - direction[-_MIRRORED:][::-1]]
    even = [length[:_MIRRORED][::-1], length, length[-_MIRRORED:][::-1]]
    at = (np.arange(count - 1) + 0.5) / bonds
    angle = CubicSpline(place, np.concatenate(turned))(at)
    fine = CubicSpline(place, np.concatenate(even))(at)
    steps = fine[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return np.concatenate([coarse[:1], coarse[:1] + np.cumsum(steps, axis=0)])
