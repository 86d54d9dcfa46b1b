"""Angle forms: energies of a turning angle psi over K = EI/a, all psi^2/2 to the lowest order.

A release uses ``quartic``; the others are for comparison. A chain must be held by the form that it is released with,
or what is measured is the jolt between two equilibria.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Derivatives = tuple[Array, Array, Array]
"""Energies over K, and their first and second derivatives."""

# Weight q of (1 - cos psi)^2 in the quartic form. With it a sharply bent coarse chain is as stiff as the band it stands
# for, where 1 - cos psi alone goes soft; as a polynomial in the cosine it stays smooth at straight angles, which
# forms in psi itself do not in LAMMPS (they clip 1/sin below psi = 0.001).
_WEIGHT = 1.0 / 6.0
FOURIER = {"angle_c0": 1.0 + 1.5 * _WEIGHT, "angle_c1": 1.0 + 2.0 * _WEIGHT, "angle_c2": 0.5 * _WEIGHT}
"""The quartic form for ``angle_style fourier``, K (C0 + C1 cos theta + C2 cos 2 theta), theta = pi - psi."""
TABLE_POINTS = 2001
_STEEPEST = 2.4
"""Turning angle beyond which a table goes on straight; no bead of a release comes near it."""


@dataclass(frozen=True)
class AngleForm:
    """One form, and how LAMMPS is given it."""

    name: str
    formula: str
    """Its energy over K."""
    by_cosine: Callable[[Array], Derivatives]
    """Energy and derivatives by the cosine of the turning angle."""
    by_angle: Callable[[Array], Derivatives]
    """Energy and derivatives by the turning angle (rad)."""
    style: str
    """LAMMPS' angle_style."""
    _coefficients: str
    """LAMMPS' angle_coeff, with ``k`` for K, ``half`` for K/2 and ``section`` for that of a table."""

    @property
    def tabulated(self) -> bool:
        """Whether LAMMPS reads the form from a table."""
        return self.style.startswith("table")

    def coefficients(self, coefficient_j: float, section: str = "ANGLE") -> str:
        """LAMMPS' angle_coeff for K = ``coefficient_j``; ``section`` names that of :meth:`table`."""
        return self._coefficients.format(
            k=format(coefficient_j, ".17g"), half=format(0.5 * coefficient_j, ".17g"), section=section
        )

    def table(self, coefficients_j: Mapping[str, float], steepest_rad: float = _STEEPEST) -> str:
        """The form as ``angle_style table`` reads it, one section for each K; straight beyond ``steepest_rad``."""
        theta = np.linspace(0.0, math.pi, TABLE_POINTS)
        turning = math.pi - theta
        near = np.minimum(turning, steepest_rad)
        energy, slope, _ = self.by_angle(near)
        energy = energy + slope * (turning - near)
        degrees = np.degrees(theta).tolist()
        sections = []
        for name, coefficient in coefficients_j.items():
            # LAMMPS takes angles in degrees and -dE/d(theta) by degree.
            force = coefficient * slope * math.pi / 180.0
            rows = zip(degrees, (coefficient * energy).tolist(), force.tolist(), strict=True)
            lines = "".join(f"{i} {t:.17g} {e:.17g} {f:.17g}\n" for i, (t, e, f) in enumerate(rows, 1))
            sections.append(f"{name}\nN {TABLE_POINTS} EQ 180.0\n\n{lines}")
        return f"# angle form {self.name}: theta degrees, energy J, force J/degree\n\n" + "\n".join(sections)


def _quartic(cosine: Array) -> Derivatives:
    u = 1.0 - cosine
    return u + _WEIGHT * u * u, -1.0 - 2.0 * _WEIGHT * u, np.full_like(u, 2.0 * _WEIGHT)


def _quartic_by_angle(turning_rad: Array) -> Derivatives:
    cosine, sine = np.cos(turning_rad), np.sin(turning_rad)
    u = 1.0 - cosine
    slope = 1.0 + 2.0 * _WEIGHT * u
    return u + _WEIGHT * u * u, slope * sine, 2.0 * _WEIGHT * sine * sine + slope * cosine


def _cosine(cosine: Array) -> Derivatives:
    return 1.0 - cosine, np.full_like(cosine, -1.0), np.zeros_like(cosine)


def _cosine_by_angle(turning_rad: Array) -> Derivatives:
    return 1.0 - np.cos(turning_rad), np.sin(turning_rad), np.cos(turning_rad)


def _harmonic(cosine: Array) -> Derivatives:
    turning = np.arccos(np.clip(cosine, -1.0 + 1e-12, 1.0))
    sine = np.maximum(np.sin(turning), 1e-12)
    # Near straight the quotients lose their digits: there they are their limits.
    slope = -np.where(turning > 1e-6, turning / sine, 1.0)
    curve = np.where(turning > 1e-3, (sine + slope * sine * np.cos(turning)) / sine**3, 1.0 / 3.0)
    return 0.5 * turning**2, slope, curve


def _harmonic_by_angle(turning_rad: Array) -> Derivatives:
    return 0.5 * turning_rad**2, turning_rad, np.ones_like(turning_rad)


def _rod(cosine: Array) -> Derivatives:
    above = np.maximum(1.0 + cosine, 1e-12)
    return 2.0 * (1.0 - cosine) / above, -4.0 / above**2, 8.0 / above**3


def _rod_by_angle(turning_rad: Array) -> Derivatives:
    tangent = np.tan(0.5 * turning_rad)
    secant = 1.0 + tangent**2
    return 2.0 * tangent**2, 2.0 * tangent * secant, secant * (1.0 + 3.0 * tangent**2)


QUARTIC = AngleForm(
    "quartic",
    "u + u²/6, u = 1 − cos ψ",
    _quartic,
    _quartic_by_angle,
    "fourier",
    "{k} " + " ".join(format(value, ".17g") for value in FOURIER.values()),
)
"""The form of every release."""

ANGLE_FORMS: dict[str, AngleForm] = {
    form.name: form
    for form in (
        QUARTIC,
        AngleForm("cosine", "1 − cos ψ", _cosine, _cosine_by_angle, "cosine", "{k}"),
        AngleForm("harmonic", "ψ²/2", _harmonic, _harmonic_by_angle, "harmonic", "{half} 180.0"),
        # That of discrete elastic rods, as an expression and as a table.
        AngleForm("rod", "2 tan²(ψ/2)", _rod, _rod_by_angle, "lepton", "180.0 2*{k}*tan(theta/2)^2"),
        AngleForm(
            "rod_table",
            "2 tan²(ψ/2), tabulated",
            _rod,
            _rod_by_angle,
            f"table spline {TABLE_POINTS}",
            "angle.table {section}",
        ),
    )
}
"""The forms by name."""
