"""The neo-Hookean law, incompressible, in uniaxial tension (Treloar 1943, Rivlin 1948)."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from beadband.model.laws import invariant
from beadband.model.laws.base import Law, constant
from beadband.model.laws.registry import register


@register
@dataclass(frozen=True)
class NeoHookean(Law):
    """W = mu/2 (s^2 + 2/s - 3), s the stretch; the modulus at rest is 3 mu.

    The network of Gaussian chains: L. R. G. Treloar, Trans. Faraday Soc. 39 (1943) 241; R. S. Rivlin, Phil. Trans. R.
    Soc. A 240 (1948) 459.
    """

    name = "neo-hookean"
    expression = "0.5*{mu_pa}*(s^2+2/s-3)"
    mu_pa: float = constant("μ", "Pa", "shear modulus at rest", above=0.0)

    def energy(self, stretch: Any) -> Any:
        return 0.5 * self.mu_pa * invariant.excess(stretch)

    def stress(self, stretch: Any) -> Any:
        return 0.5 * self.mu_pa * invariant.slope(stretch)

    def tangent(self, stretch: Any) -> Any:
        return 0.5 * self.mu_pa * invariant.curvature(stretch)
