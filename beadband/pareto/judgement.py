"""What became of each run: its errors, those that it can be relied on for, and whether its method converges."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from statistics import median

from beadband.pareto.methods import MAIN, Method
from beadband.pareto.reference import Reference, carried_on, quantities
from beadband.pareto.runs import Answer, Cost

OK, BLEW_UP, ELSEWHERE, UNSETTLED = "ok", "blew up", "converges to something else", "does not converge"
Errors = tuple[float, float, float]
_NOTHING: Errors = (math.nan, math.nan, math.nan)
_BLOWN = 0.1
"""A speed farther off than this, at a step beyond the limit, is that of a blow-up that LAMMPS did not notice."""


@dataclass(frozen=True)
class Row:
    """One run of the diagram; errors are relative, of V and of the curvature around 0.1 and 0.3 of the arrival."""

    family: str
    variant: str
    model: str
    beads: int
    steps: int
    bead_steps: int
    level: float
    relax_s: float
    setup_s: float
    integrate_s: tuple[float, ...]
    """Each of the repeats."""
    answer: Answer | None
    errors: Errors = _NOTHING
    """Against the limit of no spacing and no numerical loss."""
    sure_errors: Errors = _NOTHING
    """The largest of this run's and of all finer ones of its variant: an error that crosses zero is luck."""
    own: str = MAIN
    own_errors: Errors = _NOTHING
    """Against the limit that the method has by construction."""
    status: str = OK
    reason: str = ""
    notes: dict[str, float] = field(default_factory=dict)

    @property
    def median_s(self) -> float:
        return median(self.integrate_s) if self.integrate_s else math.nan

    @property
    def least_s(self) -> float:
        """The quickest repeat: what ratios of costs are taken from, for other work on the machine only adds."""
        return min(self.integrate_s, default=math.nan)


def row_of(method: Method, costs: Sequence[Cost], answer: Answer | None, reason: str = "") -> Row:
    """The row of a method's repeats; without an answer it blew up, for the reason given."""
    plan = method.plan
    return Row(
        family=method.family,
        variant=method.variant,
        model=method.model,
        beads=plan.beads,
        steps=plan.steps,
        bead_steps=method.bead_steps,
        level=method.level,
        relax_s=median(cost.relax_s for cost in costs) if costs else math.nan,
        setup_s=median(cost.setup_s for cost in costs) if costs else math.nan,
        integrate_s=tuple(cost.integrate_s for cost in costs),
        answer=answer,
        own=method.own,
        status=OK if answer else BLEW_UP,
        reason=reason,
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
        values = [carried_on(coarse.beads, old[i], beads, new[i], order) for i, order in enumerate((1, 2, 2))]
        found.append(
            replace(
                fine,
                family="pair",
                variant="Richardson pairs",
                bead_steps=fine.bead_steps + coarse.bead_steps,
                relax_s=fine.relax_s + coarse.relax_s,
                setup_s=fine.setup_s + coarse.setup_s,
                integrate_s=tuple(a + b for a, b in zip(fine.integrate_s, coarse.integrate_s, strict=True)),
                answer=Answer(values[0], (values[1], values[2])),
            )
        )
    return found


def judged(rows: Sequence[Row], references: Mapping[str, Reference]) -> list[Row]:
    """The rows with their errors and their status."""
    measured = [_measured(row, references) for row in rows]
    production = [row for row in measured if row.family == "beads"]
    done = []
    for variant in _by_variant(measured).values():
        verdict = _verdict(variant, production, references)
        for row in variant:
            if row.answer is None:
                done.append(row)
                continue
            finer = [other for other in variant if other.level >= row.level and other.answer is not None]
            if row.family in ("step", "plan") or (row.family not in ("beads", "pair") and len(finer) < _ENOUGH_FINER):
                # No ladder of bead counts, or its end: what a count is good for the production runs tell then.
                finer = [row] if row.family == "plan" else finer
                finer += [other for other in production if other.beads >= row.beads and other.answer is not None]
            sure = [max(_number(other.errors[i]) for other in finer) for i in range(3)]
            if row.family == "step" and row.level < 1.0:
                sure = [math.inf] * 3  # beyond the largest stable step: what survives does so by chance
            status, reason = verdict
            if row.family == "step" and row.errors[0] > _BLOWN:
                status, reason = BLEW_UP, f"V is off by {row.errors[0]:.0%}: beyond the largest stable step"
            done.append(replace(row, sure_errors=(sure[0], sure[1], sure[2]), status=status, reason=reason))
    return done


def _number(error: float) -> float:
    return error if math.isfinite(error) else math.inf


def _measured(row: Row, references: Mapping[str, Reference]) -> Row:
    if row.answer is None:
        return row
    own = references[row.own].errors(row.answer)
    return replace(row, errors=references[MAIN].errors(row.answer), own_errors=own)


def _by_variant(rows: Iterable[Row]) -> dict[tuple[str, str], list[Row]]:
    found: dict[tuple[str, str], list[Row]] = {}
    for row in rows:
        found.setdefault((row.family, row.variant), []).append(row)
    return {key: sorted(variant, key=lambda row: row.level) for key, variant in found.items()}


def _verdict(variant: Sequence[Row], production: Sequence[Row], references: Mapping[str, Reference]) -> tuple[str, str]:
    """Where the speed of a variant goes as it is refined, told from its two finest runs.

    A variant that agrees with the production run of as many beads goes where that goes.
    """
    good = [row for row in variant if row.answer is not None]
    if len(good) < 2 or good[0].family in ("plan", "step"):
        return OK, ""
    if variant[-1].answer is None and variant[-2].answer is None and good[0].family != "integrator":
        # At a step that is stable for all others; a step of rRESPA is what is on trial there.
        first = next(row.beads for row in variant if row.answer is None)
        return UNSETTLED, f"blows up from {first} beads on"
    before, last = good[-2], good[-1]
    assert before.answer is not None
    assert last.answer is not None
    main = references[MAIN]
    error = last.errors[0]
    moved = abs(last.answer.speed_m_s - before.answer.speed_m_s) / main.values[0]
    twins = [row.answer.speed_m_s for row in production if row.beads == last.beads and row.answer is not None]
    apart = max((abs(last.answer.speed_m_s / speed - 1.0) for speed in twins), default=math.inf)
    far = min(error, apart) > max(3.0 * main.relative(0), _FAR)
    if last.own != MAIN:
        gap = references[last.own].values[0] / main.values[0] - 1.0
        return (
            ELSEWHERE,
            f"by construction: {last.own}, V {gap:+.3%}; against that {last.own_errors[0]:.3%} at its finest",
        )
    if far and moved < _STANDING * error:
        return ELSEWHERE, f"its two finest runs differ by {moved:.3%}, and stay {error:.3%} off"
    if far and error > 0.5 * good[0].errors[0]:
        return UNSETTLED, f"still {error:.3%} off with {last.beads} beads, {good[0].errors[0]:.3%} with {good[0].beads}"
    return OK, ""


_FAR = 5e-4
"""Deviation of the finest run that is worth a verdict."""
_ENOUGH_FINER = 3
_STANDING = 0.2
"""Change between the two finest runs, over their error, below which a method stands still: one of the first order whose
runs are a factor of sqrt(2) apart changes by 0.41 of it."""
