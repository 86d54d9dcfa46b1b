"""The best band for a goal: inputs in their ranges for which a quantity is largest, or least, under conditions."""

from __future__ import annotations

import itertools
import math
import time
from collections.abc import Mapping
from contextlib import nullcontext
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from beadband.analysis.fits import Measured
from beadband.errors import UsageError, explain
from beadband.lammps.engine import Session, kept_session
from beadband.model.figures import THROWS, figures_of_scene
from beadband.model.scene import Scene, scene_of
from beadband.model.validity import check_validity
from beadband.notices import Notice, notice
from beadband.parameters import TABLE, refuse_errors
from beadband.planning.plan import plan_of
from beadband.runs.ask import Answer, ask
from beadband.runs.rear_run import rear_run
from beadband.studies.design.ranges import Box, Range, box_of, varied
from beadband.studies.design.search import LEAST_ROOM, MET, Kept, Search, kept_of
from beadband.studies.design.values import Array, Quantity, measured, quantity_of

_LOOSE = 0.02
"""Tolerance of the search for a speed; the optimum is asked for to that of the scene."""
_AT_BOUND = 1e-4
"""Distance from an end of a range, over the range, below which the optimum lies on it."""
_NO_EFFECT = 1e-9
"""Slopes below which an input changes nothing."""


@dataclass(frozen=True)
class Design:
    """The best scene for a goal."""

    goal: Quantity
    least: bool
    """Whether the goal was made small instead of large."""
    scene: Scene
    ranges: tuple[Range, ...]
    values: Mapping[str, Any]
    """What the inputs that vary have there, by their keys."""
    slopes: Mapping[str, float]
    """d ln goal/d ln of each number that varies."""
    kept: tuple[Kept, ...]
    value: float
    error: float
    """Bound of the numerical error of the value; 0 for a closed form."""
    confirmed: Measured | None
    """The same by a run of its own, with its error; None where a closed form needs none."""
    evaluations: int
    runs: int
    seconds: float
    found: tuple[Notice, ...] = field(default=())

    @property
    def unit(self) -> str:
        """Of the value."""
        return self.goal.unit

    @cached_property
    def figures(self) -> dict[str, float | None]:
        """All closed forms of the held band."""
        return figures_of_scene(self.scene)

    @property
    def notices(self) -> tuple[Notice, ...]:
        """What a reader should know."""
        return self.found

    @property
    def warnings(self) -> list[str]:
        """The notices as sentences."""
        return [one.sentence for one in self.notices]

    @property
    def options(self) -> str:
        """The inputs that vary as options of the command line."""
        return " ".join(f"{TABLE[key].flag} {_text(value)}" for key, value in self.values.items())

    def as_dict(self) -> dict[str, Any]:
        """The design as JSON has it; SI units."""
        return {
            "goal": self.goal.name,
            "least": self.least,
            "value": self.value,
            "error": self.error,
            "unit": self.goal.unit,
            "run": None if self.confirmed is None else {"value": self.confirmed.value, "error": self.confirmed.error},
            "inputs": [
                {
                    "input": one.key,
                    "value": self.values[one.key],
                    "range": one.as_dict(),
                    "slope": self.slopes.get(one.key),
                    "bound": _bound(one, self.values[one.key]),
                }
                for one in self.ranges
            ],
            "kept": [str(one) for one in self.kept],
            "options": self.options,
            "figures": self.figures,
            "scene": self.scene.as_dict(),
            "evaluations": self.evaluations,
            "runs": self.runs,
            "seconds": self.seconds,
            "warnings": self.warnings,
        }

    def __str__(self) -> str:
        return f"{self.goal.name} {Measured(self.value, self.error)} {self.unit} with {self.options}"


def _text(value: Any) -> str:
    return value if isinstance(value, str) else f"{value:.6g}"


def _bound(one: Range, value: Any) -> str | None:
    """The end of its range that a value lies on, "lower" or "upper"."""
    if one.words:
        return None
    place = _place(one, value)
    return "lower" if place < _AT_BOUND else "upper" if place > 1.0 - _AT_BOUND else None


def _place(one: Range, value: float) -> float:
    """Where in its range a number lies, from 0 to 1; sizes by their logarithms."""
    if one.low > 0.0:
        return math.log(value / one.low) / math.log(one.high / one.low)
    return (value - one.low) / (one.high - one.low)


def design(
    values: Mapping[str, Any],
    goal: str,
    vary: Mapping[str, Any],
    keep: Mapping[str, Any] | None = None,
    *,
    least: bool = False,
    session: Session | None = None,
) -> Design:
    """The inputs in the ranges ``vary`` for which a goal is largest, or ``least``, under the conditions ``keep``.

    The ranges are looked over at Sobol' points and their corners; from the best places quadratic programs search on, by
    formula where that holds and by runs where not. What was found is asked for to the tolerance of the scene, and for
    V, the curvature and a throw run once more by itself. UsageError where the conditions can't be met, or no scene in
    the ranges has an answer.
    """
    start = time.perf_counter()
    asked, sign = quantity_of(goal, "--goal"), -1.0 if least else 1.0
    kept = tuple(kept_of(keep or {}))
    refuse_errors("design", values)
    ranges = varied(vary)
    for one in ranges:
        if one.error is not None:
            raise UsageError(explain(f"{one.option} is given an error", str(one), "a range LOW:HIGH", "change --vary"))
    if not any(not one.words for one in ranges):
        raise UsageError(explain("nothing varies", "no range", "--vary NAME=LOW:HIGH", "add one"))
    tolerance = values.get("tolerance")
    loose = tolerance if isinstance(tolerance, str) else max(_LOOSE, tolerance or 0.0)
    box = box_of({**values, "tolerance": loose}, ranges)
    words = [one for one in box.ranges if one.words]
    best: tuple[float, Search, Array] | None = None
    searches, seen = [], []
    with kept_session() if session is None else nullcontext(session) as own:
        for choice in itertools.product(*(one.words for one in words)):
            chosen = {one.key: word for one, word in zip(words, choice, strict=True)}
            brought = box.by_band.get(chosen.get("band", ""), {})
            search = Search(Box({**box.values, **chosen, **brought}, box.ranges), asked, sign, kept, own)
            searches.append(search)
            places, looked = search.starts()
            seen.append(looked)
            # A search may end without an answer: the places from which it started count too.
            for place in (*places, *(search.best_from(one) for one in places)):
                found = search.at(place[None])
                if not np.isfinite(found).all() or search.missed(found)[0] > MET:
                    continue
                if best is None or sign * found[0, 1] > best[0]:
                    best = sign * float(found[0, 1]), search, place
        if best is None:
            raise _unmet(kept, np.concatenate(seen), searches)
        _, search, place = best
        inputs = {key: float(one[0]) for key, one in search.inputs(place[None]).items()}
        inputs |= {one.key: search.box.values[one.key] for one in words}
        exact = {} if tolerance is None else {"tolerance": tolerance}
        scene = scene_of(
            {**{key: one for key, one in search.box.values.items() if key != "tolerance"}, **inputs, **exact}
        )
        check_validity(scene)
        slopes = search.derivatives(place)
        answer = ask(scene, asked.name, own) if asked.asked else None
        value = answer.value if answer is not None else math.exp(float(search.at(place[None])[0, 1]))
        confirmed = _run(scene, asked, answer, own)
    error = answer.error if answer is not None else 0.0
    notices = [] if answer is None else list(answer.notices)
    unit = f" {asked.unit}" if asked.unit else ""
    if answer is None and confirmed is not None:
        error = abs(confirmed.value - value) + confirmed.error
        share = confirmed.value / value - 1.0
        notices.append(notice("throw-without-bending", value=confirmed.value, share=share, unit=unit))
    elif confirmed is not None and abs(confirmed.value - value) > confirmed.error + error:
        notices.append(notice("design-not-confirmed", value=value, limit=confirmed.value, unit=unit))
    near = float(search.at(place[None])[0, 0])
    if near < 2.0 * LEAST_ROOM:
        notices.append(notice("design-at-edge", value=near))
    for at, one in enumerate(search.numbers):
        end = _bound(one, inputs[one.key])
        if np.abs(slopes[1:, at]).max() < _NO_EFFECT:
            notices.append(notice("design-indifferent", name=one.option))
        elif end is not None:
            notices.append(notice("design-on-bound", name=one.option, value=end, limit=str(one)))
    scales = [math.log(one.high / one.low) if one.low > 0.0 else math.nan for one in search.numbers]
    return Design(
        goal=asked,
        least=least,
        scene=scene,
        ranges=box.ranges,
        values={one.key: inputs[one.key] for one in box.ranges},
        slopes={
            one.key: float(slope / scale)
            for one, slope, scale in zip(search.numbers, slopes[1], scales, strict=True)
            if math.isfinite(scale)
        },
        kept=kept,
        value=value,
        error=error,
        confirmed=confirmed,
        evaluations=sum(one.evaluations for one in searches),
        runs=sum(one.runs for one in searches),
        seconds=time.perf_counter() - start,
        found=tuple(notices),
    )


def _run(scene: Scene, goal: Quantity, answer: Answer | None, session: Session) -> Measured | None:
    """The goal by a run, not by the formula; None for a closed form of the held band."""
    if goal.key in THROWS:
        from beadband.runs import dispatch
        from beadband.runs.launch_results import Launch

        launch = dispatch.run(scene_of({**scene.as_dict(), "until": "launch"}))
        assert isinstance(launch, Launch)
        names = dict(zip(THROWS, ("momentum_n_s", "centre_of_mass_speed_m_s", "efficiency"), strict=True))
        thrown = launch.figures[names[goal.key]]
        return thrown if isinstance(thrown, Measured) else None
    if not goal.asked:
        return None
    if answer is not None and answer.model != "formula":
        return Measured(answer.value, answer.error)
    return measured(rear_run(plan_of(scene_of({**scene.as_dict(), "for": goal.name}), "leg"), session), goal)


def _unmet(kept: tuple[Kept, ...], seen: Array, searches: list[Search]) -> UsageError:
    """Why there is no design: no scene with an answer, or conditions that can't be met."""
    answered = seen[np.isfinite(seen).all(axis=1)]
    if len(answered) == 0:
        refused = next((one.refused for one in searches if one.refused is not None), None)
        return UsageError(
            explain("no scene in the ranges has an answer", str(refused), "ranges that hold some", "change --vary")
        )
    reached = []
    for at, one in enumerate(kept, start=2):
        low, high = np.exp(answered[:, at].min()), np.exp(answered[:, at].max())
        reached.append(f"{one.quantity.name} from {low:.3g} to {high:.3g} {one.quantity.unit}".rstrip())
    return UsageError(
        explain(
            "the conditions can't be met together in these ranges",
            ", ".join(str(one) for one in kept),
            f"each by itself about: {', '.join(reached)}",
            "change --keep or widen --vary",
        ),
        "unreachable",
    )
