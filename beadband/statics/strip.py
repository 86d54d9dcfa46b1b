"""The stretched strip: a straight chain of beads of one stretch, held at both ends."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beadband.model.calibration import Strand
from beadband.statics.chain import Array
from beadband.statics.ring import TIP, UPPER, WRAPPED


@dataclass(frozen=True)
class Strip:
    """A stretched strip; positions in m, from the end that is released at the origin along the x axis."""

    positions_m: Array
    """Shape (bonds + 1, 2)."""
    types: NDArray[np.int64]
    """Those of a ring: the released end a tip, the held end the one bead on the finger."""
    tension_n: float
    net_force: float
    """Largest net force on a bead between the ends, over the tension."""
    stretching_j: float
    bending_j: float = 0.0

    @property
    def beads(self) -> int:
        return len(self.positions_m)


def stretched_strip(strand: Strand, bonds: int, strain: float) -> Strip:
    """The strip of so many equal bonds: uniform stretch is its equilibrium under any law."""
    law, area = strand.law, strand.area_m2
    positions = np.zeros((bonds + 1, 2))
    positions[:, 0] = (1.0 + strain) * strand.spacing_m * np.arange(bonds + 1)
    types = np.full(bonds + 1, UPPER)
    types[[0, -1]] = TIP, WRAPPED
    stretch = np.diff(positions[:, 0]) / strand.spacing_m
    tension = area * float(law.stress(1.0 + strain))
    return Strip(
        positions_m=positions,
        types=types,
        tension_n=tension,
        net_force=float(np.abs(np.diff(area * law.stress(stretch))).max()) / tension,
        stretching_j=float(np.sum(area * strand.spacing_m * law.energy(stretch))),
    )
