"""Rungs ``bond`` and ``bending``: what LAMMPS makes of the bond table and of the angle energy, at rest."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from beadband.lammps.bond_table import DEEPEST_STRETCH
from beadband.model.bands import CATALOGUE, laws_of
from beadband.model.calibration import Strand
from beadband.model.scene import scene_of
from beadband.studies.verification import specimen as specimens
from beadband.studies.verification.check import Check
from beadband.studies.verification.specimen import END, FIXED, FREE, Array, Specimen, chain, frequency_rad_s, strand_of

_LENGTHS = 300
_STRAIN = 0.476
_DIFFERENCE = 1e-4
"""Half the difference of stretches from which a tangent is taken."""


def bond() -> list[Check]:
    """Force, tangent and energy of LAMMPS' bond against the law, over all lengths of the table, compression included.

    Tension A stress(r/a) and its slope by r/a, A tangent(r/a), in units of A E0, for the tension itself passes
    through 0; tangents beyond it (deep compression) relative to themselves. The energy a A W(r/a) is that of all bonds
    together. The lengths fall anywhere between the points of the table; tangents are central differences of forces.
    """
    checks = []
    for law in laws_of("III"):
        errors, held = [], math.nan
        for band in CATALOGUE:
            strand = strand_of(band, law, 1e-3)
            stretch, force, tangent, energy_error = _bond_response(strand)
            rest = strand.area_m2 * strand.law.rest_modulus_pa
            force_error = np.abs(force - strand.area_m2 * strand.law.stress(stretch)) / rest
            tangent_error = np.abs(tangent - strand.area_m2 * strand.law.tangent(stretch)) / np.maximum(
                rest, strand.area_m2 * strand.law.tangent(stretch)
            )
            errors.append((force_error.max(), tangent_error.max(), energy_error))
            if band == "III":
                held = float(force[-1])
        worst_force, worst_tangent, worst_energy = np.max(errors, axis=0).tolist()  # keeps a NaN, as max() would not
        exact = CATALOGUE["III"].area_m2 * float(scene_of({"law": law}).material.stress(1.0 + _STRAIN))
        checks += [
            Check("bond", f"{law}: tension at the strain {_STRAIN}, band III (N)", held, exact, 1e-8),
            Check("bond", f"{law}: worst force error, all bands (of A E0)", worst_force, 0.0, 1e-8),
            Check("bond", f"{law}: worst tangent error, all bands (of A E0)", worst_tangent, 0.0, 3e-6),
            Check("bond", f"{law}: worst error of the energy of all bonds, all bands (of it)", worst_energy, 0.0, 1e-8),
        ]
    return checks


def _bond_response(strand: Strand) -> tuple[Array, Array, Array, float]:
    """Stretches, tensions (N), tangents (N per unit of stretch) of single bonds, and the error of their energy."""
    ends = np.array([DEEPEST_STRETCH, 1.0 + 1.25 * _STRAIN])
    stretch = np.linspace(ends[0] + 2.0 * _DIFFERENCE, ends[1] - 2.0 * _DIFFERENCE, _LENGTHS)
    stretch = np.append(stretch, 1.0 + _STRAIN)
    lengths = strand.spacing_m * np.concatenate([stretch - _DIFFERENCE, stretch, stretch + _DIFFERENCE])
    points = np.zeros((2 * len(lengths), 2))
    points[1::2, 0] = lengths
    points[:, 1] = 4.0 * strand.spacing_m * np.repeat(np.arange(len(lengths)), 2)
    bonds = np.arange(2 * len(lengths)).reshape(-1, 2)
    record = specimens.run(
        Specimen(
            strand,
            points,
            np.full(len(points), FREE),
            bonds,
            np.empty((0, 3), dtype=np.int64),
            np.zeros_like(points),
            _STRAIN,
        )
    )
    below, at, above = np.split(record.first_forces_n[::2, 0], 3)
    energy = strand.spacing_m * strand.area_m2 * float(np.sum(strand.law.energy(lengths / strand.spacing_m)))
    error = abs(float(record.stretching_j[0]) / energy - 1.0)
    return stretch, at, (above - below) / (2.0 * _DIFFERENCE), error


def bending() -> list[Check]:
    """Energy of beads on a circle, and a clamped strip: deflection under a load at its end, and its frequencies.

    * Circle of N beads: the angle energy is EI/2 (psi/a)^2 a N (1 - psi^4/90), psi = 2 pi/N; the departure from
      EI/2 kappa^2 is of the fourth order.
    * Strip of length L: P L^3/(3 EI), and w_i = b_i^2 a_b/L^2 with b = 1.8751, 4.6941 (Euler-Bernoulli). A hinge at
      each bead turns by M a/EI, so the clamp stands midway between the two beads that are held.
    """
    strand = strand_of("III", "linear", 1e-3)
    return _circles(strand) + _strip(strand)


def _circles(strand: Strand) -> list[Check]:
    ratios = []
    counts = (10, 20, 40)
    for count in counts:
        record = specimens.run(circle(strand, count))
        exact = 0.5 * strand.bending_stiffness_n_m2 * (2.0 * math.pi) ** 2 / (count * strand.spacing_m)
        ratios.append(float(record.bending_j[0]) / exact)
    departures = [1.0 - ratio for ratio in ratios]
    order = math.log(departures[0] / departures[-1]) / math.log(counts[-1] / counts[0])
    energy = 0.5 * strand.bending_stiffness_n_m2 * (2.0 * math.pi) ** 2 / (counts[-1] * strand.spacing_m)
    return [
        Check("bending", f"energy of a circle of {counts[-1]} beads (J)", ratios[-1] * energy, energy, 2e-5),
        Check(
            "bending",
            f"its departure with {counts[0]} beads, psi^4/90",
            departures[0],
            (2.0 * math.pi / counts[0]) ** 4 / 90.0,
            0.1,
        ),
        Check("bending", "order of that departure", order, 4.0, 0.02),
    ]


def circle(strand: Strand, count: int) -> Specimen:
    """A closed ring at rest: a polygon of bonds of the reference length."""
    angle = 2.0 * math.pi * np.arange(count) / count
    radius = strand.spacing_m / (2.0 * math.sin(math.pi / count))
    points = radius * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return chain(strand, points, np.full(count, FREE), closed=True)


def _strip(strand: Strand, count: int = 40) -> list[Check]:
    """A strip of ``count`` free beads beyond two held ones; small deflections of a thousandth of its length."""
    a, stiffness = strand.spacing_m, strand.bending_stiffness_n_m2
    line = np.stack([a * np.arange(-1, count + 1), np.zeros(count + 2)], axis=1)
    types = np.full(count + 2, FREE)
    types[:2], types[-1] = FIXED, END
    strip = chain(strand, line, types)
    length = (count + 0.5) * a
    roots = (1.8751040687, 4.6940911330)
    exact = [root**2 * strand.bending_diffusivity_m2_s / length**2 for root in roots]
    step = 0.6 * strand.largest_step_s(0.0, 0.0, 1.0)

    # Near the critical damping of the first mode the deflection is settled to exp(-25) after these steps.
    load = 1e-3 * length * 3.0 * stiffness / length**3
    drag = 2.0 * exact[0] * strand.density_kg_m3 * strand.area_m2 * a
    settle = int(25.0 / exact[0] / step)
    resting = specimens.run(strip, step, settle, settle, load_n=load, drag_n_s_m=drag)
    deflection = float(resting.positions_m[-1, -1, 1])
    checks = [
        Check(
            "bending", "clamped strip: deflection of its end (m)", deflection, load * length**3 / (3 * stiffness), 5e-4
        )
    ]
    along = line[:, 0] + 0.5 * a
    for number, root, omega, bound in zip((1, 2), roots, exact, (4e-4, 4e-3), strict=True):
        shape = _clamped_shape(root, along / length)
        shape[:2] = 0.0
        weights = np.where(types == END, 0.5, 1.0) * shape
        moving = replace(strip, velocities_m_s=np.stack([np.zeros_like(shape), 1e-3 * length * omega * shape], axis=1))
        every = max(1, int(2.0 * math.pi / omega / step / 9.0))
        record = specimens.run(moving, step, 40 * every, every)
        measured = frequency_rad_s(record.times_s, record.positions_m[:, :, 1] @ weights)
        checks.append(Check("bending", f"clamped strip: frequency of mode {number} (rad/s)", measured, omega, bound))
    return checks


def _clamped_shape(root: float, place: Array) -> Array:
    """Shape of a clamped-free mode over place 0 ... 1, 1 at its largest."""
    ratio = (math.cosh(root) + math.cos(root)) / (math.sinh(root) + math.sin(root))
    z = root * place
    shape: Array = np.cosh(z) - np.cos(z) - ratio * (np.sinh(z) - np.sin(z))
    shape /= np.abs(shape).max()
    return shape
