"""The columns of a sweep's table, typed: the scene, what its release gave, and how it ended."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from beadband import observables
from beadband.observables import Column
from beadband.parameters import TABLE
from beadband.studies.sweep.grid import Axis, Grid

KEY = Column("key", "text", "the scene as JSON, which identifies it")
ENDS = (
    Column("status", "text", "done, refused (the scene has no answer) or failed"),
    Column("reason", "text", "why there is no result"),
    Column("reason_code", "text", "the same as a fixed word"),
)


def columns_of(grid: Grid) -> tuple[Column, ...]:
    """All columns of the table of a grid, in their order."""
    return (KEY, *(_of_axis(axis) for axis in grid.axes), *observables.columns(), *ENDS)


def _of_axis(axis: Axis) -> Column:
    one = TABLE[axis.key]
    kinds = {"count": "integer", "number": "number", "numbers": "number"}
    plain = all(isinstance(value, (int, float)) for value in axis.values)
    return Column(axis.key, kinds.get(one.kind, "text") if plain else "text", one.help, one.unit)


def typed(columns: Sequence[Column], texts: Sequence[str]) -> dict[str, Any]:
    """A row of the table as numbers and texts; None for a number that is not there."""
    return {
        one.name: text if one.kind == "text" else _number(text, one.kind) if text else None
        for one, text in zip(columns, texts, strict=True)
    }


def _number(text: str, kind: str) -> float | int:
    return int(text) if kind == "integer" else float(text)
