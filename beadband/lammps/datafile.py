"""LAMMPS data files: beads, masses, bonds, angles and the box, numbers to the last digit."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from beadband.model.calibration import Strand
from beadband.statics.leg import Leg
from beadband.statics.ring import Ring
from beadband.statics.strip import Strip

Array = NDArray[np.float64]
Indices = NDArray[np.int64]
Box = tuple[tuple[float, float], tuple[float, float], tuple[float, float]]


def data_file(
    title: str,
    positions_m: Array,
    types: Indices,
    masses_kg: Sequence[float],
    bonds: Indices,
    angles: Indices,
    box_m: Box,
    angle_types: Indices | None = None,
    velocities_m_s: Array | None = None,
) -> str:
    """A data file of beads in the plane, for ``atom_style angle``.

    Parameters
    ----------
    title
        First line of the file.
    positions_m, velocities_m_s
        Shape (beads, 2); beads are at rest without velocities.
    types
        Shape (beads,), from 1; ``masses_kg`` holds the mass of each type.
    bonds, angles
        Indices of beads from 0, shapes (bonds, 2) and (angles, 3), in the order in which LAMMPS gets them.
    box_m
        Ends of the box along x, y and z.
    angle_types
        Shape (angles,); all 1 if left out.
    """
    kinds = np.ones(len(angles), dtype=np.int64) if angle_types is None else angle_types
    box = "".join(f"{low:.17g} {high:.17g} {axis}lo {axis}hi\n" for axis, (low, high) in zip("xyz", box_m, strict=True))
    head = (
        f"beadband: {title}, units = si\n\n{len(positions_m)} atoms\n{len(bonds)} bonds\n{len(angles)} angles\n"
        f"{len(masses_kg)} atom types\n1 bond types\n{max(kinds.tolist(), default=1)} angle types\n\n{box}"
    )
    x, y = positions_m.T.tolist()
    ids = range(1, len(x) + 1)
    sections = {
        "Masses": [f"{kind} {mass:.17g}\n" for kind, mass in enumerate(masses_kg, 1)],
        # repr is the shortest text that gives the number again, and quicker than 17 digits.
        "Atoms # angle": [
            f"{i} 1 {kind} {px!r} {py!r} 0\n" for i, kind, px, py in zip(ids, types.tolist(), x, y, strict=True)
        ],
        "Bonds": [f"{n} 1 {i} {j}\n" for n, (i, j) in enumerate((bonds + 1).tolist(), 1)],
        "Angles": [
            f"{n} {kind} {i} {j} {k}\n"
            for n, (kind, (i, j, k)) in enumerate(zip(kinds.tolist(), (angles + 1).tolist(), strict=True), 1)
        ],
    }
    if velocities_m_s is not None:
        speeds = zip(ids, velocities_m_s.tolist(), strict=True)
        sections["Velocities"] = [f"{i} {vx!r} {vy!r} 0\n" for i, (vx, vy) in speeds]
    return head + "".join(f"\n{name}\n\n{''.join(rows)}" for name, rows in sections.items() if rows)


def closed_chain(beads: int) -> tuple[Indices, Indices]:
    """Bonds and angles of a ring of beads; angle i is that at bead i."""
    index = np.arange(beads)
    after, before = np.roll(index, -1), np.roll(index, 1)
    return np.stack([index, after], axis=1), np.stack([before, index, after], axis=1)


def ring_data(ring: Ring, strand: Strand, ahead_m: float = 0.0) -> str:
    """The held ring, in a box that the release can't leave; ``ahead_m`` is added in front, for a band that flies."""
    x, y = ring.positions_m.T
    margin, half = 0.5 * float(x.max() - x.min()), 0.5 * strand.spacing_m
    box = ((x.min() - margin, x.max() + margin + ahead_m), (y.min() - margin, y.max() + margin), (-half, half))
    return data_file(
        f"a held ring of {ring.beads} beads",
        ring.positions_m,
        ring.types,
        4 * (strand.bead_mass_kg,),
        *closed_chain(ring.beads),
        box,
    )


def strip_data(strip: Strip, strand: Strand) -> str:
    """The held strip, in a box that it can't leave before the front arrives; each end has half the mass of a bead."""
    mass, length = strand.bead_mass_kg, float(strip.positions_m[-1, 0])
    index = np.arange(strip.beads)
    bonds = np.stack([index[:-1], index[1:]], axis=1)
    half = 0.5 * strand.spacing_m
    return data_file(
        f"a held strip of {strip.beads} beads",
        strip.positions_m,
        strip.types,
        (0.5 * mass, mass, mass, 0.5 * mass),
        bonds,
        np.zeros((0, 3), dtype=np.int64),
        ((-0.5 * length, 1.5 * length), (-0.5 * length, 0.5 * length), (-half, half)),
    )


def leg_data(leg: Leg, strand: Strand) -> str:
    """A held leg: the tip (type 1), its guide (2), the leg (3) and the bead at its end (4).

    The guide, one spacing below the tip, moves with it along the axis: the angle between
    the two and the first bond is the half of the tip's turning angle that belongs to this side.
    """
    count, mass, reach = len(leg.positions_m), strand.bead_mass_kg, float(leg.positions_m[-1, 0])
    index = np.arange(count)
    types = np.full(count + 1, 3)
    types[[0, -2, -1]] = 1, 4, 2
    inner = np.stack([index[:-2], index[1:-1], index[2:]], axis=1)
    return data_file(
        f"a held leg of {count} beads and a guide",
        np.concatenate([leg.positions_m, [[0.0, -strand.spacing_m]]]),
        types,
        (0.25 * mass, 0.25 * mass, mass, mass),  # the tip's half of a bead is shared with the guide
        np.stack([index[:-1], index[1:]], axis=1),
        np.concatenate([[[count, 0, 1]], inner]),
        ((-reach, 3.0 * reach), (-reach, 2.0 * reach), (-reach, reach)),
        angle_types=np.r_[2, np.ones(count - 2, dtype=np.int64)],
    )
