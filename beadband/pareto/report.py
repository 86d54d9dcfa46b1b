"""The diagram in numbers: tidy tables, the table for the terminal, and what a program reads."""

from __future__ import annotations

import csv
import io
import math
from collections.abc import Sequence
from typing import Any

from beadband.pareto.cores import WAYS, Timing, pays_from
from beadband.pareto.judgement import OK, Row
from beadband.pareto.reference import QUANTITIES, Reference

COLUMNS = (
    "family",
    "variant",
    "model",
    "beads",
    "steps",
    "bead_steps",
    "relax_s",
    "setup_s",
    "integrate_median_s",
    "integrate_min_s",
    "integrate_max_s",
    "repeats",
    "speed_m_s",
    *(f"error_{name}" for name in QUANTITIES),
    *(f"sure_error_{name}" for name in QUANTITIES),
    "own_limit",
    "own_error_speed",
    "status",
    "reason",
)
CORE_COLUMNS = ("way", "beads", "steps", "min_ns_per_bead_step", "median_ns_per_bead_step", "repeats", "reason")


def csv_text(rows: Sequence[Row]) -> str:
    """One line for each run; what there is not stays empty."""
    lines = []
    for row in rows:
        seconds = row.integrate_s
        speed = row.answer.speed_m_s if row.answer else math.nan
        lines.append(
            (
                row.family,
                row.variant,
                row.model,
                row.beads,
                row.steps,
                row.bead_steps,
                row.relax_s,
                row.setup_s,
                row.median_s,
                min(seconds, default=math.nan),
                max(seconds, default=math.nan),
                len(seconds),
                speed,
                *row.errors,
                *row.sure_errors,
                row.own,
                row.own_errors[0],
                row.status,
                row.reason,
            )
        )
    return _csv(COLUMNS, lines)


def cores_csv(times: Sequence[Timing]) -> str:
    """One line for each size and way."""
    return _csv(
        CORE_COLUMNS,
        [(t.way, t.beads, t.steps, t.least_ns, t.median_ns, len(t.seconds), t.reason) for t in times],
    )


def _csv(heads: Sequence[str], lines: Sequence[Sequence[object]]) -> str:
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(heads)
    writer.writerows([[_cell(value) for value in line] for line in lines])
    return text.getvalue()


def _cell(value: object) -> object:
    """Six digits, and nothing for what is no number."""
    if isinstance(value, float):
        return f"{value:.6g}" if math.isfinite(value) else ""
    return value


def finite(value: Any) -> Any:
    """The same with null for what is no number."""
    if isinstance(value, dict):
        return {key: finite(one) for key, one in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(one) for one in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def reference_dict(reference: Reference) -> dict[str, Any]:
    """A reference that some methods converge to by construction."""
    return {
        "beads": list(reference.beads),
        **{
            name: {"value": value, "uncertainty": spread}
            for name, value, spread in zip(QUANTITIES, reference.values, reference.uncertainties, strict=True)
        },
    }


def strays(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Variants that blow up somewhere, do not converge, or converge to something else, each with its reason."""
    found: dict[tuple[str, str, str], list[Row]] = {}
    for row in rows:
        if row.status != OK:
            found.setdefault((row.family, row.variant, row.status), []).append(row)
    return [
        {
            "family": family,
            "variant": variant,
            "status": status,
            "beads": sorted({row.beads for row in those}),
            "reason": those[-1].reason,
        }
        for (family, variant, status), those in found.items()
    ]


def cores_dict(times: list[Timing]) -> dict[str, Any]:
    """Nanoseconds a bead and step by way and size, and from where on a second core pays."""
    return {
        "least_ns_per_bead_step": {
            way: {str(t.beads): t.least_ns for t in times if t.way == way and t.seconds} for way in WAYS
        },
        "median_ns_per_bead_step": {
            way: {str(t.beads): t.median_ns for t in times if t.way == way and t.seconds} for way in WAYS
        },
        "pays_from_beads": {way: pays_from(times, way) for way in WAYS[1:]},
        "failed": [{"way": t.way, "beads": t.beads, "reason": t.reason} for t in times if not t.seconds],
    }


def full_name(entry: dict[str, Any]) -> str:
    """Family and variant of an entry of frontier.json."""
    return f"{entry['family']}: {entry['variant']}"


def table(result: dict[str, Any]) -> str:
    """The frontier of V and the plan beside it, for the terminal."""
    lines = []
    for name, title in (
        ("speed", "V"),
        ("curvature_01", "curvature at 0.1 t_f"),
        ("curvature_03", "curvature at 0.3 t_f"),
    ):
        front = result["frontier"].get(name)
        if front is None:
            continue
        lines.append(f"frontier, {title}".ljust(46) + "beads    steps     ms   error   sure")
        lines += [
            f"  {full_name(entry):42.42s} {entry['beads']:6d} {entry['steps']:8d} "
            f"{1e3 * entry['integrate_s']:6.2f} {100 * entry['error']:6.2f}% {100 * entry['sure_error']:5.2f}%"
            for entry in front
        ]
    lines.append("plan".ljust(46) + "beads    steps     ms   error   sure  cost over frontier")
    for entry in result["plan"]:
        ratio = entry["cost_over_frontier_at_its_error"]
        name = f"for {entry['for']}, {100 * entry['tolerance']:g} %: {entry['quantity']}"
        lines.append(
            f"  {name:42.42s} {entry['beads']:6d} {entry['steps']:8d} {1e3 * entry['integrate_s']:6.2f} "
            f"{100 * entry['error']:6.2f}% {100 * entry['sure_error']:5.2f}%  "
            + ("-" if ratio is None else f"{ratio:.2f}")
        )
    lines.append("no convergence to the same answer")
    lines += [
        f"  {entry['family']}: {entry['variant']}, {', '.join(map(str, entry['beads']))} beads: {entry['status']}"
        for entry in result["not_converging"]
    ]
    return "\n".join(lines)
