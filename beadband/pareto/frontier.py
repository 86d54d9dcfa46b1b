"""The frontier: runs that no other beats in both cost and error, and where the plan stands against it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from beadband.pareto.judgement import OK, Row
from beadband.pareto.reference import QUANTITIES, Reference

Point = tuple[float, float]
"""Cost and error."""


def non_dominated(points: Sequence[Point]) -> list[int]:
    """Indices of the points that none beats, cheap to dear: no other costs as little or less with a smaller error.

    Of equal points the first stays; points that are no numbers, or not positive in cost, never do.
    """
    usable = [i for i, (cost, error) in enumerate(points) if 0.0 < cost < math.inf and 0.0 <= error < math.inf]
    best, found = math.inf, []
    for i in sorted(usable, key=lambda i: (*points[i], i)):
        if points[i][1] < best:
            best = points[i][1]
            found.append(i)
    return found


def frontier(rows: Sequence[Row], index: int, floor: float = 0.0) -> list[Row]:
    """The non-dominated rows for a quantity of :data:`~beadband.pareto.reference.QUANTITIES`, plans aside.

    By the errors that can be relied on, not below ``floor``, that of the reference; of methods that converge, for the
    others pass the answer only by chance.
    """
    candidates = reliable(rows)
    chosen = non_dominated([(row.median_s, max(row.sure_errors[index], floor)) for row in candidates])
    return [candidates[i] for i in chosen]


def reliable(rows: Iterable[Row]) -> list[Row]:
    """Runs of methods that converge to the same answer, plans aside."""
    return [row for row in rows if row.family != "plan" and row.status == OK and row.answer is not None]


def cheapest(rows: Iterable[Row], index: int, error: float, floor: float = 0.0) -> Row | None:
    """The row with the quickest repeat that keeps within an error."""
    within = [row for row in rows if max(row.sure_errors[index], floor) <= max(error, floor)]
    return min(within, key=lambda row: row.least_s) if within else None


def as_dict(rows: Sequence[Row], reference: Reference) -> dict[str, Any]:
    """The frontier of each quantity, and the plans beside it."""
    result: dict[str, Any] = {"reference": _reference(reference), "frontier": {}, "plan": []}
    for index, name in enumerate(QUANTITIES):
        if not math.isfinite(reference.values[index]):
            continue
        floor = reference.relative(index)
        front = frontier(rows, index, floor)
        result["frontier"][name] = [
            {**_entry(row), "error": row.errors[index], "sure_error": max(row.sure_errors[index], floor)}
            for row in front
        ]
        for row in rows:
            if row.family == "plan" and row.answer is not None:
                result["plan"].append(_against(row, reliable(rows), index, name, floor))
    return result


def _reference(reference: Reference) -> dict[str, Any]:
    return {
        "beads": list(reference.beads),
        **{
            name: {"value": reference.values[i], "uncertainty": reference.uncertainties[i]}
            for i, name in enumerate(QUANTITIES)
            if math.isfinite(reference.values[i])
        },
    }


def _entry(row: Row) -> dict[str, Any]:
    return {
        "family": row.family,
        "variant": row.variant,
        "beads": row.beads,
        "steps": row.steps,
        "bead_steps": row.bead_steps,
        "integrate_s": row.median_s,
        "integrate_min_s": row.least_s,
        "relax_s": row.relax_s,
    }


def _against(row: Row, others: Sequence[Row], index: int, name: str, floor: float) -> dict[str, Any]:
    """Cost of a plan over the cheapest of other runs, at its own error and at the tolerance that it was made for."""
    tolerance = row.notes["tolerance"]
    at_error = cheapest(others, index, row.sure_errors[index], floor)
    at_tolerance = cheapest(others, index, tolerance, floor)
    alike = cheapest([other for other in others if other.family == "beads"], index, row.sure_errors[index], floor)
    return {
        "quantity": name,
        "for": row.variant.split()[0],
        "tolerance": tolerance,
        **_entry(row),
        "error": row.errors[index],
        "sure_error": max(row.sure_errors[index], floor),
        "cost_over_frontier_at_its_error": row.least_s / at_error.least_s if at_error else None,
        "cost_over_production_at_its_error": row.least_s / alike.least_s if alike else None,
        "cost_over_frontier_at_tolerance": row.least_s / at_tolerance.least_s if at_tolerance else None,
        "bead_steps_over_frontier_at_its_error": row.bead_steps / at_error.bead_steps if at_error else None,
    }
