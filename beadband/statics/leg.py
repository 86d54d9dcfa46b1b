"""One leg instead of the ring: the part that can affect the rear, in equilibrium while the tip is held.

The scene is its own mirror image, and until the front arrives nothing beyond it matters. So one leg is enough for the
rear: from the tip, which is kept on the mirror axis, as far up as a disturbance can travel and return from by the end
of the run. The far end carries the tension of the leg and a drag of the front's impedance, which absorbs the front
without an echo.

The held leg needs no finger: it carries the same force T along its line everywhere. With alpha the angle of a bond
to that line the bond carries T cos alpha along itself, so its stretch follows from the law, and what is left is
the least of  sum of K f(turning) - a A W*(T cos alpha / A)  over the alphas, W* the complementary energy.

Many legs are solved at once, as rows of one array. Each row is solved by its own numbers alone, so a leg is the same to
the last digit whatever else is solved with it: rows are only ever combined bead by bead, and a row that has settled
stays as it is.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from beadband.errors import RunError, explain
from beadband.model.angle_forms import QUARTIC, AngleForm
from beadband.model.calibration import Strand
from beadband.model.laws import Law
from beadband.model.peg import released_energy_n
from beadband.statics.chain import Array
from beadband.statics.newton import BOUND

TIP_WEIGHT = 2.0
"""Coefficient of the tip's angle, over that of the others: it turns by half as much on each side of the axis."""
_GOAL = 1e-11
_SETTLED = 1e-7
"""Last step of the stretches from which the next one, of a method of the second order, is below rounding."""
_DECADES, _EXACT_POINTS = 40.0, 4000
"""Range of the logarithm of the angle over which an exact shape is summed, and its points."""
_STEPS, _SHORT_STEPS = 60, 12
"""Most steps; after the short ones, which take the stretches one step along with the angles, those are solved."""


@dataclass(frozen=True)
class Leg:
    """A held leg; the tip lies at the origin, and the mirror axis along x."""

    positions_m: Array
    """Shape (bonds + 1, 2); bead 0 is the tip."""
    tension_n: float
    half_angle_rad: float
    net_force: float
    """Largest moment out of balance on a bond, over tension and bead spacing."""


@dataclass(frozen=True)
class LegRequest:
    """What leg is asked for."""

    strand: Strand
    bonds: int
    strain: float
    half_angle_rad: float

    @property
    def tension_n(self) -> float:
        """Tension of the straight leg."""
        return self.strand.area_m2 * float(self.strand.law.stress(1.0 + self.strain))


def held_leg(strand: Strand, bonds: int, strain: float, half_angle_rad: float, form: AngleForm = QUARTIC) -> Leg:
    """The held leg of ``bonds`` bonds; RunError when it does not settle (see :func:`held_legs`)."""
    (found,) = held_legs([LegRequest(strand, bonds, strain, half_angle_rad)], form)
    if isinstance(found, RunError):
        raise found
    return found


def held_legs(requests: Sequence[LegRequest], form: AngleForm = QUARTIC) -> list[Leg | RunError]:
    """Solve for held legs by Newton's method, in the order of the requests; the RunError of one that does not settle.

    ``form`` is that of the angles that will be released; a leg held by another is not in equilibrium.
    """
    if not requests:
        return []
    found = _tried(requests, form, _SHORT_STEPS)
    for place, one in enumerate(found):
        if isinstance(one, RunError):
            # Next to a peak of the tension a start of uniform stretch leads astray: the exact one takes longer.
            (found[place],) = _tried([requests[place]], form, 0)
    return found


def _tried(requests: Sequence[LegRequest], form: AngleForm, short_steps: int) -> list[Leg | RunError]:
    """As :func:`held_legs`; without short steps from the exact shape of continuous bands."""
    rows = Rows(requests)
    alpha = rows.continuous() if short_steps else exact_angles(requests[0], float(rows.opening[0, 0]))[None, :]
    stretch = np.ones((len(requests), rows.bonds)) * rows.leg_stretch
    imbalance = np.zeros(len(requests))
    bent = rows.stiff[:, 0] > 0.0
    if bent.any():
        alpha, stretch, imbalance = _settled(rows, alpha, stretch, bent, form, short_steps)
    found: list[Leg | RunError] = []
    for place, one in enumerate(requests):
        error = float(imbalance[place])
        if not error <= BOUND:
            found.append(no_equilibrium(error))
            continue
        angles, stretches = alpha[place, : one.bonds], stretch[place, : one.bonds]
        found.append(
            laid_out(one.strand.spacing_m, angles, stretches, one.half_angle_rad, float(rows.tension[place, 0]), error)
        )
    return found


def smooth_leg(strand: Strand, bonds: int, strain: float, half_angle_rad: float) -> Leg:
    """The leg as a continuous band would lie: for chains so fine that rounding keeps :func:`held_leg` from settling."""
    rows = Rows([LegRequest(strand, bonds, strain, half_angle_rad)])
    alpha = rows.continuous()
    stretch = rows.stretches(rows.tension / rows.area * np.cos(alpha))
    return laid_out(strand.spacing_m, alpha[0], stretch[0], half_angle_rad, float(rows.tension[0, 0]), math.nan)


def exact_angles(request: LegRequest, start_rad: float, ahead_m: float = 0.0) -> Array:
    """Angles of the bonds to the leg's line as beads without end would have them, shape (bonds,).

    EI/2 (d alpha/dS)^2 = W*(T) - W*(T cos alpha), S summed over the logarithm of alpha. The angle is ``start_rad`` at
    the reference length ``ahead_m`` from the tip; bonds before it have more than that, and none of them means anything.
    """
    strand, held = request.strand, 1.0 + request.strain
    alpha = start_rad * np.exp(-np.linspace(0.0, _DECADES, _EXACT_POINTS))
    stretch = Rows([request]).stretches(strand.law.stress(held) * np.cos(alpha)[None, :])[0]
    energy = released_energy_n(strand.law, strand.area_m2, held, stretch, alpha)
    rate = alpha * np.sqrt(0.5 * strand.bending_stiffness_n_m2 / energy)
    step = np.diff(-np.log(alpha))
    reach = np.concatenate([[0.0], np.cumsum(0.5 * (rate[1:] + rate[:-1]) * step)])
    at = (np.arange(request.bonds) + 0.5) * strand.spacing_m - ahead_m
    return np.where(at <= reach[-1], np.exp(np.interp(at, reach, np.log(alpha))), 0.0)


class Rows:
    """The numbers of many legs as columns of shape (legs, 1), and their laws as one."""

    def __init__(self, requests: Sequence[LegRequest]) -> None:
        def column(values: Any) -> Array:
            return np.array(list(values), dtype=np.float64)[:, None]

        self.bonds = max(one.bonds for one in requests)
        self.count = column(one.bonds for one in requests)
        self.spacing = column(one.strand.spacing_m for one in requests)
        self.area = column(one.strand.area_m2 for one in requests)
        self.tension = column(one.tension_n for one in requests)
        self.leg_stretch = column(1.0 + one.strain for one in requests)
        self.stiff = column(one.strand.angle_coefficient_j for one in requests)
        self.opening = column(math.pi / 2.0 - one.half_angle_rad for one in requests)
        self.inside = np.arange(self.bonds) < self.count
        laws: dict[Law, list[int]] = {}
        for place, one in enumerate(requests):
            laws.setdefault(one.strand.law, []).append(place)
        self._laws = [(law, np.array(places)) for law, places in laws.items()]

    def stress(self, stretch: Array) -> Array:
        """Nominal stresses of stretches (legs, bonds), each row by its law."""
        return self._by_law("stress", stretch)

    def tangent(self, stretch: Array) -> Array:
        """The like of tangent moduli."""
        return self._by_law("tangent", stretch)

    def _by_law(self, name: str, stretch: Array) -> Array:
        if len(self._laws) == 1:
            return np.asarray(getattr(self._laws[0][0], name)(stretch))
        found = np.empty_like(stretch)
        for law, places in self._laws:
            found[places] = getattr(law, name)(stretch[places])
        return found

    def continuous(self) -> Array:
        """The answers for beads without end and uniform stretch: tan(alpha/4) = tan(alpha0/4) exp(-S/l)."""
        spacing, stiff = self.spacing, self.stiff
        with np.errstate(divide="ignore"):
            layers = np.sqrt(self.tension * self.leg_stretch / (stiff * spacing)) * spacing
        reach = (np.arange(self.bonds) + 0.5) * layers
        guess: Array = 4.0 * np.arctan(np.tan(self.opening / 4.0) * np.exp(-reach))
        return np.where(self.inside, guess, 0.0)

    def stretches(self, stress_pa: Array) -> Array:
        """Stretches that carry the stresses, between 1 and those of the legs (Newton's method, bracketed)."""
        low, high = np.ones_like(stress_pa), np.broadcast_to(self.leg_stretch, stress_pa.shape)
        stretch = 1.0 + (self.leg_stretch - 1.0) * stress_pa / (self.tension / self.area)
        settled = np.zeros(stress_pa.shape, dtype=bool)
        for _ in range(100):
            excess = self.stress(stretch) - stress_pa
            high, low = np.where(excess > 0.0, stretch, high), np.where(excess > 0.0, low, stretch)
            better = stretch - excess / self.tangent(stretch)
            better = np.where((better < low) | (better > high), 0.5 * (low + high), better)
            steps = np.abs(better - stretch)
            stretch = np.where(settled, stretch, better)
            settled |= steps < 1e-14
            if settled.all():
                break
        return stretch


def _settled(
    rows: Rows, alpha: Array, stretch: Array, bent: np.ndarray, form: AngleForm, short_steps: int
) -> tuple[Array, Array, Array]:
    """Angles and stretches of the bonds in equilibrium, (legs, bonds), and the imbalance that is left of each leg.

    Everything is over the tension times the spacing. In the first ``short_steps`` the stretches take one step of
    Newton's method each; after them they are solved for whenever the angles change.
    """
    weight = np.where(rows.inside, rows.stiff / (rows.tension * rows.spacing), 0.0)
    weight[:, 0] *= TIP_WEIGHT
    held_pa = rows.tension / rows.area
    outside = None if rows.inside.all() else ~rows.inside
    turning = np.empty_like(alpha)
    imbalance, active = np.where(bent, math.inf, 0.0), bent.copy()
    for step in range(_STEPS):
        cosine, sine = np.cos(alpha), np.sin(alpha)
        carried = held_pa * cosine
        tangent = rows.tangent(stretch)
        if step < short_steps:
            better = stretch - (rows.stress(stretch) - carried) / tangent
            better = np.minimum(np.maximum(better, 1.0), rows.leg_stretch)
            still = np.maximum.reduce(np.abs(better - stretch), axis=1) <= _SETTLED
        else:
            better, still = rows.stretches(carried), np.ones_like(active)
        # Turning angle before each bond; the far end is free to turn.
        turning[:, :1] = rows.opening - alpha[:, :1]
        np.subtract(alpha[:, :-1], alpha[:, 1:], out=turning[:, 1:])
        _, slope, curve = form.by_angle(turning)
        moment, stiffness = weight * slope, weight * curve
        across = better * sine
        unbalanced = across - moment
        unbalanced[:, :-1] += moment[:, 1:]
        diagonal = better * cosine - held_pa / tangent * sine * sine + stiffness
        diagonal[:, :-1] += stiffness[:, 1:]
        if outside is not None:
            unbalanced[outside], diagonal[outside] = 0.0, 1.0
        off = np.maximum.reduce(np.abs(unbalanced), axis=1)
        stretch = np.where(active[:, None], better, stretch)
        imbalance = np.where(active, off, imbalance)
        active = active & np.isfinite(off) & ~((off <= _GOAL) & still)
        if not active.any():
            break
        change = _solve_tridiagonal(diagonal, -stiffness[:, 1:], -unbalanced)
        most = np.maximum.reduce(np.abs(change), axis=1)
        if most.max() > 0.5:
            change *= (0.5 / np.maximum(most, 0.5))[:, None]
        # The stretches go along with the angles, to the first order: Newton's method in both.
        follow = better - held_pa / tangent * sine * change
        if active.all():
            alpha, stretch = alpha + change, follow
        else:
            alpha = np.where(active[:, None], alpha + change, alpha)
            stretch = np.where(active[:, None], follow, stretch)
    return alpha, stretch, imbalance


def no_equilibrium(imbalance: float) -> RunError:
    given = f"a moment of {imbalance:.1e} of tension and spacing"
    return RunError(
        explain("the held leg found no equilibrium", given, f"{BOUND:.0e}", "change --beads"), "no-equilibrium"
    )


def laid_out(a: float, alpha: Array, stretch: Array, half_angle_rad: float, tension: float, imbalance: float) -> Leg:
    """The leg whose bonds have the directions ``alpha`` from its line and these stretches."""
    direction = half_angle_rad + alpha
    positions = np.zeros((len(alpha) + 1, 2))
    np.cumsum(a * stretch * np.cos(direction), out=positions[1:, 0])
    np.cumsum(a * stretch * np.sin(direction), out=positions[1:, 1])
    return Leg(positions, tension, half_angle_rad, imbalance)


def _solve_tridiagonal(diagonal: Array, beside: Array, right: Array) -> Array:
    """Solutions of symmetric tridiagonal systems, one a row, by elimination; plain floats beat numpy at these sizes.

    ``diagonal`` and ``right`` (systems, n), ``beside`` (systems, n - 1).
    """
    solutions = []
    for pivots, coupling, loads in zip(diagonal.tolist(), beside.tolist(), right.tolist(), strict=True):
        for i, off in enumerate(coupling):
            factor = off / pivots[i]
            pivots[i + 1] -= factor * off
            loads[i + 1] -= factor * loads[i]
        after = loads[-1] = loads[-1] / pivots[-1]
        for i in range(len(coupling) - 1, -1, -1):
            after = loads[i] = (loads[i] - coupling[i] * after) / pivots[i]
        solutions.append(loads)
    return np.array(solutions)
