"""The findings of the study as values: a topic, a code, and the numbers; findings_text.py makes sentences of them."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from statistics import median
from typing import Any

from beadband.studies.pareto.convergence import Row
from beadband.studies.pareto.cores import WAYS, Timing, pays_from, speedups
from beadband.studies.pareto.frontier import cheapest, reliable
from beadband.studies.pareto.reference import QUANTITIES, Reference

SPEED_ERRORS, CURVATURE_ERRORS = (0.02, 0.005, 0.001), (0.05, 0.01)
_PREFERRED = 1.3
"""Cost over that of the cheapest method up to which the production method is named instead."""
_SIMILAR_ERROR, _SMALL_ERROR = 1.5, 1e-3
"""Error over that of production, or error, up to which rRESPA counts as equally accurate."""
TOPICS = ("speed", "curvature", "plan", "variants", "cores", "peers")


@dataclass(frozen=True)
class Finding:
    """One finding: ``code`` is a key of findings_text.SENTENCES, ``values`` hold its numbers."""

    topic: str
    code: str
    values: dict[str, Any]


def findings(
    rows: Sequence[Row], reference: Reference, times: Sequence[Timing], plan: Sequence[dict[str, Any]], load: float
) -> list[dict[str, Any]]:
    """Every finding as it stands in frontier.json.

    ``plan`` are the plan's entries of frontier.json, ``load`` the load average of other work.
    """
    found = [
        *_speed(rows, reference),
        *_curvature(rows, reference),
        *_plan(plan),
        *_variants(rows),
        *_cores(times, load),
    ]
    return [asdict(one) for one in found]


def _levels(rows: Sequence[Row], reference: Reference, index: int, errors: Sequence[float]) -> list[dict[str, Any]]:
    """The cheapest run within each error, production where it costs nearly as little."""
    floor, candidates = reference.relative(index), reliable(rows)
    levels = []
    for error in errors:
        best = cheapest(candidates, index, error, floor)
        usual = cheapest([row for row in candidates if row.family == "beads"], index, error, floor)
        if best is not None and usual is not None and usual.least_s < _PREFERRED * best.least_s:
            best = usual
        level: dict[str, Any] = {"error": error}
        if best is not None:
            level.update(seconds=best.least_s, beads=best.beads, family=best.family, variant=best.variant)
            level["step_share"] = best.step_share
        levels.append(level)
    return levels


def _production(rows: Iterable[Row]) -> dict[int, Row]:
    return {row.beads: row for row in rows if row.family == "beads" and row.answer}


def _beside(rows: Sequence[Row], chosen: Iterable[Row]) -> list[tuple[Row, Row]]:
    """The chosen runs that gave an answer, each with the production run of as many beads."""
    production = _production(rows)
    return [(row, production[row.beads]) for row in chosen if row.answer and row.beads in production]


def _span(values: Iterable[float]) -> list[float]:
    found = list(values)
    return [min(found), max(found)]


def _speed(rows: Sequence[Row], reference: Reference) -> list[Finding]:
    found = [Finding("speed", "cost-of-speed", {"levels": _levels(rows, reference, 0, SPEED_ERRORS)})]
    both = _beside(rows, (row for row in rows if row.model == "ring files"))
    if both:
        values = {
            "cost": _span(ring.least_s / leg.least_s for ring, leg in both),
            "error": median(ring.errors[0] / leg.errors[0] for ring, leg in both),
        }
        found.append(Finding("speed", "whole-ring", values))
    return found


def _curvature(rows: Sequence[Row], reference: Reference) -> list[Finding]:
    known = [index for index in (1, 2) if math.isfinite(reference.values[index])]
    if not known:
        return [Finding("curvature", "curvature-unknown", {})]
    levels = {QUANTITIES[index]: _levels(rows, reference, index, CURVATURE_ERRORS) for index in known}
    found = [Finding("curvature", "cost-of-curvature", {"levels": levels})]
    error = CURVATURE_ERRORS[-1]
    (speed,) = _levels(rows, reference, 0, (error,))
    ratios = [one[-1]["beads"] / speed["beads"] for one in levels.values() if "beads" in one[-1] and "beads" in speed]
    if ratios:
        found.append(Finding("curvature", "curvature-beads", {"error": error, "ratio": _span(ratios)}))
    return found


def _plan(plan: Sequence[dict[str, Any]]) -> list[Finding]:
    own = [entry for entry in plan if (entry["quantity"] == "speed") == (entry["for"] == "speed")]
    speeds = [entry for entry in plan if entry["quantity"] == "speed"]
    if not speeds:
        return []
    curved = [entry["error"] / entry["tolerance"] for entry in own if entry["quantity"] != "speed"]
    kept = {
        "kept": sum(entry["error"] <= entry["tolerance"] for entry in speeds),
        "plans": len(speeds),
        "curvature": _span(curved) if curved else None,
    }
    costs: dict[str, Any] = {}
    for name, key in (("own", "production"), ("any", "frontier")):
        ratios = [entry[f"cost_over_{key}_at_its_error"] for entry in own]
        known = [ratio for ratio in ratios if ratio is not None]
        costs[name] = _span(known) if known else None
    seconds: dict[str, dict[str, float]] = {}
    for entry in speeds:
        seconds.setdefault(entry["for"], {})[f"{entry['tolerance']:g}"] = entry["relax_s"] + entry["integrate_min_s"]
    return [
        Finding("plan", "plan-keeps", kept),
        Finding("plan", "plan-costs", costs),
        Finding("plan", "plan-seconds", seconds),
    ]


def _variants(rows: Sequence[Row]) -> list[Finding]:
    found = []
    for code, chosen in (
        ("table-points", [row for row in rows if row.family == "bond" and row.variant.endswith(" points")]),
        ("angle-form", [row for row in rows if row.family == "angle" and row.variant != "rod"]),
    ):
        both = _beside(rows, chosen)
        if both:
            finest = max(row.beads for row, _ in both)
            changes = [_change(row, usual) for row, usual in both if row.beads == finest]
            cost = median(row.least_s / usual.least_s for row, usual in both)
            found.append(Finding("variants", code, {"change": max(changes), "beads": finest, "cost": cost}))
    both = _beside(rows, (row for row in rows if row.variant == "lepton"))
    if both:
        cost_range = _span(row.least_s / usual.least_s for row, usual in both)
        found.append(Finding("variants", "expression", {"cost": cost_range}))
    respa = [row for row in rows if row.family == "integrator"]
    if respa:
        found += _respa(respa, _beside(rows, respa))
    return found


def _change(row: Row, usual: Row) -> float:
    assert row.answer is not None
    assert usual.answer is not None
    return abs(row.answer.speed_m_s / usual.answer.speed_m_s - 1.0)


def _respa(runs: Sequence[Row], both: Sequence[tuple[Row, Row]]) -> list[Finding]:
    alike = [
        (usual.least_s / row.least_s, row)
        for row, usual in both
        if row.errors[0] <= max(_SIMILAR_ERROR * usual.errors[0], _SMALL_ERROR)
    ]
    gain: dict[str, Any] = {"gain": None}
    if alike:
        best, row = max(alike, key=lambda one: one[0])
        gain = {"gain": best, "variant": row.variant, "beads": row.beads}
    failed = [row for row in runs if row.answer is None]
    failures = {
        "runs": len(runs),
        "failed": dict(Counter(row.outcome.code for row in failed)),
        "from_step_share": min((row.step_share for row in failed), default=None),
    }
    return [Finding("variants", "respa-gain", gain), Finding("variants", "respa-failures", failures)]


def _cores(times: Sequence[Timing], load: float) -> list[Finding]:
    alone = [t for t in times if t.way == WAYS[0] and t.seconds]
    if alone:
        ends = [alone[0], alone[-1]]
        values = {"beads": [t.beads for t in ends], "ns": [t.least_ns for t in ends]}
        found = [Finding("cores", "bead-step", values)]
    else:
        found = [Finding("cores", "not-timed", {"way": WAYS[0], "failed": _failures(times, WAYS[0])})]
    return found + [second_core(times, way, load) for way in WAYS[1:]]


def _failures(times: Iterable[Timing], way: str) -> dict[str, int]:
    return dict(Counter(t.outcome.code for t in times if t.way == way and not t.seconds))


def second_core(times: Sequence[Timing], way: str, load: float = 0.0) -> Finding:
    """What two ranks or two threads are worth against one core."""
    gains = speedups(times, way)
    if not gains:
        return Finding("cores", "not-timed", {"way": way, "failed": _failures(times, way)})
    most = max(gains, key=lambda beads: gains[beads])
    return Finding(
        "cores",
        "second-core",
        {
            "way": way,
            "from": pays_from(times, way),
            "beads": _span(gains),
            "gain": gains[most],
            "gain_beads": most,
            "load": load,
        },
    )
