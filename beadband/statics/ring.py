"""The stretched ring: where the beads lie while the band is held, in equilibrium of the engine's own energies.

The legs carry exactly the strain and the half-angle of the scene. A bent tip is rounded, so the lines of the legs meet
behind the tip and the finger that closes the band is a little larger than the string's: its radius is solved for, so
that the upper half, loaded at the tip by the tension T of a leg, ends on the axis.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from beadband.errors import RunError, UsageError, explain
from beadband.model.calibration import Strand
from beadband.statics.chain import LONG_CHAIN, Array, HalfRing, solve_blocks, whole_ring
from beadband.statics.newton import BOUND, damped_newton, fix
from beadband.statics.refinement import refined_half

TIP, UPPER, LOWER, WRAPPED = 1, 2, 3, 4
"""Bead types in the data file: the held tip, the two legs, and the beads that lie on the finger."""

FEWEST_BEADS = 24
TOO_FEW_ON_FINGER = "too-few-beads-on-finger"
"""Code of the refusal of a ring with too few beads on its finger."""
_NET_FORCE_GOAL = 1e-11
_FINE = 8
"""Beads in the bending layer from which on the contact is found by the finger's reaction, not bead by bead."""
State = tuple[Array, float]
"""Positions of the upper half, and the finger's radius."""


@dataclass(frozen=True)
class Ring:
    """A stretched ring; positions in m, tip at the origin, finger centre on the positive x axis."""

    positions_m: Array
    """Shape (beads, 2); bead 0 is the tip, then up the upper leg, over the finger and back."""
    types: NDArray[np.int64]
    finger_radius_m: float
    finger_centre_m: float
    """x of the finger's centre."""
    tension_n: float
    """Tension of a leg."""
    net_force: float
    """Largest net force on a free bead, over the tension."""
    stretching_j: float
    bending_j: float

    @property
    def beads(self) -> int:
        return len(self.positions_m)


def stretched_ring(strand: Strand, beads: int, strain: float, half_angle_rad: float) -> Ring:
    """Solve for the stretched ring of ``beads`` beads.

    Newton's method on the upper half. Free beads move in the plane, wrapped ones on the finger's circle (no
    friction); which ones are wrapped follows from the sign of the finger's reaction and of the gap. UsageError when
    the beads are too few to go around the finger, RunError when no equilibrium was found.
    """
    if beads < FEWEST_BEADS:
        raise UsageError(explain("too few beads", beads, f"{FEWEST_BEADS} or more", "raise --beads"), "too-few-beads")
    half = UpperHalf(strand, beads, strain, half_angle_rad)
    points, radius, first = half.held()
    net_force = half.net_force(points, first)
    if not net_force <= half.bound:
        raise no_equilibrium(net_force, half.bound)
    return half.laid_out(points, radius, first, net_force)


def no_equilibrium(net_force: float, bound: float) -> RunError:
    """The error for a net force, over the tension, above its bound."""
    return RunError(
        explain(
            "the stretched ring found no equilibrium",
            f"a net force of {net_force:.1e} of the tension",
            f"{bound:.0e}",
            "change --beads",
        ),
        "no-equilibrium",
    )


class UpperHalf:
    """The upper half of the stretched ring; coordinates with the finger's centre at the origin.

    ``height_m`` is that at which the pull T acts on the tip: 0 for a ring, whose tip lies on the mirror axis.
    """

    def __init__(self, strand: Strand, beads: int, strain: float, half_angle_rad: float, height_m: float = 0.0) -> None:
        self.strand, self.angle, self.stretch, self.height_m = strand, half_angle_rad, 1.0 + strain, height_m
        self.beads = beads
        self.bonds = beads / 2.0  # of the half; a crossing bond counts half
        self.last = beads // 2
        self.ring = HalfRing(strand, crossing=beads % 2 == 1)
        self.tension = strand.area_m2 * float(strand.law.stress(self.stretch))
        self.layer_m = math.sqrt(strand.bending_stiffness_n_m2 / (self.tension * self.stretch))
        self.pull = self.tension * np.array([math.cos(half_angle_rad), math.sin(half_angle_rad)])
        # Rounding of the positions times the stiffest modes of the chain: no net force is known better than that.
        axial = 4.0 * strand.area_m2 * float(strand.law.tangent(self.stretch)) / strand.spacing_m
        bending = 16.0 * strand.bending_stiffness_n_m2 / strand.spacing_m**3
        rounding_m = 0.5 * np.finfo(np.float64).eps * strand.spacing_m * self.stretch * self.bonds
        rounding = rounding_m * (axial + bending) / self.tension
        self.bound = max(BOUND, rounding)
        self.settled = max(BOUND, rounding * math.sqrt(self.last))

    def held(self) -> tuple[Array, float, int]:
        """Positions, the finger's radius and the first bead on it, in equilibrium.

        A long ring begins from one with a quarter of the beads.
        """
        if self.last <= LONG_CHAIN:
            return self.touch_down(*self.first_guess())
        beads = 2 * (self.last // 4)
        spacing = self.strand.spacing_m * 2.0 * self.bonds / beads
        strand = replace(self.strand, spacing_m=spacing)
        coarse = UpperHalf(strand, beads, self.stretch - 1.0, self.angle, self.height_m)
        points, radius, first = coarse.held()
        fine = refined_half(points, self.strand.spacing_m, self.bonds, self.last + 1)
        first = self.check_wrap(round((first - 0.5) * self.bonds / coarse.bonds))
        return self.touch_down(self.on_finger(fine, radius, first), radius, first)

    def first_guess(self) -> tuple[Array, float, int]:
        """Rounded tip of uniform stretch, straight leg, uniform arc: tan(alpha/4) = tan(alpha0/4) exp(-S/l)."""
        a, phi = self.strand.spacing_m, self.angle
        layer = self.layer_m
        reach = (np.arange(self.last) + 0.5) * a
        decay = np.exp(-reach / layer) if layer > 0.0 else np.zeros(self.last)
        alpha = 4.0 * np.arctan(math.tan((math.pi / 2.0 - phi) / 4.0) * decay)
        stretch = np.array(
            [
                self.strand.law.stretch_at(self.tension / self.strand.area_m2 * math.cos(x), self.stretch)
                if x > 1e-6
                else self.stretch
                for x in alpha
            ]
        )
        steps = (a * stretch)[:, None] * np.stack([np.cos(phi + alpha), np.sin(phi + alpha)], axis=1)
        leg = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)]) + np.array([0.0, self.height_m])
        # Distance along the leg's line from its crossing of the axis is bead * bond + ahead, away from the tip.
        bond = a * self.stretch
        ahead = leg[-1, 1] / math.sin(phi) - self.last * bond
        arc = math.tan(phi) * (math.pi / 2.0 + phi)
        touch = (self.bonds * bond - ahead * arc) / (bond * (1.0 + arc))
        first = self.check_wrap(round(touch))
        radius = (ahead + touch * bond) * math.tan(phi)
        points = leg
        apex = leg[-1, 0] - leg[-1, 1] / math.tan(phi)
        points[:, 0] -= apex + radius / math.sin(phi)
        beta = np.maximum(self.bonds - np.arange(self.last + 1), 0.0) * bond / radius
        points[first:] = radius * np.stack([np.cos(beta), np.sin(beta)], axis=1)[first:]
        return points, radius, first

    def check_wrap(self, first: int) -> int:
        """Refuse a finger that fewer than three beads of the half lie on, or a leg of fewer than four."""
        if not 4 <= first <= self.last - 2:
            raise UsageError(
                explain(
                    "too few beads for this finger",
                    f"{2 * self.last} beads, {max(self.last - first + 1, 0)} of a half on the finger",
                    "at least 3 on it and 4 on a leg",
                    "raise --beads",
                ),
                TOO_FEW_ON_FINGER,
            )
        return first

    def on_finger(self, points: Array, radius: float, first: int) -> Array:
        """Push the wrapped beads radially onto the circle."""
        moved = points.copy()
        wrapped = moved[first:]
        moved[first:] = wrapped * (radius / np.hypot(wrapped[:, 0], wrapped[:, 1]))[:, None]
        return moved

    def loads(self, points: Array) -> Array:
        """Net force needed on each bead beyond the pull at the tip (the gradient of the total energy), N."""
        gradient = self.ring.gradient(points)
        gradient[0] += self.pull
        return gradient

    def net_force(self, points: Array, first: int) -> float:
        free = self.loads(points)[:first]
        return float(np.hypot(free[:, 0], free[:, 1]).max()) / self.tension

    def residual(self, points: Array, first: int) -> float:
        """Root of the summed squares of unbalanced forces over the tension, and of the tip's height over a bond.

        Free beads are balanced in the plane, wrapped ones along the finger; inf where bonds have collapsed.
        """
        loads = self.loads(points) / self.tension
        slide = np.sum(loads[first:] * _tangents(points)[first:], axis=1)
        if not self.ring.crossing:
            slide = slide[:-1]
        height = (points[0, 1] - self.height_m) / self.strand.spacing_m
        total = float(np.sum(loads[:first] ** 2) + np.sum(slide**2) + height**2)
        return math.sqrt(total) if math.isfinite(total) else math.inf

    def settle(self, points: Array, radius: float, first: int) -> tuple[Array, float]:
        """Positions and finger radius in equilibrium, or near it, for given wrapped beads, by Newton's method."""

        def step(state: State) -> tuple[float, Callable[[float], State]]:
            at, at_radius = state
            move, d_radius = self._step(at, at_radius, first)
            # Changes of less than half a bond, and of a part of the radius, keep bonds from turning over.
            change = float(np.abs(np.diff(move, axis=0)).max()) / self.strand.spacing_m
            reach = 0.2 * at_radius

            def moved(share: float) -> State:
                new_radius = at_radius + share * d_radius
                new = self.on_finger(at + share * move, new_radius, first)
                if not self.ring.crossing:
                    new[-1] = new_radius, 0.0
                return new, new_radius

            return min(1.0, 0.5 / max(change, 0.5), reach / max(float(np.abs(move).max()), reach)), moved

        goal = _NET_FORCE_GOAL * self.settled / BOUND
        return damped_newton((points, radius), lambda at: self.residual(at[0], first), step, goal, self.settled)[0]

    def _step(self, points: Array, radius: float, first: int) -> tuple[Array, float]:
        """Newton step of the positions and of the radius, which is ruled by the tip's height above the axis."""
        gradient, blocks = self.ring.derivatives(points)
        gradient[0] += self.pull
        count = len(points)
        frame = np.zeros((count, 2, 2))  # columns: the two directions in which a bead may move
        frame[:] = np.eye(2)
        tangent = _tangents(points)
        normal = np.stack([tangent[:, 1], -tangent[:, 0]], axis=1)
        frame[first:, :, 0], frame[first:, :, 1] = normal[first:], tangent[first:]

        # A change of the radius moves all wrapped beads along their normals.
        outward = np.where(np.arange(count)[:, None] >= first, normal, 0.0)
        by_radius = _times(blocks, outward)
        local = np.einsum("iab,ia->ib", frame, gradient)
        push = np.einsum("iab,ia->ib", frame, by_radius)
        turned = np.zeros_like(blocks)
        for k in range(3):
            turned[k, : count - k] = frame[: count - k].transpose(0, 2, 1) @ blocks[k, : count - k] @ frame[k:]
        turned[0, first:, 1, 1] -= local[first:, 0] / radius
        fixed = np.zeros((count, 2), dtype=bool)
        fixed[first:, 0] = True
        if not self.ring.crossing:
            fixed[-1, 1] = True
        fix(turned, fixed)
        right = np.stack([-local, -push], axis=2)
        right[fixed] = 0.0
        solved = solve_blocks(turned, right)
        d_radius = -(points[0, 1] - self.height_m + solved[0, 1, 0]) / solved[0, 1, 1]
        step = np.einsum("iab,ib->ia", frame, solved[:, :, 0] + d_radius * solved[:, :, 1])
        return step + d_radius * outward, float(d_radius)

    def laid_out(self, points: Array, radius: float, first: int, net_force: float) -> Ring:
        """The ring of the half's positions, shifted along the axis so that the tip is the origin."""
        stretching, bending = self.ring.energies(points)
        centre = -float(points[0, 0])
        points = points + np.array([centre, 0.0])
        points[0] = 0.0
        types = np.full(len(points), UPPER)
        types[0] = TIP
        types[first:] = WRAPPED
        lower = types[1 : self.beads - len(points) + 1][::-1].copy()
        lower[lower == UPPER] = LOWER
        return Ring(
            positions_m=whole_ring(points, self.beads),
            types=np.concatenate([types, lower]),
            finger_radius_m=radius,
            finger_centre_m=centre,
            tension_n=self.tension,
            net_force=net_force,
            stretching_j=2.0 * stretching,
            bending_j=2.0 * bending,
        )

    def touch_down(self, points: Array, radius: float, first: int) -> tuple[Array, float, int]:
        """Settle, and find the first bead on the finger: it is pushed, and no free one lies inside.

        Stiffness lifts the band off the finger over about one bending layer; on a fine chain that is many beads,
        most of which are freed at once. From there on the search goes bead by bead: Newton's method converges after
        any change by one bead. On a very fine chain it goes by the reaction at the first bead instead.
        """
        points, radius = self.settle(points, radius, first)
        lift = int(0.8 * self.layer_m / self.strand.spacing_m)
        if lift > _FINE:
            points, radius, first = self.by_reaction(points, radius, first)
        elif lift > 1 and self.pulls(points, first) and first + lift <= self.last - 2:
            jumped, jumped_radius = self.settle(points, radius, first + lift)
            if self.net_force(jumped, first + lift) <= BOUND:
                points, radius, first = jumped, jumped_radius, first + lift
        freed = -1
        while True:
            if self.overlaps(points, radius, first):
                first -= 1
                if first == freed:  # the band leaves the finger between two beads: none may lie inside it
                    points, radius = self.settle(self.on_finger(points, radius, first), radius, first)
                    return points, radius, first
            elif self.pulls(points, first):
                freed = first
                first += 1
            else:
                return points, radius, first
            self.check_wrap(first)
            points, radius = self.settle(self.on_finger(points, radius, first), radius, first)

    def by_reaction(self, points: Array, radius: float, first: int) -> tuple[Array, float, int]:
        """The least first bead on the finger that is pushed: the root of its reaction, by secants within a bracket."""
        state = (points, radius, first)
        pulled, pushed = -1, self.last - 1
        known: list[tuple[int, float]] = []
        while True:
            reaction = float(self.loads(state[0])[state[2]] @ state[0][state[2]])
            known.append((state[2], reaction))
            if reaction < 0.0:
                pulled = state[2]
            else:
                pushed, answer = state[2], state
            if pushed - pulled == 1 and reaction >= 0.0:
                return answer
            guess = state[2] + (1 if reaction < 0.0 else -1) * 2 ** min(len(known) - 1, 12)
            if len(known) > 1:
                (a, fa), (b, fb) = known[-2:]
                root = b - fb * (b - a) / (fb - fa) if fa != fb else guess
                guess = math.ceil(root) if abs(root - b) < 1e6 else guess
            guess = self.check_wrap(min(max(guess, pulled + 1), pushed - (reaction >= 0.0)))
            moved, moved_radius = self.settle(self.on_finger(state[0], state[1], guess), state[1], guess)
            state = (moved, moved_radius, guess)

    def overlaps(self, points: Array, radius: float, first: int) -> bool:
        """Whether a free bead lies inside the finger."""
        return bool(np.any(np.hypot(points[:first, 0], points[:first, 1]) < radius * (1.0 - 1e-12)))

    def pulls(self, points: Array, first: int) -> bool:
        """Whether the finger would have to pull the first bead that lies on it."""
        return float(self.loads(points)[first] @ points[first]) < 0.0


def _tangents(points: Array) -> Array:
    """Unit vectors along the circle through each bead, counter-clockwise."""
    radial = points / np.hypot(points[:, 0], points[:, 1])[:, None]
    return np.stack([-radial[:, 1], radial[:, 0]], axis=1)


def _times(blocks: Array, vector: Array) -> Array:
    """Product of the symmetric matrix of blocks with a vector over beads."""
    product: Array = np.einsum("iab,ib->ia", blocks[0], vector)
    for k in (1, 2):
        product[:-k] += np.einsum("iab,ib->ia", blocks[k, :-k], vector[k:])
        product[k:] += np.einsum("iba,ib->ia", blocks[k, :-k], vector[:-k])
    return product
