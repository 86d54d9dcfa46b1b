"""Rung ``orders``: how fast V and the tip curvature converge with the step and the bead distance."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from beadband.analysis.fits import hann_mean
from beadband.model.scene import scene_of
from beadband.planning.plan import Plan, plan_of
from beadband.runs.rear_run import follow_rear
from beadband.studies.verification.check import Check

_FRAMES = 240


def orders() -> list[Check]:
    """Exponents of the errors of V and of the tip curvature, from differences of runs refined by factors of 2.

    Both are means under a Hann window (V around 0.6, the curvature around 0.2 of the front's arrival): the fit of a
    line between sharp ends would add an error of its own, whose phase is that of the ringing tip.

    * Step, without loss: 2, as velocity Verlet is.
    * Step, with loss: 1. A force that depends on velocities is computed from those half a step back, so that the
      dashpots' part of the error is of the first order. At a planned step it is some 1e-5 of V.
    * Bead distance, with a fixed physical loss and a fixed step: 2. Four times the bending stiffness brings the
      coarsest ring into the range where the held tip is resolved, in the other runs too.

    A plan's numerical loss is proportional to the bead distance: what it does to V and to the curvature vanishes with
    a and not with a^2, and would hide the order of the beads; hence the fixed loss.
    """
    return [*_in_step(), *_in_distance()]


def _refined(values: Sequence[tuple[float, float]]) -> tuple[float, float]:
    """Orders of V and curvature: slope of the log of successive differences over factors of 2."""
    steps = np.abs([np.subtract(fine, coarse) for coarse, fine in pairwise(values)])
    levels = np.arange(len(steps))
    speed, curvature = (-float(np.polyfit(levels, np.log2(column), 1)[0]) for column in steps.T)
    return speed, curvature


def _watched(plan: Plan) -> tuple[float, float]:
    """V and tip curvature of a release as means under their windows, m/s and 1/m."""
    rear = follow_rear(plan).rear
    later = rear.times_s > 0.0
    times, arrival = rear.times_s[later], plan.front_arrival_s
    return (
        hann_mean(times, rear.tip_speed_m_s[later], 0.6 * arrival, 0.25 * arrival),
        hann_mean(times, rear.tip_curvature_1_m[later], 0.2 * arrival, 0.1 * arrival),
    )


def _plan(steps_a_frame: int, **values: float | str) -> Plan:
    """A plan whose frames fall at the same times whatever the step."""
    arrival = plan_of(scene_of(dict(values))).front_arrival_s
    steps = _FRAMES * steps_a_frame
    fixed = {"steps": steps, "rear_steps": steps_a_frame, "frames": 1, "timestep_s": arrival / steps}
    return plan_of(scene_of({**values, **fixed}))


def _in_step() -> list[Check]:
    lossless, lossy = (
        _refined(
            [
                _watched(_plan(count, law="linear", beads=200, bending_scale=4.0, loss_time_s=loss))
                for count in (4, 8, 16, 32)
            ]
        )
        for loss in (0.0, 2e-5)
    )
    return [
        Check("orders", "V in the step, without loss", lossless[0], 2.0, 0.1),
        Check("orders", "curvature in the step, without loss", lossless[1], 2.0, 0.15),
        Check("orders", "V in the step, with dashpots", lossy[0], 1.0, 0.2, "dashpots lag by half a step"),
    ]


def _in_distance() -> list[Check]:
    beads = (100, 200, 400, 800)
    given = {"bending_scale": 4.0, "loss_time_s": 5e-5}
    finest = plan_of(scene_of({**given, "beads": beads[-1]}))
    count = math.ceil(finest.front_arrival_s / _FRAMES / (0.8 * finest.largest_timestep_s))
    found = [_watched(_plan(count, beads=number, **given)) for number in beads]
    speed, curvature = _refined(found)
    note = "loss 50 us at every distance"
    return [
        Check("orders", "V in the bead distance, fixed loss", speed, 2.0, 0.15, note),
        Check("orders", "curvature in the bead distance, fixed loss", curvature, 2.0, 0.2, note),
    ]
