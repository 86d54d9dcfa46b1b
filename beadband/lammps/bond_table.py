"""The law of the material as the table of a bond."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from beadband.model.calibration import Strand
from beadband.model.laws import Law

TABLE_POINTS = 2001
LEG_TABLE_POINTS = 101
"""A leg is released for a number or two, and reading the table would take longer than the physics."""
MOST_TABLE_POINTS = 40_000
DEEPEST_STRETCH = 0.3
"""Where the bond table begins."""
WIDEST_STRAIN = 1.6
"""Where the bond table ends, over the held strain; a law that locks before ends it earlier."""
_USED_FROM = 0.6
_USED_TO = 1.2
"""Stretch from which, and multiple of the held strain up to which, the bonds of a sound run come."""
_SMALL_STRAIN = 0.01
_REACH_RATIO = 2.0**0.25


@lru_cache(maxsize=256)
def table_points(law: Law, strain: float, least: int = TABLE_POINTS, shortest: float = DEEPEST_STRETCH) -> int:
    """Points between which the spline of a bond table keeps the force within the law's ``table_error``.

    At least ``least``; the error is taken over the force itself, or over that at a strain of 1 % where that is larger.
    """
    low, high = law.table_ends(1.0 + strain, shortest, 1.0 + WIDEST_STRAIN * strain)
    used_from, used_to = max(low, _USED_FROM), min(high, 1.0 + _USED_TO * strain)
    small = _SMALL_STRAIN * law.rest_modulus_pa
    points = least
    while points < MOST_TABLE_POINTS and np.isfinite(law.table_error):
        stretch, width = np.linspace(low, high, points, retstep=True)
        stress, tangent = law.stress(stretch), law.tangent(stretch)
        between = 0.5 * (stretch[1:] + stretch[:-1])
        # Cubic between two points with the slopes of the law: half-way a spline errs as much.
        cubic = 0.5 * (stress[1:] + stress[:-1]) - 0.125 * width * np.diff(tangent)
        exact = law.stress(between)
        used = (between >= used_from) & (between <= used_to)
        error = np.abs(cubic - exact)[used] / np.maximum(np.abs(exact[used]), small)
        if error.max(initial=0.0) <= law.table_error:
            break
        points = 2 * points - 1
    return points


@lru_cache(maxsize=256)
def leg_reach(law: Law, strain: float) -> float:
    """Strain for which the bond table of a leg is made: a little above its own, so that other strains share it.

    Not where the law ends, for the table depends on how far the held stretch is from the end, nor where the law itself
    depends on the held stretch.
    """
    if law.longest_stretch() is not None or not law.one_formula:
        return strain
    return float(_REACH_RATIO ** math.ceil(math.log(strain) / math.log(_REACH_RATIO)))


@lru_cache(maxsize=256)
def leg_table(law: Law, reach: float, points: int) -> str:
    """The bond table of legs with strains up to ``reach``, over bead spacing and area times modulus at rest."""
    strand = Strand(law, 1.0, 1.0 / law.rest_modulus_pa, 1.0, law.rest_modulus_pa, 0.0)
    return bond_table(strand, reach, points)


def bond_table(strand: Strand, strain: float, points: int = TABLE_POINTS, shortest: float = DEEPEST_STRETCH) -> str:
    """Energy and force of a bond from the stretch ``shortest`` to well beyond the held strain.

    Ahead of a shock without loss bonds ring about the held stretch, and more where the finger throws them back.
    """
    law, a, area = strand.law, strand.spacing_m, strand.area_m2
    ends = law.table_ends(1.0 + strain, shortest, 1.0 + WIDEST_STRAIN * strain)
    stretch = np.linspace(*ends, points)
    energy, force = a * area * law.energy(stretch), -area * law.stress(stretch)
    slopes = [-area * float(law.tangent(stretch[end])) / a for end in (0, -1)]
    rows = "".join(
        f"{i} {r!r} {e!r} {f!r}\n"
        for i, (r, e, f) in enumerate(zip((stretch * a).tolist(), energy.tolist(), force.tolist(), strict=True), 1)
    )
    return (
        f"# {law.name} bond: length m, energy J, force N\n\nBAND\n"
        f"N {points} FP {slopes[0]:.17g} {slopes[1]:.17g} EQ {a:.17g}\n\n{rows}"
    )
