"""What a sweep will cost, from a sample of its scenes, before it starts."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from beadband.errors import BeadbandError
from beadband.model.scene import scene_of
from beadband.observables import Column
from beadband.planning.plan import plan_of
from beadband.studies.sweep.grid import Grid, Values
from beadband.studies.sweep.row import key_of
from beadband.studies.sweep.rungs import Rungs

_SAMPLE, _PLANNED = 1024, 32
"""Scenes from which the formula's share is judged, and the cost of a release."""
_PLAN_S, _LEG_S, _BEAD_STEP_S = 3e-4, 1.2e-3, 2.0e-8
_FORMULA_S = 5e-5
"""Seconds of one core for planning a scene, for its two legs, for a bead's step, and for a row by formula."""
_START_S = 2.0
"""Seconds for starting the processes, totals and pictures."""
_NUMBER_BYTES = 19
MOST_BATCH_S = 2.0
"""Seconds that a batch of scenes is expected to take at most, unless it is a single scene."""


@dataclass(frozen=True)
class Estimate:
    """What is expected of a sweep."""

    scenes: int
    runs: int
    """How many of them are expected to be released."""
    seconds: float
    disk_bytes: float
    """Of the table; twice that while it is put in order."""
    run_s: float
    """Seconds of a release on one core, mean."""

    def as_dict(self) -> dict[str, Any]:
        return {name: value for name, value in asdict(self).items() if name != "run_s"}


def estimate(grid: Grid, columns: Sequence[Column], rungs: Rungs, workers: int, kept: int) -> Estimate:
    """What the scenes of a grid cost with so many workers, where the rows of some are kept from an earlier time."""
    scenes = grid.some(_SAMPLE)
    block = rungs.block(scenes)
    runs = [values for values, known in zip(scenes, block.known.tolist(), strict=True) if not known]
    left = max(len(runs) / len(scenes) * len(grid) - kept, 0.0)
    some = runs[:: -(-len(runs) // _PLANNED)] if runs else []
    run_s = sum(map(seconds_of, some)) / len(some) if some else 0.0
    cores = min(workers, os.cpu_count() or 1) if workers else 1
    row_bytes = _row_bytes(columns, scenes)
    seconds = _START_S + left * run_s / cores + _FORMULA_S * len(grid)
    return Estimate(len(grid), round(left), seconds, row_bytes * len(grid), run_s)


def seconds_of(values: Values) -> float:
    """Seconds on one core that a release of a scene and its coarse run are expected to take."""
    try:
        plan = plan_of(scene_of(dict(values)), "leg")
    except BeadbandError:
        return _PLAN_S
    # The coarse run has half the beads and half the steps.
    return 2.0 * _PLAN_S + _LEG_S + 1.25 * _BEAD_STEP_S * plan.bead_steps


def _row_bytes(columns: Sequence[Column], scenes: Sequence[Values]) -> float:
    own = sum(2.0 * len(key_of(values)) for values in scenes) / len(scenes)
    return own + _NUMBER_BYTES * sum(column.kind == "number" for column in columns)
