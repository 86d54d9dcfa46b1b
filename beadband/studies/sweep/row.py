"""One scene of a sweep as a row of its table: parameters, what was found, what it cost, or why there is none."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Sequence
from typing import Any, NamedTuple

from beadband import observables
from beadband.errors import BeadbandError, RunError, explain
from beadband.model.scene import scene_of
from beadband.planning.plan import Plan, plan_of
from beadband.runs.clock import peak_bytes
from beadband.runs.rear_run import rear_runs
from beadband.runs.results import RearRun
from beadband.studies import pool
from beadband.studies.sweep.grid import Values

DONE, REFUSED, FAILED = "done", "refused", "failed"

Row = dict[str, Any]


class Released(NamedTuple):
    """A row, and its share of what it took."""

    row: Row
    seconds: float
    lammps_s: float
    peak_bytes: int
    """Most memory that its process has taken so far."""


_ENCODER = json.JSONEncoder(sort_keys=True)


def key_of(values: Values) -> str:
    """The scene as text, which identifies it."""
    return _ENCODER.encode(values)


def releases(scenes: Sequence[Values]) -> list[Released | BeadbandError]:
    """Release scenes in this process, many at a time, each once more with half the beads.

    In the place of a row stands a UsageError when the scene has no answer, and a RunError when the release failed (code
    "not-finite" without a finite speed).
    """
    start, session = time.perf_counter(), pool.session()
    before_s = session.runs_s
    plans: list[Plan | BeadbandError] = []
    for values in scenes:
        try:
            plans.append(plan_of(scene_of(dict(values)), "leg"))
        except BeadbandError as error:
            plans.append(error)
    found = iter(rear_runs([plan for plan in plans if isinstance(plan, Plan)], session))
    rows: list[Row | BeadbandError] = []
    for values, plan in zip(scenes, plans, strict=True):
        done = next(found) if isinstance(plan, Plan) else plan
        try:
            rows.append({**values, **_results(done)} if isinstance(done, RearRun) else done)
        except BeadbandError as error:
            rows.append(error)
    each = (time.perf_counter() - start) / len(scenes), (session.runs_s - before_s) / len(scenes)
    peak = peak_bytes()
    return [row if isinstance(row, BeadbandError) else Released(row, *each, peak) for row in rows]


RELEASE = pool.Together(releases)
"""The task of a sweep."""


def without_result(values: Values, failed: pool.Failed) -> Row:
    """Row of a scene that has no answer, or whose release failed."""
    status = REFUSED if failed.refused else FAILED
    return {**values, "status": status, "reason": failed.reason, "reason_code": failed.code}


def _results(found: RearRun) -> Row:
    speed = found.speed
    if not (math.isfinite(speed.value) and math.isfinite(speed.error)):
        raise RunError(
            explain(
                "the rebound speed is not a number",
                f"{speed:g} m/s",
                "finite numbers",
                "lower --timestep, or give the shock a loss with --loss-time",
            ),
            "not-finite",
        )
    return {**observables.row(found), "status": DONE, "reason": "", "reason_code": ""}
