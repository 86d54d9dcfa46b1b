"""How launches converge: the same scene with ever more beads, and the orders of what they find."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from beadband.scene import Scene

BEADS = (120, 240, 480, 960)
QUANTITIES = ("centre_of_mass_speed_m_s", "efficiency", "finger_free_s", "rear_arrival_s", "pause_s")


@dataclass(frozen=True)
class Ladder:
    """One quantity over a ladder of beads."""

    quantity: str
    beads: tuple[int, ...]
    values: tuple[float, ...]

    @property
    def order(self) -> float:
        """Mean order in the bead distance, from the first and the last of the differences; nan below three rungs.

        Differences d between rungs that each have r times the beads of the one before fall as r^(-order).
        """
        if len(self.values) < 3:
            return math.nan
        differences = [abs(after - before) for before, after in zip(self.values, self.values[1:], strict=False)]
        if not differences[0] > 0.0 or not differences[-1] > 0.0:
            return math.nan
        return math.log(differences[0] / differences[-1]) / math.log(self.beads[-2] / self.beads[0])


def ladder(scene: Scene, beads: Sequence[int] = BEADS) -> list[Ladder]:
    """Launch the scene with each number of beads; a quantity that is missing on a rung is left out.

    A loss time of the user's stays; the numerical one goes with the mesh, and convergence is then of its order.
    """
    from beadband.launching.launch import follow_launch

    found = []
    for count in beads:
        bare = replace(
            scene, beads=count, timestep_s=None, frames=None, steps=None, rear_steps=None, planned=(), until="launch"
        )
        found.append(follow_launch(bare)[1])
    ladders = []
    for name in QUANTITIES:
        values = [getattr(measured, name) for measured in found]
        if None not in values:
            ladders.append(Ladder(name, tuple(beads), tuple(values)))
    return ladders


def table(ladders: Sequence[Ladder]) -> str:
    """The ladders as lines for a person."""
    head = "beads".ljust(26) + "".join(f"{count:>12d}" for count in ladders[0].beads) + "   order"
    lines = [
        one.quantity.ljust(26) + "".join(f"{value:12.6g}" for value in one.values) + f"{one.order:8.2f}"
        for one in ladders
    ]
    return "\n".join([head, *lines])
