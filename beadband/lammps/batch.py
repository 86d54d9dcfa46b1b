"""Many legs in one instance of LAMMPS: the files and variables of legs.in, and the motion of the rears that it writes.

Every leg is written in units of its own: its bead spacing, its time step, and area times modulus at rest of its band.
Step and spacing are then 1 for all, and a bond table depends on the law and the reach of the strain alone, so legs that
share them share the table. The arithmetic of a leg is its own: companions don't change its result in any digit.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import Any

from beadband.analysis.fits import Array
from beadband.analysis.readers import read_rears
from beadband.lammps.bond_table import LEG_TABLE_POINTS, leg_reach, leg_table, table_points
from beadband.lammps.engine import Session
from beadband.lammps.files import LEG_SCRIPT
from beadband.lammps.scripts import Variables, assignments, leg_dashpot_cutoff_m, script_text
from beadband.model.angle_forms import FOURIER
from beadband.planning.plan import Plan
from beadband.statics.leg import TIP_WEIGHT, Leg

MOST_LEGS = 16
"""Legs that there is room for in an instance."""
MOST_TABLES = 48
"""Bond tables that there is room for."""
DATA, COEFFICIENTS, REARS = "legs.data", "legs.coeff", "legs.bin"
_AGAIN = "label           again\n"
_FAR = 1e14
"""Distance of what guides a tip and pulls an end, over the bead spacing: a band never moves by 1e-9 of it."""
_BOX = 2.0 * _FAR
_APART = 1000.0
"""Height of a leg above the one before, over the bead spacing."""
_SKIN = 0.01
"""Skin of the list of neighbours, which never change."""
_FORM = " ".join(map(repr, FOURIER.values()))

Held = tuple[Plan, Leg]


def points_of(plan: Plan) -> int:
    """Points of a leg's bond table; legs that are released together have the same."""
    law = plan.scene.material
    return table_points(law, leg_reach(law, plan.scene.strain), LEG_TABLE_POINTS)


def release_legs(session: Session, legs: Sequence[Held]) -> list[Array]:
    """Release held legs together: at most :data:`MOST_LEGS`, with the same :func:`points <points_of>`.

    Returns for each the positions in m of its tip and of the bead next to it at every step from 0 to its last, shape
    (steps + 1, 2, 2). RunError when LAMMPS fails for any of them, ReadError when what it wrote is not whole.
    """
    beginning, rest = _parts(points_of(legs[0][0]))
    tables = session.begin(beginning)
    if len(tables) + len(legs) > MOST_TABLES:
        session.forget()
        tables = session.begin(beginning)
    session.go_on(rest, write_legs(session.folder, legs, tables))
    found = read_rears(session.folder / REARS, 1 + max(plan.steps for plan, _ in legs), len(legs))
    return [found[: plan.steps + 1, place] * plan.strand.spacing_m for place, (plan, _) in enumerate(legs)]


@lru_cache(maxsize=8)
def _parts(points: int) -> tuple[str, str]:
    """The beginning of legs.in with its variables, and its rest."""
    beginning, _, rest = script_text(LEG_SCRIPT).partition(_AGAIN)
    return assignments(_room(points), again=True) + beginning, rest


def _room(points: int) -> Variables:
    """What the beginning of legs.in needs to know: points of the tables, and room for the legs."""
    return {
        "first": -_BOX,
        "beyond": _BOX,
        "atom_types": 1 + 2 * MOST_LEGS,
        "bond_types": MOST_TABLES + MOST_LEGS,
        "angle_types": 2 * MOST_LEGS,
        "skin": _SKIN,
        "table_points": points,
    }


def write_legs(folder: Path, legs: Sequence[Held], tables: dict[Any, int]) -> Variables:
    """Write what legs.in reads, and return the variables of its rest.

    ``tables`` are the bond tables that the instance has, bond types by law and reach; those that it lacks are added.
    """
    stride = 32 * math.ceil((max(len(leg.positions_m) for _, leg in legs) + 2) / 32)
    atoms, bonds, angles, coefficients, drags = [], [], [], [], []
    for place, (plan, leg) in enumerate(legs):
        law = plan.scene.material
        key = (law, leg_reach(law, plan.scene.strain))
        if key not in tables:
            tables[key] = len(tables) + 1
            name = f"bond{tables[key]}.table"
            (folder / name).write_text(leg_table(*key, points_of(plan)), encoding="utf-8")
            coefficients.append(f"bond_coeff {tables[key]} table {name} BAND\n")
        coefficients.append(_coefficients(plan, leg, place))
        heads, bonded, angled = _topology(len(leg.positions_m), place, stride, tables[key])
        x, y = (leg.positions_m / plan.strand.spacing_m).T.tolist()
        ahead = _FAR * math.cos(leg.half_angle_rad), _FAR * math.sin(leg.half_angle_rad)
        height = f" {_APART * place:g}\n"
        x += [ahead[0], 0.0]
        y += [ahead[1], -_FAR]
        atoms += [f"{head}{px!r} {py!r}{height}" for head, px, py in zip(heads, x, y, strict=True)]
        bonds.append(bonded)
        angles.append(angled)
        front = plan.scene.band.mass_per_length_kg_m * plan.string.front_speed_m_s
        drags.append(f"scale {2 * place + 3} {front / _damping_unit(plan)!r}")
    beads = sum(len(leg.positions_m) for _, leg in legs)
    count = len(legs)
    (folder / DATA).write_text(
        # The box stays as it is.
        f"beadband: {count} held legs\n\n{beads + 2 * count} atoms\n{beads} bonds\n{beads - count} angles\n\n"
        f"Atoms # angle\n\n{''.join(atoms)}\nBonds\n\n{''.join(bonds)}\nAngles\n\n{''.join(angles)}",
        encoding="utf-8",
    )
    (folder / COEFFICIENTS).write_text("".join(coefficients), encoding="utf-8")
    return {
        "stride": stride,
        "last": stride * count,
        "drags": " ".join(drags),
        "steps": max(plan.steps for plan, _ in legs),
    }


@lru_cache(maxsize=1024)
def _topology(beads: int, place: int, stride: int, table: int) -> tuple[list[str], str, str]:
    """Of the leg at a place: the beginnings of its lines of atoms, and its bonds and angles.

    Its beads come first, then the one that it is pulled to and the one below its tip. The end has the last id.
    """
    first, end = stride * place + 1, stride * (place + 1)
    ids = [*range(first, first + beads - 1), end]
    pull, guide = end - 1, end - 2
    tip, other = 2 * place + 2, 2 * place + 3
    kinds = [tip, *[other] * (beads - 1), 1, 1]
    heads = [f"{i} 1 {kind} " for i, kind in zip([*ids, pull, guide], kinds, strict=True)]
    bonds = "".join(f"1 {table} {i} {j}\n" for i, j in pairwise(ids)) + f"1 {MOST_TABLES + place + 1} {end} {pull}\n"
    angles = f"1 {2 * place + 1} {guide} {first} {first + 1}\n" + "".join(
        f"1 {2 * place + 2} {i} {j} {k}\n" for i, j, k in zip(ids, ids[1:], ids[2:], strict=False)
    )
    return heads, bonds, angles


def _force_unit(plan: Plan) -> float:
    """Area times modulus at rest of the law, N."""
    return plan.strand.area_m2 * plan.strand.law.rest_modulus_pa


def _damping_unit(plan: Plan) -> float:
    """Force over spacing and step, N s/m."""
    return _force_unit(plan) * plan.timestep_s / plan.strand.spacing_m


def _coefficients(plan: Plan, leg: Leg, place: int) -> str:
    """Masses and coefficients of the leg at a place, in its own units."""
    strand, force = plan.strand, _force_unit(plan)
    mass = strand.bead_mass_kg * strand.spacing_m / (plan.timestep_s**2 * force)
    stiff = strand.angle_coefficient_j / (force * strand.spacing_m)
    dashpot = strand.dashpot_n_s_m(plan.loss_time_s) / _damping_unit(plan)
    dashpots = f"0.0 {leg_dashpot_cutoff_m(leg) / strand.spacing_m!r} {dashpot!r}\n"
    tip, other = 2 * place + 2, 2 * place + 3
    return (
        f"mass {tip} {0.5 * mass!r}\nmass {other} {mass!r}\n"
        f"pair_coeff {tip} {other} {dashpots}pair_coeff {other} {other} {dashpots}"
        f"angle_coeff {2 * place + 1} {TIP_WEIGHT * stiff!r} {_FORM}\nangle_coeff {2 * place + 2} {stiff!r} {_FORM}\n"
        f"bond_coeff {MOST_TABLES + place + 1} harmonic {0.5 * leg.tension_n / (force * _FAR)!r} 0.0\n"
    )
