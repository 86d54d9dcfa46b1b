"""One leg instead of the ring: the part that can affect the rear, in equilibrium while the tip is held.

The scene is its own mirror image, and until the front arrives nothing beyond it matters. So one leg is enough for the
rear: from the tip, which is kept on the mirror axis, as far up as a disturbance can travel and return from by the end
of the run. The far end carries the tension of the leg and a drag of the front's impedance, which absorbs the front
without an echo.

The held leg needs no finger: it carries the same force T along its line everywhere. With alpha the angle of a bond
to that line the bond carries T cos alpha along itself, so its stretch follows from the law, and what is left is
the least of  sum of K f(turning) - a A W*(T cos alpha / A)  over the alphas, W* the complementary energy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from beadband.errors import RunError, explain
from beadband.model.angle_forms import QUARTIC, AngleForm
from beadband.model.calibration import Strand
from beadband.model.laws import Law
from beadband.statics.chain import Array
from beadband.statics.newton import BOUND

TIP_WEIGHT = 2.0
"""Coefficient of the tip's angle, over that of the others: it turns by half as much on each side of the axis."""
_GOAL = 1e-12


@dataclass(frozen=True)
class Leg:
    """A held leg; the tip lies at the origin, and the mirror axis along x."""

    positions_m: Array
    """Shape (bonds + 1, 2); bead 0 is the tip."""
    tension_n: float
    half_angle_rad: float
    net_force: float
    """Largest moment out of balance on a bond, over tension and bead spacing."""


def held_leg(strand: Strand, bonds: int, strain: float, half_angle_rad: float, form: AngleForm = QUARTIC) -> Leg:
    """Solve for the held leg of ``bonds`` bonds by Newton's method; RunError when it does not settle.

    ``form`` is that of the angles that will be released; a leg held by another is not in equilibrium.
    """
    a, leg_stretch = strand.spacing_m, 1.0 + strain
    tension = strand.area_m2 * float(strand.law.stress(leg_stretch))
    stiff = strand.angle_coefficient_j
    opening = math.pi / 2.0 - half_angle_rad
    alpha, stretch, imbalance = np.zeros(bonds), np.full(bonds, leg_stretch), 0.0
    near: Array | None = None  # stretches of the step before: Newton's method is there in one or two from them
    if stiff > 0.0:
        weight = np.full(bonds, stiff)
        weight[0] = TIP_WEIGHT * stiff
        alpha = _continuous(strand, tension, leg_stretch, opening, bonds)
        for _ in range(60):
            near = stretch = _stretches(strand.law, tension / strand.area_m2 * np.cos(alpha), leg_stretch, near)
            across = tension * np.sin(alpha)
            # Turning angle before each bond; the far end is free to turn.
            turning = -np.diff(alpha, prepend=opening)
            _, slope, curve = form.by_angle(turning)
            moment = weight * slope
            unbalanced = a * stretch * across - moment
            unbalanced[:-1] += moment[1:]
            imbalance = float(np.abs(unbalanced).max()) / (tension * a)
            if imbalance <= _GOAL or not math.isfinite(imbalance):
                break
            give = strand.area_m2 * strand.law.tangent(stretch)
            diagonal = a * (stretch * tension * np.cos(alpha) - across**2 / give) + weight * curve
            diagonal[:-1] += (weight * curve)[1:]
            change = _solve_tridiagonal(diagonal, -(weight * curve)[1:], -unbalanced)
            alpha = alpha + change * min(1.0, 0.5 / max(float(np.abs(change).max()), 0.5))
        if not imbalance <= BOUND:
            raise RunError(
                explain(
                    "the held leg found no equilibrium",
                    f"a moment of {imbalance:.1e} of tension and spacing",
                    f"{BOUND:.0e}",
                    "change --beads",
                ),
                "no-equilibrium",
            )
    return _laid_out(strand.spacing_m, alpha, stretch, half_angle_rad, tension, imbalance)


def smooth_leg(strand: Strand, bonds: int, strain: float, half_angle_rad: float) -> Leg:
    """The leg as a continuous band would lie: for chains so fine that rounding keeps :func:`held_leg` from settling."""
    leg_stretch = 1.0 + strain
    tension = strand.area_m2 * float(strand.law.stress(leg_stretch))
    alpha = _continuous(strand, tension, leg_stretch, math.pi / 2.0 - half_angle_rad, bonds)
    stretch = _stretches(strand.law, tension / strand.area_m2 * np.cos(alpha), leg_stretch)
    return _laid_out(strand.spacing_m, alpha, stretch, half_angle_rad, tension, math.nan)


def _laid_out(a: float, alpha: Array, stretch: Array, half_angle_rad: float, tension: float, imbalance: float) -> Leg:
    """The leg whose bonds have the directions ``alpha`` from its line and these stretches."""
    direction = half_angle_rad + alpha
    bond = (a * stretch)[:, None] * np.stack([np.cos(direction), np.sin(direction)], axis=1)
    positions = np.concatenate([np.zeros((1, 2)), np.cumsum(bond, axis=0)])
    return Leg(positions, tension, half_angle_rad, imbalance)


def _continuous(strand: Strand, tension: float, leg_stretch: float, opening: float, bonds: int) -> Array:
    """The answer for beads without end and uniform stretch: tan(alpha/4) = tan(alpha0/4) exp(-S/l)."""
    layer = math.sqrt(strand.bending_stiffness_n_m2 / (tension * leg_stretch))
    reach = (np.arange(bonds) + 0.5) * strand.spacing_m
    guess: Array = 4.0 * np.arctan(math.tan(opening / 4.0) * np.exp(-reach / layer))
    return guess


def _stretches(law: Law, stress_pa: Array, at_most: float, near: Array | None = None) -> Array:
    """Stretches that carry the stresses, between 1 and ``at_most`` (Newton's method from ``near``, bracketed)."""
    low, high = np.ones_like(stress_pa), np.full_like(stress_pa, at_most)
    stretch = 1.0 + (at_most - 1.0) * stress_pa / float(law.stress(at_most)) if near is None else near
    for _ in range(100):
        excess = law.stress(stretch) - stress_pa
        high, low = np.where(excess > 0.0, stretch, high), np.where(excess > 0.0, low, stretch)
        better = stretch - excess / law.tangent(stretch)
        better = np.where((better < low) | (better > high), 0.5 * (low + high), better)
        step = float(np.abs(better - stretch).max())
        stretch = better
        if step < 1e-14:
            break
    return stretch


def _solve_tridiagonal(diagonal: Array, beside: Array, right: Array) -> Array:
    """Solution of a symmetric tridiagonal system by elimination; plain floats beat numpy at these sizes."""
    pivots, loads = diagonal.tolist(), right.tolist()
    coupling = beside.tolist()
    for i, off in enumerate(coupling):
        factor = off / pivots[i]
        pivots[i + 1] -= factor * off
        loads[i + 1] -= factor * loads[i]
    loads[-1] /= pivots[-1]
    for i in range(len(coupling) - 1, -1, -1):
        loads[i] = (loads[i] - coupling[i] * loads[i + 1]) / pivots[i]
    return np.array(loads)
