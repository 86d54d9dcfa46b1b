"""The Mooney-Rivlin law, incompressible, in uniaxial tension (Mooney 1940, Rivlin 1948)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from beadband.model.laws.base import Law, constant
from beadband.model.laws.registry import register


@register
@dataclass(frozen=True)
class MooneyRivlin(Law):
    """W = C10 (s^2 + 2/s - 3) + C01 (2 s + 1/s^2 - 3), s the stretch; the modulus at rest is 6 (C10 + C01)."""

    name = "mooney-rivlin"
    table_error = math.inf  # its tables have the same points for every strain
    expression = "{c10_pa}*(s^2+2/s-3)+{c01_pa}*(2*s+1/s^2-3)"
    c10_pa: float = constant("C10", "Pa", "coefficient C10")
    c01_pa: float = constant("C01", "Pa", "coefficient C01")

    def energy(self, stretch: Any) -> Any:
        # Factored so that small strains do not cancel: s^2 + 2/s - 3 = (s-1)^2 (s+2)/s, and the like for C01.
        shape = (stretch - 1.0) ** 2 / stretch
        return shape * (self.c10_pa * (stretch + 2.0) + self.c01_pa * (2.0 * stretch + 1.0) / stretch)

    def stress(self, stretch: Any) -> Any:
        # Products of 1/s: a power of an array takes ten times as long.
        inverse = 1.0 / stretch
        return 2.0 * (stretch - inverse * inverse) * (self.c10_pa + self.c01_pa * inverse)

    def tangent(self, stretch: Any) -> Any:
        inverse = 1.0 / stretch
        cube = inverse * inverse * inverse
        return 2.0 * (self.c10_pa * (1.0 + 2.0 * cube) + 3.0 * self.c01_pa * cube * inverse)
