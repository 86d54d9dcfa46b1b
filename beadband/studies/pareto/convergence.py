"""Errors of the runs, error bounds over a method's finer runs, and whether a method converges to the common limit."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from statistics import median

from beadband.studies.pareto.methods import MAIN, Method
from beadband.studies.pareto.outcomes import DONE, OTHER_LIMIT, UNSETTLED, UNSTABLE, Outcome, noticed
from beadband.studies.pareto.reference import Reference, quantities, richardson_limit
from beadband.studies.pareto.runs import Answer, Cost

Errors = tuple[float, float, float]
_UNKNOWN: Errors = (math.nan, math.nan, math.nan)
_UNSTABLE_FROM = 0.1
"""Error of V from which a run beyond the step limit counts as unstable, though LAMMPS did not stop."""
_SIGNIFICANT = 5e-4
"""Error of the finest run from which a method is examined for another limit."""
_ENOUGH_FINER = 3
STALLED = 0.2
"""Change between the two finest runs, over their error, below which a method no longer converges to the reference: a
method of the first order whose runs are a factor of sqrt(2) apart changes by 0.41 of it."""


@dataclass(frozen=True)
class Row:
    """One run of the study; errors are relative, of V and of the curvature around 0.1 and 0.3 of the arrival."""

    family: str
    variant: str
    model: str
    beads: int
    steps: int
    bead_steps: int
    level: float
    step_share: float
    """Its (outer) step over the largest stable one of Verlet's method."""
    relax_s: float
    setup_s: float
    integrate_s: tuple[float, ...]
    """Each of the repeats."""
    whole_s: float
    """Relaxing, setting up and integrating together, the quickest repeat."""
    answer: Answer | None
    errors: Errors = _UNKNOWN
    """Against the limit of no spacing and no numerical loss."""
    error_bounds: Errors = _UNKNOWN
    """The largest error of this run and of all finer ones of its variant: an error that crosses zero is chance."""
    own: str = MAIN
    own_errors: Errors = _UNKNOWN
    """Against the limit that the method has by construction."""
    outcome: Outcome = DONE
    notes: dict[str, float] = field(default_factory=dict)

    @property
    def median_s(self) -> float:
        return median(self.integrate_s) if self.integrate_s else math.nan

    @property
    def least_s(self) -> float:
        """The quickest repeat: what ratios of costs are taken from, for other work on the machine only adds."""
        return min(self.integrate_s, default=math.nan)


def row_of(method: Method, costs: Sequence[Cost], answer: Answer | None, outcome: Outcome = DONE) -> Row:
    """The row of a method's repeats; ``answer`` is None where the outcome is a failure."""
    plan = method.plan
    return Row(
        family=method.family,
        variant=method.variant,
        model=method.model,
        beads=plan.beads,
        steps=plan.steps,
        bead_steps=method.bead_steps,
        level=method.level,
        step_share=plan.timestep_s / plan.largest_timestep_s,
        relax_s=median(cost.relax_s for cost in costs) if costs else math.nan,
        setup_s=median(cost.setup_s for cost in costs) if costs else math.nan,
        integrate_s=tuple(cost.integrate_s for cost in costs),
        whole_s=min((cost.relax_s + cost.setup_s + cost.integrate_s for cost in costs), default=math.nan),
        answer=answer,
        own=method.own,
        outcome=outcome,
        notes={"tolerance": method.level} if method.family == "plan" else {},
    )


def pairs(rows: Iterable[Row]) -> list[Row]:
    """Richardson pairs of the production runs with n and n/2 beads, at the cost of both."""
    production = {row.beads: row for row in rows if row.family == "beads" and row.answer is not None}
    found = []
    for beads, fine in production.items():
        coarse = production.get(beads // 2)
        if coarse is None or coarse.answer is None or fine.answer is None or beads % 2:
            continue
        old, new = quantities(coarse.answer), quantities(fine.answer)
        values = [richardson_limit(coarse.beads, old[i], beads, new[i], order) for i, order in enumerate((1, 2, 2))]
        found.append(
            replace(
                fine,
                family="pair",
                variant="Richardson pairs",
                bead_steps=fine.bead_steps + coarse.bead_steps,
                relax_s=fine.relax_s + coarse.relax_s,
                setup_s=fine.setup_s + coarse.setup_s,
                whole_s=fine.whole_s + coarse.whole_s,
                integrate_s=tuple(a + b for a, b in zip(fine.integrate_s, coarse.integrate_s, strict=True)),
                answer=Answer(values[0], (values[1], values[2])),
            )
        )
    return found


def with_errors(rows: Sequence[Row], references: Mapping[str, Reference]) -> list[Row]:
    """The rows with their errors, error bounds and outcomes, sorted by variant and level."""
    measured = [
        replace(row, errors=references[MAIN].errors(row.answer), own_errors=references[row.own].errors(row.answer))
        if row.answer is not None
        else row
        for row in rows
    ]
    production = [row for row in measured if row.family == "beads" and row.answer is not None]
    done = []
    for variant in _by_variant(measured).values():
        common = _convergence(variant, production, references)
        for row in variant:
            if row.answer is None:
                done.append(row)
                continue
            outcome = common
            if row.family == "step" and row.errors[0] > _UNSTABLE_FROM:
                outcome = noticed(UNSTABLE, "unstable-unnoticed", value=row.errors[0], limit=_UNSTABLE_FROM)
            done.append(replace(row, error_bounds=_bounds(row, variant, production), outcome=outcome))
    return done


def _bounds(row: Row, variant: Sequence[Row], production: Sequence[Row]) -> Errors:
    if row.family == "step" and row.level < 1.0:
        return math.inf, math.inf, math.inf  # beyond the largest stable step a run survives by chance
    finer = [other for other in variant if other.level >= row.level and other.answer is not None]
    if row.family in ("step", "plan") or (row.family not in ("beads", "pair") and len(finer) < _ENOUGH_FINER):
        # Too few finer runs of its own: the production runs with at least as many beads stand in for them.
        finer = [row] if row.family == "plan" else finer
        finer += [other for other in production if other.beads >= row.beads]
    first, second, third = (
        max(other.errors[i] if math.isfinite(other.errors[i]) else math.inf for other in finer) for i in range(3)
    )
    return first, second, third


def _by_variant(rows: Iterable[Row]) -> dict[tuple[str, str], list[Row]]:
    found: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        found.setdefault((row.family, row.variant), []).append(row)
    return {key: sorted(variant, key=lambda row: row.level) for key, variant in found.items()}


def _convergence(variant: Sequence[Row], production: Sequence[Row], references: Mapping[str, Reference]) -> Outcome:
    """Where the speed of a variant goes as it is refined, from its two finest runs.

    A variant that agrees with the production run of as many beads goes where that goes.
    """
    good = [row for row in variant if row.answer is not None]
    if len(good) < 2 or good[0].family in ("plan", "step"):
        return DONE
    if variant[-1].answer is None and variant[-2].answer is None and good[0].family != "integrator":
        # At a step that is stable for all others; for rRESPA it is the step that is varied.
        return noticed(UNSETTLED, "fails-when-refined", value=min(row.beads for row in variant if row.answer is None))
    before, last = good[-2], good[-1]
    assert before.answer is not None
    assert last.answer is not None
    main = references[MAIN]
    error = last.errors[0]
    if last.own != MAIN:
        gap = references[last.own].values[0] / main.values[0] - 1.0
        return noticed(OTHER_LIMIT, "other-limit-by-design", limit=last.own, gap=gap, value=last.own_errors[0])
    moved = abs(last.answer.speed_m_s - before.answer.speed_m_s) / main.values[0]
    same_beads = [row.answer.speed_m_s for row in production if row.beads == last.beads and row.answer is not None]
    apart = max((abs(last.answer.speed_m_s / speed - 1.0) for speed in same_beads), default=math.inf)
    if min(error, apart) <= max(3.0 * main.relative(0), _SIGNIFICANT):
        return DONE
    if moved < STALLED * error:
        return noticed(OTHER_LIMIT, "stalled-off-limit", change=moved, value=error)
    coarsest = good[0]
    if error > 0.5 * coarsest.errors[0]:
        values = {"value": error, "beads": last.beads, "coarse": coarsest.errors[0], "coarse_beads": coarsest.beads}
        return noticed(UNSETTLED, "not-improving", **values)
    return DONE
