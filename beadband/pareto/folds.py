"""Forms of the angle energy that are compared, as functions of the turning angle psi over the angle coefficient.

Each is psi^2/2 to the lowest order. A leg must be held by the form that it is released with, or what is measured is the
jolt of one equilibrium that is none for the other.
"""

from __future__ import annotations

import math

import numpy as np

from beadband.chain import Array, fold_energy
from beadband.leg import TIP_WEIGHT, Fold

ANGLE_POINTS = 2001
_STEEPEST = 2.4
"""Turning angle beyond which the table of the rod goes on straight; no bead of a release comes near it."""


def harmonic(turning_rad: Array) -> tuple[Array, Array, Array]:
    """psi^2/2, of ``angle_style harmonic``."""
    return 0.5 * turning_rad**2, turning_rad, np.ones_like(turning_rad)


def cosine(turning_rad: Array) -> tuple[Array, Array, Array]:
    """1 - cos psi, of ``angle_style cosine``."""
    return 1.0 - np.cos(turning_rad), np.sin(turning_rad), np.cos(turning_rad)


def rod(turning_rad: Array) -> tuple[Array, Array, Array]:
    """2 tan^2(psi/2), that of discrete elastic rods."""
    tangent = np.tan(0.5 * turning_rad)
    secant = 1.0 + tangent**2
    return 2.0 * tangent**2, 2.0 * tangent * secant, secant * (1.0 + 3.0 * tangent**2)


FOLDS: dict[str, Fold] = {
    "house": fold_energy,
    "harmonic": harmonic,
    "cosine": cosine,
    "rod": rod,
    "rod_table": rod,
}
"""By the names that leg_variants.in knows them."""


def angle_table(coefficient_j: float, fold: Fold = rod, points: int = ANGLE_POINTS) -> str:
    """An angle energy as ``angle_style table`` reads it, for the leg and, weighted, for its tip."""
    theta = np.linspace(0.0, math.pi, points)
    turning = math.pi - theta
    near = np.minimum(turning, _STEEPEST)
    energy, slope, _ = fold(near)
    energy = energy + slope * (turning - near)
    sections = []
    for name, weight in (("LEG", 1.0), ("TIP", TIP_WEIGHT)):
        # LAMMPS takes angles in degrees and -dE/d(theta) by degree.
        force = weight * coefficient_j * slope * math.pi / 180.0
        rows = zip(np.degrees(theta).tolist(), (weight * coefficient_j * energy).tolist(), force.tolist(), strict=True)
        lines = "".join(f"{i} {t:.17g} {e:.17g} {f:.17g}\n" for i, (t, e, f) in enumerate(rows, 1))
        sections.append(f"{name}\nN {points} EQ 180.0\n\n{lines}")
    return "# turning angles: theta degrees, energy J, force J/degree\n\n" + "\n".join(sections)
