"""A tip held by a round peg: where the band leaves it, by the exact shape of the held leg, for any law.

Along a free leg the internal force is T, so with alpha the angle of the band to the leg's line

    EI/2 (d alpha/dS)^2 = W*(T) - W*(T cos alpha),    dW*/dN = stretch(N),

S the reference arc length and N the axial tension. On a frictionless peg of the radius r (of the band's centre line)
the turning is d alpha/dS = stretch/r, and r N + M is constant with the moment M = EI stretch/r: so the stretch is the
same everywhere on the peg. N and M are continuous where the band leaves it, at the angle that solves
EI/2 (stretch/r)^2 = W*(T) - W*(T cos alpha). A peg below the radius of the point-held tip touches the tip alone.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from beadband.model.calibration import Strand
from beadband.model.laws import Law
from beadband.model.roots import root

_WIDEST_STEP = 1.0
"""Angle between neighbouring beads on a peg, rad, beyond which they are too far apart for it."""
_SOFTEST = 0.8
"""d ln stretch/d ln tension on the peg from which on beads must be closer: the tension of a bond at an angle d to the
next is too high by d^2/8, and next to a tension peak that stretches it much."""
_SMALL_ANGLE = 1e-3
"""Angle below which the released energy is its series: the difference of the two energies would lose its digits."""


@dataclass(frozen=True)
class Peg:
    """A peg that the held band touches beyond its tip."""

    radius_m: float
    """Of the band's centre line round it, r."""
    lift_off_rad: float
    """Angle of the band to the line of its leg where it leaves the peg."""
    stretch: float
    """Of the band on the peg."""
    wrapped_m: float
    """Reference length on the peg, from the tip to where one leg leaves it."""
    widest_m: float
    """Spacing of beads beyond which they are too far apart for the peg."""

    @property
    def curvature_1_m(self) -> float:
        """Turning on the peg per reference length, stretch/r."""
        return self.stretch / self.radius_m


def released_energy_n(law: Law, area_m2: float, held: float, stretch: Any, alpha: Any) -> Any:
    """W*(T) - W*(T cos alpha), N = J/m; floats or arrays.

    ``held`` is the stretch under T, ``stretch`` that under T cos alpha. W* = A (stress stretch - W).
    """
    tension = area_m2 * float(law.stress(held))

    def complementary(at: Any) -> Any:
        return area_m2 * (law.stress(at) * at - law.energy(at))

    drop = 2.0 * tension * np.sin(0.5 * alpha) ** 2  # T - T cos alpha
    series = drop * (held - 0.5 * drop / (area_m2 * float(law.tangent(held))))
    return np.where(alpha > _SMALL_ANGLE, complementary(held) - complementary(stretch), series)


def own_radius_m(strand: Strand, strain: float, half_angle_rad: float) -> float:
    """Radius to which a point-held tip bends by itself; 0 without bending."""
    stretch, excess = _excess(strand, strain, math.pi / 2.0 - half_angle_rad)
    return stretch * math.sqrt(strand.bending_stiffness_n_m2 / (2.0 * excess))


def peg_of(strand: Strand, strain: float, half_angle_rad: float, radius_m: float) -> Peg | None:
    """The held shape on a peg; None for one that touches the tip alone. Any spacing of the strand gives the same."""
    opening = math.pi / 2.0 - half_angle_rad
    if radius_m <= own_radius_m(strand, strain, half_angle_rad):
        return None

    def surplus(alpha: float) -> float:
        stretch, excess = _excess(strand, strain, alpha)
        return excess - 0.5 * strand.bending_stiffness_n_m2 * (stretch / radius_m) ** 2

    lift_off = root(surplus, 0.0, opening)
    stretch, _ = _excess(strand, strain, lift_off)
    law = strand.law
    softness = float(law.stress(stretch)) / (stretch * float(law.tangent(stretch)))  # d ln stretch / d ln tension
    widest = _WIDEST_STEP * min(1.0, _SOFTEST / softness) * radius_m / stretch
    return Peg(radius_m, lift_off, stretch, radius_m * (opening - lift_off) / stretch, widest)


def _excess(strand: Strand, strain: float, alpha: float) -> tuple[float, float]:
    """Stretch under T cos alpha, and :func:`released_energy_n` there."""
    held = 1.0 + strain
    stretch = strand.law.stretch_at(float(strand.law.stress(held)) * math.cos(alpha), held)
    return stretch, float(released_energy_n(strand.law, strand.area_m2, held, stretch, alpha))
