"""Rung ``self-contact``: parts of a band that meet push each other away, and nothing else changes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from beadband.analysis.contact import crossings
from beadband.analysis.energy import launch_balance
from beadband.analysis.readers import Overlaps, Trajectory, Watch, read, read_overlaps, read_watch
from beadband.lammps import files
from beadband.lammps.engine import run_script
from beadband.lammps.scripts import write_launch
from beadband.model.scene import scene_of
from beadband.planning.launch_plan import LaunchPlan, launch_plan_of
from beadband.planning.self_contact import NEAR, OVERLAP_BOUND
from beadband.runs.rear_run import reading_own_files
from beadband.studies.verification.check import Check

# The rear of a slim wedge, pulled far, overtakes the front of the flying band.
_SCENE: dict[str, Any] = {
    "until": "launch", "band": "I", "strain": 1.3, "half_angle_deg": 5.0, "beads": 140, "for": "speed",
    "finger": "clears", "flight_s": 7e-4,
}  # fmt: skip


def self_contact() -> list[Check]:
    """A launch whose rear overtakes its front, with the contact and without.

    * Until the first touch both move as one, to the last digit written; then the one crosses itself, the other not.
    * The least distance of its parts is the thickness, by the distances of all beads in all frames.
    * Forces inside the band leave its momentum, and the energy of the contact closes the balance.
    """
    plan, frames, watch, overlaps = _launched("on")
    _, free, _, _ = _launched("off")
    band, times = plan.scene.band, frames.times_s(plan.timestep_s)
    first = (overlaps.first_step or 0) * plan.timestep_s
    alike = np.abs(frames.positions_m - free.positions_m)[times < first]
    flying = watch.momentum_n_s[watch.times_s(plan.timestep_s) > 1.2 * plan.string.finger_free_s]
    crossed = [sum(crossings(frame) > 0 for frame in each.positions_m) for each in (frames, free)]
    name = f"touch at {first * 1e3:.3g} ms: "
    return [
        Check("self-contact", "changed before the first " + name + "(of the thickness)",
              float(alike.max()) / band.thickness_m, 0.0, 1e-12),
        Check("self-contact", "frames in which the band crosses itself", crossed[0], 0.0, 0.0,
              f"{crossed[1]} without contact"),
        Check("self-contact", "least distance of its parts (m)", _closest_m(plan, frames.positions_m[times >= first]),
              band.thickness_m, OVERLAP_BOUND),
        Check("self-contact", "change of its momentum in flight (of itself)", float(np.ptp(flying)) / flying[-1], 0.0,
              1e-12),
        Check("self-contact", "unbalanced energy (of the stored)", launch_balance(watch, plan.timestep_s).error, 0.0,
              4e-3),
    ]  # fmt: skip


def _launched(contact: str) -> tuple[LaunchPlan, Trajectory, Watch, Overlaps]:
    plan = launch_plan_of(scene_of({**_SCENE, "self_contact": contact}))
    with files.scratch() as folder, reading_own_files():
        write_launch(folder, plan, *plan.held())
        run_script(folder, files.LAUNCH_SCRIPT)
        none = Overlaps(np.empty(0, dtype=np.int64), np.empty(0), np.empty(0))
        overlaps = read_overlaps(folder / files.TOUCH) if plan.self_contact else none
        return plan, read(folder / files.TRAJECTORY), read_watch(folder / files.FINGER), overlaps


def _closest_m(plan: LaunchPlan, positions_m: np.ndarray) -> float:
    """Least distance of beads that are further apart along the strand than the contact leaves out."""
    number = np.arange(plan.beads)
    apart = np.abs(number[:, None] - number)
    near = math.ceil((NEAR + 1.0) * plan.scene.band.thickness_m / plan.strand.spacing_m)
    far = np.minimum(apart, plan.beads - apart) > near
    return min(float(np.linalg.norm(frame[:, None] - frame, axis=-1)[far].min()) for frame in positions_m)
