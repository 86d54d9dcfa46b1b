"""The leg whose tip is held by a round peg: beads on a circle, and free ones that the leg's tension pulls off it.

The first beads lie on the circle, the tip on the mirror axis; they may slide along it. The rest is the leg of
:mod:`beadband.statics.leg`: it carries the force T along its line, so a free bond's stretch follows from its direction.
What is left are the places of the beads on the circle as angles theta from the tip, and the angles alpha of the free
bonds to the leg's line. All turning angles are linear in them, and the energy

    sum of K f(turning) + sum on the circle of a A W(chord/a) - T x - sum of the free bonds of a A W*(T cos alpha / A),

x the place along the leg's line of the last bead on the circle, is least. The equilibrium on the peg is that with the
fewest beads on the circle that leaves none inside it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from beadband.errors import RunError, explain
from beadband.model.angle_forms import QUARTIC
from beadband.model.peg import Peg
from beadband.statics.chain import Array, solve_blocks
from beadband.statics.leg import TIP_WEIGHT, Leg, LegRequest, Rows, exact_angles, laid_out, no_equilibrium
from beadband.statics.newton import BOUND, damped_newton

LEG_TIP = (TIP_WEIGHT, 1.0)
RING_TIP = (0.5, 2.0)
"""Weight of the tip's angle energy over that of other beads, and its angle over that between the first bond and the
normal of the axis: a leg turns by halves to both sides, a ring turns at one bead, half of which is the leg's."""
_GOAL = 1e-11
_INSIDE = 1e-12
"""Share of the radius by which a bead may lie inside the circle: rounding."""


class PegLeg(NamedTuple):
    """A leg held by a peg, and how many of its beads lie on it, the tip included."""

    leg: Leg
    on_peg: int


def peg_leg(request: LegRequest, peg: Peg | None, tip: tuple[float, float] = LEG_TIP) -> PegLeg:
    """Solve for the leg on a peg, or held at a point, also where the beads are too far apart for the peg.

    RunError when it does not settle.

    ``tip`` is :data:`LEG_TIP` for a leg that is released by itself, :data:`RING_TIP` for the tip of a ring.
    """
    if peg is not None and request.strand.spacing_m > peg.widest_m:
        peg = None
    shape = _Shape(request, peg, tip)
    if peg is None:
        return PegLeg(shape.leg(shape.settled(1), 1), 1)
    count = min(1 + math.floor(peg.wrapped_m / request.strand.spacing_m), request.bonds - 1)
    unknown = shape.settled(count)
    if shape.overlaps(unknown, count):
        while shape.overlaps(unknown, count):
            if count == request.bonds - 1:
                allowed = "some beyond the peg"
                raise RunError(explain("the leg ends on its peg", f"{request.bonds} bonds", allowed, "raise --beads"))
            count += 1
            unknown = shape.settled(count, unknown)
        return PegLeg(shape.leg(unknown, count), count)
    while count > 1:
        fewer = shape.settled(count - 1, unknown)
        if shape.overlaps(fewer, count - 1):
            break
        count, unknown = count - 1, fewer
    return PegLeg(shape.leg(unknown, count), count)


class _Shape:
    """Energy of the leg in its unknowns, over T a: theta of beads 1 to ``count - 1``, alpha of the other bonds."""

    def __init__(self, request: LegRequest, peg: Peg | None, tip: tuple[float, float]) -> None:
        self.request, self.peg, self.phi = request, peg, request.half_angle_rad
        self.rows = Rows([request])
        strand = request.strand
        self.held_pa = float(strand.law.stress(1.0 + request.strain))
        self.radius = peg.radius_m / strand.spacing_m if peg else math.inf
        self.weight = np.full(request.bonds, strand.angle_coefficient_j / (request.tension_n * strand.spacing_m))
        self.factor = np.ones(request.bonds)
        self.weight[0] *= tip[0]
        self.factor[0] = tip[1]
        # Of beads without end: the angles of the bonds, and that between beads on the circle.
        opening = math.pi / 2.0 - self.phi
        lift_off, wrapped = (peg.lift_off_rad, peg.wrapped_m) if peg else (opening, 0.0)
        self.free = np.minimum(exact_angles(request, lift_off, wrapped), opening)
        self.step = strand.spacing_m * peg.stretch / peg.radius_m if peg else 0.0
        self.on_circle = 0
        self.at: Array | None = None

    def start(self, count: int, near: Array | None) -> Array:
        """Unknowns to begin with: of beads without end, or those ``near`` with one bead more or less on the circle.

        A bead that goes onto the circle does so along its radius; a bond that leaves it keeps its direction.
        """
        if near is None:
            return np.concatenate([self.step * np.arange(1, count), self.free[count - 1 :]])
        at, more = near.copy(), self.on_circle < count
        last = count - 2 if more else count - 1  # the unknown that changes its meaning
        if more:
            x, y = self.leg(near, self.on_circle).positions_m[last + 1]
            at[last] = math.atan2(y, self.radius * self.request.strand.spacing_m - x)
        else:
            at[last] = math.pi / 2.0 - self.phi - 0.5 * (near[last] + (near[last - 1] if last else 0.0))
        return at

    def settled(self, count: int, near: Array | None = None) -> Array:
        """Unknowns in equilibrium with so many beads on the circle; RunError where there is none to be found."""

        def step(at: Array) -> tuple[float, Callable[[float], Array]]:
            gradient, blocks = self.derivatives(at, count)
            right = np.zeros((blocks.shape[1], 2, 1))
            right.ravel()[: len(at)] = -gradient
            move = solve_blocks(blocks, right).ravel()[: len(at)]
            # Chords keep more than half of their length, and no bond turns over.
            chords = self.radius * np.diff(move[: count - 1], prepend=0.0) if count > 1 else move[:0]
            change = max(float(np.abs(chords).max(initial=0.0)), float(np.abs(move).max()))
            return min(1.0, 0.5 / max(change, 0.5)), lambda share: at + share * move

        unknown, error = damped_newton(self.start(count, near), lambda at: self.imbalance(at, count), step, _GOAL)
        if not error <= BOUND:
            raise no_equilibrium(error)
        if (self.request.strand.law.tangent(self.chords(unknown, count)) <= 0.0).any():
            raise RunError(
                explain(
                    "the band on its peg is stretched past its tension peak",
                    f"{count} beads on the peg",
                    "more of them, which share the turning",
                    "raise --beads",
                ),
                "no-equilibrium",
            )
        self.on_circle = count
        return unknown

    def imbalance(self, at: Array, count: int) -> float:
        """Largest moment out of balance on a free bond over T a, or force along the circle on a bead over T."""
        gradient = self._gradient(at, count)[0].copy()
        gradient[: count - 1] /= self.radius
        return float(np.abs(gradient).max())

    def _gradient(self, at: Array, count: int) -> tuple[Array, Array, Array, Array, Array]:
        """:meth:`_terms`, made once for each state."""
        if at is not self.at:
            self.at, self.terms = at, self._terms(at, count)
        return self.terms

    def _terms(self, at: Array, count: int) -> tuple[Array, Array, Array, Array, Array]:
        """Gradient; derivatives of turning by the unknown of the same number and the two before; terms of stretch."""
        chords, alpha = count - 1, at[count - 1 :]
        slope = np.ones(len(at))  # of each bond's direction, by its own unknown and the one before
        slope[:chords] = -0.5
        before = np.zeros(len(at))
        before[1:chords] = -0.5
        theta = np.concatenate([[0.0], at[:chords]])
        direction = np.concatenate([math.pi / 2.0 - 0.5 * (theta[1:] + theta[:-1]), self.phi + alpha])
        turning = self.factor * -np.diff(direction, prepend=math.pi / 2.0)
        _, bend, curve = QUARTIC.by_angle(turning)
        own, one, two = -slope, -before, np.zeros(len(at))
        one[1:] += slope[:-1]
        two[1:] = before[:-1]
        turns = np.stack([own, one, two]) * self.factor
        moment = self.weight * bend
        gradient = turns[0] * moment
        gradient[:-1] += (turns[1] * moment)[1:]
        gradient[:-2] += (turns[2] * moment)[2:]

        # A chord's stretch by the difference of its angles; a free bond's energy by its own.
        law, r, half = self.request.strand.law, self.radius, 0.5 * np.diff(theta)
        diagonal, beside = np.zeros(len(at)), np.zeros(len(at))
        if chords:
            stretch = self.chords(at, count)
            pull = law.stress(stretch) / self.held_pa
            force = pull * r * np.cos(half)
            stiff = law.tangent(stretch) / self.held_pa * (r * np.cos(half)) ** 2 - 0.5 * pull * r * np.sin(half)
            gradient[:chords] += force
            gradient[: chords - 1] -= force[1:]
            diagonal[:chords] += stiff
            diagonal[: chords - 1] += stiff[1:]
            beside[1:chords] = -stiff[1:]
            gradient[chords - 1] -= r * math.sin(theta[-1] + self.phi)
            diagonal[chords - 1] -= r * math.cos(theta[-1] + self.phi)
        free = self.free_stretches(alpha)
        gradient[chords:] += free * np.sin(alpha)
        diagonal[chords:] += free * np.cos(alpha) - self.held_pa / law.tangent(free) * np.sin(alpha) ** 2
        return gradient, turns, self.weight * curve, diagonal, beside

    def chords(self, at: Array, count: int) -> Array:
        """Stretches of the bonds between beads on the circle."""
        stretch: Array = (
            2.0 * self.radius * np.sin(0.5 * np.diff(at[: count - 1], prepend=0.0)) if count > 1 else at[:0]
        )
        return stretch

    def free_stretches(self, alpha: Array) -> Array:
        """Stretches of free bonds by their angles to the leg's line."""
        found: Array = self.rows.stretches(self.held_pa * np.cos(alpha)[None, :])[0]
        return found

    def derivatives(self, at: Array, count: int) -> tuple[Array, Array]:
        """Gradient, and the pentadiagonal Hessian as blocks of :func:`beadband.statics.chain.solve_blocks`."""
        gradient, turns, stiff, diagonal, first = self._gradient(at, count)
        second = np.zeros(len(at))  # each with the unknown two before
        diagonal, first = diagonal + stiff * turns[0] ** 2, first + stiff * turns[0] * turns[1]
        diagonal[:-1] += (stiff * turns[1] ** 2)[1:]
        diagonal[:-2] += (stiff * turns[2] ** 2)[2:]
        first[1:-1] += (stiff * turns[1] * turns[2])[2:]
        second += stiff * turns[0] * turns[2]
        size = len(at) + len(at) % 2
        pad = np.zeros((3, size))
        pad[0, len(at) :] = 1.0
        pad[:, : len(at)] = diagonal, first, second
        blocks = np.zeros((3, size // 2, 2, 2))
        blocks[0, :, 0, 0], blocks[0, :, 1, 1] = pad[0, ::2], pad[0, 1::2]
        blocks[0, :, 0, 1] = blocks[0, :, 1, 0] = pad[1, 1::2]
        blocks[1, :-1, 1, 0] = pad[1, 2::2]
        blocks[1, :-1, 0, 0], blocks[1, :-1, 1, 1] = pad[2, 2::2], pad[2, 3::2]
        return gradient, blocks

    def leg(self, at: Array, count: int) -> Leg:
        """The leg of the unknowns, its tip at the origin."""
        a, alpha = self.request.strand.spacing_m, at[count - 1 :]
        stretch = self.free_stretches(alpha)
        free = laid_out(a, alpha, stretch, self.phi, self.request.tension_n, self.imbalance(at, count))
        if count == 1:
            return free
        theta = np.concatenate([[0.0], at[: count - 1]])
        circle = self.radius * a * np.stack([1.0 - np.cos(theta), np.sin(theta)], axis=1)
        return Leg(np.concatenate([circle, circle[-1] + free.positions_m[1:]]), *_rest(free))

    def overlaps(self, at: Array, count: int) -> bool:
        """Whether a free bead lies inside the circle."""
        points = self.leg(at, count).positions_m[count:]
        radius = self.radius * self.request.strand.spacing_m
        return bool(np.hypot(points[:, 0] - radius, points[:, 1]).min() < radius * (1.0 - _INSIDE))


def _rest(leg: Leg) -> tuple[float, float, float]:
    return leg.tension_n, leg.half_angle_rad, leg.net_force
