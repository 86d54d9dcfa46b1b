"""Results of a strip: what a release gave, its front, and what its held end took up."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from beadband.analysis.fits import Array, Measured
from beadband.analysis.readers import Trajectory
from beadband.analysis.strip import strip_stretch
from beadband.model import strip
from beadband.planning import error_curves
from beadband.runs.checks import Check, momentum_limit
from beadband.runs.measurement import StripFound
from beadband.runs.results import Estimate, Run, level_error

FRONT_ORDER, FAN_ORDER = 0.75, 0.5
"""Least orders with which speed and arrival of the front converge: of a wave of one part, and of several, where a
viscous corner is as wide as the root of the spacing (tests/validation/strip.py)."""


@dataclass(frozen=True)
class StripFrames:
    """The whole strip over time; frames but the first are averages over the interval before them."""

    trajectory: Trajectory
    times_s: Array
    """Shape (frames,)."""
    stretch: Array
    """Of each bond, from the released end on, shape (frames, bonds)."""

    @property
    def positions_m(self) -> Array:
        """Positions of the beads, shape (frames, bonds + 1, 2)."""
        return self.trajectory.positions_m


@dataclass(frozen=True, repr=False)
class StripRun(Run):
    """A finished release of a strip; its rebound speed is the recoil speed of the released end."""

    level: ClassVar[str] = "strip"

    @property
    def strip(self) -> StripFound:
        """What was measured beyond the released end, with the errors of the fits."""
        assert self.measurement.strip is not None
        return self.measurement.strip

    @cached_property
    def frames(self) -> StripFrames:
        """The whole strip over time, as arrays."""
        trajectory = self.ring.trajectory
        spacing = self.plan.strand.spacing_m
        return StripFrames(
            trajectory, trajectory.times_s(self.plan.timestep_s), strip_stretch(trajectory.positions_m, spacing)
        )

    @property
    def exact_front_speed_m_s(self) -> float:
        """Speed of the middle of the foremost part of the wave in the exact solution, m/s in reference length."""
        return strip.front_speed_m_s(self.scene)

    @property
    def exact_arrival_s(self) -> float:
        """When that reaches the held end, s."""
        return self.scene.wedge.reference_leg_m / self.exact_front_speed_m_s

    @cached_property
    def front_speed(self) -> Measured | None:
        """Measured speed of the same, with its whole error; None where no front was seen (``strip.no_front``)."""
        front = self.strip.front
        return None if front is None else self._whole(front.speed_m_s, "front_speed_m_s")

    @cached_property
    def arrival(self) -> Measured | None:
        """Its measured arrival at the held end, s, with its whole error."""
        front = self.strip.front
        return None if front is None else self._whole(front.arrival_s, "arrival_s")

    def _whole(self, fit: Measured, name: str) -> Measured:
        value = getattr(self.estimate, name) if isinstance(self.estimate, Estimate) else None
        coarse = (self.estimate.beads, value) if isinstance(self.estimate, Estimate) and value is not None else None
        floor = float(np.hypot(fit.error, error_curves.front_error(self.plan.beads) * fit.value))
        order = FRONT_ORDER if len(self.plan.string.wave.parts) == 1 else FAN_ORDER
        return Measured(fit.value, level_error(self.plan.beads, fit.value, coarse, order, floor))

    @property
    def momentum_n_s(self) -> float:
        """Momentum of the strip at the end of the run, N s."""
        return float(self.strip.momentum_n_s[-1])

    @property
    def impulse_n_s(self) -> float:
        """Impulse of the held end until then, N s."""
        return float(self.strip.impulse_n_s[-1])

    @property
    def checks(self) -> dict[str, Check]:
        """The checks of a release; in the place of the symmetry of a ring, momentum and impulse."""
        found = {name: one for name, one in super().checks.items() if name != "asymmetry"}
        apart = float(np.abs(self.strip.momentum_n_s - self.strip.impulse_n_s).max()) / abs(self.momentum_n_s)
        return {**found, "momentum": Check("momentum-unbalanced", apart, momentum_limit(self.plan.steps))}
