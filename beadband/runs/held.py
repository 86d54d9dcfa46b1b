"""The held shapes of plans."""

from __future__ import annotations

from collections.abc import Sequence

from beadband.errors import RunError
from beadband.planning.plan import Plan
from beadband.statics.leg import Leg, LegRequest, held_legs
from beadband.statics.ring import Ring, stretched_ring
from beadband.statics.strip import Strip, stretched_strip


def hold_whole(plan: Plan) -> Ring | Strip:
    """The held ring of a plan, or its strip."""
    if plan.scene.is_strip:
        return stretched_strip(plan.strand, plan.beads, plan.scene.strain)
    return hold(plan)


def hold(plan: Plan) -> Ring:
    """The held ring of a plan."""
    scene = plan.scene
    if scene.peg is None:
        return stretched_ring(plan.strand, plan.beads, scene.strain, scene.half_angle_rad)
    from beadband.statics.peg_ring import peg_ring

    return peg_ring(plan.strand, plan.beads, scene.strain, scene.half_angle_rad, scene.peg)


def hold_legs(plans: Sequence[Plan]) -> list[Leg | RunError]:
    """The held legs of plans, in their order; the RunError of one that does not settle."""
    pointed = [plan for plan in plans if plan.scene.peg is None]
    solved = iter(held_legs([_request(plan) for plan in pointed]))
    return [next(solved) if plan.scene.peg is None else _on_peg(plan) for plan in plans]


def hold_leg(plan: Plan) -> Leg:
    """The held leg of a plan; RunError when it does not settle."""
    (found,) = hold_legs([plan])
    if isinstance(found, RunError):
        raise found
    return found


def _request(plan: Plan) -> LegRequest:
    return LegRequest(plan.strand, plan.leg_bonds, plan.scene.strain, plan.scene.half_angle_rad)


def _on_peg(plan: Plan) -> Leg | RunError:
    from beadband.statics.peg import peg_leg

    try:
        return peg_leg(_request(plan), plan.scene.peg).leg
    except RunError as error:
        return error
