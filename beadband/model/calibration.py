"""Calibration: what a chain of beads must be made of to move like a band of given E, density and bending stiffness.

Every formula that turns a continuum into beads stands here, once. a is the reference spacing of the beads.

=================  =================================================================================
bead mass          m = density A a
bond energy        a A W(r/a), so the bond carries the tension A stress(r/a)
angle energy       (EI/a)(u + u^2/6), u = 1 - cos psi, psi the turning angle: EI/2 (psi/a)^2 a up to the order psi^6
dashpot            gamma = E A tau/a along each bond: Kelvin-Voigt, viscous stress E tau d(stretch)/dt
largest step       dt = 2/(sqrt(w^2 + g^2) + g), g = 2 gamma/m: velocity Verlet, dashpots half a step behind, at
                   the stiffest mode; w^2 = 4 (tangent/density)/a^2 along the strand at a stretch s; across it g = 0,
                   w^2 = (4 a_b/(a^2 s))^2 + 4 (stress/(density s))/a^2, a_b = sqrt(EI/(density A))
=================  =================================================================================
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from beadband.model.laws import Law


@dataclass(frozen=True)
class Strand:
    """A chain of beads standing for a band; SI units."""

    law: Law
    spacing_m: float
    """Reference distance a of neighbouring beads."""
    area_m2: float
    density_kg_m3: float
    modulus_pa: float
    """Modulus E by which the loss time is turned into a viscosity: the table's."""
    bending_stiffness_n_m2: float
    """EI."""

    @property
    def bead_mass_kg(self) -> float:
        return self.density_kg_m3 * self.area_m2 * self.spacing_m

    @property
    def angle_coefficient_j(self) -> float:
        """K = EI/a, by which the forms of :mod:`beadband.model.angle_forms` are multiplied."""
        return self.bending_stiffness_n_m2 / self.spacing_m

    @property
    def bending_diffusivity_m2_s(self) -> float:
        """a_b = sqrt(EI/(density A))."""
        return math.sqrt(self.bending_stiffness_n_m2 / (self.density_kg_m3 * self.area_m2))

    def dashpot_n_s_m(self, loss_time_s: float) -> float:
        """Force along a bond per rate of its length."""
        return self.modulus_pa * self.area_m2 * loss_time_s / self.spacing_m

    def axial_step_s(self, stretch: float, loss_time_s: float = 0.0) -> float:
        """Largest stable step of motions along a uniform straight strand: neighbours against each other."""
        mass_rate = 2.0 * self.dashpot_n_s_m(loss_time_s) / self.bead_mass_kg
        rate2 = 4.0 * self.law.tangent(stretch) / (self.density_kg_m3 * self.spacing_m**2)
        # A falling tension (rate2 < 0) has no stable step of its own; what a step can bear is the dashpots'.
        return 2.0 / (math.sqrt(max(rate2 + mass_rate**2, 0.0)) + mass_rate) if rate2 > 0.0 else math.inf

    def transverse_step_s(self, stretch: float) -> float:
        """Largest stable step of motions across it: bending, which short bonds stiffen, and the tension.

        In a zigzag every angle turns by four heights over a bond: w^2 = (16 EI/(a^3 s^2) + 4 T/(a s))/m. There are no
        dashpots across.
        """
        bending = (4.0 * self.bending_diffusivity_m2_s / (self.spacing_m**2 * stretch)) ** 2
        pulled = 4.0 * self.law.stress(stretch) / (stretch * self.density_kg_m3 * self.spacing_m**2)
        return 2.0 / math.sqrt(bending + pulled) if bending + pulled > 0.0 else math.inf

    def state_step_s(self, stretch: float, loss_time_s: float = 0.0) -> float:
        """Largest stable step of a straight strand at one stretch: the exact linear limit of velocity Verlet."""
        return min(self.axial_step_s(stretch, loss_time_s), self.transverse_step_s(stretch))

    def largest_step_s(self, loss_time_s: float, strain: float, compression: float) -> float:
        """Step at which velocity Verlet loses stability while the strand unloads from ``strain``.

        The smallest of :meth:`state_step_s` over the stretches from ``compression`` to that strain, with the help of
        a push along the strand against bending left out: bonds of different stretches meet at a hinge. No state of a
        release between these stretches has a smaller limit, up to the coupling of bending and stretching at turning
        angles of some tens of degrees (see :mod:`beadband.studies.stability.frozen`, which has it exactly).
        """
        stretch = compression + (1.0 + strain - compression) * np.linspace(0.0, 1.0, 65)
        rates2 = 4.0 * self.law.tangent(stretch) / (self.density_kg_m3 * self.spacing_m**2)
        mass_rate = 2.0 * self.dashpot_n_s_m(loss_time_s) / self.bead_mass_kg
        # The stiffest of each kind; a falling tension has no step of its own.
        stiffest = float(np.max(rates2))
        axial = 2.0 / (math.sqrt(stiffest + mass_rate**2) + mass_rate) if stiffest > 0.0 else math.inf
        bending = (4.0 * self.bending_diffusivity_m2_s / self.spacing_m**2) ** 2
        relaxed = 2.0 * compression / math.sqrt(bending) if bending > 0.0 else math.inf
        pulled = stretch[stretch >= 1.0]
        across = bending / pulled**2 + 4.0 * self.law.stress(pulled) / (pulled * self.density_kg_m3 * self.spacing_m**2)
        swiftest = float(np.max(across))
        return min(axial, relaxed, 2.0 / math.sqrt(swiftest) if swiftest > 0.0 else math.inf)
