"""Mullins softening of any law by Ogden and Roxburgh's pseudo-elasticity (Proc. R. Soc. A 455, 1999, 2861)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from beadband.model.laws.base import Law


@dataclass(frozen=True)
class Softened(Law):
    """The law of a strand that was stretched once to ``held`` and unloads from there.

    Its stress is that of the primary law times eta = 1 - erf((Wm - W)/(m + beta Wm))/r, W the primary energy and Wm
    its value at the held stretch. Since eta depends on W alone, the energy that the band gives back is the integral of
    eta over W, in closed form. Above the held stretch the slope there goes on.
    """

    primary: Law
    held: float
    r: float
    """Above 1; at rest the stress is at least 1 - 1/r of the primary one."""
    m_pa: float
    beta: float
    name = ""
    one_formula = False

    def __post_init__(self) -> None:
        for name in ("name", "ends_because", "table_error"):
            object.__setattr__(self, name, getattr(self.primary, name))

    @property
    def _most(self) -> float:
        return float(self.primary.energy(self.held))

    @property
    def _width(self) -> float:
        return self.m_pa + self.beta * self._most

    def values(self) -> dict[str, Any]:
        """Those of the primary law, and of the softening."""
        softening = {"softening_r": self.r, "softening_m_pa": self.m_pa, "softening_beta": self.beta}
        return {**self.primary.values(), **softening}

    def _within(self, stretch: Any) -> tuple[Any, Any, Any]:
        """Stretch up to the held one, what is beyond, and the reduced distance z = (Wm - W)/(m + beta Wm)."""
        beyond = np.where(np.real(stretch) > self.held, stretch - self.held, 0.0)
        below = stretch - beyond
        return below, beyond, (self._most - self.primary.energy(below)) / self._width

    def energy(self, stretch: Any) -> Any:
        below, beyond, z = self._within(stretch)
        saved = self._width / self.r * (_area(self._most / self._width) - _area(z))
        end = self._stress_at_held * beyond + 0.5 * self._slope_at_held * beyond**2
        return self.primary.energy(below) - saved + end

    def stress(self, stretch: Any) -> Any:
        below, beyond, z = self._within(stretch)
        return (1.0 - _erf(z) / self.r) * self.primary.stress(below) + self._slope_at_held * beyond

    def tangent(self, stretch: Any) -> Any:
        below, _, z = self._within(stretch)
        softer = 2.0 / math.sqrt(math.pi) / (self.r * self._width) * np.exp(-z * z)
        return (1.0 - _erf(z) / self.r) * self.primary.tangent(below) + softer * self.primary.stress(below) ** 2

    @property
    def _stress_at_held(self) -> float:
        return float(self.primary.stress(self.held))

    @property
    def _slope_at_held(self) -> float:
        softer = 2.0 / math.sqrt(math.pi) / (self.r * self._width)
        return float(self.primary.tangent(self.held)) + softer * self._stress_at_held**2

    def longest_stretch(self) -> float | None:
        """The primary law's."""
        return self.primary.longest_stretch()

    def shortest_stretch(self) -> float | None:
        """The primary law's."""
        return self.primary.shortest_stretch()

    def table_ends(self, held: float, shortest: float, longest: float) -> tuple[float, float]:
        """The primary law's."""
        return self.primary.table_ends(held, shortest, longest)

    def peak_stretch(self) -> float | None:
        """The primary law's, along which the held stretch is reached."""
        return self.primary.peak_stretch()

    def lost_density_pa(self, held: float) -> float:
        """Energy between loading and unloading up to the held stretch, J/m3."""
        return float(self.primary.energy(held) - self.energy(held))


def softened(law: Law, held: float, r: float, m_pa: float, beta: float) -> Softened:
    """The unloading of ``law`` from ``held``: r > 1, m in Pa and beta not negative, not both zero."""
    return Softened(law, held, r, m_pa, beta)


def _erf(z: Any) -> Any:
    from scipy.special import erf

    return erf(z)


def _area(z: Any) -> Any:
    """Integral of erf from 0 to z."""
    return z * _erf(z) + np.expm1(-z * z) / math.sqrt(math.pi)
