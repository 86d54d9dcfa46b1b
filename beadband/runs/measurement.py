"""From a plan and the arrays of a run to its measurement: speed of the rear, decay of its curvature."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial

from beadband.analysis.curvature import Decay, decay
from beadband.analysis.fits import Measured, path_slope, slope
from beadband.analysis.readers import ReadError, Trajectory
from beadband.analysis.rear import Rear, rear_of
from beadband.errors import BeadbandError, RunError, UsageError, explain
from beadband.model.beam import eq7_curvature
from beadband.model.scales import SPEED_WINDOW, SimilarityWindow
from beadband.planning.plan import Plan


@dataclass(frozen=True)
class Measurement:
    """Measured on the rear's path; errors are those of the fits alone."""

    rear: Rear
    fitted_speed_m_s: Measured
    """Slope of the rear's path; :attr:`RearRun.speed` has the whole error."""
    window: SimilarityWindow
    decay: Decay | None
    no_decay: str | None
    """Why no decay is reported, where that is so."""


def measure_rear(plan: Plan, trajectory: Trajectory) -> Rear:
    """The tip (bead 1, next to beads 2 and ``plan.beads``) over time; ReadError for a trajectory that is not whole."""
    trajectory.require_steps(plan.steps)
    tip, upper, lower = (trajectory.bead(number) for number in (1, 2, plan.beads))
    spacing = plan.scene.strand(plan.beads).spacing_m
    return rear_of(trajectory.times_s(plan.timestep_s), lower, tip, upper, spacing)


def measure(plan: Plan, trajectory: Trajectory) -> Measurement:
    """Rebound speed and curvature decay of a release.

    Raises ReadError for a trajectory that is not whole, UsageError when the release was too short to measure.
    """
    rear = measure_rear(plan, trajectory)
    start, end = (share * plan.front_arrival_s for share in SPEED_WINDOW)
    # Off a peg the rear gains speed smoothly; V is the mean by its definition, and that bend no error of it.
    degree = 1 if plan.scene.peg is None else 3
    try:
        speed = Measured(
            path_slope(rear.times_s, rear.tip_x_m, start, end),
            slope(rear.times_s, rear.tip_x_m, start, end, degree).error,
        )
    except ValueError as error:
        raise UsageError(
            explain("the rebound speed can't be measured", str(error), "4 frames or more", "use more beads or frames")
        ) from error
    window = plan.scene.scales.window
    found, reason = None, window.reason
    if reason is None and plan.unresolved_curvature:
        reason = "the beads are too coarse for the bending layer of the held tip"
    if reason is None:
        later = rear.times_s > 0.0
        times = rear.times_s[later]
        eq7 = eq7_curvature(times, plan.scene.half_angle_rad, plan.scene.bending_diffusivity_m2_s)
        try:
            found = decay(times, rear.tip_curvature_1_m[later], eq7, window.start_s, window.end_s)
        except ValueError as error:
            reason = str(error)
    return Measurement(rear, speed, window, found, reason)


@contextmanager
def reading(kind: type[BeadbandError]) -> Iterator[None]:
    """Turn what is wrong with a file into an error of this kind."""
    try:
        yield
    except ReadError as error:
        raise kind(explain(error.wrong, error.given, error.expected, "run it again"), "unreadable-file") from error


reading_own_files = partial(reading, RunError)
"""Context in which a file that can't be read is a RunError: the request was sound, what LAMMPS wrote is not."""
reading_users_files = partial(reading, UsageError)
"""Context in which it is a UsageError: the folder is the user's."""
