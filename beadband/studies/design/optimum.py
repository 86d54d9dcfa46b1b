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
from beadband.errors import BeadbandError, UsageError, explain
from beadband.lammps.engine import Session, kept_session
from beadband.model.figures import THROWS, figures_of_scene
from beadband.model.formula import VARIED, room, shares_law
from beadband.model.scene import Scene, scene_of
from beadband.model.validity import check_validity
from beadband.notices import Notice, notice
from beadband.parameters import TABLE
from beadband.planning.plan import plan_of
from beadband.runs.ask import Answer, ask
from beadband.runs.rear_run import rear_run
from beadband.studies.design.ranges import Box, Range, box_of, varied
from beadband.studies.design.values import Array, Quantity, evaluate, quantity_of
from beadband.studies.samples import unit_points

_LOOK = 256
"""Points at which the ranges are looked over."""
_STARTS, _APART = 6, 0.15
"""Most places from which a search starts, and their least distance in the box of side 1."""
_STEP, _RUN_STEP = 1e-4, 0.05
"""Steps of derivatives in that box: of closed forms, and of runs, whose values scatter."""
_MOST_STEPS, _MOST_RUN_STEPS, _RUN_STARTS = 60, 12, 2
"""Steps of a search by closed forms, and of one by runs, of which there are fewer."""
LOOSE = 0.02
"""Tolerance of the search for a speed; the optimum is asked for to that of the scene."""
_MET = 1e-5
"""Share by which a condition may be missed."""
_AT_BOUND = 1e-4
"""Distance from an end of a range, over the range, below which the optimum lies on it."""
_NO_ANSWER = 1e3
"""Logarithm that stands for a goal or a condition where there is no answer, on the bad side."""
_LEAST_ROOM = 1e-3
"""How near to scenes without an answer a design may come (:func:`beadband.model.formula.room`)."""
_NO_EFFECT = 1e-9
"""Slopes below which an input changes nothing."""
_SEED = 0


@dataclass(frozen=True)
class Kept:
    """A condition: a quantity between two values, or equal to one."""

    quantity: Quantity
    low: float = 0.0
    high: float = math.inf

    def missed(self, value: Any) -> Any:
        """By how much of itself a value lies outside, as a logarithm; 0 inside."""
        below = np.log(self.low / value) if self.low > 0.0 else -math.inf
        above = np.log(value / self.high) if math.isfinite(self.high) else -math.inf
        return np.maximum(np.maximum(below, above), 0.0)

    def __str__(self) -> str:
        unit = f" {self.quantity.unit}" if self.quantity.unit else ""
        if self.low == self.high:
            return f"{self.quantity.name} {self.low:g}{unit}"
        if math.isinf(self.high):
            return f"{self.quantity.name} at least {self.low:g}{unit}"
        if self.low == 0.0:
            return f"{self.quantity.name} at most {self.high:g}{unit}"
        return f"{self.quantity.name} from {self.low:g} to {self.high:g}{unit}"


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


def kept_of(given: Mapping[str, Any]) -> list[Kept]:
    """Conditions by the names of quantities: a value, "LOW:HIGH" with an end left open, or a pair with None for one.

    UsageError for what is none.
    """
    found = []
    for name, value in given.items():
        quantity = quantity_of(name.removeprefix("--"), "--keep")
        ends = value.split(":") if isinstance(value, str) else value if isinstance(value, (list, tuple)) else [value]
        try:
            numbers = [math.nan if end in ("", None) else float(end) for end in ends]
        except (TypeError, ValueError):
            numbers = []
        low, high = (numbers * 2)[:2] if len(numbers) in (1, 2) else (-1.0, -1.0)
        low, high = (0.0 if math.isnan(low) else low), (math.inf if math.isnan(high) else high)
        if not 0.0 <= low <= high or high == 0.0 or (low == 0.0 and math.isinf(high)) or math.isinf(low):
            allowed = "VALUE, LOW:HIGH, LOW: or :HIGH, above 0"
            raise UsageError(explain(f"{name} is given no condition", repr(value), allowed, "change --keep"))
        found.append(Kept(quantity, low, high))
    return found


class _Search:
    """A goal and its conditions over one box of numbers, each from 0 to 1."""

    def __init__(self, box: Box, goal: Quantity, sign: float, kept: tuple[Kept, ...], session: Session) -> None:
        self.box, self.goal, self.sign, self.kept, self.session = box, goal, sign, kept, session
        self.numbers = [one for one in box.ranges if not one.words]
        self.evaluations = self.runs = 0
        self.known: dict[bytes, Array] = {}
        self.refused: BeadbandError | None = None
        self.base: Scene | None = None
        self.ran: set[bytes] = set()
        """Places that took a run."""

    def inputs(self, places: Array) -> dict[str, Any]:
        """Values of what varies at places of shape (points, numbers)."""
        columns: dict[str, Any] = {}
        for at, one in enumerate(self.numbers):
            share = places[:, at]
            if one.low > 0.0:
                columns[one.key] = one.low * (one.high / one.low) ** share
            else:
                columns[one.key] = one.low + (one.high - one.low) * share
        return columns

    def at(self, places: Array) -> Array:
        """Room, and logarithms of the goal and of what is kept, shape (points, 2 + kept); NaN without an answer."""
        new = [row for row in places if row.tobytes() not in self.known]
        if new:
            rows = np.array(new)
            for row, found in zip(rows, self._values(rows), strict=True):
                self.known[row.tobytes()] = found
        return np.array([self.known[row.tobytes()] for row in places])

    def _values(self, places: Array) -> Array:
        """What :meth:`at` gives for places that are new; where some fail, half of them at a time."""
        columns = self.inputs(places)
        found = np.full((len(places), 2 + len(self.kept)), np.nan)
        found[:, 0] = self._room(columns, len(places))
        inside = found[:, 0] > 0.0
        if not inside.any():
            return found
        part = {key: one[inside] for key, one in columns.items()}
        try:
            for at, quantity in enumerate((self.goal, *(one.quantity for one in self.kept)), start=1):
                values = evaluate({**self.box.values, **part}, quantity, self.session)
                self.runs += values.runs
                self.ran |= {row.tobytes() for row in places[inside][values.by_run]}
                found[inside, at] = np.log(values.value)
        except BeadbandError as refused:
            if len(places) == 1:
                self.refused = refused
                found[:, 1:] = np.nan
                return found
            half = len(places) // 2
            return np.concatenate([self._values(places[:half]), self._values(places[half:])])
        self.evaluations += len(places)
        return found

    def _room(self, columns: Mapping[str, Array], size: int) -> Array:
        """How far scenes are from ones without an answer; 1 where that shows only when they are asked for."""
        if self.base is None:
            for at in range(size):
                try:
                    self.base = scene_of({**self.box.values, **{key: float(one[at]) for key, one in columns.items()}})
                    break
                except UsageError as refused:
                    self.refused = refused
        constants = self.base.material.values() if self.base is not None else {}
        own = {key: one for key, one in columns.items() if key in VARIED or key in constants}
        if self.base is None or not shares_law(self.base) or not own.keys() <= {*VARIED}:
            return np.ones(size)
        return room(self.base, own) if own else np.ones(size)

    def missed(self, values: Array) -> Array:
        """By how much the conditions are missed at most, shape (points,)."""
        found = np.zeros(len(values))
        for at, one in enumerate(self.kept):
            found = np.maximum(found, one.missed(np.exp(values[:, 2 + at])))
        return found

    def starts(self) -> tuple[Array, Array]:
        """Good places apart from each other, shape (starts, numbers), and all values that were seen."""
        places = unit_points("sobol", _LOOK, len(self.numbers), _SEED)
        corners = np.array(list(itertools.product((0.0, 1.0), repeat=min(len(self.numbers), 4))))
        places = np.concatenate([places, np.pad(corners, ((0, 0), (0, len(self.numbers) - corners.shape[1])))])
        values = self.at(places)
        merit = self.sign * values[:, 1] - 10.0 * self.missed(values)
        chosen: list[Array] = []
        for at in np.argsort(-merit):
            if not np.isfinite(merit[at]) or len(chosen) == (_RUN_STARTS if self.runs else _STARTS):
                break
            if all(np.linalg.norm(places[at] - one) >= _APART for one in chosen):
                chosen.append(places[at])
        return np.array(chosen), values

    def derivatives(self, place: Array) -> Array:
        """Derivatives of :meth:`at` by the places, shape (2 + kept, numbers).

        Central, but one-sided at the ends of ranges and towards scenes that have no answer; 0 where both sides have
        none.
        """
        middle = self.at(place[None])
        for step in (_STEP, _RUN_STEP):
            steps = step * np.eye(len(place))
            low, high = np.maximum(place - steps, 0.0), np.minimum(place + steps, 1.0)
            below, above = self.at(low), self.at(high)
            if self.ran.isdisjoint(one.tobytes() for one in (*low, *high, place)):
                break
        reach = [np.broadcast_to(np.diag(one)[:, None], below.shape) for one in (place - low, high - place)]
        span = np.where(np.isfinite(below), reach[0], 0.0) + np.where(np.isfinite(above), reach[1], 0.0)
        rise = np.where(np.isfinite(above), above, middle) - np.where(np.isfinite(below), below, middle)
        with np.errstate(invalid="ignore", divide="ignore"):
            found: Array = np.where(span > 0.0, rise / span, 0.0).T
        return np.nan_to_num(found)

    def best_from(self, start: Array) -> Array:
        """The best place that a search by quadratic programs (SLSQP) finds from a start."""
        from scipy.optimize import minimize

        def value(place: Array, column: int) -> float:
            found = float(self.at(np.clip(place, 0.0, 1.0)[None])[0, column])
            return found if math.isfinite(found) else -self.sign * _NO_ANSWER if column == 1 else _NO_ANSWER

        def slopes(place: Array, column: int) -> Array:
            found: Array = self.derivatives(np.clip(place, 0.0, 1.0))[column]
            return found

        def condition(column: int, sign: float, limit: float, kind: str) -> dict[str, Any]:
            return {
                "type": kind,
                "fun": lambda place: sign * (value(place, column) - math.log(limit)),
                "jac": lambda place: sign * slopes(place, column),
            }

        conditions: list[dict[str, Any]] = [
            {
                "type": "ineq",
                "fun": lambda place: value(place, 0) - _LEAST_ROOM,
                "jac": lambda place: slopes(place, 0),
            }
        ]
        for at, one in enumerate(self.kept, start=2):
            if one.low == one.high:
                conditions.append(condition(at, 1.0, one.low, "eq"))
                continue
            conditions += [condition(at, 1.0, one.low, "ineq")] if one.low > 0.0 else []
            conditions += [condition(at, -1.0, one.high, "ineq")] if math.isfinite(one.high) else []
        done = minimize(
            lambda place: -self.sign * value(place, 1),
            start,
            jac=lambda place: -self.sign * slopes(place, 1),
            method="SLSQP",
            bounds=[(0.0, 1.0)] * len(start),
            constraints=conditions,
            options={"maxiter": _MOST_RUN_STEPS if self.runs else _MOST_STEPS, "ftol": 1e-6 if self.runs else 1e-10},
        )
        place: Array = np.clip(done.x, 0.0, 1.0)
        return place


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
    ranges = varied(vary)
    for one in ranges:
        if one.error is not None:
            raise UsageError(explain(f"{one.option} is given an error", str(one), "a range LOW:HIGH", "change --vary"))
    if not any(not one.words for one in ranges):
        raise UsageError(explain("nothing varies", "no range", "--vary NAME=LOW:HIGH", "add one"))
    tolerance = values.get("tolerance")
    box = box_of({**values, "tolerance": max(LOOSE, tolerance) if isinstance(tolerance, float) else LOOSE}, ranges)
    words = [one for one in box.ranges if one.words]
    best: tuple[float, _Search, Array] | None = None
    searches, seen = [], []
    with kept_session() if session is None else nullcontext(session) as own:
        for choice in itertools.product(*(one.words for one in words)):
            chosen = {one.key: word for one, word in zip(words, choice, strict=True)}
            brought = box.by_band.get(chosen.get("band", ""), {})
            search = _Search(Box({**box.values, **chosen, **brought}, box.ranges), asked, sign, kept, own)
            searches.append(search)
            places, looked = search.starts()
            seen.append(looked)
            # A search may end without an answer: the places from which it started count too.
            for place in (*places, *(search.best_from(one) for one in places)):
                found = search.at(place[None])
                if not np.isfinite(found).all() or search.missed(found)[0] > _MET:
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
    if near < 2.0 * _LEAST_ROOM:
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
    found = rear_run(plan_of(scene_of({**scene.as_dict(), "for": goal.name}), "leg"), session)
    if goal.name == "speed":
        return found.speed
    return None if found.curvature is None else found.curvature.eq7_ratio


def _unmet(kept: tuple[Kept, ...], seen: Array, searches: list[_Search]) -> UsageError:
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
