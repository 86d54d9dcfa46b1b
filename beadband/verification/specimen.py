"""Specimens: strands, circles and single bonds made like a band (:class:`beadband.strand.Strand`), run in LAMMPS."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beadband import folder as files
from beadband import inputs
from beadband.analysis.trajectory import Trajectory, read
from beadband.engine import run_script
from beadband.strand import Strand

Array = NDArray[np.float64]
Indices = NDArray[np.int64]

FREE, END, HELD = 1, 2, 3
"""Bead types: free, free with half the mass, held."""

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
    index = np.arange(len(points_m))
    after, before = np.roll(index, -1), np.roll(index, 1)
    bonds = np.stack([index, after], axis=1)
    angles = np.stack([before, index, after], axis=1)
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
    """Follow a specimen over ``steps`` steps, with a frame every ``frame_steps``; RunError when LAMMPS fails.

    ``load_n`` acts on the end beads across the strand (y), ``drag_n_s_m`` on every bead that is not held.
    """
    strand = specimen.strand
    cutoff = specimen.cutoff_m or 3.8 * strand.spacing_m
    variables: dict[str, int | float] = {
        "table_points": inputs.TABLE_POINTS,
        "angle_coefficient": strand.angle_coefficient_j,
        "dashpot": strand.dashpot_n_s_m(loss_time_s),
        "dashpot_cutoff": cutoff,
        "skin": 0.01 * cutoff,
        "load": load_n,
        "drag": drag_n_s_m,
        "timestep": timestep_s,
        "steps": steps,
        "frame_steps": frame_steps,
    }
    with files.scratch() as folder:
        (folder / SCRIPT).write_text(inputs.with_variables(SCRIPT, variables), encoding="utf-8")
        (folder / files.TABLE).write_text(inputs.bond_table(strand, specimen.strain), encoding="utf-8")
        (folder / files.DATA).write_text(data_file(specimen), encoding="utf-8")
        run_script(folder, SCRIPT)
        frames: Trajectory = read(folder / files.TRAJECTORY)
        table = np.loadtxt(folder / files.ENERGY, ndmin=2)
        first = np.loadtxt(folder / files.TRAJECTORY, skiprows=9, max_rows=len(specimen.points_m), ndmin=2)
    return Record(
        times_s=np.asarray(timestep_s * frames.steps, dtype=np.float64),
        positions_m=frames.positions_m,
        stretching_j=table[:, 1],
        bending_j=table[:, 2],
        kinetic_j=table[:, 3],
        momentum_kg_m_s=table[:, 4:6],
        angular_momentum_kg_m2_s=table[:, 6],
        first_forces_n=first[:, 8:10],
    )


def data_file(specimen: Specimen) -> str:
    """LAMMPS data file of a specimen, in a box that is too wide to leave."""
    points, strand = specimen.points_m, specimen.strand
    low, high = points.min(axis=0), points.max(axis=0)
    margin = 0.5 * float((high - low).max()) + 4.0 * strand.spacing_m
    mass = strand.bead_mass_kg
    ids = range(1, len(points) + 1)
    sections = {
        "Masses": [f"{kind} {share * mass:.17g}" for kind, share in ((FREE, 1.0), (END, 0.5), (HELD, 1.0))],
        "Atoms # angle": [
            f"{i} 1 {kind} {x:.17g} {y:.17g} 0"
            for i, kind, (x, y) in zip(ids, specimen.types.tolist(), points.tolist(), strict=True)
        ],
        "Velocities": [
            f"{i} {vx:.17g} {vy:.17g} 0" for i, (vx, vy) in zip(ids, specimen.velocities_m_s.tolist(), strict=True)
        ],
        "Bonds": [f"{n} 1 {i + 1} {j + 1}" for n, (i, j) in enumerate(specimen.bonds.tolist(), 1)],
        "Angles": [f"{n} 1 {i + 1} {j + 1} {k + 1}" for n, (i, j, k) in enumerate(specimen.angles.tolist(), 1)],
    }
    head = (
        f"beadband: a specimen of {len(points)} beads, units = si\n\n"
        f"{len(points)} atoms\n{len(specimen.bonds)} bonds\n{len(specimen.angles)} angles\n"
        "3 atom types\n1 bond types\n1 angle types\n\n"
        f"{low[0] - margin:.17g} {high[0] + margin:.17g} xlo xhi\n"
        f"{low[1] - margin:.17g} {high[1] + margin:.17g} ylo yhi\n"
        f"{-0.5 * strand.spacing_m:.17g} {0.5 * strand.spacing_m:.17g} zlo zhi\n"
    )
    return head + "".join(f"\n{name}\n\n" + "\n".join(rows) + "\n" for name, rows in sections.items() if rows)


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
    from dataclasses import replace

    from beadband.scene import scene_of

    strand = scene_of({"band": band, "law": law, "bending_scale": bending_scale}).strand(100)
    return replace(strand, spacing_m=spacing_m)
