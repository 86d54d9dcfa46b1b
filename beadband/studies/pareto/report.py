"""The study in numbers: CSV tables, the table for the terminal, and the parts of frontier.json."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Iterable, Sequence
from typing import Any

from beadband.studies.pareto.convergence import Row
from beadband.studies.pareto.cores import WAYS, Timing, pays_from
from beadband.studies.pareto.outcomes import OK, name_of
from beadband.studies.pareto.reference import QUANTITIES


def csv_text(rows: Sequence[Row]) -> str:
    """One line for each run; cells without a value stay empty."""
    return _csv(map(_cells, rows))


def _cells(row: Row) -> dict[str, object]:
    seconds = row.integrate_s
    return {
        **{key: getattr(row, key) for key in ("family", "variant", "model", "beads", "steps", "bead_steps")},
        "relax_s": row.relax_s,
        "setup_s": row.setup_s,
        "integrate_median_s": row.median_s,
        "integrate_min_s": min(seconds, default=math.nan),
        "integrate_max_s": max(seconds, default=math.nan),
        "repeats": len(seconds),
        "speed_m_s": row.answer.speed_m_s if row.answer else math.nan,
        **{f"error_{name}": error for name, error in zip(QUANTITIES, row.errors, strict=True)},
        **{f"sure_error_{name}": error for name, error in zip(QUANTITIES, row.error_bounds, strict=True)},
        "own_limit": row.own,
        "own_error_speed": row.own_errors[0],
        "status": row.outcome.code,
        "reason": str(row.outcome.cause),
    }


def cores_csv(times: Iterable[Timing]) -> str:
    """One line for each size and way."""
    return _csv(
        {
            **{key: getattr(one, key) for key in ("way", "beads", "steps")},
            "min_ns_per_bead_step": one.least_ns,
            "median_ns_per_bead_step": one.median_ns,
            "repeats": len(one.seconds),
            "reason": str(one.outcome.cause),
        }
        for one in times
    )


def _csv(lines: Iterable[dict[str, object]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    for number, line in enumerate(lines):
        if not number:
            writer.writerow(line)
        writer.writerow(map(_cell, line.values()))
    return text.getvalue()


def _cell(value: object) -> object:
    """Six digits; empty for NaN and infinity."""
    if isinstance(value, float):
        return f"{value:.6g}" if math.isfinite(value) else ""
    return value


def finite(value: Any) -> Any:
    """The same with null for NaN and infinity, as JSON needs."""
    if isinstance(value, dict):
        return {key: finite(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def not_converging(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Variants that fail at some size, do not converge, or converge to another limit, each with its cause."""
    found: dict[tuple[str, str, str], list[Row]] = {}
    for row in rows:
        if row.outcome.code != OK:
            found.setdefault((row.family, row.variant, row.outcome.code), []).append(row)
    return [
        {
            "family": family,
            "variant": variant,
            "status": code,
            "beads": sorted({row.beads for row in those}),
            "reason": those[-1].outcome.brief,
        }
        for (family, variant, code), those in found.items()
    ]


def cores_dict(times: Sequence[Timing]) -> dict[str, Any]:
    """Nanoseconds a bead and step by way and size, and from where on a second core pays."""
    timed = {way: [t for t in times if t.way == way and t.seconds] for way in WAYS}
    return {
        "least_ns_per_bead_step": {way: {str(t.beads): t.least_ns for t in timed[way]} for way in WAYS},
        "median_ns_per_bead_step": {way: {str(t.beads): t.median_ns for t in timed[way]} for way in WAYS},
        "pays_from_beads": {way: pays_from(times, way) for way in WAYS[1:]},
        "failed": [
            {"way": t.way, "beads": t.beads, "status": t.outcome.code, "reason": str(t.outcome.cause)}
            for t in times
            if not t.seconds
        ],
    }


def full_name(entry: dict[str, Any]) -> str:
    """Family and variant of an entry of frontier.json."""
    return f"{entry['family']}: {entry['variant']}"


TITLES = {"speed": "V", "curvature_01": "κ at 0.1 t_f", "curvature_03": "κ at 0.3 t_f"}
"""Of :data:`~beadband.studies.pareto.reference.QUANTITIES`, for readers."""


def table(result: dict[str, Any]) -> str:
    """The frontiers, the plans and the methods that do not converge, for the terminal."""
    lines = []
    for name, front in result["frontier"].items():
        lines.append(f"frontier, {TITLES[name]}".ljust(46) + "beads    steps     ms   error  bound")
        lines += [_line(full_name(entry), entry) for entry in front]
    lines.append("plan".ljust(46) + "beads    steps     ms   error  bound  cost over frontier")
    for entry in result["plan"]:
        ratio = entry["cost_over_frontier_at_its_error"]
        name = f"for {entry['for']}, {100 * entry['tolerance']:g} %: {TITLES[entry['quantity']]}"
        lines.append(_line(name, entry) + ("  -" if ratio is None else f"  {ratio:.2f}"))
    lines.append("no convergence to the common limit")
    lines += [
        f"  {full_name(entry)}, {', '.join(map(str, entry['beads']))} beads: {name_of(entry['status'])}"
        for entry in result["not_converging"]
    ]
    return "\n".join(lines)


def _line(name: str, entry: dict[str, Any]) -> str:
    return (
        f"  {name:42.42s} {entry['beads']:6d} {entry['steps']:8d} {1e3 * entry['integrate_s']:6.2f} "
        f"{100 * entry['error']:6.2f}% {100 * entry['sure_error']:5.2f}%"
    )
