"""One release, measured: speed of the rear, decay of its curvature, balance of energy. Arrays in, values out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from beadband.analysis.tip import Array, Decay, Measured, curvatures, decay, slope, speeds
from beadband.analysis.trajectory import Energies, Trajectory
from beadband.beam import eq7_curvature
from beadband.errors import UsageError, explain
from beadband.plan import Plan
from beadband.scales import SPEED_WINDOW, SimilarityWindow, similarity_window


@dataclass(frozen=True)
class Rear:
    """The rear tip over time; arrays of shape (frames,)."""

    times_s: Array
    tip_x_m: Array
    tip_speed_m_s: Array
    tip_curvature_1_m: Array
    asymmetry_m: float
    """Largest distance of the tip from the mirror axis."""


@dataclass(frozen=True)
class Balance:
    """Energies over the run; arrays of shape (frames,), J."""

    times_s: Array
    stretching_j: Array
    bending_j: Array
    kinetic_j: Array
    dissipated_j: Array

    @property
    def stored_j(self) -> float:
        """Energy of the held ring."""
        return float(self.stretching_j[0] + self.bending_j[0])

    @property
    def error(self) -> float:
        """Largest deviation of the sum of all from the stored energy, over the stored energy."""
        total = self.stretching_j + self.bending_j + self.kinetic_j + self.dissipated_j
        return float(np.abs(total - self.stored_j).max()) / self.stored_j


@dataclass(frozen=True)
class Measurement:
    """What a run's trajectory says; errors are those of the fits alone."""

    rear: Rear
    speed_m_s: Measured
    window: SimilarityWindow
    decay: Decay | None
    no_decay: str | None
    """Why there is no decay, if there is none."""


def measure_rear(plan: Plan, trajectory: Trajectory) -> Rear:
    """Follow the tip through frames of the rear or of the whole ring; UsageError for a trajectory that is not whole.

    The tip is bead 1; its neighbours are beads 2 and ``plan.beads``.
    """
    if trajectory.steps[-1] != plan.steps or trajectory.steps[0] != 0:
        raise UsageError(
            explain(
                "the trajectory is not that of the whole run",
                f"steps {trajectory.steps[0]} to {trajectory.steps[-1]}",
                f"0 to {plan.steps}",
                "run it again",
            )
        )
    index = {int(bead): place for place, bead in enumerate(trajectory.ids)}
    try:
        tip, upper, lower = (trajectory.positions_m[:, index[bead]] for bead in (1, 2, plan.beads))
    except KeyError as error:
        raise UsageError(
            explain("the trajectory lacks a bead", f"no bead {error}", f"beads 1, 2 and {plan.beads}", "run it again")
        ) from error
    times = trajectory.times_s(plan.timestep_s)
    spacing = plan.scene.strand(plan.beads).spacing_m
    return Rear(
        times_s=times,
        tip_x_m=tip[:, 0],
        tip_speed_m_s=speeds(times, tip[:, 0]),
        tip_curvature_1_m=curvatures(lower, tip, upper, spacing),
        asymmetry_m=float(np.abs(tip[:, 1]).max()),
    )


def measure(plan: Plan, trajectory: Trajectory) -> Measurement:
    """Rebound speed and curvature decay of a release; UsageError when it was too short to measure."""
    rear = measure_rear(plan, trajectory)
    start, end = (share * plan.front_arrival_s for share in SPEED_WINDOW)
    try:
        speed = slope(rear.times_s, rear.tip_x_m, start, end)
    except ValueError as error:
        raise UsageError(
            explain("the rebound speed can't be measured", str(error), "4 frames or more", "use more beads or frames")
        ) from error
    window = similarity_window(plan.scene, plan.string)
    found, reason = None, window.reason
    if reason is None and plan.unresolved_curvature:
        reason = "the beads are too coarse for the bending layer of the held tip"
    if reason is None:
        diffusivity = plan.scene.bending_diffusivity_m2_s
        later = rear.times_s > 0.0
        times = rear.times_s[later]
        eq7 = eq7_curvature(times, plan.scene.half_angle_rad, diffusivity)
        try:
            found = decay(times, rear.tip_curvature_1_m[later], eq7, window.start_s, window.end_s)
        except ValueError as error:
            reason = str(error)
    return Measurement(rear, speed, window, found, reason)


def balance(plan: Plan, energies: Energies) -> Balance:
    """Energies with the loss summed up; UsageError when they do not cover the run."""
    if energies.steps[-1] != plan.steps or energies.steps[0] != 0:
        raise UsageError(
            explain(
                "the energies are not those of the whole run",
                f"up to step {energies.steps[-1]}",
                f"0 to {plan.steps}",
                "run it again",
            )
        )
    intervals = np.diff(energies.steps, prepend=0) * plan.timestep_s
    return Balance(
        times_s=np.asarray(energies.steps * plan.timestep_s, dtype=np.float64),
        stretching_j=energies.stretching_j,
        bending_j=energies.bending_j,
        kinetic_j=energies.kinetic_j,
        dissipated_j=np.cumsum(energies.loss_w * intervals),
    )
