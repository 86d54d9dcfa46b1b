"""The frontier: runs that no other beats in both cost and error, and the plan's cost against it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any

from beadband.studies.pareto.convergence import Row
from beadband.studies.pareto.outcomes import OK
from beadband.studies.pareto.reference import QUANTITIES, Reference

Point = tuple[float, float]
"""Cost and error."""


def non_dominated(points: Sequence[Point]) -> list[int]:
    """Indices of the non-dominated points by rising cost: no other costs as little or less with a smaller error.

    Of equal points the first stays; points that are not finite, or not positive in cost, are left out.
    """
    usable = [i for i, (cost, error) in enumerate(points) if 0.0 < cost < math.inf and 0.0 <= error < math.inf]
    best, found = math.inf, []
    for i in sorted(usable, key=lambda i: (*points[i], i)):
        if points[i][1] < best:
            best = points[i][1]
            found.append(i)
    return found


def frontier(rows: Sequence[Row], index: int, floor: float = 0.0) -> list[Row]:
    """The non-dominated rows for the quantity ``index`` of QUANTITIES, without the plans.

    By the error bounds, not below ``floor``, the uncertainty of the reference; of methods that converge, for the
    others pass the answer only by chance.
    """
    candidates = reliable(rows)
    chosen = non_dominated([(row.median_s, max(row.error_bounds[index], floor)) for row in candidates])
    return [candidates[i] for i in chosen]


def reliable(rows: Iterable[Row]) -> list[Row]:
    """Runs of methods that converge to the common limit, without the plans."""
    return [row for row in rows if row.family != "plan" and row.outcome.code == OK and row.answer is not None]


def cheapest(rows: Iterable[Row], index: int, error: float, floor: float = 0.0) -> Row | None:
    """The row with the quickest repeat that has an error bound of at most ``error``."""
    within = [row for row in rows if max(row.error_bounds[index], floor) <= max(error, floor)]
    return min(within, key=lambda row: row.least_s) if within else None


def as_dict(rows: Sequence[Row], reference: Reference) -> dict[str, Any]:
    """The frontier of each quantity, and the cost of the plans over it."""
    result: dict[str, Any] = {"reference": reference.as_dict(), "frontier": {}, "plan": []}
    for index, name in enumerate(QUANTITIES):
        if not math.isfinite(reference.values[index]):
            continue
        floor = reference.relative(index)
        front = frontier(rows, index, floor)
        result["frontier"][name] = [
            {**_entry(row), "error": row.errors[index], "sure_error": max(row.error_bounds[index], floor)}
            for row in front
        ]
        for row in rows:
            if row.family == "plan" and row.answer is not None:
                result["plan"].append(_against(row, reliable(rows), index, name, floor))
    return result


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
    at_error = cheapest(others, index, row.error_bounds[index], floor)
    at_tolerance = cheapest(others, index, tolerance, floor)
    production = cheapest([other for other in others if other.family == "beads"], index, row.error_bounds[index], floor)
    return {
        "quantity": name,
        "for": row.variant.split()[0],
        "tolerance": tolerance,
        **_entry(row),
        "error": row.errors[index],
        "sure_error": max(row.error_bounds[index], floor),
        "cost_over_frontier_at_its_error": row.least_s / at_error.least_s if at_error else None,
        "cost_over_production_at_its_error": row.least_s / production.least_s if production else None,
        "cost_over_frontier_at_tolerance": row.least_s / at_tolerance.least_s if at_tolerance else None,
        "bead_steps_over_frontier_at_its_error": row.bead_steps / at_error.bead_steps if at_error else None,
    }
