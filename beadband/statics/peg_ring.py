"""The stretched ring whose tip is held by a round peg.

Half-way up its legs a ring is straight and carries T, whatever holds the tip: there the tip on a peg takes the place of
the point-held one. The point-held ring is solved with its tip off the mirror axis, by what the two tips differ across
it, so that the finger's radius is that of a ring on a peg.
"""

from __future__ import annotations

import numpy as np

from beadband.errors import UsageError, explain
from beadband.model.calibration import Strand
from beadband.model.peg import Peg
from beadband.statics.leg import LegRequest
from beadband.statics.peg import RING_TIP, peg_leg
from beadband.statics.ring import Ring, UpperHalf

BOUND = 1e-5
"""Largest net force on a bead, over the tension; what bending leaves of it in the middle of the legs, mostly 1e-11."""


def peg_ring(strand: Strand, beads: int, strain: float, half_angle_rad: float, peg: Peg) -> Ring:
    """Solve for the stretched ring on a peg.

    Errors as :func:`beadband.statics.ring.stretched_ring`; UsageError also where the legs are straight nowhere.
    """
    _, _, first = UpperHalf(strand, beads, strain, half_angle_rad).first_guess()
    request = LegRequest(strand, first, strain, half_angle_rad)
    held, on_peg = peg_leg(request, peg, RING_TIP)
    pointed, _ = peg_leg(request, None, RING_TIP)
    height = float(held.positions_m[-1, 1] - pointed.positions_m[-1, 1])
    half = UpperHalf(strand, beads, strain, half_angle_rad, height)
    points, radius, first = half.held()
    middle = min((on_peg + first) // 2, request.bonds)
    rear = held.positions_m[: middle + 1]
    points = np.concatenate([rear + (points[middle] - rear[-1]), points[middle + 1 :]])
    # Beads on the circle may slide along it; what pushes them off it is the peg's.
    loads = half.loads(points) / half.tension
    outward = points[1:on_peg] - (points[0] + np.array([peg.radius_m, 0.0]))
    along = (loads[1:on_peg, 1] * outward[:, 0] - loads[1:on_peg, 0] * outward[:, 1]) / peg.radius_m
    free = loads[on_peg:first]
    net_force = max(float(np.hypot(free[:, 0], free[:, 1]).max()), float(np.abs(along).max(initial=0.0)))
    if not net_force <= BOUND:
        raise UsageError(
            explain(
                "the legs are too short, and bent all along, to be held by a peg",
                f"a net force of {net_force:.1e} of the tension in their middle",
                f"{BOUND:.0e}",
                "lower --thickness, --half-angle or --tip-radius",
            ),
            "bent-legs-on-peg",
        )
    return half.laid_out(points, radius, first, net_force)
