"""How launches converge: the same scene with ever more beads, and the orders of what they find."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

from beadband.model.scene import Scene

BEADS = (120, 240, 480, 960)
QUANTITIES = ("centre_of_mass_speed_m_s", "efficiency", "finger_free_s", "rear_arrival_s", "pause_s")
_MOST_ORDER = 20.0


@dataclass(frozen=True)
class Ladder:
    """One quantity over a ladder of beads."""

    quantity: str
    beads: tuple[int, ...]
    values: tuple[float, ...]

    @property
    def order(self) -> float:
        """Order p in the bead distance, from the first and the last difference; nan below three rungs.

        With errors that fall as beads^(-p), the difference between rungs of n and m beads is n^(-p) - m^(-p) times a
        constant, whatever the ratios of the rungs. nan where a difference vanishes, or for no p from -20 to 20.
        """
        if len(self.values) < 3:
            return math.nan
        first, last = (abs(self.values[i + 1] - self.values[i]) for i in (0, -2))
        if not (first > 0.0 and last > 0.0):
            return math.nan
        growth = math.log(self.beads[-2] / self.beads[0])
        widths = math.log(self.beads[1] / self.beads[0]), math.log(self.beads[-1] / self.beads[-2])

        def excess(order: float) -> float:
            """Log of the ratio of the two differences for this order, over the measured one; rises with the order."""
            near, far = (-math.expm1(-order * width) if order else width for width in widths)
            return order * growth + math.log(near / far) - math.log(first / last)

        if excess(-_MOST_ORDER) > 0.0 or excess(_MOST_ORDER) < 0.0:
            return math.nan
        from scipy.optimize import brentq

        return float(brentq(excess, -_MOST_ORDER, _MOST_ORDER))


def ladder(scene: Scene, beads: Sequence[int] = BEADS) -> list[Ladder]:
    """Launch the scene with each number of beads, fewest first; a quantity that is missing on a rung is left out.

    A loss time of the user's stays. One that a plan chose goes with the mesh, and convergence is then of its order.
    """
    from beadband.runs.launch import follow_launch

    rungs = tuple(sorted(beads))
    found = [follow_launch(replace(scene.with_beads(count), until="launch"))[1] for count in rungs]
    columns = {name: tuple(getattr(measured, name) for measured in found) for name in QUANTITIES}
    return [Ladder(name, rungs, values) for name, values in columns.items() if None not in values]


def table(ladders: Sequence[Ladder]) -> str:
    """The ladders as lines for a person."""
    head = "beads".ljust(26) + "".join(f"{count:>12d}" for count in ladders[0].beads) + "   order"
    lines = [
        one.quantity.ljust(26) + "".join(f"{value:12.6g}" for value in one.values) + f"{one.order:8.2f}"
        for one in ladders
    ]
    return "\n".join([head, *lines])
