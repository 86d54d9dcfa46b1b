"""One scene of a sweep as a row of its table: parameters, what was found, what it cost, or why there is none."""

from __future__ import annotations

import json
import math
import time
from typing import Any

from beadband import observables
from beadband.errors import RunError, explain
from beadband.model.scene import scene_of
from beadband.planning.plan import plan_of
from beadband.runs.rear_run import rear_run
from beadband.runs.results import RearRun
from beadband.studies import pool
from beadband.studies.sweep.grid import Values

WAVES = tuple(observables.WAVES)
DONE, REFUSED, FAILED = "done", "refused", "failed"

Row = dict[str, Any]


def key_of(values: Values) -> str:
    """The scene as text, which identifies it."""
    return json.dumps(values, sort_keys=True)


def release(values: Values) -> tuple[Row, float, float]:
    """Release one scene in this process, and once more with half the beads.

    Returns its row, the seconds that this took, and those inside LAMMPS. UsageError when the scene has no answer,
    RunError when the release failed (code "not-finite" without a finite speed).
    """
    start, session = time.perf_counter(), pool.session()
    before_s = session.runs_s
    found = rear_run(plan_of(scene_of(dict(values)), "leg"), session)
    row = {"key": key_of(values), **values, **_results(found)}
    return row, time.perf_counter() - start, session.runs_s - before_s


def without_result(values: Values, failed: pool.Failed) -> Row:
    """Row of a scene that has no answer, or whose release failed."""
    status = REFUSED if failed.refused else FAILED
    return {"key": key_of(values), **values, "status": status, "reason": failed.reason, "reason_code": failed.code}


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


def columns() -> tuple[str, ...]:
    """Columns of a table behind those of its scenes."""
    return (*observables.columns(), "status", "reason", "reason_code")
