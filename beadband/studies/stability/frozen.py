"""The largest stable step of a chain as it stands: exact, for every shape, stretch, angle form and loss.

``fix nve`` takes the forces of dashpots from the velocities half a step back, so that small motions of a chain with
the masses M, the stiffness K and the dashpots C obey

    M (x[n+1] - 2 x[n] + x[n-1]) = -dt^2 K x[n] - dt C (x[n] - x[n-1]).

A solution x[n] = z^n x has, with the Rayleigh quotients k = dt^2 (x, K x)/(x, M x) and c = dt (x, C x)/(x, M x), the
real quadratic z^2 - (2 - k - c) z + 1 - c = 0, whose roots stay within the unit circle as long as k >= 0 and
k + 2 c <= 4. The first motion to grow alternates from step to step (z = -1), and the step is stable if and only if

    4 M - dt^2 K - 2 dt C   is positive definite.

That is a statement about symmetric matrices, whatever modes they have: along, across, at a bend, at the finger. For a
uniform straight chain it is ``Strand.state_step_s`` of the calibration. A chain that is stiffer nowhere has a step
that is smaller nowhere, which makes the uniform chain at the worst stretch of a run a safe bound.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from beadband.model.angle_forms import AngleForm
from beadband.model.calibration import Strand

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Chain:
    """What a chain is made of; its shape is given apart."""

    strand: Strand
    form: AngleForm
    closed: bool
    shares: Array
    """Masses of the beads over that of the strand, shape (beads,)."""
    free: NDArray[np.bool_]
    """Which beads can move, shape (beads,)."""
    finger: Callable[[Array], Array] | None = None
    """Forces of a finger on beads at given places, (beads, 2) both."""


def forces(chain: Chain, points: Array) -> Array:
    """Forces of bonds, angles and finger on the beads at rest, N, shape (beads, 2)."""
    strand = chain.strand
    bonds = (np.roll(points, -1, axis=0) - points) if chain.closed else np.diff(points, axis=0)
    lengths = np.hypot(bonds[:, 0], bonds[:, 1])
    unit = bonds / lengths[:, None]
    pull = (strand.area_m2 * strand.law.stress(lengths / strand.spacing_m))[:, None] * unit
    if chain.closed:
        first, second, along, next_length = unit, np.roll(unit, -1, axis=0), lengths, np.roll(lengths, -1)
    else:
        first, second, along, next_length = unit[:-1], unit[1:], lengths[:-1], lengths[1:]
    cosine = np.sum(first * second, axis=1)
    slope = (strand.angle_coefficient_j * chain.form.by_cosine(cosine)[1])[:, None]
    left = slope * (second - cosine[:, None] * first) / along[:, None]
    right = slope * (first - cosine[:, None] * second) / next_length[:, None]
    result = np.zeros_like(points)
    if chain.closed:
        by_bond = pull + left + np.roll(right, 1, axis=0)
        result = by_bond - np.roll(by_bond, 1, axis=0)
    else:
        by_bond = pull
        by_bond[:-1] += left
        by_bond[1:] += right
        result[:-1] += by_bond
        result[1:] -= by_bond
    return result if chain.finger is None else result + chain.finger(points)


def stiffness(chain: Chain, points: Array) -> Array:
    """Stiffness K = -d(forces)/d(points) in bands: shape (beads, 5, 2, 2), of bead i on i-2 ... i+2 (round a ring).

    Central differences; five beads apart nothing interacts, so that every fifth bead is moved at once.
    """
    count = len(points)
    bands = np.zeros((count, 5, 2, 2))
    small = 1e-6 * chain.strand.spacing_m
    if chain.closed and count % 5:
        groups = [np.arange(start, min(start + 1, count)) for start in range(count)]
    else:
        groups = [np.arange(start, count, 5) for start in range(5)]
    for moved in groups:
        for axis in range(2):
            change = np.zeros_like(points)
            change[moved, axis] = small
            by = (forces(chain, points - change) - forces(chain, points + change)) / (2.0 * small)
            for offset in range(-2, 3):
                rows = moved - offset  # bead i = moved - offset feels moved = i + offset
                inside = np.ones(len(rows), dtype=bool) if chain.closed else (rows >= 0) & (rows < count)
                bands[rows[inside] % count, offset + 2, :, axis] = by[rows[inside] % count]
    return bands


def dashpots(chain: Chain, points: Array, loss_time_s: float) -> Array:
    """Matrix C of the dashpots along the bonds, in the bands of :func:`stiffness`."""
    count = len(points)
    bands = np.zeros((count, 5, 2, 2))
    bonds = (np.roll(points, -1, axis=0) - points) if chain.closed else np.diff(points, axis=0)
    unit = bonds / np.hypot(bonds[:, 0], bonds[:, 1])[:, None]
    block = chain.strand.dashpot_n_s_m(loss_time_s) * unit[:, :, None] * unit[:, None, :]
    first = np.arange(len(bonds))
    second = (first + 1) % count
    bands[first, 2] += block
    bands[second, 2] += block
    bands[first, 3] -= block
    bands[second, 1] -= block
    return bands


def largest_step_s(chain: Chain, points: Array, loss_time_s: float = 0.0, at_most_s: float = math.inf) -> float:
    """Largest stable step of velocity Verlet in this very shape, s: where 4 M - dt^2 K - 2 dt C loses definiteness.

    ``at_most_s`` is returned where the limit is not below it.
    """
    stiff, damping = stiffness(chain, points), dashpots(chain, points, loss_time_s)
    mass = chain.strand.bead_mass_kg * chain.shares

    def stable(step: float) -> bool:
        return _definite(chain, mass, step**2 * stiff + 2.0 * step * damping)

    if math.isfinite(at_most_s) and stable(at_most_s):
        return at_most_s
    # A step that is surely too large: no largest mode is slower than the largest diagonal term.
    diagonal = np.einsum("ijj->ij", stiff[:, 2])[chain.free] / mass[chain.free, None]
    low, high = 0.0, min(2.0 / math.sqrt(float(diagonal.max())), at_most_s)
    while high - low > 1e-6 * high:
        middle = 0.5 * (low + high)
        if stable(middle):
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


def _definite(chain: Chain, mass: Array, bands: Array) -> bool:
    """Whether 4 M less a banded matrix is positive definite on the free beads."""
    count = len(mass)
    if chain.closed:
        dense = np.zeros((count, 2, count, 2))
        index = np.arange(count)
        for offset in range(-2, 3):
            dense[index, :, (index + offset) % count, :] -= bands[:, offset + 2]
        dense[index, 0, index, 0] += 4.0 * mass
        dense[index, 1, index, 1] += 4.0 * mass
        whole = dense.reshape(2 * count, 2 * count)
        keep = np.repeat(chain.free, 2)
        try:
            np.linalg.cholesky(whole[np.ix_(keep, keep)])
        except np.linalg.LinAlgError:
            return False
        return True
    from scipy.linalg import LinAlgError, cholesky_banded

    # Lower bands: entry d, column j is the element (j + d, j); fixed beads keep a 1 of their own.
    lower = np.zeros((6, 2 * count))
    free = chain.free
    index = np.arange(count)
    for offset in range(3):
        rows = index[offset:]
        both = free[rows] & free[rows - offset]
        for row_axis in range(2):
            for column_axis in range(2):
                d = 2 * offset + row_axis - column_axis
                if d < 0:
                    continue
                values = -bands[rows, 2 - offset, row_axis, column_axis]
                if offset == 0 and row_axis == column_axis:
                    values = values + 4.0 * mass
                lower[d, 2 * (rows - offset) + column_axis] = np.where(both, values, 0.0)
    scale = 4.0 * float(mass.max())
    lower /= scale
    fixed = np.repeat(~free, 2)
    lower[0, fixed] = 1.0
    try:
        cholesky_banded(lower, lower=True, check_finite=False)
    except LinAlgError:
        return False
    return True


def met(chain: Chain, shapes: Array, loss_time_s: float) -> float:
    """Smallest of the largest steps over the shapes that a run went through, (frames, beads, 2)."""
    least = math.inf
    for points in shapes:
        least = largest_step_s(chain, points, loss_time_s, least)
    return least


def softened(chain: Chain, share: float) -> Chain:
    """The chain with a share of its bending stiffness."""
    strand = replace(chain.strand, bending_stiffness_n_m2=share * chain.strand.bending_stiffness_n_m2)
    return replace(chain, strand=strand)


def respa_growth(outer_rate2: Array, inner_rate2: Array, outer_loss: Array, step_s: float, inner_steps: int) -> Array:
    """Largest factor per step by which modes grow under rRESPA, with outer and inner w^2 (1/s2) and outer c (1/s).

    The outer forces, dashpots among them, act as one kick a step; between two of them velocity Verlet takes
    ``inner_steps`` steps of the inner forces. Resonance: the kicks meet the same phase of the inner motion again and
    again, wherever the step is near a multiple of half its period.
    """
    h = step_s / inner_steps
    zero, one = np.zeros_like(inner_rate2), np.ones_like(inner_rate2)
    half = np.array([[one, zero], [-0.5 * h * inner_rate2, one]])
    drift = np.array([[one, h * one], [zero, one]])
    half, drift = (np.moveaxis(matrix, (0, 1), (-2, -1)) for matrix in (half, drift))
    inner = half @ drift @ half
    kick = np.moveaxis(np.array([[one, zero], [-step_s * outer_rate2, one - step_s * outer_loss]]), (0, 1), (-2, -1))
    whole = np.linalg.matrix_power(inner, inner_steps) @ kick
    return np.asarray(np.abs(np.linalg.eigvals(whole)).max(axis=-1), dtype=np.float64)
