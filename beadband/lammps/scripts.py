"""The scripts that LAMMPS runs: their texts, the variables of each, and the files that they read."""

from __future__ import annotations

import re
from collections.abc import Mapping
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from beadband.lammps.bond_table import TABLE_POINTS, bond_table, table_points
from beadband.lammps.datafile import ring_data, strip_data
from beadband.lammps.files import DATA, LAUNCH_SCRIPT, SCRIPT, TABLE, write_text
from beadband.model.angle_forms import FOURIER
from beadband.model.calibration import Strand
from beadband.planning.plan import Plan
from beadband.statics.leg import TIP_WEIGHT, Leg
from beadband.statics.ring import Ring
from beadband.statics.strip import Strip

if TYPE_CHECKING:
    from beadband.planning.launch_plan import LaunchPlan
    from beadband.statics.finger import Support

MOST_ENERGY = 1.05
"""Share of the held energy above which a run is stopped; sound ones stay within a per cent."""
GUARD_STEPS = 200
"""Steps between checks of the energy."""
_NEVER = 2_000_000_000
_KINDS = 4  # types of beads in band.data
_MOST_BINS = 3000
"""Bins along the band; the box around it has some of them more."""
_IDLE_FORCE = 1e-6
"""Share of the held load below which the finger carries nothing."""
LOSS_SAMPLES = 8
"""Times in a frame at which the power of the dashpots is taken."""

_HAND = tuple(
    f"hand_{name}" for name in ("moves", "preload", "stiffness", "damping", "inverse", "start", "kick", "first")
)
"""Variables of the hand."""

Variables = dict[str, int | float | str]
_PLAIN = re.compile(r"[\w.+\-*/^(),;= ]*")
"""What a variable's text may hold: nothing that LAMMPS' parser would read as more than text."""


def write_ring(folder: Path, plan: Plan, ring: Ring | Strip, pictures: bool = True) -> None:
    """Write what LAMMPS needs: data file, bond table and script. Without ``pictures`` only the rear is written."""
    strand = plan.scene.strand(plan.beads)
    data = strip_data(ring, strand) if isinstance(ring, Strip) else ring_data(ring, strand)
    write_text(folder / DATA, data)
    write_text(folder / TABLE, bond_table(strand, plan.scene.strain, table_points(strand.law, plan.scene.strain)))
    write_text(folder / SCRIPT, with_variables(SCRIPT, ring_variables(plan, ring, pictures)))


def write_launch(folder: Path, plan: LaunchPlan, ring: Ring, support: Support, pictures: bool = True) -> None:
    """As :func:`write_ring`, for a launch; without ``pictures`` only the rear and the finger are written."""
    from beadband.planning.launch_plan import CAP, SHORTEST_STRETCH

    # The box reaches as far ahead as the band flies.
    # A hand that is not hit flies as long as the run may last.
    longest = plan.cap_s / (1.0 if plan.scene.hand else CAP)
    ahead = 1.5 * plan.string.centre_of_mass_speed_m_s * (longest + plan.scene.flight_s)
    points = table_points(plan.strand.law, plan.reach, shortest=SHORTEST_STRETCH)
    table = bond_table(plan.strand, plan.reach, points, SHORTEST_STRETCH)
    write_text(folder / DATA, ring_data(ring, plan.strand, ahead))
    write_text(folder / TABLE, table)
    write_text(folder / LAUNCH_SCRIPT, with_variables(LAUNCH_SCRIPT, launch_variables(plan, ring, support, pictures)))


def assignments(variables: Mapping[str, int | float | str], again: bool = False) -> str:
    """Commands that set the variables of a script, numbers to the last digit; ``again`` where they may be set already.

    Texts are a script's own words (a style, its coefficients) or expressions of a law, never a user's; ValueError for
    one that holds more than words, numbers and operators.
    """
    lines = []
    for key, value in variables.items():
        if isinstance(value, str) and not _PLAIN.fullmatch(value):
            raise ValueError(f"not the text of a variable: {value!r}")
        text = f'"{value}"' if isinstance(value, str) else format(value, ".17g")
        lines.append((f"variable {key} delete\n" if again else "") + f"variable        {key} index {text}\n")
    return "".join(lines)


def with_variables(name: str, variables: Mapping[str, int | float | str]) -> str:
    """A script of :mod:`beadband.lmp_inputs` under the variables that it needs."""
    return assignments(variables) + "\n" + script_text(name)


@cache
def script_text(name: str) -> str:
    """The text of a script of :mod:`beadband.lmp_inputs`."""
    return files("beadband.lmp_inputs").joinpath(name).read_text(encoding="utf-8")


def chain_variables(strand: Strand, cutoff_m: float, loss_time_s: float, timestep_s: float) -> Variables:
    """What every script needs to know: bonds, angles and dashpots of a chain, and its step."""
    return {
        "table_points": TABLE_POINTS,
        "angle_coefficient": strand.angle_coefficient_j,
        **FOURIER,
        "dashpot": strand.dashpot_n_s_m(loss_time_s),
        "dashpot_cutoff": cutoff_m,
        "skin": 0.01 * cutoff_m,
        "timestep": timestep_s,
    }


def bin_m(points_m: np.ndarray, cutoff_m: float) -> float:
    """Size of the bins in which LAMMPS looks for neighbours: 0, its own choice, unless there were too many of them."""
    extent = float(np.ptp(points_m, axis=0).max())
    return extent / _MOST_BINS if 2.0 * extent > _MOST_BINS * cutoff_m else 0.0


def frame_variables(frame_steps: int, pictures: bool) -> Variables:
    """How often the frames of the whole ring and its energies are written; never without ``pictures``."""
    every = sample_every(frame_steps, LOSS_SAMPLES)
    return {
        "frame_steps": frame_steps if pictures else _NEVER,
        "frame_average": frame_steps if pictures else 1,
        "loss_every": every if pictures else 1,
        "loss_average": frame_steps // every if pictures else 1,
    }


def ring_variables(plan: Plan, ring: Ring | Strip, pictures: bool) -> Variables:
    """What release.in needs to know."""
    strand = plan.scene.strand(plan.beads)
    return {
        "beads": plan.beads,
        **chain_variables(strand, dashpot_cutoff_m(ring), plan.loss_time_s, plan.timestep_s),
        "bin": bin_m(ring.positions_m, dashpot_cutoff_m(ring)),
        "table_points": table_points(strand.law, plan.scene.strain),
        "bead_radius": 0.5 * plan.scene.band.thickness_m,
        "steps": plan.steps,
        "rear_steps": plan.rear_steps,
        **frame_variables(plan.frame_steps, pictures),
        "spacing": strand.spacing_m,
        "largest_timestep": plan.largest_timestep_s,
        "most_energy": MOST_ENERGY * (ring.stretching_j + ring.bending_j),
        "guard_steps": GUARD_STEPS,
        "strip": int(isinstance(ring, Strip)),
        "damped": "all" if isinstance(ring, Strip) else "released",
    }


def launch_variables(plan: LaunchPlan, ring: Ring, support: Support, pictures: bool) -> Variables:
    """What launch.in needs to know."""
    from beadband.planning.launch_plan import CORE_DEPTH, SHORTEST_STRETCH

    scene = plan.scene
    core = min(CORE_DEPTH * scene.band.thickness_m, 0.5 * support.radius_m)
    lost_every = sample_every(plan.rear_steps, plan.rear_steps // 4)
    held_n = 2.0 * ring.tension_n * float(np.cos(scene.half_angle_rad))
    return {
        "beads": plan.beads,
        **chain_variables(plan.strand, dashpot_cutoff_m(ring), plan.release.loss_time_s, plan.timestep_s),
        "table_points": table_points(plan.strand.law, plan.reach, shortest=SHORTEST_STRETCH),
        "bead_radius": 0.5 * scene.band.thickness_m,
        "steps": plan.steps,
        "rear_steps": plan.rear_steps,
        "idle_steps": plan.idle_steps,
        "flight_steps": plan.flight_steps,
        **touch_variables(plan, ring),
        "finger_clears": int(scene.finger == "clears"),
        "finger_x": support.centre_m,
        "finger_radius": support.radius_m,
        "half_stiffness": 0.5 * support.stiffness_n_m,
        "core_radius": support.radius_m - core,
        "core_depth": core,
        "nose": plan.nose_beads,
        "gap_margin": plan.gap_margin_m,
        "idle_force": _IDLE_FORCE * held_n,
        **hand_variables(plan, support.pull_n(ring.positions_m)),
        **frame_variables(plan.frame_steps, pictures),
        "lost_every": lost_every,
        "lost_average": plan.rear_steps // lost_every,
    }


def touch_variables(plan: LaunchPlan, ring: Ring) -> Variables:
    """What launch.in needs to know of the contact of the band with itself."""
    from beadband.planning.self_contact import tip_pairs

    touching = plan.self_contact
    if touching is None:
        return {"touches": 0, "more_types": 0, "touch_from": plan.steps, "touch_every": _NEVER}
    pairs, thickness = (plan.beads + 1) // 2, plan.scene.band.thickness_m
    return {
        "touches": 1,
        "pairs": pairs,
        "more_types": max(0, pairs + 1 - _KINDS),
        "near": touching.near_pairs,
        "tip": tip_pairs(ring, thickness),
        "thickness": thickness,
        "bead_mass": plan.strand.bead_mass_kg,
        "touch_stiffness": touching.stiffness_n_m,
        "touch_skin": touching.skin_m,
        "touch_from": min(touching.from_steps, plan.steps),
        "touch_every": touching.every_steps,
        "touch_sample": sample_every(plan.rear_steps, plan.rear_steps // 2),
    }


def hand_variables(plan: LaunchPlan, pull_n: float) -> Variables:
    """What launch.in needs to know of the hand, which the held band pulls with ``pull_n``; zeros where there is none.

    The first half step is taken here: the velocity after it, and the place at the first step.
    """
    hand, step = plan.scene.hand, plan.timestep_s
    if hand is None:
        return dict.fromkeys(_HAND, 0)
    preload = pull_n if hand.preload_n is None else hand.preload_n
    kick = hand.velocity_m_s + 0.5 * step * (preload - pull_n) * hand.inverse_mass_1_kg
    half_damped = 1.0 + 0.5 * step * hand.damping_n_s_m * hand.inverse_mass_1_kg
    return dict(
        zip(
            _HAND,
            (
                *(1, preload, hand.stiffness_n_m, hand.damping_n_s_m, hand.inverse_mass_1_kg / half_damped),
                *(hand.velocity_m_s, kick, step * kick),
            ),
            strict=True,
        )
    )


def leg_variables(plan: Plan, leg: Leg) -> Variables:
    """What leg_variants.in needs to know of a leg, its bond table left out."""
    strand = plan.scene.strand(plan.beads)
    return {
        **chain_variables(strand, leg_dashpot_cutoff_m(leg), plan.loss_time_s, plan.timestep_s),
        "tip_coefficient": TIP_WEIGHT * strand.angle_coefficient_j,
        "skin": 0.01 * strand.spacing_m,
        "pull_x": leg.tension_n * np.cos(leg.half_angle_rad),
        "pull_y": leg.tension_n * np.sin(leg.half_angle_rad),
        "impedance": plan.scene.band.mass_per_length_kg_m * plan.string.front_speed_m_s,
        "steps": plan.steps,
        "rear_steps": plan.rear_steps,
    }


def sample_every(steps: int, samples: int) -> int:
    """Largest divisor of ``steps`` that takes at least so many samples."""
    every = max(1, steps // max(1, samples))
    while steps % every:
        every -= 1
    return every


def dashpot_cutoff_m(ring: Ring | Strip) -> float:
    """Cutoff of the dashpots: as wide as other beads allow, for their strength is 1 - (r/cutoff)^8.

    Bonded neighbours count; the second and third are left out by ``special_bonds``. The fourth along the strand and
    the beads across the finger are the closest others.
    """
    if isinstance(ring, Strip):
        return _fourth_m(ring.positions_m)
    return min(_fourth_m(ring.positions_m[: ring.beads // 2 + 1]), 0.95 * ring.finger_radius_m)


def leg_dashpot_cutoff_m(leg: Leg) -> float:
    """Cutoff of a leg's dashpots: as wide as its other beads allow (see :func:`dashpot_cutoff_m`)."""
    return _fourth_m(leg.positions_m)


def _fourth_m(points_m: np.ndarray) -> float:
    """Just below the least distance of a bead from the fourth after it."""
    apart = points_m[4:] - points_m[:-4]
    return 0.95 * float(np.hypot(apart[:, 0], apart[:, 1]).min())
