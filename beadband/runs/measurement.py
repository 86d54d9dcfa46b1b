"""From a plan and the arrays of a run to its measurement: speed of the rear, decay of its curvature."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from beadband.analysis.curvature import Decay, bond_stretch, decay
from beadband.analysis.fits import Array, Measured, path_slope, slope
from beadband.analysis.readers import Pull, ReadError, Trajectory, read, read_pull
from beadband.analysis.rear import Rear, rear_of
from beadband.analysis.strip import Front, crossings, impulse
from beadband.analysis.strip import front as front_of
from beadband.errors import BeadbandError, RunError, UsageError, explain
from beadband.model.beam import eq7_curvature
from beadband.model.scales import SPEED_WINDOW, SimilarityWindow
from beadband.model.strip import front_level
from beadband.planning.plan import Plan
from beadband.runs import folder as files


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
    strip: StripFound | None = None
    """Of a strip: its front and what holds it."""


@dataclass(frozen=True)
class StripFound:
    """Measured on a strip beyond its released end; errors are those of the fits alone."""

    front: Front | None
    no_front: str | None
    """Why no front is reported, where that is so."""
    path_m: Array
    """Of the front at the frames of the whole strip, in reference length, shape (frames,); NaN where it is not seen."""
    frame_times_s: Array
    times_s: Array
    """Of the lines about the held end, shape (lines,)."""
    pull_n: Array
    """On the held end, mean over the interval before."""
    impulse_n_s: Array
    """Of the held end since the release, size."""
    momentum_n_s: Array
    """Of the strip, size."""


def measured(plan: Plan, folder: Path, reader: Callable[[Path], Trajectory] = read) -> Measurement:
    """What the files of a release say, of a strip with its front; errors as :func:`measure`."""
    found = measure(plan, reader(folder / files.REAR))
    if not plan.scene.is_strip:
        return found
    return replace(
        found, strip=_measured_strip(plan, reader(folder / files.TRAJECTORY), read_pull(folder / files.HELD))
    )


def _measured_strip(plan: Plan, frames: Trajectory, pull: Pull) -> StripFound:
    frames.require_steps(plan.steps)
    pull.require_steps(plan.steps)
    times, spacing = frames.times_s(plan.timestep_s), plan.strand.spacing_m
    stretch = bond_stretch(frames.positions_m, spacing, closed=False)
    path = crossings(stretch, front_level(plan.scene), spacing)
    window = (share * plan.front_arrival_s for share in SPEED_WINDOW)
    found, reason = None, None
    try:
        found = front_of(times, path, plan.scene.band.circumference_m, *window)
    except ValueError as error:
        reason = str(error)
    return StripFound(
        front=found,
        no_front=reason,
        path_m=path,
        frame_times_s=times,
        times_s=pull.times_s(plan.timestep_s),
        pull_n=-pull.mean_force_n,
        impulse_n_s=impulse(pull, plan.timestep_s),
        momentum_n_s=pull.momentum_n_s,
    )


def measure_rear(plan: Plan, trajectory: Trajectory) -> Rear:
    """The tip (bead 1, next to beads 2 and ``plan.beads``) over time; ReadError for a trajectory that is not whole."""
    trajectory.require_steps(plan.steps)
    tip, upper = trajectory.bead(1), trajectory.bead(2)
    # The end of a strip has one neighbour; its mirror image says that the strip is straight.
    lower = 2.0 * tip - upper if plan.scene.is_strip else trajectory.bead(plan.beads)
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
