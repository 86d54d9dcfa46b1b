"""Which input's range decides the answer: Sobol' indices of first and total order, with their confidence."""

from __future__ import annotations

import csv
import json
import math
import os
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from beadband.analysis.sobol import Indices, indices
from beadband.errors import UsageError, explain
from beadband.lammps.engine import Session
from beadband.notices import Notice, notice
from beadband.parameters import TABLE
from beadband.runs.folder import write_text
from beadband.studies.design.ranges import Box, Range, box_of, spans, varied
from beadband.studies.design.values import TOO_MANY_RUNS, Quantity, evaluate, quantity_of
from beadband.studies.samples import unit_points

POINTS = 4096
"""Points of each of the two samples, unless others are asked for."""
FEWEST_POINTS, MOST_POINTS = 64, 2**17
CONFIDENCE = 0.95
TOLERANCE = {"speed": 0.02, "curvature": 0.1}
"""Relative error of each value, unless another is asked for: the spread over ranges is many times larger."""
_NOISE = 0.1
"""Largest error of a value, over the standard deviation of the values, without a notice."""


@dataclass(frozen=True)
class Sensitivity:
    """Sobol' indices of a quantity over ranges of inputs."""

    quantity: Quantity
    box: Box
    indices: Indices
    """Of each range, in their order."""
    mean: float
    deviation: float
    """Standard deviation over the ranges, in the unit of the quantity."""
    interval_95: tuple[float, float]
    """Between which 95 % of the values lie."""
    error: float
    """Largest stated error of a value."""
    scenes: int
    runs: int
    """Scenes that took a run; the others were had by formula."""
    seconds: float
    seed: int

    @property
    def ranges(self) -> tuple[Range, ...]:
        """The inputs that vary."""
        return self.box.ranges

    @cached_property
    def notices(self) -> tuple[Notice, ...]:
        """What a reader should know."""
        share = self.error / self.deviation
        return (notice("indices-of-errors", value=share, limit=_NOISE),) if share > _NOISE else ()

    @property
    def warnings(self) -> list[str]:
        """The notices as sentences."""
        return [one.sentence for one in self.notices]

    def rows(self) -> list[dict[str, Any]]:
        """One row for each input: its range, its indices, and the ends of their intervals."""
        found, rows = self.indices, []
        for at, one in enumerate(self.ranges):
            row: dict[str, Any] = {"input": one.label or one.key, "unit": TABLE[one.key].unit, "range": str(one)}
            for name, value, interval in (
                ("first_order", found.first, found.first_interval),
                ("total_order", found.total, found.total_interval),
            ):
                low, high = interval[at].tolist()
                row |= {name: float(value[at]), f"{name}_low": low, f"{name}_high": high}
            rows.append(row)
        return rows

    def as_dict(self) -> dict[str, Any]:
        """The study as JSON has it; SI units."""
        names = ("mean", "deviation", "error", "scenes", "runs", "seed", "seconds")
        inputs = [{**row, **one.as_dict()} for row, one in zip(self.rows(), self.ranges, strict=True)]
        return {
            "quantity": self.quantity.name,
            "unit": self.quantity.unit,
            "inputs": inputs,
            "confidence": CONFIDENCE,
            "sum_first_order": float(self.indices.first.sum()),
            "interval_95": list(self.interval_95),
            **{name: getattr(self, name) for name in names},
            "scene": {key: value for key, value in self.box.values.items() if value is not None},
            "warnings": self.warnings,
        }

    def write(self, out: str | os.PathLike[str]) -> list[Path]:
        """Write sensitivity.csv and sensitivity.json into a folder that exists; return their paths."""
        folder, rows = Path(out), self.rows()
        with open(folder / "sensitivity.csv", "w", encoding="utf-8", newline="") as file:
            writer = csv.DictWriter(file, rows[0], lineterminator="\n")
            writer.writeheader()
            writer.writerows(rows)
        write_text(folder / "sensitivity.json", json.dumps(self.as_dict(), indent=1, allow_nan=False) + "\n")
        return [folder / "sensitivity.csv", folder / "sensitivity.json"]

    def __str__(self) -> str:
        shares = zip(self.ranges, self.indices.total, strict=True)
        return f"{self.quantity.sentence}: " + ", ".join(f"{one.option} {share:.2f}" for one, share in shares)


def sensitivity(
    values: Mapping[str, Any],
    *,
    vary: Mapping[str, Any] | None = None,
    spanned: Sequence[str] = (),
    quantity: str = "speed",
    points: int = POINTS,
    seed: int = 0,
    session: Session | None = None,
) -> Sensitivity:
    """Sobol' indices of a quantity over ranges of the inputs of the scene that ``values`` make.

    What varies is named by ``vary`` (:func:`beadband.studies.design.ranges.varied`), by bands whose numbers are
    ``spanned``, and by errors of the scene's inputs, which are normal. Inputs are independent. Two samples of
    ``points`` are one of Sobol' points in twice as many inputs; each of (inputs + 2) x ``points`` scenes is had by
    formula where that holds, else by runs. UsageError where a scene in the ranges has no answer, nothing varies, or too
    many scenes would be run.
    """
    start = time.perf_counter()
    asked = quantity_of(quantity)
    if not (isinstance(points, int) and FEWEST_POINTS <= points <= MOST_POINTS and points & (points - 1) == 0):
        allowed = f"a power of 2 from {FEWEST_POINTS} to {MOST_POINTS}"
        raise UsageError(explain("the number of points is out of range", points, allowed, "change --points"))
    own = varied(vary or {})
    given = {one.key for one in own}
    box = box_of(
        {**values, "tolerance": values.get("tolerance") or TOLERANCE.get(quantity)},
        [*own, *(one for one in (spans(spanned) if spanned else ()) if one.key not in given)],
    )
    inputs = len(box.ranges)
    samples = unit_points("sobol", points, 2 * inputs, seed)
    a, b = samples[:, :inputs], samples[:, inputs:]
    places = np.repeat(a[None], inputs + 2, axis=0)
    places[1] = b
    for at in range(inputs):
        places[2 + at, :, at] = b[:, at]
    try:
        found = evaluate(box.at(places.reshape(-1, inputs)), asked, session)
    except UsageError as refused:
        if refused.code == TOO_MANY_RUNS:
            raise
        raise UsageError(
            explain(
                "the ranges hold a scene without an answer",
                str(refused),
                "ranges throughout which the quantity exists",
                "narrow them",
            ),
            refused.code,
        ) from refused
    by_sample = found.value.reshape(inputs + 2, points)
    drawn = by_sample[:2].ravel()
    deviation = float(drawn.std())
    if not deviation > 1e-12 * abs(float(drawn.mean())):
        names = ", ".join(one.option for one in box.ranges)
        raise UsageError(
            explain(f"{asked.sentence} does not depend on what varies", names, "inputs that change it", "add others")
        )
    low, high = np.percentile(drawn, [2.5, 97.5]).tolist()
    return Sensitivity(
        quantity=asked,
        box=box,
        indices=indices(by_sample[0], by_sample[1], by_sample[2:], CONFIDENCE, seed=seed),
        mean=math.fsum(drawn) / len(drawn),
        deviation=deviation,
        interval_95=(low, high),
        error=float(found.error.max()),
        scenes=found.value.size,
        runs=found.runs,
        seconds=time.perf_counter() - start,
        seed=seed,
    )
