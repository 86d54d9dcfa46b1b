"""The prefactor of Eq. 7 without stretch: corners of small and large turning, released at rest."""

from __future__ import annotations

import math

import numpy as np

from beadband.analysis.curvature import curvatures
from beadband.analysis.fits import Measured
from beadband.model.beam import eq7_curvature
from beadband.studies.verification.specimen import bent, run, strand_of

HALF_ANGLES_DEG = (85.0, 60.0, 30.0, 14.0)
_SPACING_M = 2.5e-4
_BEADS = 800
"""Of each leg, so long that no wave returns from its end."""
_ROUNDING = 4.0
"""Standard deviation of the turning angle along the strand, in bead distances."""
_FROM_S, _UNTIL_S = 1e-3, 4e-3
"""Late against the rounding and against h/c0 of Band III (0.07 ms)."""
_FRAMES = 60


def prefactor(half_angle_deg: float) -> Measured:
    """Mean of the tip curvature over Eq. 7 in the window, and its standard deviation.

    An unstretched strand of Band III, linear law, is bent into a corner of two legs at the half-angle to both sides
    and released with both ends free. Stretching is included, for it carries the legs' axial inertia.
    """
    strand = strand_of("III", "linear", _SPACING_M)
    half_angle = math.radians(half_angle_deg)
    along = np.arange(-_BEADS, _BEADS + 1)
    turning = np.exp(-0.5 * (along / _ROUNDING) ** 2)
    specimen = bent(strand, (math.pi - 2.0 * half_angle) * turning / turning.sum())
    largest = 0.6 * strand.largest_step_s(0.0, 0.1, 0.9)
    every = math.ceil(_UNTIL_S / _FRAMES / largest)
    record = run(specimen, _UNTIL_S / _FRAMES / every, _FRAMES * every, every)
    tip = _BEADS
    before, at, after = (record.positions_m[:, tip + k] for k in (-1, 0, 1))
    kappa = curvatures(before, at, after, strand.spacing_m)
    late = record.times_s >= _FROM_S
    eq7 = eq7_curvature(record.times_s[late], half_angle, strand.bending_diffusivity_m2_s)
    ratio = kappa[late] / eq7
    return Measured(float(ratio.mean()), float(ratio.std(ddof=1)))
