"""The whole ring, or strip, over time, from its trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from beadband.analysis.curvature import bond_stretch, ring_curvature
from beadband.analysis.fits import Array
from beadband.analysis.readers import Trajectory, read


@dataclass(frozen=True)
class RingFrames:
    """The whole ring, or an open strip, over time, read from the trajectory when first asked for.

    All frames but the first are averages over the interval before them, at the middle of it.
    """

    path: Path
    timestep_s: float
    spacing_m: float
    """Reference distance of the beads."""
    closed: bool = True
    """Whether a bond joins the last bead to the first."""

    @cached_property
    def trajectory(self) -> Trajectory:
        """The frames as they were written; ReadError when they can't be read."""
        return read(self.path)

    @cached_property
    def times_s(self) -> Array:
        """Time of each frame, shape (frames,)."""
        return self.trajectory.times_s(self.timestep_s)

    @property
    def positions_m(self) -> Array:
        """Positions of the beads, shape (frames, beads, 2); bead 0 is the rear tip."""
        return self.trajectory.positions_m

    @cached_property
    def stretch(self) -> Array:
        """Stretch of the bond from each bead to the next, shape (frames, beads); of a strip one less."""
        return bond_stretch(self.positions_m, self.spacing_m, self.closed)

    @cached_property
    def curvature_1_m(self) -> Array:
        """Curvature at each bead, 1/m, shape (frames, beads); positive where the ring bends around its inside.

        A strip is straight, and has none.
        """
        if not self.closed:
            return np.zeros(self.positions_m.shape[:2])
        return ring_curvature(self.positions_m, self.spacing_m)
