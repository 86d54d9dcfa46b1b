"""An entry of the catalogue of failures: what was found, what it means, and its picture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Curve:
    """A curve of a picture, or a set of points."""

    x: NDArray[Any]
    y: NDArray[Any]
    label: str = ""
    style: str = "-"
    """matplotlib's format of the line."""


@dataclass(frozen=True)
class Picture:
    """A picture as data, drawn by :meth:`draw`: entries are found in processes of their own."""

    title: str
    xlabel: str
    ylabel: str
    curves: tuple[Curve, ...]
    logx: bool = False
    logy: bool = False
    equal: bool = False
    levels: tuple[tuple[float, str], ...] = ()
    """Horizontal lines with their names."""
    ylim: tuple[float, float] | None = None

    def draw(self, axes: Any) -> None:
        """Draw onto matplotlib axes."""
        colours = ("#1f5fa8", "#c8601a", "#2c7d4f", "#8a3d8f", "#6b6b6b", "#b8322a")
        for curve, colour in zip(self.curves, colours * 4, strict=False):
            axes.plot(
                curve.x, curve.y, curve.style, color=colour, label=curve.label or None, linewidth=1.1, markersize=4
            )
        for level, name in self.levels:
            axes.axhline(level, color="#999999", linestyle="--", linewidth=1.0, label=name)
        if self.logx:
            axes.set_xscale("log")
        if self.logy:
            axes.set_yscale("log")
        if self.equal:
            axes.set_aspect("equal", adjustable="datalim")
        if self.ylim is not None:
            axes.set_ylim(*self.ylim)
        axes.set(xlabel=self.xlabel, ylabel=self.ylabel, title=self.title)
        axes.grid(alpha=0.25)
        if any(curve.label for curve in self.curves) or self.levels:
            axes.legend(fontsize=7, frameon=False)


@dataclass(frozen=True)
class Entry:
    """One failure, reproduced."""

    name: str
    title: str
    failure: str
    """What fails, and why."""
    answer: str
    """What beadband does about it."""
    numbers: Mapping[str, float | str]
    """What was measured, units in the names."""
    picture: Picture
    held: bool
    """Whether the failure appeared as described and the answer works."""

    def as_dict(self) -> dict[str, Any]:
        return {
            "name": self.name,
            "title": self.title,
            "failure": self.failure,
            "answer": self.answer,
            "numbers": {
                key: value if isinstance(value, str) else float(value) if np.isfinite(value) else None
                for key, value in self.numbers.items()
            },
            "held": bool(self.held),  # numpy's are not JSON's
        }
