"""The totals of a sweep: how well the published formula holds, with which factor, and how large the errors are.

They are summed up block by block; in memory there are eight bytes a row, its relative error, for the median.
"""

from __future__ import annotations

import random
from array import array
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from beadband.analysis.fits import Array, Measured
from beadband.observables import WAVES, Column
from beadband.studies.sweep.columns import typed
from beadband.studies.sweep.row import DONE, Row

SHOWN = 2000
"""Most rows in the pictures."""


@dataclass
class Line:
    """Sums of points for a straight line through zero."""

    count: int = 0
    xx: float = 0.0
    xy: float = 0.0
    yy: float = 0.0

    def add(self, x: Array, y: Array) -> Line:
        self.count += len(x)
        self.xx, self.xy, self.yy = self.xx + float(x @ x), self.xy + float(x @ y), self.yy + float(y @ y)
        return self

    @property
    def slope(self) -> Measured:
        """Slope of y = slope x by least squares, with twice its standard error."""
        slope = self.xy / self.xx
        residual = max(self.yy - slope * self.xy, 0.0)
        return Measured(slope, 2.0 * (residual / max(self.count - 1, 1) / self.xx) ** 0.5)


@dataclass
class Moments:
    """Mean and scatter of numbers that come in parts."""

    count: int = 0
    mean: float = 0.0
    squares: float = 0.0

    def add(self, values: Array) -> None:
        if len(values) == 0:
            return
        total, mean = self.count + len(values), float(values.mean())
        apart = mean - self.mean
        self.squares += float(((values - mean) ** 2).sum()) + apart**2 * self.count * len(values) / total
        self.mean += apart * len(values) / total
        self.count = total

    @property
    def spread(self) -> Measured | None:
        """The mean with its standard deviation; None below two numbers."""
        return None if self.count < 2 else Measured(self.mean, (self.squares / (self.count - 1)) ** 0.5)


@dataclass
class Factor:
    """V/C over the published formula, for one wave speed C."""

    alpha: Moments = field(default_factory=Moments)
    line: Line = field(default_factory=Line)


class Totals:
    """What is summed up over the rows of a table, and a sample of them for the pictures."""

    def __init__(self, columns: Sequence[Column]) -> None:
        self._columns = columns
        self._at = {column.name: place for place, column in enumerate(columns)}
        self.scenes = 0
        self.status: Counter[str] = Counter()
        self.models: Counter[str] = Counter()
        self.factors: dict[tuple[str | None, str], Factor] = {}
        """By law, None for all of them, and wave."""
        self._reasons: dict[str, list[Any]] = {}
        self._errors = array("d")
        self._bead_steps = 0
        self._above = 0
        self._seen = 0
        self._draws = random.Random(0)
        self._sample: list[tuple[int, list[str]]] = []

    def add(self, first: int, rows: list[list[str]]) -> None:
        """Take rows of the table, as texts; ``first`` is the place of the first of them."""
        at = self._at
        self.scenes += len(rows)
        self.status.update(row[at["status"]] for row in rows)
        for row in rows:
            if row[at["status"]] != DONE:
                count = self._reasons.setdefault(row[at["reason_code"]], [0, row[at["reason"]]])
                count[0] += 1
        for place, row in enumerate(rows, first):
            if row[at["status"]] == DONE:
                self._keep(place, row)
        done = [row for row in rows if row[at["status"]] == DONE]
        if not done:
            return
        self.models.update(row[at["model"]] for row in done)
        self._errors.extend(self._numbers(done, "rebound_speed_error_m_s") / self._numbers(done, "rebound_speed_m_s"))
        self._bead_steps += sum(int(row[at["bead_steps"]] or 0) for row in done)
        self._above += sum(row[at["within_tolerance"]] == "no" for row in done)
        published = self._numbers(done, "published_ratio")
        laws = np.array([row[at["law"]] for row in done]) if "law" in at else np.full(len(done), "")
        for wave in WAVES:
            alphas, ratios = self._numbers(done, f"alpha_{wave}"), self._numbers(done, f"ratio_{wave}")
            for law in (None, *(np.unique(laws).tolist() if "law" in at else ())):
                chosen = slice(None) if law is None else laws == law
                factor = self.factors.setdefault((law, wave), Factor())
                factor.alpha.add(alphas[chosen])
                factor.line.add(published[chosen], ratios[chosen])

    def _numbers(self, rows: list[list[str]], column: str) -> Array:
        return np.array([row[self._at[column]] or "nan" for row in rows]).astype(np.float64)

    def _keep(self, place: int, row: list[str]) -> None:
        """Keep each row with the same chance (reservoir sampling), from a seed: the pictures are the same again."""
        self._seen += 1
        if len(self._sample) < SHOWN:
            self._sample.append((place, row))
        elif (other := self._draws.randrange(self._seen)) < SHOWN:
            self._sample[other] = (place, row)

    def sample(self) -> list[Row]:
        """Finished rows in the order of the table: all of them, or :data:`SHOWN` drawn from them."""
        return [typed(self._columns, row) for _, row in sorted(self._sample)]

    def as_dict(self) -> dict[str, Any]:
        """Totals for sweep.json."""
        laws = sorted({law for law, _ in self.factors if law is not None})
        factors: dict[str, Any] = {law: {} for law in (laws or ["all"])}
        for (law, wave), one in self.factors.items():
            spread, fit = one.alpha.spread, one.line.slope
            if spread is None or (law is None and laws):
                continue
            factors[law or "all"][wave] = {
                "mean": spread.value,
                "standard_deviation": spread.error,
                "slope": fit.value,
                "slope_interval_95": [fit.value - fit.error, fit.value + fit.error],
            }
        errors = np.frombuffer(self._errors) if self._errors else np.zeros(0)
        return {
            "scenes": self.scenes,
            "status": dict(self.status),
            "models": dict(self.models),
            "without_result": {
                code: {"scenes": count, "first": first} for code, (count, first) in self._reasons.items()
            },
            "bead_steps": self._bead_steps,
            "relative_error": {"median": float(np.median(errors)), "largest": float(errors.max())}
            if len(errors)
            else None,
            "above_tolerance": self._above,
            "alpha": factors,
        }
