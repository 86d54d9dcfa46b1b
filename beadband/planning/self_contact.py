"""Contact of the band with itself in a launch: whether parts of it can meet, from when on, and how stiffly.

Before the two fronts meet every part of the band is pulled, and the strands between rear and finger move apart: no two
parts can touch. The fronts that meet compress the band, which buckles, and a rear that has passed the place of a finger
runs into the band ahead of it. So the contact is searched for from shortly before the meeting on.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from beadband.model.calibration import Strand
from beadband.model.launch_string import StringLaunch
from beadband.model.scene import Scene
from beadband.notices import Notice, notice
from beadband.statics.ring import Ring

OVERLAP_BOUND = 0.05
"""Deepest overlap of two parts that a sound launch may have, over the band's thickness."""
MOST_BEADS = 3000
"""Every two beads are a type of their own, and LAMMPS keeps tables of types by types: 0.3 GB of them."""
_COARSEST = 1.0
"""Spacing over thickness up to which strands of beads are smooth enough: beads that face gaps lie closer by 13 %."""
_FROM = 0.9
"""Where the search begins, over the time at which the string's fronts meet."""
NEAR = 3.0
"""Distance along the strand, in thicknesses, within which beads never touch: a U-turn takes pi/2, and the band
compressed to half of its length twice as many beads."""
_STIFFNESS = 0.25
"""Of a pair of beads, over that of a bead on the finger: both of the pair move, and a bead faces two or so."""
_SKIN = 2.0
_CHECKED = 0.05  # of the skin, at most, is what beads move towards each other between two checks


@dataclass(frozen=True)
class SelfContact:
    """Contact between parts of the band, at the distance of its thickness."""

    stiffness_n_m: float
    """Force between two beads over their overlap."""
    from_steps: int
    """Step from which on neighbours are searched for."""
    every_steps: int
    """Steps between checks of how far beads have moved since the last search."""
    near_pairs: int
    """Beads in pairs along the strand closer than this never touch."""
    skin_m: float


def self_contact(
    scene: Scene, strand: Strand, string: StringLaunch, finger_n_m: float, step_s: float, rear_steps: int
) -> tuple[SelfContact | None, Notice | None]:
    """The contact that a launch takes, and the plan's reason; None where it takes none.

    ``finger_n_m`` is the stiffness of the finger under one bead, with which the step was chosen.
    """
    thickness = scene.band.thickness_m
    coarse, beads = strand.spacing_m / thickness, round(scene.band.circumference_m / strand.spacing_m)
    begin_s = _FROM * string.finger_free_s
    if scene.self_contact == "off" or scene.bending_scale == 0.0:
        return None, None
    if coarse > _COARSEST:
        return None, notice("self-contact-coarse", value=coarse, limit=_COARSEST)
    if beads > MOST_BEADS:
        return None, notice("self-contact-many", value=beads, limit=MOST_BEADS)
    if string.rear_arrival_s < begin_s and scene.flight_s == 0.0 and scene.hand is None:
        return None, notice("self-contact-never", value=string.rear_arrival_s, limit=string.finger_free_s)
    skin = _SKIN * thickness
    way = 2.0 * scene.string.rear_speed_m_s * step_s
    found = SelfContact(
        stiffness_n_m=_STIFFNESS * finger_n_m,
        from_steps=rear_steps * max(1, round(begin_s / (rear_steps * step_s))),
        every_steps=max(1, int(_CHECKED * skin / way)),
        near_pairs=math.ceil(0.5 * NEAR / coarse),
        skin_m=skin,
    )
    return found, notice("self-contact", value=begin_s, stiffness=found.stiffness_n_m, thickness_mm=1e3 * thickness)


def tip_pairs(ring: Ring, thickness_m: float) -> int:
    """Pairs of beads to either side of the tip whose mirror images lie within the thickness in the held ring.

    The legs of a slim wedge start from one point: beside it they overlap until the rear has opened.
    """
    leg = ring.positions_m[: ring.beads // 4, 1]
    close = int(np.flatnonzero(2.0 * leg <= thickness_m)[-1])
    return math.ceil(0.5 * (close + 1))
