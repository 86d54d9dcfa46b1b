"""The checks of physics that a sound run passes, with limits from what rounding and the step can do."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from beadband.analysis.energy import Balance
from beadband.notices import Notice, notice
from beadband.planning.plan import Plan

_FRONT_BEADS = 20.0
"""Beads inside the fronts of both legs: each spreads over some ten of them (planning.plan.LOSS_BEADS)."""
_LOSS_SAMPLED = 0.1
"""Share of the loss by which its sum over samples may be off."""
_FAST_BEADS = 10.0
"""Largest speed of a bead over that of the centre of mass, generously."""


@dataclass(frozen=True)
class Check:
    """A law of physics or of numerics that a sound run keeps: ``value`` is at most ``limit``."""

    code: str
    """Of the notice that says how it failed."""
    value: float
    limit: float
    more: Mapping[str, Any] = field(default_factory=dict)

    @property
    def failed(self) -> bool:
        return not self.value <= self.limit

    @property
    def notice(self) -> Notice:
        return notice(self.code, value=self.value, limit=self.limit, **self.more)


def rounding_limit(steps: float) -> float:
    """Distance of a symmetric run's tip from the axis, over the leg, that rounding alone may reach: eps steps^(3/2).

    The release starts symmetric to the last digit. Each step rounds positions of the size of a leg L, by eps L at
    most, and with them the stretch of a bond of length a by eps L/a. The force from that moves a bead within a step
    by (c dt/a)^2 eps L, and c dt < a is the limit of stability: eps L again, now as a change of the way in every
    later step. Nothing pulls back a free bead, so that n such changes, independent ones, sum up to eps L n^(3/2).
    Releases of 240 to 560 beads reach a thousandth of it; a bead displaced by 1e-4 of the leg a million times as much.
    """
    return float(np.finfo(np.float64).eps * steps**1.5)


def energy_limit(plan: Plan, energy: Balance) -> float:
    """Unbalanced share of the stored energy that the step and the sampling of the loss may leave.

    Velocity Verlet conserves, for a mode of frequency w, not its energy E but one that differs by up to (w dt)^2/4 of
    it, which is (dt/largest step)^2 at the stiffest mode. Of the stored energy, modes at the scale of the beads hold
    what is inside the fronts, some :data:`_FRONT_BEADS` beads of all, and what a shock without enough loss leaves
    ringing behind it: the energy that the shock of the string limit gives up in its legs, less the loss. The loss is
    a sum over samples.
    """
    scene, string, law = plan.scene, plan.string, plan.scene.material
    held, behind = 1.0 + scene.strain, 1.0 + string.residual_strain
    mean_stress = 0.5 * (float(law.stress(held)) + string.residual_stress_pa)
    shock = float(law.energy(held) - law.energy(behind)) - mean_stress * (held - behind)
    shock_j = scene.legs * scene.wedge.reference_leg_m * scene.band.area_m2 * shock
    lost_j = float(energy.dissipated_j[-1])
    at_beads = _FRONT_BEADS / plan.beads + max(shock_j - lost_j, 0.0) / energy.stored_j
    return (plan.timestep_s / plan.largest_timestep_s) ** 2 * at_beads + _LOSS_SAMPLED * lost_j / energy.stored_j


def momentum_limit(steps: int) -> float:
    """Difference of momentum and impulse over the momentum that rounding may leave.

    Velocity Verlet adds the impulse step by step, and each step rounds the velocity of each bead by eps at most. With
    beads up to :data:`_FAST_BEADS` times as fast as the centre of mass, and all roundings one way, that is
    10 eps steps.
    """
    return _FAST_BEADS * float(np.finfo(np.float64).eps) * steps
