"""A release of which the rear alone is measured: the cheap way to V and the curvature, and to the error of both."""

from __future__ import annotations

from collections.abc import Sequence

from beadband.errors import BeadbandError
from beadband.lammps.engine import Session
from beadband.planning.plan import Plan, plan_of
from beadband.runs.batch import follow_rears
from beadband.runs.held import hold, hold_leg
from beadband.runs.measurement import Measurement, reading_own_files, reading_users_files
from beadband.runs.results import Estimate, NoEstimate, RearRun

__all__ = [
    "estimate_of",
    "follow_rear",
    "follow_rears",
    "hold",
    "hold_leg",
    "reading_own_files",
    "reading_users_files",
    "rear_run",
    "rear_runs",
]


def follow_rear(plan: Plan, session: Session | None = None) -> Measurement:
    """Release a plan and measure its rear; no file is kept.

    A plan of one leg runs in the ``session``, or in one of its own; RunError when LAMMPS fails.
    """
    (found,) = follow_rears([plan], session)
    if isinstance(found, BeadbandError):
        raise found
    return found


def rear_run(plan: Plan, session: Session | None = None) -> RearRun:
    """Release a plan and its coarse run: speed and curvature of the rear with their whole errors.

    RunError when LAMMPS fails in the release itself; a coarse run that fails leaves its reason.
    """
    return RearRun(plan, follow_rear(plan, session), estimate_of(plan, session))


def rear_runs(plans: Sequence[Plan], session: Session | None = None) -> list[RearRun | BeadbandError]:
    """:func:`rear_run` of many plans, in their order, with the error in the place of one that failed."""
    coarse: list[Plan | BeadbandError] = []
    for plan in plans:
        try:
            coarse.append(_coarse(plan))
        except BeadbandError as error:
            coarse.append(error)
    found = follow_rears([*plans, *(one for one in coarse if isinstance(one, Plan))], session)
    rest = iter(found[len(plans) :])
    runs: list[RearRun | BeadbandError] = []
    for plan, one, other in zip(plans, found, coarse, strict=False):
        second = next(rest) if isinstance(other, Plan) else other
        if isinstance(one, BeadbandError):
            runs.append(one)
        else:
            runs.append(RearRun(plan, one, _judged(plan, second)))
    return runs


def estimate_of(plan: Plan, session: Session | None = None) -> Estimate | NoEstimate:
    """The release again with half the beads; the reason where that is impossible."""
    try:
        return _judged(plan, follow_rear(_coarse(plan), session))
    except BeadbandError as error:
        return _judged(plan, error)


def _coarse(plan: Plan) -> Plan:
    return plan_of(plan.scene.with_beads(plan.beads // 2), "leg")


def _judged(plan: Plan, found: Measurement | BeadbandError) -> Estimate | NoEstimate:
    if isinstance(found, BeadbandError):
        return NoEstimate(found.code, str(found))
    return Estimate.of(plan.beads // 2, found)
