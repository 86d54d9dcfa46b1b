"""The linear law: nominal stress proportional to strain."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from beadband.model.laws.base import Law, constant
from beadband.model.laws.registry import register


@register
@dataclass(frozen=True)
class Linear(Law):
    """W = E/2 (s - 1)^2, s the stretch."""

    name = "linear"
    table_error = math.inf  # its tables have the same points for every strain
    expression = "0.5*{modulus_pa}*(s-1)^2"
    modulus_pa: float = constant("E", "Pa", "Young's modulus", above=0.0)

    def energy(self, stretch: Any) -> Any:
        return 0.5 * self.modulus_pa * (stretch - 1.0) ** 2

    def stress(self, stretch: Any) -> Any:
        return self.modulus_pa * (stretch - 1.0)

    def tangent(self, stretch: Any) -> Any:
        return self.modulus_pa + 0.0 * stretch
