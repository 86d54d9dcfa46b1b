"""One number of a release with its error, at the least cost: by formula where that will do, by runs where not."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any

import numpy as np

from beadband.errors import BeadbandError, RunError, UsageError, explain
from beadband.lammps.engine import Session, kept_session
from beadband.model.formula import formula
from beadband.model.scene import Scene
from beadband.model.uncertainty import changed, estimated_error, with_auto_tolerance
from beadband.model.validity import validity_notices
from beadband.notices import Notice, distinct_digits, notice
from beadband.parameters import PLANNED, TABLE
from beadband.planning.ladder import FORMULA_COVERS, MOST_BEADS, MOST_SECONDS, Question, next_step
from beadband.planning.plan import Plan
from beadband.runs.input_errors import budget_of
from beadband.runs.measurement import Measurement
from beadband.runs.rear_run import follow_rear

_MOST_FAILURES = 6
"""Levels whose run may fail before the question is given up."""
QUANTITIES = ("speed", "curvature")
UNITS = {"speed": "m/s", "curvature": "1"}
"""V; and the tip curvature over that of Eq. 7, mean over its window."""


@dataclass(frozen=True)
class Answer:
    """A number with its error, and what it took."""

    value: float
    error: float
    """Bound that holds 98 % of the true errors, in the unit of the value."""
    unit: str
    model: str
    """"formula", "leg" or "ring"."""
    runs: int
    beads: int
    """Of the finest run, counted on the whole ring; 0 without one."""
    seconds: float
    input_error: float | None = None
    """Error from those of the inputs; None where none was given."""
    found: tuple[Notice, ...] = ()
    """What the ladder has to say."""
    about: Callable[[], tuple[Notice, ...]] | None = field(default=None, repr=False, compare=False)
    """What there is to say of the scene, made when it is asked for."""

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """Everything that a reader of the number should know."""
        return (*(self.about() if self.about is not None else ()), *self.found)

    @property
    def warnings(self) -> list[str]:
        """The notices as sentences."""
        return [one.sentence for one in self.notices]

    @property
    def within_tolerance(self) -> bool:
        """Whether the error is at most what was asked for."""
        return all(one.code != "ladder-ends" for one in self.found)

    def as_dict(self) -> dict[str, Any]:
        """The answer as JSON has it; SI units."""
        names = ("value", "error", "unit", "model", "runs", "beads", "seconds", "input_error", "within_tolerance")
        return {**{name: getattr(self, name) for name in names}, "warnings": self.warnings}

    def __str__(self) -> str:
        from beadband.analysis.fits import Measured

        return f"{Measured(self.value, self.error)} {self.unit}".removesuffix(" 1")


def ask(
    scene: Scene, quantity: str = "speed", session: Session | None = None, most_seconds: float = MOST_SECONDS
) -> Answer:
    """One number of a release to the tolerance of the scene, at the least expected cost.

    The formula comes first: its bar says whether it will do. Then levels of beads, from the cheapest that is expected
    to state the tolerance on, until one does. Where none does the best is given with a notice ``ladder-ends``. The runs
    share the ``session``; no file is kept, and no level is predicted to take more than ``most_seconds``. UsageError
    for a scene that is no release, or has no such number.
    """
    start = time.perf_counter()
    if scene.auto_tolerance:
        scene = with_auto_tolerance(scene)
    question = replace(question_of(scene, quantity), most_seconds=most_seconds)
    value, error = (float(one) for one in formula(question.scene, quantity))
    if error <= scene.tolerance * abs(value):
        found = answer_by_formula(question.scene, quantity, value, error, {}, start)
    else:
        with kept_session() if session is None else nullcontext(session) as own:
            found = _climbed(question, (value, error) if math.isfinite(error) else None, own)
    inputs = _input_error(scene, quantity, found.value, session) if scene.errors or scene.covariance else None
    return replace(found, input_error=inputs, seconds=time.perf_counter() - start)


def answer_by_formula(
    scene: Scene, quantity: str, value: float, error: float, varied: Mapping[str, float], start: float
) -> Answer:
    """The answer that needs no run, for a scene or a copy of it with some inputs varied."""
    about = partial(_about, scene, dict(varied))
    return Answer(value, error, UNITS[quantity], "formula", 0, 0, time.perf_counter() - start, about=about)


def _about(scene: Scene, varied: Mapping[str, float]) -> tuple[Notice, ...]:
    return validity_notices(changed(scene, varied) if varied else scene)


def question_of(scene: Scene, quantity: str) -> Question:
    """What is asked, without what a plan chose for the scene; UsageError where it can't be answered."""
    if quantity not in QUANTITIES:
        raise UsageError(explain("unknown quantity", repr(quantity), ", ".join(QUANTITIES), "change --quantity"))
    if scene.until != "release":
        raise UsageError(
            explain("a launch is not asked for one number", f"--until {scene.until}", "a release", "use 'beadband run'")
        )
    for key in PLANNED:
        if getattr(scene, key) is not None and key not in scene.planned:
            flag = TABLE[key].flag
            raise UsageError(
                explain(
                    f"{flag} is not used by 'beadband ask'",
                    getattr(scene, key),
                    "a choice of its own",
                    f"leave {flag} out",
                )
            )
    window = scene.scales.window
    if quantity == "curvature" and window.reason is not None:
        raise UsageError(
            explain("the tip curvature has no answer", window.reason, "a self-similar window", "ask for the speed")
        )
    bare = replace(scene.unplanned(), errors=(), covariance=(), samples=0, auto_tolerance=False, input_share=None)
    return Question(bare, quantity, scene.tolerance)


def _climbed(question: Question, known: tuple[float, float] | None, session: Session) -> Answer:
    """Run levels until the stated error is within the tolerance, or the ladder ends."""
    prior = None if known is None else (known[0], known[1] / FORMULA_COVERS)
    relative = None if prior is None else prior[1] / abs(prior[0])
    levels: dict[int, float] = {}
    tried: list[int] = []
    failure: BeadbandError | None = None
    plan: Plan | None = None
    notices: tuple[Notice, ...] = ()
    best: tuple[float, float] | None = None
    while True:
        step = next_step(question, tuple(tried), relative)
        if step is None or len(tried) - len(levels) > _MOST_FAILURES:
            break
        for level in step.levels:
            tried.append(level)
            try:
                plan = question.plan(level)
                levels[level] = _value(question, plan, follow_rear(plan, session))
            except BeadbandError as refused:
                # Too few beads for the finger, or for an equilibrium: finer ones may do.
                failure = refused
        if not levels:
            continue
        ranked = sorted(levels, reverse=True)
        beads = np.array([question.beads(one) for one in ranked], dtype=np.float64)
        limit = question.limit(beads, np.array([levels[one] for one in ranked]), prior)
        best = limit.value, question.stated(limit)
        if best[1] <= question.tolerance * abs(best[0]):
            break
    if best is None or plan is None:
        allowed = f"at most {MOST_BEADS} beads and {question.most_seconds:g} s for a level"
        raise failure or RunError(
            explain("no level can be run", f"{question.beads(0)} beads", allowed, "change the scene")
        )
    value, error = best
    about = partial(_about, question.scene, {})
    if error > question.tolerance * abs(value):
        relative_error = error / abs(value)
        digits = distinct_digits(relative_error, question.tolerance)
        notices = (
            notice(
                "ladder-ends", value=relative_error, limit=question.tolerance, digits=digits, beads=max(beads.tolist())
            ),
        )
    return Answer(
        value, error, UNITS[question.quantity], plan.model, len(levels), int(beads[0]), 0.0, found=notices, about=about
    )


def _value(question: Question, plan: Plan, found: Measurement) -> float:
    if question.quantity == "speed":
        return found.fitted_speed_m_s.value
    if found.decay is None:
        raise UsageError(
            explain(
                "the tip curvature has no answer", str(found.no_decay), "a self-similar window", "ask for the speed"
            )
        )
    return found.decay.eq7_ratio.value


def _input_error(scene: Scene, quantity: str, value: float, session: Session | None) -> float | None:
    purpose = replace(scene, purpose=quantity)
    if scene.is_strip:
        # The formula is exact, and so are its derivatives.
        relative = estimated_error(scene)
        return None if relative is None else relative * value
    budget = budget_of(purpose, value, session)
    if budget is None:
        return None
    if quantity == "speed":
        return budget.speed_error_m_s
    return (
        None
        if budget.eq7_ratio_error is None or not math.isfinite(budget.eq7_ratio_error)
        else budget.eq7_ratio_error * value
    )
