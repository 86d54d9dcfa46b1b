"""The totals of a sweep: how well the published formula holds, with which factor, and how large the errors are."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from beadband.analysis.fits import Array, Measured
from beadband.studies.sweep.row import DONE, WAVES, Row
from beadband.studies.sweep.store import number


def columns(rows: Sequence[Row]) -> dict[str, Any]:
    """The table as arrays of shape (rows,): numbers where a column holds numbers, else text; NaN and "" for nothing."""
    names = list(dict.fromkeys(name for row in rows for name in row))
    found: dict[str, Any] = {}
    for name in names:
        texts = [row.get(name, "") for row in rows]
        try:
            found[name] = np.array([float("nan") if text in ("", None) else float(text) for text in texts])
        except (TypeError, ValueError):
            found[name] = np.array([str(text) for text in texts])
    return found


def alpha(rows: Sequence[Row], wave: str) -> Measured | None:
    """Mean of alpha, V/C over the published formula, with its standard deviation; None below two scenes."""
    values = np.array([number(row, f"alpha_{wave}") for row in rows if row["status"] == DONE])
    return None if len(values) < 2 else Measured(float(values.mean()), float(values.std(ddof=1)))


def slope_through_zero(x: Array, y: Array) -> Measured:
    """Slope of y = slope x by least squares, with twice its standard error."""
    slope = float(np.sum(x * y) / np.sum(x * x))
    residual = y - slope * x
    variance = float(np.sum(residual**2)) / max(len(x) - 1, 1) / float(np.sum(x * x))
    return Measured(slope, 2.0 * variance**0.5)


def summary(rows: Sequence[Row]) -> dict[str, Any]:
    """Totals for sweep.json."""
    done = [row for row in rows if row["status"] == DONE]
    laws = sorted({row["law"] for row in done if "law" in row}) or [None]
    factors: dict[str, Any] = {}
    for law in laws:
        of = [row for row in done if law is None or row["law"] == law]
        factors[law or "all"] = {}
        for wave in WAVES:
            spread = alpha(of, wave)
            if spread is None:
                continue
            published = np.array([number(row, "published_ratio") for row in of])
            ratios = np.array([number(row, f"ratio_{wave}") for row in of])
            fit = slope_through_zero(published, ratios)
            factors[law or "all"][wave] = {
                "mean": spread.value,
                "standard_deviation": spread.error,
                "slope": fit.value,
                "slope_interval_95": [fit.value - fit.error, fit.value + fit.error],
            }
    reasons: dict[str, list[str]] = {}
    for row in rows:
        if row["status"] != DONE:
            reasons.setdefault(row["reason_code"], []).append(row["reason"])
    errors = np.array([number(row, "rebound_speed_error_m_s") / number(row, "rebound_speed_m_s") for row in done])
    return {
        "scenes": len(rows),
        "status": dict(Counter(row["status"] for row in rows)),
        "without_result": {code: {"scenes": len(texts), "first": texts[0]} for code, texts in reasons.items()},
        "bead_steps": int(sum(number(row, "bead_steps") for row in done)),
        "relative_error": {"median": float(np.median(errors)), "largest": float(errors.max())} if done else None,
        "above_tolerance": sum(row["within_tolerance"] == "no" for row in done),
        "alpha": factors,
    }
