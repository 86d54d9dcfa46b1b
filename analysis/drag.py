"""The air that a moving band meets across its length: arrays in, arrays out."""

from __future__ import annotations

import numpy as np

from beadband.analysis.fits import Array


def cross_flow_m3_s2(times_s: Array, positions_m: Array) -> Array:
    """Integral of |v_n| v_n n along a closed chain (frames, beads, 2), for each interval between frames.

    v_n is the velocity of a bond along its normal n in the plane: only flow across a slender body drags it (the
    cross-flow principle, S. F. Hoerner, Fluid-Dynamic Drag, 1965, chapter 3). Shape (frames - 1, 2); times (1/2)
    (density of the air) (drag coefficient) (width) it is the force against the motion. A circle of circumference C
    that moves at the speed v has 4/(3 pi) C v^2.
    """
    velocity = np.diff(positions_m, axis=0) / np.diff(times_s)[:, None, None]
    middle = 0.5 * (positions_m[1:] + positions_m[:-1])
    bond = np.roll(middle, -1, axis=1) - middle
    across = np.stack([-bond[..., 1], bond[..., 0]], axis=-1)
    length = np.linalg.norm(bond, axis=-1)
    speed = np.sum(0.5 * (velocity + np.roll(velocity, -1, axis=1)) * across, axis=-1) / length
    flow: Array = np.sum((np.abs(speed) * speed)[..., None] * across, axis=1)
    return flow
