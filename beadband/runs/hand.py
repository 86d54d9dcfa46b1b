"""The hand of a launch: its motion from the folder of a run, its figures with errors, its checks and remarks."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from beadband.analysis.contact import impulse_n_s
from beadband.analysis.convergence import plain_error
from beadband.analysis.fits import Array, Measured
from beadband.analysis.hand import (
    LATEST_HIT,
    HandMeasurement,
    HandMotion,
    hand_energy_j,
    hand_impulse_n_s,
    measure_hand,
)
from beadband.analysis.readers import HandPath, Watch, read_hand
from beadband.notices import Notice, notice
from beadband.planning.launch_plan import LaunchPlan
from beadband.runs import folder as files
from beadband.runs.checks import Check, momentum_limit
from beadband.statics.finger import Support
from beadband.statics.ring import Ring

_FIGURES = ("hit_speed_m_s", "peak_force_n", "impulse_n_s", "displacement_m", "velocity_m_s")
"""Figures that have an error; the last two none where the velocity is prescribed."""

_LEAST = dict(zip(_FIGURES, (0.003, 0.005, 0.004, 0.005, 0.005), strict=True))
"""Relative errors that two launches can miss, for they may agree by chance: nose and contact ring. With planned beads
the figures are off those of finite elements by up to 0.2, 0.9, 0.7 and 1.7 %, in the order above."""


@dataclass(frozen=True)
class HandRun:
    """A hand that was moved."""

    motion: HandMotion
    path: HandPath
    found: HandMeasurement
    energy_j: Array
    """Taken from the band by each line of hand.dat, shape (lines,)."""
    given_n_s: float
    """Impulse of preload, spring, damper and band over the whole run."""

    @cached_property
    def momentum_n_s(self) -> float:
        """At the end of the run."""
        return (self.motion.mass_kg or 0.0) * float(self.path.velocity_m_s[-1])

    def figures(self, beads: int, coarse: tuple[int, HandMeasurement] | None, floor: float) -> dict[str, Any]:
        """The figures by their names, with the error that a launch with other beads gives them, as in a launch's.

        ``floor`` is the relative error expected of the rebound speed. A coarse launch that differs in whether the hand
        is hit gives none.
        """
        found: dict[str, Any] = asdict(self.found)
        if coarse is not None and coarse[1].hit != self.found.hit:
            return found
        for name in _FIGURES if self.motion.mass_kg is not None else _FIGURES[:3]:
            value, other = found[name], coarse and getattr(coarse[1], name)
            if value is not None and other is not None and coarse is not None:
                spacing = 1.0 / np.array([beads, coarse[0]])
                least = math.hypot(floor, _LEAST[name]) * abs(value)
                found[name] = Measured(value, plain_error(spacing, np.array([value, other]), least))
        return found

    def checks(self, band_momentum_n_s: float) -> dict[str, Check]:
        """That its momentum is its impulse, measured by the band's momentum."""
        if self.motion.mass_kg is None:
            return {}
        apart = abs(self.momentum_n_s - self.given_n_s) / abs(band_momentum_n_s)
        return {"hand": Check("hand-unbalanced", apart, momentum_limit(int(self.path.steps[-1])))}

    def remarks(self, coarse: tuple[int, HandMeasurement] | None) -> list[Notice]:
        """Whether it is hit, and whether the beads decide that."""
        found, more = self.found, []
        if coarse is not None and coarse[1].hit != found.hit:
            more = [notice("hand-hit-unsure", beads=coarse[0], other="hit" if coarse[1].hit else "not hit")]
        if not found.hit:
            return [notice("hand-not-hit", limit=LATEST_HIT), *more]
        way = 1e3 * found.displacement_m
        return [notice("hand-hit", value=found.hit_speed_m_s, time_s=found.hit_s, way_mm=way), *more]


def hand_run(folder: Path, plan: LaunchPlan, ring: Ring, support: Support, watch: Watch) -> HandRun | None:
    """Read and measure the hand of a launch; None where the finger stays. ReadError for a damaged hand.dat."""
    hand = plan.scene.hand
    if hand is None:
        return None
    path, step = read_hand(folder / files.HAND), plan.timestep_s
    preload = support.pull_n(ring.positions_m) if hand.preload_n is None else hand.preload_n
    motion = HandMotion(hand.mass_kg, hand.stiffness_n_m, hand.damping_n_s_m, preload)
    return HandRun(
        motion=motion,
        path=path,
        found=measure_hand(path, watch, step, plan.gap_margin_m, plan.release.front_arrival_s),
        energy_j=hand_energy_j(motion, path, watch, step),
        given_n_s=hand_impulse_n_s(motion, path, step) - impulse_n_s(watch, step),
    )
