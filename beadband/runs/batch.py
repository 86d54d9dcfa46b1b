"""Many releases of which the rears alone are measured: legs of similar length share a run of LAMMPS.

Setting up a leg and taking its steps cost more than its beads do, and sixteen legs cost little more than one. A leg's
result does not depend on those that it was released with, to the last digit (tests/runs/test_batch.py).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from beadband.analysis.readers import averaged_rear
from beadband.errors import BeadbandError, RunError
from beadband.lammps import files
from beadband.lammps.batch import MOST_LEGS, Held, points_of, release_legs
from beadband.lammps.engine import Session, run_script
from beadband.lammps.scripts import write_ring
from beadband.planning.plan import Plan
from beadband.runs.held import hold_legs, hold_whole
from beadband.runs.measurement import Measurement, measure, measured, reading_own_files

_MOST_PAIRS = 120_000
"""Most legs times the square of their beads: beyond, to look for neighbours among all takes what a batch saves."""
_LONGER = 1.3
"""Most steps of a leg over those of another in its batch: all run to the longest, past the end of what is asked."""


def follow_rears(plans: Sequence[Plan], session: Session | None = None) -> list[Measurement | BeadbandError]:
    """Release plans and measure their rears, in the order of the plans; no file is kept.

    Plans of one leg run in the ``session``, or in one for all of them, many at a time. One that fails takes no other
    down: its error stands in its place.
    """
    if session is None and any(plan.model == "leg" for plan in plans):
        with Session() as own:
            return follow_rears(plans, own)
    found: dict[int, Measurement | BeadbandError] = {}
    legs = [place for place, plan in enumerate(plans) if plan.model == "leg"]
    for place in (place for place, plan in enumerate(plans) if plan.model != "leg"):
        try:
            found[place] = _follow_whole(plans[place])
        except BeadbandError as error:
            found[place] = error
    for places in _batches(plans, legs):
        assert session is not None
        batch = [plans[place] for place in places]
        found.update(zip(places, _follow_legs(batch, session), strict=True))
    return [found[place] for place in range(len(plans))]


def _batches(plans: Sequence[Plan], places: Sequence[int]) -> Iterator[list[int]]:
    """Places of plans that are released together: the same bond table points, similar steps, and not too many beads."""
    batch: list[int] = []
    points = {place: points_of(plans[place]) for place in places}
    for place in sorted(places, key=lambda place: (points[place], -plans[place].steps)):
        first = plans[batch[0]] if batch else plans[place]
        longest = max(plans[each].leg_bonds for each in (*batch, place))
        if batch and (
            len(batch) == MOST_LEGS
            or points[place] != points[batch[0]]
            or first.steps > _LONGER * plans[place].steps
            or (len(batch) + 1) * longest**2 > _MOST_PAIRS
        ):
            yield batch
            batch = []
        batch.append(place)
    if batch:
        yield batch


def _follow_legs(plans: Sequence[Plan], session: Session) -> list[Measurement | BeadbandError]:
    """Release legs together, and each alone where that fails."""
    held = hold_legs(plans)
    legs: list[Held] = [(plan, leg) for plan, leg in zip(plans, held, strict=True) if not isinstance(leg, RunError)]
    rest = iter(_released(legs, session))
    return [leg if isinstance(leg, RunError) else next(rest) for leg in held]


def _released(legs: Sequence[Held], session: Session) -> list[Measurement | BeadbandError]:
    if not legs:
        return []
    try:
        with reading_own_files():
            paths = release_legs(session, legs)
    except BeadbandError as error:
        if len(legs) == 1:
            return [error]
        return [found for leg in legs for found in _released([leg], session)]
    found: list[Measurement | BeadbandError] = []
    for (plan, _), path in zip(legs, paths, strict=True):
        try:
            found.append(measure(plan, averaged_rear(path, plan.rear_steps, plan.beads)))
        except BeadbandError as error:
            found.append(error)
    return found


def _follow_whole(plan: Plan) -> Measurement:
    with files.scratch() as folder, reading_own_files():
        # The front of a strip is followed in its frames.
        write_ring(folder, plan, hold_whole(plan), pictures=plan.scene.is_strip)
        run_script(folder, files.SCRIPT)
        return measured(plan, folder)
