"""The second method of beadband: cubic finite elements and an implicit method in time, with nothing of the beads."""

from __future__ import annotations

import math
import time
from typing import TYPE_CHECKING

from beadband.errors import RunError
from beadband.model.scene import Scene
from beadband.studies.pareto.peers.protocol import Trace, end_s

if TYPE_CHECKING:
    from beadband.studies.pareto.peers.elements import Rod

LOSS = 0.02
"""Viscosity over (mean element length x density x front speed) of a law that unloads through a shock."""
STEPS_PER_ELEMENT = 5
_GROWTH = 4.0
"""Length of the last element over that of the first: the tip bends most."""


class FiniteElements:
    """Cubic Hermite elements, Alexander's implicit method of the third order, in numpy."""

    name = "finite elements"
    package: str | None = None
    laws: tuple[str, ...] | None = None
    ladder = (15, 30, 60, 120)
    quick = (15, 30, 60)
    note = "cubic Hermite elements graded 1 to 4, five steps an element, implicit, of third order; numpy"

    def run(self, scene: Scene, elements: int) -> Trace:
        """Release a leg."""
        from beadband.studies.pareto.peers import elements as method

        rod = rod_of(scene, elements)
        nodes = method.graded_nodes(scene.wedge.reference_leg_m, elements, _GROWTH)
        shape = method.held_shape(rod, 1.0 + scene.strain, scene.half_angle_rad, nodes, scene.tip_radius_m)
        start = time.perf_counter()
        mesh = method.Elements(rod, nodes)
        ready = time.perf_counter()
        try:
            found = method.follow(mesh, shape, nodes, end_s(scene), STEPS_PER_ELEMENT * elements)
        except RuntimeError as error:
            raise RunError(str(error)) from error
        done = time.perf_counter()
        return Trace(*found, loop_s=done - ready, whole_s=done - start)


def rod_of(scene: Scene, elements: int) -> Rod:
    """The band as a rod; the loss vanishes with the elements, and where no shock needs it there is none."""
    from beadband.studies.pareto.peers.elements import Rod

    strand, front = scene.strand(1000), scene.string.front_speed_m_s
    mean_m = scene.wedge.reference_leg_m / elements
    loss = LOSS * mean_m * strand.density_kg_m3 * front if scene.string.wave.shocks else 0.0
    return Rod(
        strand.law.stress,
        strand.law.tangent,
        strand.area_m2,
        strand.density_kg_m3,
        max(strand.bending_stiffness_n_m2, math.ulp(1.0)),
        loss,
    )
