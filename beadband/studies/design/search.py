"""The search for the best place in a box of inputs: conditions, and quadratic programs from several starts."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from beadband.errors import BeadbandError, UsageError, explain
from beadband.lammps.engine import Session
from beadband.model.formula import VARIED, room, shares_law
from beadband.model.scene import Scene, scene_of
from beadband.studies.design.ranges import Box
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
MET = 1e-5
"""Share by which a condition may be missed."""
_NO_ANSWER = 1e3
"""Logarithm that stands for a goal or a condition where there is no answer, on the bad side."""
LEAST_ROOM = 1e-3
"""How near to scenes without an answer a design may come (:func:`beadband.model.formula.room`)."""
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


class Search:
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
                "fun": lambda place: value(place, 0) - LEAST_ROOM,
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
