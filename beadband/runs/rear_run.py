"""A release of which the rear alone is measured: the cheap way to V and the curvature, and to the error of both."""

from __future__ import annotations

from functools import partial

from beadband.analysis.readers import read, read_path
from beadband.errors import BeadbandError, RunError, UsageError
from beadband.lammps.engine import Session, run_script
from beadband.lammps.scripts import leg_variables, script_text, write_leg, write_ring
from beadband.planning.plan import Plan, plan_of
from beadband.runs import folder as files
from beadband.runs.measurement import Measurement, measure, reading
from beadband.runs.results import Estimate, NoEstimate, RearRun
from beadband.statics.leg import Leg, held_leg
from beadband.statics.ring import Ring, stretched_ring

reading_own_files = partial(reading, RunError)
"""Context in which a file that can't be read is a RunError: the request was sound, what LAMMPS wrote is not."""
reading_users_files = partial(reading, UsageError)
"""Context in which it is a UsageError: the folder is the user's."""


def hold(plan: Plan) -> Ring:
    """The held ring of a plan."""
    scene = plan.scene
    return stretched_ring(scene.strand(plan.beads), plan.beads, scene.strain, scene.half_angle_rad)


def hold_leg(plan: Plan) -> Leg:
    """The held leg of a plan."""
    scene = plan.scene
    return held_leg(scene.strand(plan.beads), plan.leg_bonds, scene.strain, scene.half_angle_rad)


def follow_rear(plan: Plan, session: Session | None = None) -> Measurement:
    """Release a plan and measure its rear; no file is kept.

    A plan of one leg runs in the ``session``, or in one of its own; RunError when LAMMPS fails.
    """
    if plan.model == "ring":
        with files.scratch() as folder, reading_own_files():
            write_ring(folder, plan, hold(plan), pictures=False)
            run_script(folder, files.SCRIPT)
            return measure(plan, read(folder / files.REAR))
    if session is None:
        with Session() as own:
            return follow_rear(plan, own)
    leg = hold_leg(plan)
    write_leg(session.folder, plan, leg)
    session.run(script_text(files.LEG_SCRIPT), leg_variables(plan, leg))
    with reading_own_files():
        return measure(plan, read_path(session.folder / files.PATH, leg.positions_m, plan.beads))


def rear_run(plan: Plan, session: Session | None = None) -> RearRun:
    """Release a plan and its coarse run: speed and curvature of the rear with their whole errors.

    RunError when LAMMPS fails in the release itself; a coarse run that fails leaves its reason.
    """
    return RearRun(plan, follow_rear(plan, session), estimate_of(plan, session))


def estimate_of(plan: Plan, session: Session | None = None) -> Estimate | NoEstimate:
    """The release again with half the beads; the reason where that is impossible."""
    beads = plan.beads // 2
    try:
        return Estimate.of(beads, follow_rear(plan_of(plan.scene.with_beads(beads), "leg"), session))
    except BeadbandError as error:
        return NoEstimate(error.code, str(error))
