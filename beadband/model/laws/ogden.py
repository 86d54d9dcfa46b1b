"""The Ogden law, incompressible, in uniaxial tension (Ogden 1972)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from beadband.errors import UsageError, explain
from beadband.model.laws.base import Law, constant
from beadband.model.laws.registry import register


@register
@dataclass(frozen=True)
class Ogden(Law):
    """W = sum of mu/alpha (s^alpha + 2 s^(-alpha/2) - 3) over its terms, s the stretch.

    The modulus at rest is 3/2 of the sum of mu alpha. R. W. Ogden, Proc. R. Soc. Lond. A 326 (1972) 565.
    """

    name = "ogden"
    mu_pa: tuple[float, ...] = constant("μ", "Pa", "of ogden, one modulus for each exponent", many=True)
    alpha: tuple[float, ...] = constant("α", "", "exponents, one for each modulus mu", many=True)

    def __post_init__(self) -> None:
        for key, value in self.values().items():
            object.__setattr__(self, key, tuple(value) if isinstance(value, (list, tuple)) else (value,))
        if len(self.mu_pa) != len(self.alpha):
            raise UsageError(
                explain(
                    "the law ogden needs as many moduli as exponents",
                    f"{len(self.mu_pa)} mu and {len(self.alpha)} alpha",
                    "one of each for every term",
                    "change --mu or --alpha",
                )
            )
        if 0.0 in self.alpha:
            raise UsageError(
                explain("an exponent of the law ogden is 0", list(self.alpha), "other numbers", "change --alpha")
            )

    def lammps_expression(self) -> str:
        return "+".join(
            f"({mu / alpha:.17g})*(s^({alpha:.17g})+2*s^({-0.5 * alpha:.17g})-3)" for mu, alpha in self._terms()
        )

    # With p = s^(alpha/2) a term of the energy is p^2 + 2/p - 3 = (p - 1)^2 (p + 2)/p: small strains do not cancel.

    def energy(self, stretch: Any) -> Any:
        total = 0.0 * stretch
        for mu, alpha in self._terms():
            rest = np.expm1(0.5 * alpha * np.log(stretch))
            total = total + mu / alpha * rest**2 * (rest + 3.0) / (rest + 1.0)
        return total

    def stress(self, stretch: Any) -> Any:
        total = 0.0 * stretch
        for mu, alpha in self._terms():
            rest = np.expm1(0.5 * alpha * np.log(stretch))
            total = total + mu * rest * (3.0 + rest * (3.0 + rest)) / (rest + 1.0)
        return total / stretch

    def tangent(self, stretch: Any) -> Any:
        total = 0.0 * stretch
        for mu, alpha in self._terms():
            power = stretch ** (0.5 * alpha)
            total = total + mu * ((alpha - 1.0) * power**2 + (0.5 * alpha + 1.0) / power)
        return total / stretch**2

    def _terms(self) -> Iterator[tuple[float, float]]:
        return zip(self.mu_pa, self.alpha, strict=True)
