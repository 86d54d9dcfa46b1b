"""Calibration: what a chain of beads must be made of to move like a band of given E, density and bending stiffness.

Every formula that turns a continuum into beads stands here, once. a is the reference spacing of the beads.

=================  =================================================================================
bead mass          m = density A a
bond energy        a A W(r/a), so the bond carries the tension A stress(r/a)
angle energy       (EI/a)(u + u^2/6), u = 1 - cos psi, psi the turning angle: EI/2 (psi/a)^2 a up to the order psi^6
dashpot            gamma = E A tau/a along each bond: Kelvin-Voigt, viscous stress E tau d(stretch)/dt
largest step       dt = 2/(sqrt(w^2 + g^2) + g), g = 2 gamma/m: velocity Verlet at the stiffest mode, with
                   w = 2 c_max/a axially; g = 0 and w = 4 a_b/(a^2 s) for bending of bonds at a stretch s,
                   a_b = sqrt(EI/(density A))
=================  =================================================================================
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from beadband.law import Law

# Weight of (1 - cos psi)^2 in the angle energy. With it a sharply bent coarse chain is as stiff as the band it stands
# for, where 1 - cos psi alone goes soft; as a polynomial in the cosine it stays smooth at straight angles, which
# forms in psi itself do not in LAMMPS (they clip 1/sin below psi = 0.001).
QUARTIC = 1.0 / 6.0


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
        """K of ``angle_style fourier``, E = K (C0 + C1 cos theta + C2 cos 2 theta) with theta = pi - psi.

        The release script holds C0 = 1 + 3 q/2, C1 = 1 + 2 q, C2 = q/2 for q = :data:`QUARTIC`.
        """
        return self.bending_stiffness_n_m2 / self.spacing_m

    @property
    def bending_diffusivity_m2_s(self) -> float:
        """a_b = sqrt(EI/(density A))."""
        return math.sqrt(self.bending_stiffness_n_m2 / (self.density_kg_m3 * self.area_m2))

    def dashpot_n_s_m(self, loss_time_s: float) -> float:
        """Force along a bond per rate of its length."""
        return self.modulus_pa * self.area_m2 * loss_time_s / self.spacing_m

    def largest_step_s(self, loss_time_s: float, strain: float, compression: float) -> float:
        """Step at which velocity Verlet loses stability while the strand unloads from ``strain``.

        Axial modes are as stiff as the law is anywhere between that strain and the stretch ``compression``; transverse
        ones are checked compressed (short bonds bend most stiffly) and held (long bonds under tension).
        """
        held, density = 1.0 + strain, self.density_kg_m3
        samples = [compression + (held - compression) * i / 64 for i in range(65)]
        stiffest = max(self.law.tangent(stretch) for stretch in samples)
        mass_rate = 2.0 * self.dashpot_n_s_m(loss_time_s) / self.bead_mass_kg
        axial = 4.0 * stiffest / (density * self.spacing_m**2)
        bending = (4.0 * self.bending_diffusivity_m2_s / self.spacing_m**2) ** 2
        pulled = 4.0 * self.law.stress(held) / (held * density * self.spacing_m**2)
        transverse = max(bending / compression**2, bending / held**2 + pulled)
        return min(2.0 / (math.sqrt(axial + mass_rate**2) + mass_rate), 2.0 / math.sqrt(transverse))
