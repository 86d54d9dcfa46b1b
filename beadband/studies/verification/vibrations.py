"""Rungs ``waves`` and ``ring``: frequencies of small vibrations, along and across, straight and closed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from beadband.model.bands import laws_of
from beadband.model.calibration import Strand
from beadband.studies.verification import specimen as specimens
from beadband.studies.verification.check import Check
from beadband.studies.verification.specimen import (
    FIXED,
    FREE,
    Array,
    Specimen,
    chain,
    decay_rate_1_s,
    frequency_rad_s,
    strand_of,
)
from beadband.studies.verification.statics import circle

_SHARE = 0.65
"""Share of the largest stable step, as in a plan."""
_FRAMES = 40
_FRAMES_A_PERIOD = 9.0


def _straight(strand: Strand, bonds: int, strain: float = 0.0) -> Specimen:
    """A straight strand along x, held and free of moment at both ends."""
    along = strand.spacing_m * (1.0 + strain) * np.arange(bonds + 1)
    types = np.full(bonds + 1, FREE)
    types[[0, -1]] = FIXED
    points = np.stack([along, np.zeros(bonds + 1)], axis=1)
    specimen = chain(strand, points, types, strain=max(strain, 0.1))
    return replace(specimen, cutoff_m=3.8 * strand.spacing_m * (1.0 + strain))


def _standing(
    specimen: Specimen, mode: int, axis: int, omega: float, amplitude_m: float, share: float, loss_time_s: float = 0.0
) -> tuple[Array, Array, float]:
    """Start a standing wave of ``mode`` half waves; its amplitude over time, and the step."""
    beads = len(specimen.points_m)
    shape = np.sin(mode * math.pi * np.arange(beads) / (beads - 1))
    shape[[0, -1]] = 0.0
    velocities = np.zeros((beads, 2))
    velocities[:, axis] = amplitude_m * omega * shape
    period = 2.0 * math.pi / omega
    every = max(1, round(period / _FRAMES_A_PERIOD / (share * specimen.strand.largest_step_s(loss_time_s, 0.5, 0.95))))
    step = period / _FRAMES_A_PERIOD / every
    record = specimens.run(replace(specimen, velocities_m_s=velocities), step, _FRAMES * every, every, loss_time_s)
    moved = record.positions_m[:, :, axis] - specimen.points_m[:, axis]
    return record.times_s, moved @ shape, step


def waves() -> list[Check]:
    """Waves in a straight strand, in reference length.

    * Along: w/k = sqrt(tangent/density) at rest and at a held strain, for either law.
    * The dashpots of a Kelvin-Voigt strand with the loss time tau let a wave die away as exp(-E tau k^2/(2 density) t).
    * Across: w = a_b k^2, from which the lattice departs as (k a)^2/12: w = (4 a_b/a^2) sin^2(k a/2) to all
      wavelengths, and velocity Verlet takes steps of sin(w' dt/2) = w dt/2.
    """
    return _along() + _across()


def _along(bonds: int = 100, mode: int = 2) -> list[Check]:
    checks = []
    for law in laws_of("III"):
        for strain in (0.0, 0.476):
            strand = strand_of("III", law, 1e-3)
            wave_number = mode * math.pi / (bonds * strand.spacing_m)
            speed = math.sqrt(float(strand.law.tangent(1.0 + strain)) / strand.density_kg_m3)
            specimen = _straight(strand, bonds, strain)
            times, amplitudes, _ = _standing(specimen, mode, 0, speed * wave_number, 1e-5 / wave_number, _SHARE)
            measured = frequency_rad_s(times, amplitudes) / wave_number
            checks.append(
                Check("waves", f"{law}: axial wave speed at the strain {strain} (m/s)", measured, speed, 5e-4)
            )
    strand = strand_of("III", "linear", 1e-3)
    speed = math.sqrt(strand.modulus_pa / strand.density_kg_m3)
    wave_number = mode * math.pi / (bonds * strand.spacing_m)
    loss_time = 0.02 * strand.spacing_m / speed  # so little that a wrong sign shows as growth, not as a crash
    times, amplitudes, _ = _standing(
        _straight(strand, bonds), mode, 0, speed * wave_number, 1e-5 / wave_number, 0.2, loss_time
    )
    exact = strand.modulus_pa * loss_time * wave_number**2 / (2.0 * strand.density_kg_m3)
    rate = decay_rate_1_s(times, amplitudes)
    checks.append(Check("waves", "linear: decay by the dashpots (1/s)", rate, exact, 1e-3))
    return checks


def _across(bonds: int = 60) -> list[Check]:
    strand = strand_of("III", "linear", 1e-3)
    a, diffusivity = strand.spacing_m, strand.bending_diffusivity_m2_s

    def measured(mode: int) -> tuple[float, float, float]:
        """k a, the frequency, and that of the lattice in Verlet's steps."""
        wave_number = mode * math.pi / (bonds * a)
        lattice = 4.0 * diffusivity / a**2 * math.sin(0.5 * wave_number * a) ** 2
        times, amplitudes, step = _standing(_straight(strand, bonds), mode, 1, lattice, 1e-5 / wave_number, _SHARE)
        verlet = 2.0 / step * math.asin(0.5 * lattice * step)
        return wave_number * a, frequency_rad_s(times, amplitudes), verlet

    checks = []
    phase, omega, _ = measured(2)
    exact = diffusivity * (phase / a) ** 2
    checks.append(Check("waves", f"bending frequency at k a = {phase:.3f}, a_b k^2 (rad/s)", omega, exact, 2e-3))
    phase, omega, _ = measured(6)
    departure = 1.0 - omega / (diffusivity * (phase / a) ** 2)
    checks.append(
        Check(
            "waves",
            f"its departure at k a = {phase:.3f}, (k a)^2/12",
            departure,
            phase**2 / 12.0,
            0.05,
            "1 % at k a = 0.35, 18 beads a wavelength",
        )
    )
    for mode in (20, 40):
        phase, omega, lattice = measured(mode)
        name = f"bending frequency at k a = {phase:.3f}, lattice (rad/s)"
        checks.append(Check("waves", name, omega, lattice, 1e-8))
    return checks


def ring(count: int = 120) -> list[Check]:
    """A free ring of radius R: w_n^2 = EI/(density A R^4) n^2 (n^2 - 1)^2/(n^2 + 1), breathing w^2 = E/(density R^2).

    The angles of a band are straight at rest, so the ring carries a uniform moment EI/R. That changes no frequency:
    the energy is EI/2 of (dtheta/dS)^2 over the reference length S, whose part linear in the change of curvature is
    EI/R times the change of the total turning, 2 pi for any closed ring, stretched or not. A ring curved at rest has
    the same energy but for a constant. For the same reason bending takes no part in breathing. The formula is that of
    an inextensible ring; for this energy det/trace of the 2 x 2 problem differs by less than n^2 h^2/(12 R^2).
    """
    strand = strand_of("III", "linear", 6e-3)
    radius = count * strand.spacing_m / (2.0 * math.pi)
    angle = 2.0 * math.pi * np.arange(count) / count
    outward = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    along = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    rest = circle(strand, count)
    largest = _SHARE * strand.largest_step_s(0.0, 0.0, 1.0)
    exact = {n: strand.bending_diffusivity_m2_s / radius**2 * n * (n * n - 1) / math.sqrt(n * n + 1) for n in (2, 3, 4)}
    velocities = np.zeros((count, 2))
    for n, omega in exact.items():  # inextensible: v' + w = 0 for w outward and v along
        shape = np.cos(n * angle)[:, None] * outward - np.sin(n * angle)[:, None] / n * along
        velocities += 1e-6 * radius * omega * shape
    every = int(2.0 * math.pi / exact[4] / _FRAMES_A_PERIOD / largest)
    record = specimens.run(replace(rest, velocities_m_s=velocities), largest, 150 * every, every)
    moved = np.sum((record.positions_m - rest.points_m) * outward, axis=2)
    checks = [
        Check(
            "ring",
            f"bending frequency, n = {n} (rad/s)",
            frequency_rad_s(record.times_s, moved @ np.cos(n * angle)),
            omega,
            6e-4 * n * n,
        )
        for n, omega in exact.items()
    ]
    breathing = math.sqrt(strand.modulus_pa / strand.density_kg_m3) / radius
    every = int(2.0 * math.pi / breathing / _FRAMES_A_PERIOD / largest)
    record = specimens.run(
        replace(rest, velocities_m_s=1e-6 * radius * breathing * outward), largest, _FRAMES * every, every
    )
    moved = np.sum((record.positions_m - rest.points_m) * outward, axis=2)
    omega = frequency_rad_s(record.times_s, moved.mean(axis=1))
    return [*checks, Check("ring", "breathing frequency (rad/s)", omega, breathing, 3e-4)]
