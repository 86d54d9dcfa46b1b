"""The elastic finger that a launch leaves, and the stretched ring in equilibrium on it.

The stretched ring of :mod:`beadband.statics.ring` has its wrapped beads on a rigid circle. Here the circle is elastic:
a bead inside it by d is pushed out by k d, along the radius and therefore without friction. The ring settles again on
that support with its tip where it was, so that a launch begins at rest.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from beadband.errors import RunError, explain
from beadband.model.calibration import Strand
from beadband.statics.chain import Array, HalfRing, solve_blocks, whole_ring
from beadband.statics.newton import BOUND, damped_newton, fix
from beadband.statics.ring import Ring

_NET_FORCE_GOAL = 1e-12


@dataclass(frozen=True)
class Support:
    """The finger: lengths in m."""

    stiffness_n_m: float
    """Force on a bead over its depth in the finger, k."""
    radius_m: float
    """Where the force on a bead begins; the wrapped beads lie inside by the depth that carries their load."""
    centre_m: float
    """x of the axis; y is 0."""

    def depths_m(self, positions_m: Array) -> Array:
        """How deep beads (..., 2) are in the finger; negative outside."""
        depths: Array = self.radius_m - np.hypot(positions_m[..., 0] - self.centre_m, positions_m[..., 1])
        return depths

    def energy_j(self, positions_m: Array) -> float:
        """Energy of the support for beads (beads, 2)."""
        return float(0.5 * self.stiffness_n_m * np.sum(np.maximum(self.depths_m(positions_m), 0.0) ** 2))

    def pull_n(self, positions_m: Array) -> float:
        """Force of beads (beads, 2) on the support along x, towards the tip positive: what holds it there."""
        ahead = positions_m[:, 0] - self.centre_m
        pushes = self.stiffness_n_m * np.maximum(self.depths_m(positions_m), 0.0)
        return float(np.sum(pushes * ahead / np.hypot(ahead, positions_m[:, 1])))


def finger_loads_n(ring: Ring, strand: Strand) -> Array:
    """What the rigid finger carries at each bead of the upper half (beads//2 + 1,), N; zero off the finger."""
    half, points = _half(ring, strand)
    outward = points - np.array([ring.finger_centre_m, 0.0])
    outward /= np.hypot(outward[:, 0], outward[:, 1])[:, None]
    loads = np.sum(half.gradient(points) * outward, axis=1)
    if not half.crossing:
        loads[-1] *= 2.0  # half of the bead on the axis belongs to the other side
    loads[ring.types[: len(points)] != 4] = 0.0
    return np.asarray(loads, dtype=np.float64)


def settle_on(ring: Ring, strand: Strand, stiffness_n_m: float) -> tuple[Ring, Support]:
    """The stretched ring, settled on a finger of the given stiffness; RunError when it finds no equilibrium.

    The finger's radius is chosen so that beads under the mean load lie where they did. Newton's method on the
    upper half, the beads in contact found anew in each step.
    """
    half, points = _half(ring, strand)
    loads = finger_loads_n(ring, strand)
    carried = loads[loads > 0.0]
    # On a fine chain few beads carry much at the edge of the contact: the median is that of the uniform part.
    depth = float(np.median(carried)) / stiffness_n_m
    support = Support(stiffness_n_m, ring.finger_radius_m + depth, ring.finger_centre_m)
    # To begin with, each bead at the depth of its own load.
    away = points - np.array([ring.finger_centre_m, 0.0])
    shift = np.where(loads > 0.0, depth - loads / stiffness_n_m, 0.0) / np.hypot(away[:, 0], away[:, 1])
    points = points + shift[:, None] * away
    fixed = np.zeros(points.shape, dtype=bool)
    fixed[0] = True
    if not half.crossing:
        fixed[-1, 1] = True
    share = np.ones(len(points))
    if not half.crossing:
        share[-1] = 0.5

    def unbalanced(at: Array) -> float:
        force = np.where(fixed, 0.0, half.gradient(at) + _push(support, at, share)[0])
        return float(np.linalg.norm(force)) / ring.tension_n

    def step(at: Array) -> tuple[float, Callable[[float], Array]]:
        gradient, blocks = half.derivatives(at)
        pushed, stiff = _push(support, at, share)
        blocks[0] += stiff
        fix(blocks, fixed)
        right = -np.where(fixed, 0.0, gradient + pushed)[:, :, None]
        move = solve_blocks(blocks, right)[:, :, 0]
        # Changes of a quarter of a bond at most: beads that enter or leave the contact make longer ones overshoot.
        change = max(float(np.abs(np.diff(move, axis=0)).max()), 1e-300)
        return min(1.0, 0.25 * strand.spacing_m / change), lambda part: at + part * move

    points, error = damped_newton(points, unbalanced, step, _NET_FORCE_GOAL)
    if not error <= BOUND:
        raise RunError(
            explain(
                "the ring found no equilibrium on the finger",
                f"a net force of {error:.1e} of the tension",
                f"{BOUND:.0e}",
                "change --beads",
            ),
            "no-equilibrium",
        )
    stretching, bending = half.energies(points)
    settled = replace(
        ring,
        positions_m=whole_ring(points, ring.beads),
        net_force=error,
        stretching_j=2.0 * stretching,
        bending_j=2.0 * bending,
    )
    return settled, support


def _half(ring: Ring, strand: Strand) -> tuple[HalfRing, Array]:
    return HalfRing(strand, crossing=ring.beads % 2 == 1), ring.positions_m[: ring.beads // 2 + 1].copy()


def _push(support: Support, points: Array, share: Array) -> tuple[Array, Array]:
    """Gradient (beads, 2) and Hessian blocks (beads, 2, 2) of the support's energy."""
    away = points - np.array([support.centre_m, 0.0])
    distance = np.hypot(away[:, 0], away[:, 1])
    normal = away / distance[:, None]
    depth = np.maximum(support.radius_m - distance, 0.0)
    k = support.stiffness_n_m * share
    gradient = -(k * depth)[:, None] * normal
    along = normal[:, :, None] * normal[:, None, :]
    stiff = np.where(depth > 0.0, k, 0.0)[:, None, None] * along
    stiff -= (k * depth / distance)[:, None, None] * (np.eye(2) - along)
    return gradient, stiff
