"""What LAMMPS reads: data files, the table of the law, and the scripts under their variables."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path

import numpy as np

from beadband.folder import DATA, SCRIPT, TABLE, write_text
from beadband.leg import TIP_WEIGHT, Leg
from beadband.plan import Plan
from beadband.ring import Ring
from beadband.strand import Strand

TABLE_POINTS = 2001
LEG_TABLE_POINTS = 101
"""A leg is released for a number or two, and reading the table would take longer than the physics."""
DEEPEST_STRETCH = 0.3
"""Where the bond table begins."""
WIDEST_STRAIN = 1.6
"""Where the bond table ends, over the held strain."""
MOST_ENERGY = 1.05
"""Share of the held energy above which a run has blown up; sound ones stay within a per cent."""
GUARD_STEPS = 200
"""Steps between looks at the energy."""
_NEVER = 2_000_000_000
LOSS_SAMPLES = 8
"""Times in a frame at which the power of the dashpots is taken."""

Variables = dict[str, int | float]


def write_ring(folder: Path, plan: Plan, ring: Ring, pictures: bool = True) -> None:
    """Write what LAMMPS needs: data file, bond table and script. Without ``pictures`` only the rear is followed."""
    strand = plan.scene.strand(plan.beads)
    write_text(folder / DATA, data_file(ring, strand))
    write_text(folder / TABLE, bond_table(strand, plan.scene.strain))
    write_text(folder / SCRIPT, script(plan, ring, pictures))


def write_leg(folder: Path, plan: Plan, leg: Leg) -> None:
    """Write what LAMMPS needs for one leg; it is there for numbers alone, and nothing is kept."""
    strand = plan.scene.strand(plan.beads)
    (folder / DATA).write_text(leg_data_file(leg, strand), encoding="utf-8")
    (folder / TABLE).write_text(bond_table(strand, plan.scene.strain, LEG_TABLE_POINTS), encoding="utf-8")


def data_file(ring: Ring, strand: Strand, ahead_m: float = 0.0) -> str:
    """LAMMPS data file of the held ring: a box that the release can't leave, beads, bonds and angles.

    ``ahead_m`` is added to the box in front of the ring, for a band that flies.
    """
    x, y = ring.positions_m[:, 0], ring.positions_m[:, 1]
    count = ring.beads
    margin = 0.5 * (x.max() - x.min())
    index = np.arange(1, count + 1)
    after, before = np.roll(index, -1), np.roll(index, 1)
    head = f"""beadband: a held ring of {count} beads, units = si

{count} atoms
{count} bonds
{count} angles
4 atom types
1 bond types
1 angle types

{x.min() - margin:.17g} {x.max() + margin + ahead_m:.17g} xlo xhi
{y.min() - margin:.17g} {y.max() + margin:.17g} ylo yhi
{-0.5 * strand.spacing_m:.17g} {0.5 * strand.spacing_m:.17g} zlo zhi

Masses

"""
    masses = "".join(f"{kind} {strand.bead_mass_kg:.17g}\n" for kind in range(1, 5))
    atoms = "".join(
        f"{i} 1 {kind} {px!r} {py!r} 0\n"
        for i, kind, px, py in zip(index.tolist(), ring.types.tolist(), x.tolist(), y.tolist(), strict=True)
    )
    bonds = "".join(f"{i} 1 {i} {j}\n" for i, j in zip(index.tolist(), after.tolist(), strict=True))
    angles = "".join(
        f"{i} 1 {h} {i} {j}\n" for h, i, j in zip(before.tolist(), index.tolist(), after.tolist(), strict=True)
    )
    return f"{head}{masses}\nAtoms # angle\n\n{atoms}\nBonds\n\n{bonds}\nAngles\n\n{angles}"


def bond_table(strand: Strand, strain: float, points: int = TABLE_POINTS, shortest: float = DEEPEST_STRETCH) -> str:
    """Energy and force of a bond from the stretch ``shortest`` to well beyond the held strain.

    Ahead of a shock without loss bonds ring about the held stretch, and more where the finger throws them back.
    """
    law, a, area = strand.law, strand.spacing_m, strand.area_m2
    stretch = np.linspace(shortest, 1.0 + WIDEST_STRAIN * strain, points)
    energy, force = a * area * law.energy(stretch), -area * law.stress(stretch)
    slopes = [-area * float(law.tangent(stretch[end])) / a for end in (0, -1)]
    rows = "".join(
        f"{i} {r!r} {e!r} {f!r}\n"
        for i, (r, e, f) in enumerate(zip((stretch * a).tolist(), energy.tolist(), force.tolist(), strict=True), 1)
    )
    return (
        f"# {law.name} bond: length m, energy J, force N\n\nBAND\n"
        f"N {points} FP {slopes[0]:.17g} {slopes[1]:.17g} EQ {a:.17g}\n\n{rows}"
    )


def with_variables(name: str, variables: Mapping[str, int | float | str]) -> str:
    """A script of :mod:`beadband.lmp_inputs` under the variables that it needs, numbers to the last digit.

    Texts are words of the scripts' own (a style, its coefficients), never a user's.
    """
    values = {
        key: f'"{value}"' if isinstance(value, str) else format(value, ".17g") for key, value in variables.items()
    }
    lines = (f"variable        {key} index {value}\n" for key, value in values.items())
    return "".join(lines) + "\n" + script_text(name)


@cache
def script_text(name: str) -> str:
    """A script of :mod:`beadband.lmp_inputs`, as it comes."""
    return files("beadband.lmp_inputs").joinpath(name).read_text(encoding="utf-8")


def script(plan: Plan, ring: Ring, pictures: bool) -> str:
    """The release script under the variables of this plan."""
    return with_variables(SCRIPT, ring_variables(plan, ring, pictures))


def ring_variables(plan: Plan, ring: Ring, pictures: bool) -> Variables:
    """What release.in needs to know."""
    strand = plan.scene.strand(plan.beads)
    cutoff = dashpot_cutoff_m(ring)
    loss_every = sample_every(plan.frame_steps, LOSS_SAMPLES)
    return {
        "beads": plan.beads,
        "table_points": TABLE_POINTS,
        "angle_coefficient": strand.angle_coefficient_j,
        "bead_radius": 0.5 * plan.scene.band.thickness_m,
        "dashpot": strand.dashpot_n_s_m(plan.loss_time_s),
        "dashpot_cutoff": cutoff,
        "skin": 0.01 * cutoff,
        "timestep": plan.timestep_s,
        "steps": plan.steps,
        "rear_steps": plan.rear_steps,
        "frame_steps": plan.frame_steps if pictures else _NEVER,
        "frame_average": plan.frame_steps if pictures else 1,
        "spacing": strand.spacing_m,
        "largest_timestep": plan.largest_timestep_s,
        "most_energy": MOST_ENERGY * (ring.stretching_j + ring.bending_j),
        "guard_steps": GUARD_STEPS,
        "loss_every": loss_every if pictures else 1,
        "loss_average": plan.frame_steps // loss_every if pictures else 1,
    }


def sample_every(steps: int, samples: int) -> int:
    """Largest divisor of ``steps`` that takes at least so many samples."""
    every = max(1, steps // max(1, samples))
    while steps % every:
        every -= 1
    return every


def dashpot_cutoff_m(ring: Ring) -> float:
    """Cutoff of the dashpots: as wide as other beads allow, for their strength is 1 - (r/cutoff)^8.

    Bonded neighbours count; the second and third are left out by ``special_bonds``. The fourth along the strand and
    the beads across the finger are the closest others.
    """
    upper = ring.positions_m[: ring.beads // 2 + 1]
    apart = upper[4:] - upper[:-4]
    return 0.95 * min(float(np.hypot(apart[:, 0], apart[:, 1]).min()), ring.finger_radius_m)


def leg_data_file(leg: Leg, strand: Strand) -> str:
    """LAMMPS data file of a held leg: the tip (type 1), its guide (2), the leg (3) and the bead at its end (4).

    The guide, one spacing below the tip, moves with it along the axis: the angle between
    the two and the first bond is the half of the tip's turning angle that belongs to this side.
    """
    x, y = leg.positions_m.T
    count = len(x)
    a, mass, reach = strand.spacing_m, strand.bead_mass_kg, float(x[-1])
    # The tip's half of a bead is shared with the guide.
    masses = (0.25 * mass, 0.25 * mass, mass, mass)
    kinds = [1] + [3] * (count - 2) + [4]
    head = f"""beadband: a held leg of {count} beads and a guide, units = si

{count + 1} atoms
{count - 1} bonds
{count - 1} angles
4 atom types
1 bond types
2 angle types

{-reach:.17g} {3.0 * reach:.17g} xlo xhi
{-reach:.17g} {2.0 * reach:.17g} ylo yhi
{-reach:.17g} {reach:.17g} zlo zhi

Masses

"""
    weights = "".join(f"{kind} {value:.17g}\n" for kind, value in enumerate(masses, 1))
    atoms = "".join(
        f"{i} 1 {kind} {px!r} {py!r} 0\n"
        for i, (kind, px, py) in enumerate(zip(kinds, x.tolist(), y.tolist(), strict=True), 1)
    )
    guide = f"{count + 1} 1 2 0 {-a:.17g} 0\n"
    bonds = "".join(f"{i} 1 {i} {i + 1}\n" for i in range(1, count))
    angles = f"1 2 {count + 1} 1 2\n" + "".join(f"{i} 1 {i - 1} {i} {i + 1}\n" for i in range(2, count))
    return f"{head}{weights}\nAtoms # angle\n\n{atoms}{guide}\nBonds\n\n{bonds}\nAngles\n\n{angles}"


def leg_variables(plan: Plan, leg: Leg) -> Variables:
    """What leg.in needs to know."""
    strand = plan.scene.strand(plan.beads)
    return {
        "table_points": LEG_TABLE_POINTS,
        "angle_coefficient": strand.angle_coefficient_j,
        "tip_coefficient": TIP_WEIGHT * strand.angle_coefficient_j,
        "dashpot": strand.dashpot_n_s_m(plan.loss_time_s),
        "dashpot_cutoff": leg_dashpot_cutoff_m(leg),
        "skin": 0.01 * strand.spacing_m,
        "pull_x": leg.tension_n * np.cos(leg.half_angle_rad),
        "pull_y": leg.tension_n * np.sin(leg.half_angle_rad),
        "impedance": plan.scene.band.mass_per_length_kg_m * plan.string.front_speed_m_s,
        "timestep": plan.timestep_s,
        "steps": plan.steps,
        "rear_steps": plan.rear_steps,
    }


def leg_dashpot_cutoff_m(leg: Leg) -> float:
    """Cutoff of a leg's dashpots: as wide as its other beads allow (see :func:`dashpot_cutoff_m`)."""
    apart = leg.positions_m[4:] - leg.positions_m[:-4]
    return 0.95 * float(np.hypot(apart[:, 0], apart[:, 1]).min())
