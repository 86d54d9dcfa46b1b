"""A release followed at its rear alone: the cheap way to V and the curvature, and to the error of both."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from beadband import folder as files
from beadband.analysis.measurement import Measurement, measure
from beadband.analysis.trajectory import read, read_path
from beadband.engine import Session, run_script
from beadband.errors import BeadbandError, RunError, UsageError
from beadband.inputs import leg_variables, script_text, write_leg, write_ring
from beadband.leg import Leg, held_leg
from beadband.plan import Plan, plan_of
from beadband.results import Estimate
from beadband.ring import Ring, stretched_ring


def hold(plan: Plan) -> Ring:
    """The held ring of a plan."""
    scene = plan.scene
    return stretched_ring(scene.strand(plan.beads), plan.beads, scene.strain, scene.half_angle_rad)


def hold_leg(plan: Plan) -> Leg:
    """The held leg of a plan."""
    scene = plan.scene
    return held_leg(scene.strand(plan.beads), plan.leg_bonds, scene.strain, scene.half_angle_rad)


def follow_rear(plan: Plan, session: Session | None = None) -> Measurement:
    """Release a plan without keeping anything but what its rear does.

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


def estimate_of(plan: Plan, session: Session | None = None) -> Estimate | None:
    """The release again with half the beads, its rear alone followed; None if that can't be."""
    beads = plan.beads // 2
    try:
        return Estimate.of(beads, follow_rear(plan_of(plan.scene.with_beads(beads), "leg"), session))
    except BeadbandError:
        return None


@contextmanager
def reading_own_files() -> Iterator[None]:
    """Turn complaints about files into RunError: the request was sound, what LAMMPS wrote is not."""
    try:
        yield
    except UsageError as error:
        raise RunError(str(error)) from error
