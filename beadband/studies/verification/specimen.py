"""Specimens: strands, circles and single bonds made like a band (see ``model.calibration``), run in LAMMPS."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from beadband.analysis.readers import Trajectory, read
from beadband.lammps import files
from beadband.lammps.bond_table import bond_table
from beadband.lammps.datafile import closed_chain, data_file
from beadband.lammps.engine import run_script
from beadband.lammps.scripts import chain_variables, with_variables
from beadband.model.calibration import Strand
from beadband.model.scene import scene_of
from beadband.runs.rear_run import reading_own_files

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

FREE, END, FIXED = 1, 2, 3
"""Bead types: free, free with half the mass, fixed in place."""

SCRIPT = "specimen.in"
_SMALL_STRAIN = 0.1


@dataclass(frozen=True)
class Specimen:
    """Beads, and which of them are bonded and hinged; positions in m, velocities in m/s."""

    strand: Strand
    points_m: Array
    """Shape (beads, 2)."""
    types: Indices
    """Shape (beads,)."""
    bonds: Indices
    """Shape (bonds, 2), indices of beads."""
    angles: Indices
    """Shape (angles, 3)."""
    velocities_m_s: Array
    """Shape (beads, 2)."""
    strain: float = _SMALL_STRAIN
    """Largest strain that its bonds meet: the table of the law reaches a quarter beyond."""
    cutoff_m: float | None = None
    """Reach of the dashpots; None reaches almost to the fourth neighbour of an unstretched strand."""


def chain(
    strand: Strand, points_m: Array, types: Indices, closed: bool = False, strain: float = _SMALL_STRAIN
) -> Specimen:
    """One strand through the points, hinged at every bead but its ends, or closed; at rest."""
    bonds, angles = closed_chain(len(points_m))
    if not closed:
        bonds, angles = bonds[:-1], angles[1:-1]
    return Specimen(strand, points_m, types, bonds, angles, np.zeros_like(points_m), strain)


def bent(strand: Strand, turning_rad: Array) -> Specimen:
    """A free strand through beads with these turning angles, symmetric about the middle; ends of half the mass."""
    half = len(turning_rad) // 2
    direction = np.cumsum(turning_rad)[:-1]
    direction -= 0.5 * direction[-1]
    steps = strand.spacing_m * np.stack([np.cos(direction), np.sin(direction)], axis=1)
    points = np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
    types = np.full(2 * half + 1, FREE)
    types[[0, -1]] = END
    return chain(strand, points - points[half], types)


@dataclass(frozen=True)
class Record:
    """What LAMMPS wrote about a specimen; every array has a frame for each time, the first at 0."""

    times_s: Array
    positions_m: Array
    """Shape (frames, beads, 2)."""
    stretching_j: Array
    bending_j: Array
    kinetic_j: Array
    momentum_kg_m_s: Array
    """Shape (frames, 2)."""
    angular_momentum_kg_m2_s: Array
    first_forces_n: Array
    """Forces of frame 0, shape (beads, 2)."""


def run(
    specimen: Specimen,
    timestep_s: float = 1e-9,
    steps: int = 0,
    frame_steps: int = 1,
    loss_time_s: float = 0.0,
    load_n: float = 0.0,
    drag_n_s_m: float = 0.0,
) -> Record:
    """Run a specimen for ``steps`` steps, with a frame every ``frame_steps``; RunError when LAMMPS fails.

    ``load_n`` acts on the end beads across the strand (y), ``drag_n_s_m`` on every bead that is not fixed.
    """
    variables = {"load": load_n, "drag": drag_n_s_m, "steps": steps, "frame_steps": frame_steps}
    frames, table, forces = run_files(specimen, SCRIPT, variables, timestep_s, loss_time_s)
    return Record(
        times_s=np.asarray(timestep_s * frames.steps, dtype=np.float64),
        positions_m=frames.positions_m,
        stretching_j=table[:, 1],
        bending_j=table[:, 2],
        kinetic_j=table[:, 3],
        momentum_kg_m_s=table[:, 4:6],
        angular_momentum_kg_m2_s=table[:, 6],
        first_forces_n=forces,
    )


def run_files(
    specimen: Specimen,
    script: str,
    variables: Mapping[str, int | float | str],
    timestep_s: float,
    loss_time_s: float,
    tables: Mapping[str, str] | None = None,
) -> tuple[Trajectory, Array, Array]:
    """Run a script on a specimen in a folder of its own; its frames, its energies, and the forces of frame 0.

    ``variables`` are those that the script has beyond :func:`beadband.lammps.scripts.chain_variables`, ``tables`` the
    texts of further files by their names. Energies have a row for each line of the file, forces the shape (beads, 2).
    """
    strand = specimen.strand
    cutoff = specimen.cutoff_m or 3.8 * strand.spacing_m
    everything = {**chain_variables(strand, cutoff, loss_time_s, timestep_s), **variables}
    texts = {
        script: with_variables(script, everything),
        files.TABLE: bond_table(strand, specimen.strain),
        files.DATA: specimen_data(specimen),
        **(tables or {}),
    }
    with files.scratch() as folder:
        for name, text in texts.items():
            (folder / name).write_text(text, encoding="utf-8")
        run_script(folder, script)
        first = np.loadtxt(folder / files.TRAJECTORY, skiprows=9, max_rows=len(specimen.points_m), ndmin=2)
        with reading_own_files():
            return read(folder / files.TRAJECTORY), np.loadtxt(folder / files.ENERGY, ndmin=2), first[:, 8:10]


def specimen_data(specimen: Specimen) -> str:
    """LAMMPS data file of a specimen, in a box that is too wide to leave."""
    points, a, mass = specimen.points_m, specimen.strand.spacing_m, specimen.strand.bead_mass_kg
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.5 * float((high - low).max()) + 4.0 * a
    return data_file(
        f"a specimen of {len(points)} beads",
        points,
        specimen.types,
        (mass, 0.5 * mass, mass),  # free, end, fixed
        specimen.bonds,
        specimen.angles,
        ((low[0] - margin, high[0] + margin), (low[1] - margin, high[1] + margin), (-0.5 * a, 0.5 * a)),
        velocities_m_s=specimen.velocities_m_s,
    )


def frequency_rad_s(times_s: Array, amplitudes: Array) -> float:
    """Angular frequency of an undamped oscillation about 0, from evenly spaced samples (frames,).

    q(t + d) + q(t - d) = 2 cos(w d) q(t) for every t: cos(w d) by least squares, exact for a single mode.
    """
    middle, sides = amplitudes[1:-1], amplitudes[2:] + amplitudes[:-2]
    cosine = 0.5 * float(np.sum(middle * sides) / np.sum(middle**2))
    return float(np.arccos(np.clip(cosine, -1.0, 1.0)) / (times_s[1] - times_s[0]))


def decay_rate_1_s(times_s: Array, amplitudes: Array) -> float:
    """Rate at which a damped oscillation about 0 dies away; negative for one that grows.

    q(t + d) = 2 exp(-r d) cos(w d) q(t) - exp(-2 r d) q(t - d), both factors by least squares.
    """
    matrix = np.stack([amplitudes[1:-1], -amplitudes[:-2]], axis=1)
    solution = np.linalg.lstsq(matrix, amplitudes[2:], rcond=None)[0]
    return -0.5 * float(np.log(solution[1])) / float(times_s[1] - times_s[0])


def strand_of(band: str, law: str, spacing_m: float, bending_scale: float = 1.0) -> Strand:
    """The strand of a band of the catalogue at a bead distance of choice."""
    strand = scene_of({"band": band, "law": law, "bending_scale": bending_scale}).strand(100)
    return replace(strand, spacing_m=spacing_m)
