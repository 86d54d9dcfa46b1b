"""The Gent law, incompressible, in uniaxial tension (Gent 1996)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from beadband.model.laws import invariant
from beadband.model.laws.base import Law, constant
from beadband.model.laws.registry import register
from beadband.model.roots import root


@register
@dataclass(frozen=True)
class Gent(Law):
    """W = -mu Jm/2 ln(1 - I/Jm), I = I1 - 3 = s^2 + 2/s - 3, s the stretch; the modulus at rest is 3 mu.

    A. N. Gent, Rubber Chem. Technol. 69 (1996) 59. The chains are fully stretched, and the law locks, where I = Jm.
    """

    name = "gent"
    expression = "-0.5*{mu_pa}*{jm}*log(1-(s^2+2/s-3)/{jm})"
    ends_because = "its law locks"
    mu_pa: float = constant("μ", "Pa", "shear modulus at rest", above=0.0)
    jm: float = constant("Jm", "", "largest I1 - 3, where the chains lock", above=0.0)

    def longest_stretch(self) -> float:
        return root(lambda stretch: invariant.excess(stretch) - self.jm, 1.0, 2.0 + self.jm**0.5)

    def shortest_stretch(self) -> float:
        return root(lambda stretch: invariant.excess(stretch) - self.jm, 2.0 / (3.0 + self.jm), 1.0)

    def energy(self, stretch: Any) -> Any:
        return -0.5 * self.mu_pa * self.jm * np.log1p(-invariant.excess(stretch) / self.jm)

    def stress(self, stretch: Any) -> Any:
        return 0.5 * self.mu_pa * invariant.slope(stretch) / self._room(stretch)

    def tangent(self, stretch: Any) -> Any:
        room = self._room(stretch)
        return 0.5 * self.mu_pa / room * (invariant.curvature(stretch) + invariant.slope(stretch) ** 2 / room / self.jm)

    def _room(self, stretch: Any) -> Any:
        """Share of Jm that is left, 1 - I/Jm."""
        return 1.0 - invariant.excess(stretch) / self.jm
