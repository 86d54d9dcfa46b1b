"""An entry of the catalogue of failures: what was found, what it means, and its picture."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beadband.notices import Notice

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
class Finding:
    """A statement about measured numbers, and whether it is the expected one."""

    expected: bool
    sentence: str


def finding(holds: Any, sentence: str, otherwise: str) -> Finding:
    """The finding ``sentence`` where the numbers bear it out, and ``otherwise`` where they do not."""
    return Finding(bool(holds), sentence if holds else otherwise)


@dataclass(frozen=True)
class Entry:
    """One failure, reproduced. Its texts are made of explanations (str) and of findings."""

    name: str
    title: str
    failure: tuple[Finding | str, ...]
    """What fails, and why."""
    answer: tuple[Finding | str, ...]
    """What beadband does about it."""
    numbers: Mapping[str, float | str]
    """What was measured, units in the names."""
    picture: Picture

    @property
    def findings(self) -> tuple[Finding, ...]:
        return tuple(one for one in (*self.failure, *self.answer) if isinstance(one, Finding))

    @property
    def reproduced(self) -> bool:
        """Whether every finding is the expected one: the failure appears as described, and the answer works."""
        return all(one.expected for one in self.findings)

    def as_dict(self) -> dict[str, Any]:
        return {
            "name": self.name,
            "title": self.title,
            "failure": text(self.failure),
            "answer": text(self.answer),
            "numbers": {
                key: value if isinstance(value, str) else float(value) if np.isfinite(value) else None
                for key, value in self.numbers.items()
            },
            "findings": [{"expected": one.expected, "sentence": one.sentence} for one in self.findings],
            "held": self.reproduced,
        }


def text(parts: Iterable[Finding | str]) -> str:
    """Explanations and findings as one paragraph."""
    return " ".join(one.sentence if isinstance(one, Finding) else one for one in parts)


def carries(warnings: Iterable[Notice], code: str) -> bool:
    """Whether a notice of this code is among the warnings of a plan or a scene."""
    return any(one.code == code for one in warnings)
