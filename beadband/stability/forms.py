"""Angle forms: energies of a turning angle psi over K = EI/a, all psi^2/2 for small angles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beadband.strand import QUARTIC, Strand

Array = NDArray[np.float64]
TABLE_POINTS = 2001


@dataclass(frozen=True)
class Form:
    """One form; functions of the cosine of the turning angle, numpy arrays."""

    name: str
    text: str
    """Its energy over K as a formula."""
    energy: Callable[[Array], Array]
    slope: Callable[[Array], Array]
    """Derivative by the cosine."""
    style: str
    """LAMMPS' angle_style."""

    def numbers(self, strand: Strand) -> str:
        """LAMMPS' angle_coeff."""
        k = strand.angle_coefficient_j
        if self.name == "beadband":
            return f"{k:.17g} {1.0 + 1.5 * QUARTIC:.17g} {1.0 + 2.0 * QUARTIC:.17g} {0.5 * QUARTIC:.17g}"
        if self.name == "cosine":
            return f"{k:.17g}"
        if self.name == "harmonic":
            return f"{0.5 * k:.17g} 180.0"
        return "angle.table FORM"

    def table(self, strand: Strand) -> str:
        """The form as an angle table of LAMMPS: degrees, energy, and -dE/d(degree)."""
        theta = np.linspace(0.0, 180.0, TABLE_POINTS)
        # A fold (theta = 0) is where tan^2 has no value: the table ends at the last angle before it.
        psi = np.radians(180.0 - np.maximum(theta, 180.0 / (TABLE_POINTS - 1)))
        k = strand.angle_coefficient_j
        energy = k * self.energy(np.cos(psi))
        force = k * -self.slope(np.cos(psi)) * np.sin(psi) * np.pi / 180.0
        rows = "".join(
            f"{i} {a:.17g} {e:.17g} {f:.17g}\n"
            for i, (a, e, f) in enumerate(zip(theta.tolist(), energy.tolist(), force.tolist(), strict=True), 1)
        )
        return f"# angle form {self.name}\n\nFORM\nN {TABLE_POINTS}\n\n{rows}"


def _harmonic_slope(cosine: Any) -> Any:
    clipped = np.clip(cosine, -1.0 + 1e-12, 1.0)
    psi = np.arccos(clipped)
    return -np.where(psi > 1e-6, psi / np.maximum(np.sin(psi), 1e-12), 1.0)


FORMS: dict[str, Form] = {
    form.name: form
    for form in (
        Form(
            "beadband",
            "u + u²/6, u = 1 − cos ψ",
            lambda c: (1.0 - c) + QUARTIC * (1.0 - c) ** 2,
            lambda c: -1.0 - 2.0 * QUARTIC * (1.0 - c),
            "fourier",
        ),
        Form("cosine", "1 − cos ψ", lambda c: 1.0 - c, lambda c: -1.0 + 0.0 * c, "cosine"),
        Form("harmonic", "ψ²/2", lambda c: 0.5 * np.arccos(np.clip(c, -1.0, 1.0)) ** 2, _harmonic_slope, "harmonic"),
        Form(
            "tangent",
            "2 tan²(ψ/2)",
            lambda c: 2.0 * (1.0 - c) / np.maximum(1.0 + c, 1e-12),
            lambda c: -4.0 / np.maximum(1.0 + c, 1e-12) ** 2,
            f"table spline {TABLE_POINTS}",
        ),
    )
}
"""The forms by name; beadband's own is the first."""
