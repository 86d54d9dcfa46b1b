"""Which scenes a sweep is made of: a grid of options, or random draws from their ranges."""

from __future__ import annotations

import itertools
import os
import random
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from beadband.band import CATALOGUE, PROPERTIES
from beadband.errors import UsageError, explain
from beadband.scene import CHOICES, KEYS

WORDS = ("band", *(key for key in CHOICES if key != "until"))
"""Options that are words; a sweep is over releases."""
NUMBERS = ("strain", "half_angle_deg", "tolerance", "bending_scale", "timestep_s", "loss_time_s", *PROPERTIES)
COUNTS = ("beads",)
SWEPT = tuple(key for key in KEYS if key in (*WORDS, *NUMBERS, *COUNTS))
MOST_SCENES = 10_000_000

Values = dict[str, Any]


@dataclass(frozen=True)
class Axis:
    """The values of one option: those listed, or for a random sweep anything between two numbers."""

    key: str
    values: tuple[Any, ...]
    between: tuple[float, float] | None = None


@dataclass(frozen=True)
class Grid:
    """All scenes of a sweep, in order."""

    axes: tuple[Axis, ...]
    count: int | None = None
    """Number of random draws; None for the whole grid."""
    seed: int = 0

    def __len__(self) -> int:
        total = 1
        for axis in self.axes:
            total *= len(axis.values)
        return total if self.count is None else self.count

    def scenes(self) -> list[Values]:
        """Values of every scene; the last axis runs fastest."""
        if self.count is None:
            keys = [axis.key for axis in self.axes]
            return [
                dict(zip(keys, point, strict=True)) for point in itertools.product(*(axis.values for axis in self.axes))
            ]
        draws = random.Random(self.seed)
        return [{axis.key: _draw(axis, draws) for axis in self.axes} for _ in range(self.count)]

    def as_dict(self) -> dict[str, Any]:
        """The grid as JSON takes it."""
        return {
            "axes": {axis.key: list(axis.between or axis.values) for axis in self.axes},
            "random": self.count,
            "seed": self.seed if self.count is not None else None,
        }


def _draw(axis: Axis, draws: random.Random) -> Any:
    if axis.between is None:
        return draws.choice(axis.values)
    return draws.uniform(*axis.between)


def grid_of(values: Mapping[str, Any], count: int | None = None, seed: int = 0) -> Grid:
    """Build a grid from an option's values each: a value, a list, or text as in "0.1:1.4:14" and "I,II,III".

    Options that are not named keep their defaults. With ``count`` so many scenes are drawn, ranges evenly between
    their ends and lists by choice. UsageError for what is no option, no number, or too much.
    """
    axes = []
    for key, given in values.items():
        if key not in SWEPT:
            raise UsageError(explain("this can't be swept", repr(key), ", ".join(SWEPT), "correct its name"))
        axes.append(_axis(key, given, count is not None))
    for key, default in (("for", "speed"), ("band", "III")):
        if key not in values:
            axes.insert(0, Axis(key, (default,)))
    axes.sort(key=lambda axis: SWEPT.index(axis.key))
    if count is not None and not 1 <= count <= MOST_SCENES:
        raise UsageError(explain("the number of scenes is out of range", count, f"1 to {MOST_SCENES}", "mend --random"))
    grid = Grid(tuple(axes), count, seed)
    if len(grid) > MOST_SCENES:
        raise UsageError(
            explain("the grid is too large", f"{len(grid)} scenes", f"at most {MOST_SCENES}", "thin it out")
        )
    return grid


def read_grid(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Values of a TOML grid, option by option; UsageError when it can't be read."""
    try:
        return dict(tomllib.loads(Path(path).read_text(encoding="utf-8")))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise UsageError(
            explain("the grid can't be read", f"{str(path)!r} ({reason})", "TOML, one 'key = values' a line", "mend it")
        ) from error


def _axis(key: str, given: Any, random_draws: bool) -> Axis:
    parts: Sequence[Any] = given if isinstance(given, (list, tuple)) else [given]
    if len(parts) == 1 and isinstance(parts[0], str):
        if key not in WORDS and ":" in parts[0]:
            return _range(key, parts[0], random_draws)
        parts = [part.strip() for part in parts[0].split(",") if part.strip()]
    values = tuple(dict.fromkeys(_value(key, part) for part in parts))
    if not values:
        raise UsageError(explain(f"no value for {key}", repr(given), "one value or more", "mend it"))
    return Axis(key, values)


def _range(key: str, text: str, random_draws: bool) -> Axis:
    """FIRST:LAST:COUNT, both ends included; the count may be left out of a random sweep."""
    pieces = text.split(":")
    wrong = UsageError(
        explain(f"{key} is no range", repr(text), "FIRST:LAST:COUNT (COUNT may be left out with --random)", "mend it")
    )
    if len(pieces) not in ((2, 3) if random_draws else (3,)):
        raise wrong
    low, high = (_value(key, piece) for piece in pieces[:2])
    if random_draws and key not in COUNTS:
        return Axis(key, (low, high), (low, high))
    try:
        count = int(pieces[2])
    except (ValueError, IndexError):
        raise wrong from None
    if not 1 <= count <= MOST_SCENES:
        raise wrong
    step = (high - low) / (count - 1) if count > 1 else 0.0
    # Twelve digits: what a person would have written, and the same on every machine.
    points = [float(f"{low + step * i:.12g}") for i in range(count)]
    if key in COUNTS:
        return Axis(key, tuple(dict.fromkeys(round(point) for point in points)))
    return Axis(key, tuple(dict.fromkeys(points)))


def _value(key: str, part: Any) -> Any:
    if key in WORDS:
        text = str(part)
        allowed = tuple(CATALOGUE) if key == "band" else CHOICES[key]
        if text not in allowed:
            raise UsageError(explain(f"unknown {key}", repr(part), ", ".join(allowed), "mend it"))
        return text
    try:
        if isinstance(part, bool):
            raise ValueError
        return int(part) if key in COUNTS else float(part)
    except (TypeError, ValueError):
        kind = "a whole number" if key in COUNTS else "a number"
        raise UsageError(explain(f"{key} is not a number", repr(part), kind, "mend it")) from None
