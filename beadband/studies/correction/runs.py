"""Accurate releases of one leg: the string limit's correction without bead spacing, with its own error."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from beadband.model.scene import Scene
from beadband.planning.plan import plan_of
from beadband.runs.rear_run import follow_rear
from beadband.studies import pool

BEADS_IN_REAR = (80, 113, 160)
"""Levels of each scene, in beads along what moves at the rear: enough for smooth errors of the first order."""
COARSEST_LAYER = 0.6
"""Bead spacing over the bending layer at the coarsest level from which the curvature is not extrapolated."""
_SPEED_ORDER, _CURVATURE_ORDER = 1, 2
_CHUNK = 4


@dataclass(frozen=True)
class Released:
    """One scene at all its levels; relative to the string limit and to Eq. 7, NaN where it was not measured."""

    beads: tuple[int, ...]
    deviations: tuple[float, ...]
    """V/V_string - 1 at each level."""
    eq7_ratios: tuple[float, ...]

    @property
    def delta(self) -> tuple[float, float]:
        """V/V_string - 1 without spacing, and its error."""
        return limit(self.beads, self.deviations, _SPEED_ORDER)

    @property
    def ratio(self) -> tuple[float, float]:
        """Mean curvature over Eq. 7 without spacing, and its error."""
        return limit(self.beads, self.eq7_ratios, _CURVATURE_ORDER)


def limit(beads: Iterable[int], values: Iterable[float], order: int) -> tuple[float, float]:
    """Value at no spacing of a straight line in beads^(-order), and its error; NaN where a value is.

    The error joins the scatter about the line, as it is worth at no spacing, and a tenth of the way from the finest
    run: what is left when the order is not quite the one assumed.
    """
    x, y = 1.0 / np.asarray(tuple(beads), dtype=np.float64) ** order, np.asarray(tuple(values), dtype=np.float64)
    if not np.all(np.isfinite(y)):
        return math.nan, math.nan
    matrix = np.stack([np.ones_like(x), x / x.max()], axis=1)
    gain = np.linalg.pinv(matrix)
    found = gain @ y
    scatter = math.sqrt(float(np.sum((y - matrix @ found) ** 2)) / max(len(y) - 2, 1))
    return float(found[0]), math.hypot(scatter * float(np.linalg.norm(gain[0])), 0.1 * (float(found[0]) - float(y[-1])))


def release(scene: Scene) -> Released:
    """Run one scene at all its levels, in the session of this process."""
    beads, deviations, ratios = [], [], []
    layer, length = scene.scales.bending_layer_m, scene.band.circumference_m
    for count in BEADS_IN_REAR:
        number = 2 * round(0.5 * count * length / scene.scales.rear_length_m)
        found = follow_rear(plan_of(scene.with_beads(number), "leg"), pool.session())
        beads.append(number)
        deviations.append(found.fitted_speed_m_s.value / scene.string.rear_speed_m_s - 1.0)
        resolved = found.decay is not None and length / beads[0] <= COARSEST_LAYER * layer
        ratios.append(found.decay.eq7_ratio.value if found.decay is not None and resolved else math.nan)
    return Released(tuple(beads), tuple(deviations), tuple(ratios))


def released(
    scenes: list[Scene], jobs: int | None, progress: pool.Progress | None = None
) -> list[Released | pool.Failed]:
    """All scenes at all their levels, in their order; a run that fails is told from one that was done."""
    return pool.run_all(release, scenes, jobs=jobs, progress=progress, chunk=_CHUNK)
