"""Results of a strip: what a release gave, its front, and what its held end took up."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from beadband.analysis.convergence import LEAST_ORDER
from beadband.analysis.fits import Measured
from beadband.analysis.ring import RingFrames
from beadband.model import strip
from beadband.planning import error_curves
from beadband.runs.checks import Check, momentum_limit
from beadband.runs.measurement import StripFound
from beadband.runs.results import Estimate, Run, level_error


@dataclass(frozen=True, repr=False)
class StripRun(Run):
    """A finished release of a strip; its rebound speed is the recoil speed of the released end."""

    level: ClassVar[str] = "strip"

    @property
    def strip(self) -> StripFound:
        """What was measured beyond the released end, with the errors of the fits."""
        assert self.measurement.strip is not None
        return self.measurement.strip

    @property
    def frames(self) -> RingFrames:
        """The whole strip over time: ``times_s``, ``positions_m`` and ``stretch``, from the released end on."""
        return self.ring

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
        # The corners of a fan, and a front without loss, sharpen with the root of the spacing alone.
        return Measured(fit.value, level_error(self.plan.beads, fit.value, coarse, LEAST_ORDER, floor))

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
