"""One scene of a sweep as a row of its table: parameters, what was found, what it cost, or why there is none."""

from __future__ import annotations

import json
import math
from typing import Any

from beadband.engine import Session
from beadband.errors import BeadbandError, UsageError
from beadband.follow import estimate_of, follow_rear
from beadband.plan import plan_of
from beadband.results import curvature_errors, joined_error_m_s
from beadband.scene import scene_of
from beadband.sweeping.grid import Values

WAVES = ("bar", "rest", "front_horizontal")
RESULTS = (
    "rebound_speed_m_s",
    "rebound_speed_error_m_s",
    "string_speed_m_s",
    "published_ratio",
    *(f"ratio_{wave}" for wave in WAVES),
    *(f"alpha_{wave}" for wave in WAVES),
    *(f"alpha_{wave}_error" for wave in WAVES),
    "exponent",
    "exponent_error",
    "eq7_ratio",
    "eq7_ratio_error",
    "no_curvature",
    "model",
    "beads",
    "steps",
    "bead_steps",
)
"""Columns of what was found; those of the scene stand before them, ``status`` and ``reason`` behind."""
DONE, REFUSED, FAILED = "done", "refused", "failed"


def key_of(values: Values) -> str:
    """The scene as a text that tells it from every other."""
    return json.dumps(values, sort_keys=True)


def release(values: Values, session: Session) -> dict[str, Any]:
    """Release one scene, and its half-as-fine twin; always a row, with ``status`` and ``reason``."""
    row: dict[str, Any] = {"key": key_of(values), **values}
    try:
        plan = plan_of(scene_of(dict(values)), "leg")
        found = follow_rear(plan, session)
        estimate = estimate_of(plan, session)
    except UsageError as error:
        return {**row, "status": REFUSED, "reason": str(error)}
    except BeadbandError as error:
        return {**row, "status": FAILED, "reason": str(error)}
    scene, speed = plan.scene, found.speed_m_s.value
    error_m_s = joined_error_m_s(found.speed_m_s, estimate, plan.speed_error)
    if not (math.isfinite(speed) and math.isfinite(error_m_s)):
        return {**row, "status": FAILED, "reason": "the rebound speed is not finite: the run blew up"}
    string = plan.string
    row |= {
        "rebound_speed_m_s": speed,
        "rebound_speed_error_m_s": error_m_s,
        "string_speed_m_s": string.rear_speed_m_s,
        "published_ratio": scene.published_ratio,
        "no_curvature": found.no_decay or "",
        "model": plan.model,
        "beads": plan.beads,
        "steps": plan.steps,
        "bead_steps": plan.bead_steps,
        "status": DONE,
        "reason": "",
    }
    for wave, wave_speed in scene.wave_speeds(string.front_speed_m_s).items():
        row[f"ratio_{wave}"] = speed / wave_speed
        row[f"alpha_{wave}"] = speed / wave_speed / scene.published_ratio
        row[f"alpha_{wave}_error"] = error_m_s / wave_speed / scene.published_ratio
    if found.decay is not None:
        exponent_error, ratio_error = curvature_errors(found, estimate, plan.curvature_error)
        row |= {
            "exponent": found.decay.exponent.value,
            "exponent_error": exponent_error,
            "eq7_ratio": found.decay.eq7_ratio.value,
            "eq7_ratio_error": ratio_error,
        }
    return row
