"""A tensile test as a CSV file: stretch and nominal stress as arrays, or one line that says why not."""

from __future__ import annotations

import csv
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
from numpy.typing import NDArray

from beadband.errors import UsageError, explain

Array = NDArray[np.float64]

FEWEST_POINTS = 5
"""Different stretches above 1 that a curve needs."""
LARGEST_STRETCH = 12.0
LARGEST_STRESS_PA = 1e10
BACKWARDS = 0.01
"""Share of the strain range by which the strain may fall from point to point: the noise of its measurement."""
AT_REST, OFFSET = 0.005, 0.1
"""Share of the strain range that counts as rest, and share of the largest stress that the stress may have there."""
_UNITS = {"nominal_stress_pa": 1.0, "nominal_stress_kpa": 1e3, "nominal_stress_mpa": 1e6}
_COLUMNS = "a header with stretch or strain, and nominal_stress_pa, _kpa or _mpa"


@dataclass(frozen=True)
class TensileTest:
    """Points of a test, sorted by stretch, each stretch once."""

    source: str
    """Name of the file."""
    stretch: Array
    """Shape (points,)."""
    stress_pa: Array
    """Nominal stress, shape (points,)."""
    repeats: Array
    """Measurements of which each point is the mean, shape (points,)."""


def read_test(path: str | os.PathLike[str], unloading: bool = False) -> TensileTest:
    """Read a tensile test; with ``unloading`` its stretch may fall instead of rising.

    Columns other than stretch or strain and the nominal stress are ignored, as are lines with #. Measurements at one
    stretch are averaged. UsageError, naming file and line, for what is no such test.
    """
    return _File(path).test(unloading)


class _File:
    """One file while it is read."""

    def __init__(self, path: str | os.PathLike[str]) -> None:
        self.name = os.fspath(path)

    def refuse(self, wrong: str, given: object, allowed: str, advice: str) -> NoReturn:
        """UsageError about this file."""
        raise UsageError(explain(f"tensile test {self.name!r}: {wrong}", given, allowed, advice), code="tensile-test")

    def test(self, unloading: bool) -> TensileTest:
        lines, numbers = self._lines()
        separator = next((sign for sign in "\t;," if sign in lines[0]), ",")
        header = [cell.strip().lower() for cell in _cells(lines[0], separator)]
        columns, to_stretch, to_pa = self._columns(header, numbers[0])
        values = self._values(lines[1:], numbers[1:], separator, columns, len(header))
        stretch, stress = values[:, 0] + to_stretch, values[:, 1] * to_pa
        self._check(stretch, stress, numbers[1:], values)
        self._check_order(stretch, numbers[1:], unloading)
        order = np.argsort(stretch, kind="stable")
        each, first, repeats = np.unique(stretch[order], return_index=True, return_counts=True)
        mean = np.add.reduceat(stress[order], first) / repeats
        if np.count_nonzero(each > 1.0) < FEWEST_POINTS:
            self.refuse(
                "too few points in tension",
                f"{np.count_nonzero(each > 1.0)} different stretches above 1",
                f"at least {FEWEST_POINTS}",
                "measure more points",
            )
        return TensileTest(self.name, each, mean, repeats.astype(np.float64))

    def _lines(self) -> tuple[list[str], list[int]]:
        """Lines that are neither empty nor comments, and their numbers from 1 on."""
        try:
            raw = Path(self.name).read_bytes()
        except (OSError, ValueError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            self.refuse("can't be read", reason, "a CSV file", "check --tensile, or file in [law]")
        if b"\0" in raw:
            self.refuse("is no text", "a binary file, or one in UTF-16", "UTF-8 text", "export it as CSV in UTF-8")
        text = raw.decode("utf-8-sig", errors="replace").replace("\r\n", "\n").replace("\r", "\n")
        lines, numbers = [], []
        for number, line in enumerate(text.split("\n"), 1):
            if line and not line.isspace() and line.lstrip()[0] != "#":
                lines.append(line)
                numbers.append(number)
        if not lines:
            self.refuse("is empty", "no line but comments", _COLUMNS, "check the file")
        return lines, numbers

    def _columns(self, header: list[str], line: int) -> tuple[tuple[int, int], float, float]:
        """Places of strain and stress, what makes a stretch of the one, and Pa of the other."""
        if all(_is_number(cell) for cell in header):
            self.refuse(f"has no header (line {line})", ", ".join(header)[:60], _COLUMNS, "add the header")
        for name in (*_UNITS, "stretch", "strain"):
            if header.count(name) > 1:
                self.refuse(f"has two columns of one name (line {line})", name, "each once", "remove one")
        along = [name for name in ("stretch", "strain") if name in header]
        stresses = [name for name in _UNITS if name in header]
        shown = ", ".join(header)[:80]
        if not stresses and any("stress" in name for name in header):
            self.refuse(
                f"the unit of the nominal stress is missing (line {line})",
                shown,
                "nominal_stress_pa, _kpa or _mpa (force over the undeformed section)",
                "rename the column",
            )
        if not along or not stresses:
            missing = "stretch or strain" if not along else "nominal stress"
            self.refuse(f"has no column of {missing} (line {line})", shown, _COLUMNS, "rename the columns")
        if len(along) > 1 or len(stresses) > 1:
            self.refuse(
                f"has more than one column of the same quantity (line {line})",
                shown,
                "stretch or strain, and one nominal stress",
                "remove one",
            )
        places = header.index(along[0]), header.index(stresses[0])
        return places, 0.0 if along[0] == "stretch" else 1.0, _UNITS[stresses[0]]

    def _values(
        self, lines: list[str], numbers: list[int], separator: str, columns: tuple[int, int], count: int
    ) -> Array:
        """The two columns, shape (points, 2)."""
        if not lines:
            self.refuse("has no points", "a header alone", "a line for each point", "check the file")
        if separator != ",":
            # Where commas don't separate the columns, they are decimal.
            lines = [line.replace(",", ".") for line in lines]
        try:
            # loadtxt does not see a line with more cells than the header, as decimal commas make them.
            if sum(line.count(separator) for line in lines) == len(lines) * (count - 1):
                return np.loadtxt(lines, delimiter=separator, usecols=columns, quotechar='"', ndmin=2)
        except ValueError:
            pass
        return np.array([self._row(line, n, separator, columns, count) for line, n in zip(lines, numbers, strict=True)])

    def _row(self, line: str, number: int, separator: str, columns: tuple[int, int], count: int) -> list[float]:
        """Two numbers of a line, read with patience so that what is wrong can be named."""
        cells = _cells(line.split("#")[0], separator)
        if len(cells) > count and any(cell.strip() for cell in cells[count:]):
            advice = "write decimal points, or separate the columns by semicolons" if separator == "," else "correct it"
            self.refuse(f"line {number} has more columns than the header", f"{line.strip()[:60]!r}", f"{count}", advice)
        found = []
        for place in columns:
            cell = cells[place].strip() if place < len(cells) else ""
            if not _is_number(cell):
                self.refuse(f"line {number} has no number", repr(cell[:40]), "a decimal number", "correct or remove it")
            found.append(float(cell))
        return found

    def _check(self, stretch: Array, stress: Array, numbers: list[int], values: Array) -> None:
        """Refuse numbers that no test of rubber gives."""

        def first(wrong: Any) -> int | None:
            found = np.flatnonzero(wrong)
            return int(found[0]) if len(found) else None

        i = first(~np.isfinite(values).all(axis=1))
        if i is not None:
            given = ", ".join(f"{x:g}" for x in values[i])
            self.refuse(f"line {numbers[i]} is not finite", given, "finite numbers", "correct or remove it")
        i = first((stretch <= 0.0) | (stretch > LARGEST_STRETCH))
        if i is not None:
            self.refuse(
                f"the stretch of line {numbers[i]} is out of range",
                f"{stretch[i]:.6g}",
                f"above 0 and up to {LARGEST_STRETCH:g}; a strain begins at 0, is no percentage, and is called strain",
                "check the column",
            )
        i = first(np.abs(stress) > LARGEST_STRESS_PA)
        if i is not None:
            self.refuse(
                f"the stress of line {numbers[i]} is not that of rubber",
                f"{stress[i]:.4g} Pa",
                f"up to {LARGEST_STRESS_PA:g} Pa",
                "check the unit in the column's name",
            )
        if float(stretch.max()) <= 1.0:
            self.refuse(
                "has no point in tension",
                f"stretches up to {stretch.max():.4g}",
                "stretches above 1",
                "test in tension",
            )
        if float(stress[stretch > 1.0].max()) <= 0.0:
            self.refuse(
                "tension is not positive",
                f"a nominal stress of at most {stress[stretch > 1.0].max():.4g} Pa",
                "positive in tension",
                "change the sign of the column",
            )

        most, start = float(stress.max()), np.abs(stretch - 1.0) <= AT_REST * (float(stretch.max()) - 1.0)
        rest = float(stress[start].mean()) if start.any() else 0.0
        if abs(rest) > OFFSET * most:
            self.refuse(
                f"the stress at rest is not zero (line {numbers[int(np.flatnonzero(start)[0])]})",
                f"{rest:.4g} Pa at a stretch of 1",
                f"within {OFFSET:.0%} of the largest stress",
                "subtract the preload",
            )

    def _check_order(self, stretch: Array, numbers: list[int], unloading: bool) -> None:
        """Refuse a strain that goes back by more than its noise."""
        falls = unloading and stretch[0] > stretch[-1]
        rising = -stretch if falls else stretch
        back = np.maximum.accumulate(rising) - rising
        wrong = np.flatnonzero(back > BACKWARDS * np.ptp(stretch))
        if len(wrong):
            i = int(wrong[0])
            self.refuse(
                f"the stretch is not monotone: it {'rises' if falls else 'falls'} at line {numbers[i]}",
                f"{stretch[i]:.6g} after {stretch[i - 1]:.6g}",
                "one way only" if unloading else "loading only, stretch rising from line to line",
                "keep one branch of the test" if unloading else "give the way back with --tensile-unloading",
            )


def _cells(line: str, separator: str) -> list[str]:
    return next(csv.reader([line], delimiter=separator), [])


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
