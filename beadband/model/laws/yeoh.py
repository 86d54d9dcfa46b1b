"""The Yeoh law, incompressible, in uniaxial tension (Yeoh 1993)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from beadband.model.laws import invariant
from beadband.model.laws.base import Law, constant
from beadband.model.laws.registry import register


@register
@dataclass(frozen=True)
class Yeoh(Law):
    """W = C1 I + C2 I^2 + C3 I^3, I = I1 - 3 = s^2 + 2/s - 3, s the stretch; the modulus at rest is 6 C1.

    O. H. Yeoh, Rubber Chem. Technol. 66 (1993) 754. Usually C2 < 0 < C3: the law softens, then stiffens. A C2 that is
    too negative makes the tension fall between a peak and a trough.
    """

    name = "yeoh"
    expression = "{c1_pa}*(s^2+2/s-3)+{c2_pa}*(s^2+2/s-3)^2+{c3_pa}*(s^2+2/s-3)^3"
    c1_pa: float = constant("C1", "Pa", "coefficient C1", above=0.0)
    c2_pa: float = constant("C2", "Pa", "coefficient C2")
    c3_pa: float = constant("C3", "Pa", "coefficient C3")

    def energy(self, stretch: Any) -> Any:
        excess = invariant.excess(stretch)
        return excess * (self.c1_pa + excess * (self.c2_pa + excess * self.c3_pa))

    def stress(self, stretch: Any) -> Any:
        return invariant.slope(stretch) * self._rise(invariant.excess(stretch))

    def tangent(self, stretch: Any) -> Any:
        excess = invariant.excess(stretch)
        bend = 2.0 * self.c2_pa + 6.0 * self.c3_pa * excess
        return invariant.curvature(stretch) * self._rise(excess) + invariant.slope(stretch) ** 2 * bend

    def _rise(self, excess: Any) -> Any:
        """dW/dI1."""
        return self.c1_pa + excess * (2.0 * self.c2_pa + 3.0 * self.c3_pa * excess)
