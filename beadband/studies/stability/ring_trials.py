"""A whole ring released as a trial: sampled frames, any angle form, any start; and the limit of its step."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from beadband.analysis.curvature import curvatures
from beadband.analysis.fits import slope
from beadband.lammps.divergence import DivergenceError
from beadband.lammps.scripts import MOST_ENERGY, dashpot_cutoff_m
from beadband.model.angle_forms import QUARTIC
from beadband.model.scales import SPEED_WINDOW
from beadband.model.scene import scene_of
from beadband.planning.plan import Plan, plan_of
from beadband.runs.rear_run import hold
from beadband.statics.ring import WRAPPED, Ring
from beadband.studies.stability import frozen, trials
from beadband.studies.stability.catalogue_entry import carries
from beadband.studies.verification.specimen import FIXED, FREE, Array, Specimen, chain

_END = 0.97
_SHAPES = 60
LEAST = 0.97
MOST_SMOOTH, MOST_AT_SHOCK = 1.12, 2.0
"""Measured limits over those of the worst shape, and over the uniform strand's, that count as agreement."""
"""Shapes of a release whose limits are computed."""


def specimen_of(plan: Plan, ring: Ring) -> Specimen:
    """The ring as a specimen: beads that lie on the finger are fixed, all others free."""
    types = np.where(ring.types == WRAPPED, FIXED, FREE)
    strip = chain(plan.scene.strand(plan.beads), ring.positions_m, types, closed=True, strain=plan.scene.strain)
    return replace(strip, cutoff_m=dashpot_cutoff_m(ring))


def options_of(plan: Plan, **changes: Any) -> trials.Options:
    """How a plan's release is run as a trial."""
    half = plan.beads // 2 + 1
    return trials.Options(loss_time_s=plan.loss_time_s, legs=(half, half + 1), **changes)


def release(
    plan: Plan, ring: Ring, timestep_s: float, frames: int, options: trials.Options | None = None
) -> tuple[trials.Course, Array]:
    """Release to just before the front's arrival, with some such number of sampled frames; the course, their times (s).

    Not beyond it: the beads on the finger stay where they are, and a front that meets them compresses the leg.

    DivergenceError when it diverges.
    """
    steps = int(_END * plan.front_arrival_s / timestep_s)
    every = max(1, steps // frames)
    steps = every * (steps // every)
    course = trials.run(
        specimen_of(plan, ring),
        timestep_s,
        steps,
        every,
        options or options_of(plan),
        largest_step_s=plan.largest_timestep_s,
    )
    return course, timestep_s * course.steps.astype(np.float64)


def tip_speed_m_s(plan: Plan, course: trials.Course, times_s: Array) -> float:
    """Rebound speed: slope of the tip's path over the window of a release."""
    start, end = (share * plan.front_arrival_s for share in SPEED_WINDOW)
    return slope(times_s, course.positions_m[:, 0, 0], start, end).value


def tip_curvature_1_m(plan: Plan, course: trials.Course) -> Array:
    """Curvature at the tip over the frames."""
    points = course.positions_m
    return curvatures(points[:, -1], points[:, 0], points[:, 1], plan.scene.strand(plan.beads).spacing_m)


def upper_stretches(plan: Plan, ring: Ring, points: Array) -> Array:
    """Stretches of the bonds of the upper leg, from the tip on; ``points`` (beads, 2)."""
    last = int(np.flatnonzero(ring.types == WRAPPED)[0])
    bonds = np.diff(points[: last + 1], axis=0)
    return np.asarray(np.hypot(bonds[:, 0], bonds[:, 1]) / plan.scene.strand(plan.beads).spacing_m)


@dataclass(frozen=True)
class ReleaseLimit:
    """The step limit of a whole release, s."""

    name: str
    planned_s: float
    """As the plan has it: a uniform strand at the worst stretch that it expects."""
    uniform_s: float
    """A uniform strand at the worst stretch that the release met: a bound from below."""
    frozen_s: float
    """The smallest exact limit of the shapes that the release went through."""
    measured_s: float
    least_stretch: float
    smooth: bool
    """Whether the front is; without loss a shock is not."""

    @property
    def agrees(self) -> bool:
        """Whether the release bears its bound, and what its shapes say to some per cent.

        A shape's limit may be passed for the few steps for which the shape lasts, and a release is free of noise, so
        that growth needs time to show. Behind a shock without loss single bonds are compressed for a few steps only.
        """
        high = MOST_SMOOTH if self.smooth else MOST_AT_SHOCK
        return self.measured_s >= LEAST * self.uniform_s and LEAST <= self.measured_s / self.frozen_s <= high

    def as_dict(self) -> dict[str, Any]:
        return {
            "scene": self.name,
            "planned_s": self.planned_s,
            "uniform_s": self.uniform_s,
            "frozen_s": self.frozen_s,
            "measured_s": self.measured_s,
            "least_stretch": self.least_stretch,
            "held": bool(self.agrees),
        }


def release_limit(values: dict[str, Any]) -> ReleaseLimit:
    """Measure the limit of a release to 0.5 per cent, and compute it from the shapes of a run well below it."""
    plan = plan_of(scene_of(values))
    ring = hold(plan)
    course, _ = release(plan, ring, 0.6 * plan.largest_timestep_s, 400)
    count = plan.beads
    order = np.r_[count // 2 + 1 : count, 0 : count // 2 + 1]  # from the finger over the tip to the finger
    shapes = course.positions_m[:, order]
    strand = plan.scene.strand(count)
    model = frozen.Chain(strand, QUARTIC, False, np.ones(count), ring.types[order] != WRAPPED)
    bonds = np.diff(shapes, axis=1)
    stretches = np.hypot(bonds[..., 0], bonds[..., 1]) / strand.spacing_m
    # The most compressed shapes, and some of all times.
    chosen = set(np.argsort(stretches.min(axis=1))[: _SHAPES // 2].tolist())
    chosen |= set(np.linspace(0, len(shapes) - 1, _SHAPES // 2).astype(int).tolist())
    exact = frozen.met(model, shapes[sorted(chosen)], plan.loss_time_s)
    least = float(stretches.min())
    uniform = strand.largest_step_s(plan.loss_time_s, plan.scene.strain, min(least, 1.0))

    def unstable(step: float) -> bool:
        try:
            total = release(plan, ring, step, 40)[0].total_j
        except DivergenceError:
            return True
        return not total.max() <= MOST_ENERGY * total[0]

    found = trials.bisect(unstable, exact, sharpness=5e-3, reach=0.05)
    name = ", ".join(
        f"{key} {value:g}" if isinstance(value, (int, float)) else f"{value}" for key, value in values.items()
    )
    # Without loss a shock rings: the plan warns about it.
    smooth = not carries(plan.warnings, "lossless-shock")
    return ReleaseLimit(name, plan.largest_timestep_s, uniform, exact, found, least, smooth)


def scenes(quick: bool) -> list[dict[str, Any]]:
    """Releases whose limit is measured."""
    few: list[dict[str, Any]] = [
        {"beads": 120},
        {"beads": 240, "law": "linear", "loss_time_s": 0.0},
        {"beads": 300, "strain": 1.2, "half_angle_deg": 8.0},
    ]
    if quick:
        return few
    return [
        *few,
        {"beads": 400},
        {"beads": 400, "law": "linear"},
        {"beads": 800},
        {"beads": 400, "loss_time_s": 4e-5},
        {"beads": 300, "loss_time_s": 0.0},
        {"band": "I", "beads": 300, "strain": 0.8},
        {"band": "II", "beads": 300, "strain": 1.4, "half_angle_deg": 5.0},
        {"band": "IV", "beads": 400, "strain": 0.9, "law": "linear"},
        {"band": "circular", "beads": 300, "strain": 0.2, "half_angle_deg": 25.0},
    ]
