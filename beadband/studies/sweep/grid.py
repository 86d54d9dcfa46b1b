"""Which scenes a sweep is made of: a grid of options, or samples of their ranges."""

from __future__ import annotations

import itertools
import os
import random
import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from beadband import parameters
from beadband.errors import UsageError, explain
from beadband.model.bands import known_values
from beadband.parameters import TABLE
from beadband.studies.samples import check_sample

MOST_SCENES = 10_000_000
_PART = 4096
"""Draws that are made together."""

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
    """Number of draws; None for the whole grid."""
    seed: int = 0
    sample: str = "random"
    """How they are drawn: one of :data:`beadband.studies.samples.SAMPLES`."""

    def __len__(self) -> int:
        total = 1
        for axis in self.axes:
            total *= len(axis.values)
        return total if self.count is None else self.count

    def scenes(self) -> Iterator[Values]:
        """Values of every scene, one after another; the last axis runs fastest. Each call begins anew."""
        if self.count is None:
            keys = [axis.key for axis in self.axes]
            for point in itertools.product(*(axis.values for axis in self.axes)):
                yield dict(zip(keys, point, strict=True))
            return
        if self.sample != "random":
            yield from self._filling()
            return
        draws = random.Random(self.seed)
        for _ in range(self.count):
            yield {axis.key: _draw(axis, draws) for axis in self.axes}

    def some(self, number: int) -> list[Values]:
        """So many scenes that stand for all: spread evenly over the grid, or the first draws."""
        if self.count is not None:
            return list(itertools.islice(self.scenes(), number))
        return (
            [self._point(at * len(self) // number) for at in range(number)] if len(self) > number else [*self.scenes()]
        )

    def _point(self, place: int) -> Values:
        """The scene at a place of the whole grid."""
        found = []
        for axis in reversed(self.axes):
            place, at = divmod(place, len(axis.values))
            found.append((axis.key, axis.values[at]))
        return dict(reversed(found))

    def _filling(self) -> Iterator[Values]:
        """Draws that fill the ranges evenly; in memory there is a number a draw and option."""
        from beadband.studies.samples import unit_points

        open_axes = [axis for axis in self.axes if len(axis.values) > 1]
        points = unit_points(self.sample, self.count or 0, len(open_axes), self.seed)
        alone = {axis.key: axis.values[0] for axis in self.axes}
        for first in range(0, len(points), _PART):
            part = points[first : first + _PART]
            columns = [_placed(axis, part[:, at]) for at, axis in enumerate(open_axes)]
            for row in zip(*columns, strict=True) if columns else [()] * len(part):
                yield {**alone, **{axis.key: value for axis, value in zip(open_axes, row, strict=True)}}

    def as_dict(self) -> dict[str, Any]:
        """The grid as JSON takes it."""
        return {
            "axes": {axis.key: list(axis.between or axis.values) for axis in self.axes},
            "random": self.count,
            "sample": self.sample if self.count is not None else None,
            "seed": self.seed if self.count is not None else None,
        }


def _draw(axis: Axis, draws: random.Random) -> Any:
    if axis.between is None:
        return draws.choice(axis.values)
    return draws.uniform(*axis.between)


def _placed(axis: Axis, places: Any) -> list[Any]:
    """Values of an option at places in it from 0 to 1, shape (draws,)."""
    if axis.between is None:
        return [axis.values[int(place * len(axis.values))] for place in places]
    low, high = axis.between
    found: list[Any] = (low + (high - low) * places).tolist()
    return found


def grid_of(
    values: Mapping[str, Any], count: int | None = None, seed: int | None = None, sample: str | None = None
) -> Grid:
    """Build a grid from an option's values each: a value, a list, or text as in "0.1:1.4:14" and "I,II,III".

    Options that are not named keep their defaults. With ``count`` so many scenes are drawn, ranges evenly between
    their ends and lists by choice: as ``sample`` says, by default at random. UsageError for an option or value that a
    sweep does not take, or too many scenes.
    """
    axes = []
    values = parameters.by_key(values)
    parameters.refuse_unused("sweep", values)
    parameters.refuse_errors("sweep", values)
    order = list(TABLE)
    for key, given in values.items():
        axes.append(_axis(key, given, count is not None))
    if "band_file" not in values:
        for name in next((axis.values for axis in axes if axis.key == "band"), ()):
            known_values(name)
    for key, default in (("for", "speed"), ("band", "III")):
        if key not in values:
            axes.insert(0, Axis(key, (default,)))
    axes.sort(key=lambda axis: order.index(axis.key))
    if count is not None and not 1 <= count <= MOST_SCENES:
        allowed = f"1 to {MOST_SCENES}"
        raise UsageError(explain("the number of scenes is out of range", count, allowed, "change --random"))
    for flag, given in (("--seed", seed), ("--sample", sample)):
        if given is not None and count is None:
            wrong = f"{flag} is not used without --random: the grid has no draws"
            raise UsageError(
                explain(wrong, f"{flag} {given}", f"{flag} with --random", "leave it out"), parameters.UNUSED
            )
    check_sample(sample or "random")
    grid = Grid(tuple(axes), count, seed or 0, sample or "random")
    if len(grid) > MOST_SCENES:
        raise UsageError(
            explain("the grid is too large", f"{len(grid)} scenes", f"at most {MOST_SCENES}", "give fewer values")
        )
    return grid


def read_grid(path: str | os.PathLike[str]) -> dict[str, Any]:
    """Values of a TOML grid, option by option; UsageError when it can't be read."""
    try:
        return dict(tomllib.loads(Path(path).read_text(encoding="utf-8")))
    except (OSError, UnicodeDecodeError, tomllib.TOMLDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        allowed = "TOML, one 'key = values' a line"
        raise UsageError(
            explain("the grid can't be read", f"{str(path)!r} ({reason})", allowed, "change the file")
        ) from error


def _axis(key: str, given: Any, random_draws: bool) -> Axis:
    parts: Sequence[Any] = given if isinstance(given, (list, tuple)) else [given]
    if len(parts) == 1 and isinstance(parts[0], str):
        if not _is_word(key) and ":" in parts[0]:
            return _range(key, parts[0], random_draws)
        parts = [part.strip() for part in parts[0].split(",") if part.strip()]
    values = tuple(dict.fromkeys(_value(key, part) for part in parts))
    if not values:
        raise UsageError(explain(f"no value for {key}", repr(given), "one value or more", "change it"))
    return Axis(key, values)


def _range(key: str, text: str, random_draws: bool) -> Axis:
    """FIRST:LAST:COUNT, both ends included; the count may be left out of a random sweep."""
    pieces = text.split(":")
    wrong = UsageError(
        explain(f"{key} is not a range", repr(text), "FIRST:LAST:COUNT (with --random also FIRST:LAST)", "change it")
    )
    if len(pieces) not in ((2, 3) if random_draws else (3,)):
        raise wrong
    low, high = (_value(key, piece) for piece in pieces[:2])
    if random_draws and TABLE[key].kind != "count":
        return Axis(key, (low, high), (low, high))
    try:
        given = float(pieces[2])
    except (ValueError, IndexError):
        raise wrong from None
    if not (given.is_integer() and 1 <= given <= MOST_SCENES):
        raise wrong
    count = int(given)
    step = (high - low) / (count - 1) if count > 1 else 0.0
    # Twelve digits, as a person would write the values; they are the same on every machine.
    points = [float(f"{low + step * i:.12g}") for i in range(count)]
    if TABLE[key].kind == "count":
        return Axis(key, tuple(dict.fromkeys(round(point) for point in points)))
    return Axis(key, tuple(dict.fromkeys(points)))


def _is_word(key: str) -> bool:
    return TABLE[key].kind in ("word", "name", "path")


def _value(key: str, part: Any) -> Any:
    return parameters.parsed(key, part) if isinstance(part, str) else parameters.checked(key, part)
