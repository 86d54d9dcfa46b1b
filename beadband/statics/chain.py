"""Mechanics of half a mirror-symmetric ring of beads: energy, gradient and Hessian, exactly those of the engine.

The half runs from the tip (bead 0, on the mirror axis y = 0) to the front. With an even number of beads the last one
lies on the axis too; with an odd number the last bond crosses it. Arrays over beads have shape (beads, 2).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beadband.model.angle_forms import QUARTIC
from beadband.model.calibration import Strand

Array = NDArray[np.float64]

_MIRROR = np.diag([-1.0, 1.0])
"""A bond b and its mirror image make the cosine b.(S b)/b^2 at a bead on the axis."""
_DOWN = np.array([0.0, -1.0])


@dataclass(frozen=True)
class HalfRing:
    """Half of a ring: ``strand`` gives the energies, ``crossing`` says that the last bond crosses the axis."""

    strand: Strand
    crossing: bool

    def energies(self, points: Array) -> tuple[float, float]:
        """Stretching and bending energy of this half, J; inf where two beads coincide."""
        bonds = np.diff(points, axis=0)
        lengths = np.hypot(bonds[:, 0], bonds[:, 1])
        if not lengths.min() > 0.0:
            return np.inf, np.inf
        law, a, bend = self.strand.law, self.strand.spacing_m, QUARTIC.by_cosine
        unit = bonds / lengths[:, None]
        stretching = float(np.sum(law.energy(lengths / a)))
        cosines = np.sum(unit[:-1] * unit[1:], axis=1)
        bending = float(np.sum(bend(cosines)[0]) + 0.5 * bend(unit[0] @ _MIRROR @ unit[0])[0])
        if self.crossing:
            stretching += 0.5 * float(law.energy(2.0 * points[-1, 1] / a))
            bending += float(bend(unit[-1] @ _DOWN)[0])
        else:
            bending += 0.5 * float(bend(unit[-1] @ _MIRROR @ unit[-1])[0])
        return a * self.strand.area_m2 * stretching, self.strand.angle_coefficient_j * bending

    def gradient(self, points: Array) -> Array:
        """Derivative of this half's energy by the position of each bead, N."""
        return self._derivatives(points, False)[0]

    def derivatives(self, points: Array) -> tuple[Array, Array]:
        """Gradient, and Hessian blocks ``H[k, i]`` between beads i and i + k, k = 0, 1, 2; shape (3, beads, 2, 2)."""
        return self._derivatives(points, True)

    def _derivatives(self, points: Array, curvature: bool) -> tuple[Array, Array]:
        strand = self.strand
        law, a, area, stiff = strand.law, strand.spacing_m, strand.area_m2, strand.angle_coefficient_j
        count = len(points)
        bonds = np.diff(points, axis=0)
        lengths = np.hypot(bonds[:, 0], bonds[:, 1])
        unit = bonds / lengths[:, None]
        stretch = lengths / a
        tension = area * law.stress(stretch)

        # Derivatives by the bond vectors first: diagonal terms, and the coupling of successive bonds.
        by_bond = tension[:, None] * unit
        eye = np.eye(2)
        parallel = unit[:, :, None] * unit[:, None, :]
        across = eye - parallel

        # Every angle is a cosine c; energy K f(c) has the gradient K f' grad c and the Hessian
        # K (f' hess c + f'' grad c grad c^T).
        cosine = np.sum(unit[:-1] * unit[1:], axis=1)
        left = (unit[1:] - cosine[:, None] * unit[:-1]) / lengths[:-1, None]
        right = (unit[:-1] - cosine[:, None] * unit[1:]) / lengths[1:, None]
        _, slopes, curves = QUARTIC.by_cosine(cosine)
        force = stiff * slopes
        by_bond[:-1] += force[:, None] * left
        by_bond[1:] += force[:, None] * right
        ends = [(0, 0.5, *_self_cosine(unit[0], lengths[0]))]
        if self.crossing:
            ends.append((-1, 1.0, *_fixed_cosine(unit[-1], lengths[-1])))
        else:
            ends.append((-1, 0.5, *_self_cosine(unit[-1], lengths[-1])))
        for bond, weight, value, slope, _ in ends:
            by_bond[bond] += weight * stiff * QUARTIC.by_cosine(value)[1] * slope

        gradient = np.zeros((count, 2))
        gradient[1:] += by_bond
        gradient[:-1] -= by_bond
        closing = 2.0 * points[-1, 1] / a
        if self.crossing:
            gradient[-1, 1] += area * law.stress(closing)
        if not curvature:
            return gradient, np.empty(0)

        diagonal = (area * law.tangent(stretch) / a)[:, None, None] * parallel
        diagonal += (tension / lengths)[:, None, None] * across
        curve = (stiff * curves)[:, None, None]
        push = force[:, None, None]
        diagonal[:-1] += push * _cosine_hessian(left, unit[:-1], across[:-1], cosine, lengths[:-1])
        diagonal[:-1] += curve * left[:, :, None] * left[:, None, :]
        diagonal[1:] += push * _cosine_hessian(right, unit[1:], across[1:], cosine, lengths[1:])
        diagonal[1:] += curve * right[:, :, None] * right[:, None, :]
        coupling = push * (across[:-1] @ across[1:]) / (lengths[:-1] * lengths[1:])[:, None, None]
        coupling += curve * left[:, :, None] * right[:, None, :]
        for bond, weight, value, slope, hessian in ends:
            _, first, second = QUARTIC.by_cosine(value)
            diagonal[bond] += weight * (stiff * first * hessian + stiff * second * np.outer(slope, slope))

        # Bond i is bead i+1 minus bead i.
        blocks = np.zeros((3, count, 2, 2))
        blocks[0, 1:] += diagonal
        blocks[0, :-1] += diagonal
        blocks[1, :-1] -= diagonal
        blocks[0, 1:-1] -= coupling + coupling.transpose(0, 2, 1)
        blocks[1, :-2] += coupling
        blocks[1, 1:-1] += coupling
        blocks[2, :-2] -= coupling
        if self.crossing:
            blocks[0, -1, 1, 1] += 2.0 * area * law.tangent(closing) / a
        return gradient, blocks


def _cosine_hessian(slope: Array, unit: Array, across: Array, cosine: Array, lengths: Array) -> Array:
    """Second derivative of the cosine between two bonds by one of them, whose slope is given."""
    outer = slope[:, :, None] * unit[:, None, :]
    bent = (cosine / lengths**2)[:, None, None] * across
    return -(outer + outer.transpose(0, 2, 1)) / lengths[:, None, None] - bent


def _self_cosine(unit: Array, length: float) -> tuple[Array, Array, Array]:
    """Cosine b.(S b)/b^2 between a bond b and its mirror image, its gradient and its Hessian."""
    value = unit @ _MIRROR @ unit
    slope = 2.0 * (_MIRROR @ unit - value * unit) / length
    outer = np.outer(slope, unit)
    return value, slope, 2.0 * ((_MIRROR - value * np.eye(2)) / length - outer - outer.T) / length


def _fixed_cosine(unit: Array, length: float) -> tuple[Array, Array, Array]:
    """Cosine between a bond and the downward direction of a crossing bond, its gradient and its Hessian."""
    value = unit @ _DOWN
    slope = (_DOWN - value * unit) / length
    outer = np.outer(slope, unit)
    return value, slope, -(outer + outer.T) / length - value * (np.eye(2) - np.outer(unit, unit)) / length**2


LONG_CHAIN = 2000
"""Beads of a half from which on scipy's banded solver is quicker, its import included."""
_BAND = 5  # the farthest coupled coordinates: those across two beads


def _solve_banded(blocks: Array, right: Array) -> Array:
    """The like of :func:`solve_blocks` by LAPACK, in time and memory proportional to the beads."""
    from scipy.linalg import solve_banded

    count, _, columns = right.shape
    band = np.zeros((2 * _BAND + 1, 2 * count))
    for offset in range(3):
        for row in range(2):
            for column in range(2):
                across = 2 * offset + column - row
                value = blocks[offset, : count - offset, row, column]
                band[_BAND - across, 2 * offset + column :: 2][: len(value)] = value
                if offset:
                    band[_BAND + across, row::2][: len(value)] = value
    solved: Array = solve_banded((_BAND, _BAND), band, right.reshape(2 * count, columns), check_finite=False)
    if not np.isfinite(solved).all():
        raise np.linalg.LinAlgError("singular")
    return solved.reshape(count, 2, columns)


def solve_blocks(blocks: Array, right: Array, beads_a_block: int = 16) -> Array:
    """Solve H x = right for the symmetric pentadiagonal (in beads) matrix of :meth:`HalfRing.derivatives`.

    ``blocks`` (3, beads, 2, 2), ``right`` (beads, 2, columns). Beads are gathered into blocks that couple only to the
    next, and eliminated in turn; numpy alone, for importing scipy's banded solver takes longer than a release. A long
    chain is worth that import. Raises numpy.linalg.LinAlgError when singular.
    """
    count, columns = right.shape[0], right.shape[2]
    if count > LONG_CHAIN:
        return _solve_banded(blocks, right)
    size = 2 * beads_a_block
    parts = -(-count // beads_a_block)
    padded = parts * beads_a_block
    dense = np.zeros((parts, beads_a_block, 2, 2, beads_a_block, 2))  # part, bead, axis, (same | next), bead, axis
    for offset in range(3):
        index = np.arange(count - offset)
        part, row = np.divmod(index, beads_a_block)
        other_part, column = np.divmod(index + offset, beads_a_block)
        dense[part, row, :, other_part - part, column, :] = blocks[offset, index]
        if offset:
            same = other_part == part
            dense[part[same], column[same], :, 0, row[same], :] = blocks[offset, index[same]].transpose(0, 2, 1)
    pad = np.arange(count, padded) - (parts - 1) * beads_a_block
    for axis in range(2):
        dense[parts - 1, pad, axis, 0, pad, axis] = 1.0
    same_block = dense[:, :, :, 0].reshape(parts, size, size)
    next_block = dense[:, :, :, 1].reshape(parts, size, size)
    rhs = np.zeros((padded, 2, columns))
    rhs[:count] = right
    rhs = rhs.reshape(parts, size, columns)

    # Forward elimination with the reduced blocks kept, then back substitution.
    forward = np.empty((parts, size, size))
    reduced = np.empty_like(rhs)
    pivot, load = same_block[0], rhs[0]
    for k in range(parts):
        solved = np.linalg.solve(pivot, np.concatenate([next_block[k], load], axis=1))
        forward[k], reduced[k] = solved[:, :size], solved[:, size:]
        if k + 1 < parts:
            pivot = same_block[k + 1] - next_block[k].T @ forward[k]
            load = rhs[k + 1] - next_block[k].T @ reduced[k]
    for k in range(parts - 2, -1, -1):
        reduced[k] -= forward[k] @ reduced[k + 1]
    return reduced.reshape(padded, 2, columns)[:count]


def whole_ring(half: Array, beads: int) -> Array:
    """All ``beads`` positions of a ring from those of its upper half, shape (beads, 2)."""
    return np.concatenate([half, half[1 : beads - len(half) + 1][::-1] * np.array([1.0, -1.0])])
