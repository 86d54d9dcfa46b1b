"""How a strand unloads: the admissible wave, from the lower convex envelope of the law's stress.

Where the envelope leaves the curve and runs along a chord the wave is a shock; where it is the curve itself, a fan. The
envelope is found on a grid, and the ends of its chords, where they touch the curve, to the last digits.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from beadband.model.roots import root

Array = NDArray[Any]

SHOCK, FAN, SHARP_FRONT = "shock", "fan", "sharp front"

_PIECES = 128
"""Into which the way down of an unloading wave is cut."""
_FINE_PIECES = 256
"""The same, for a wave that is neither one chord nor one fan."""
_TOUCHING = 1e-9
"""Relative difference of slopes below which a chord touches the curve."""
_STRAIGHT = 1e-10
"""Distance between chord and curve, over the rise, below which the law counts as linear."""
_NODES = 12
_FAN_ERROR = 1e-13
_MOST_PANELS = 256


class Curve(Protocol):
    """What a law must offer to unload."""

    def energy(self, stretch: Any) -> Any: ...
    def stress(self, stretch: Any) -> Any: ...
    def tangent(self, stretch: Any) -> Any: ...


class WavePart(NamedTuple):
    """One part of an unloading wave; speeds in m/s, in reference length."""

    kind: str
    """"shock", "fan", or "sharp front": the front of a linear law, which loses no energy."""
    ahead: float
    """Stretch ahead of it."""
    behind: float
    """Stretch behind it."""
    front_speed_m_s: float
    tail_speed_m_s: float
    """Speeds of its two ends: equal for a shock and a sharp front."""
    loss_j_m3: float
    """Energy that it turns into heat, per volume of the strand that it has passed: 0 for all but a shock."""


class UnloadingWave(NamedTuple):
    """What a strand does when the stretch ahead of a wave drops to a lower one behind it."""

    particle_speed_m_s: float
    """Speed of the material behind the wave, along the strand."""
    front_speed_m_s: float
    """Speed of the foremost point of the wave, in reference length."""
    parts: tuple[WavePart, ...] = ()
    """From the foremost part to the last; none where nothing unloads."""

    @property
    def kind(self) -> str:
        """ "shock", "fan", "shock and fan" or "sharp front"; "" where nothing unloads."""
        kinds = {part.kind for part in self.parts}
        return f"{SHOCK} and {FAN}" if len(kinds) > 1 else next(iter(kinds), "")

    @property
    def shocks(self) -> bool:
        """Whether any part of it is a shock, which turns energy into heat at any spacing."""
        return any(part.kind == SHOCK for part in self.parts)

    @property
    def tail_speed_m_s(self) -> float:
        """Speed of its last point, in reference length."""
        return self.parts[-1].tail_speed_m_s if self.parts else self.front_speed_m_s

    @property
    def mean_speed_ratio(self) -> float:
        """Mean speed over the stretches of the wave, over that of its foremost point: 1 where it has one speed."""
        if len(self.parts) < 2 and self.tail_speed_m_s == self.front_speed_m_s:
            return 1.0
        return self.particle_speed_m_s / (self.front_speed_m_s * (self.parts[0].ahead - self.parts[-1].behind))

    @property
    def loss_j_m3(self) -> float:
        """Energy that its shocks turn into heat, per volume of the strand that it has passed."""
        return sum(part.loss_j_m3 for part in self.parts)


def unloading_wave(curve: Curve, ahead: float, behind: float, density_kg_m3: float) -> UnloadingWave:
    """The wave that takes the stretch from ``ahead`` down to ``behind`` in a strand at rest.

    The material behind it moves at the integral of sqrt(slope/density) along the lower convex envelope.
    """
    if not behind < ahead:
        return UnloadingWave(0.0, math.sqrt(curve.tangent(ahead) / density_kg_m3))
    stretch = np.linspace(behind, ahead, _PIECES + 1)
    stress = curve.stress(stretch)
    rise = float(stress[-1]) - float(stress[0])
    slope = rise / (ahead - behind)
    slack = 1e-13 * abs(float(stress[-1]))
    touching = max(_TOUCHING, slack / abs(rise)) * abs(slope) if rise else math.inf
    first, last = float(curve.tangent(behind)), float(curve.tangent(ahead))
    above = stress[1:-1] - np.interp(stretch[1:-1], [behind, ahead], stress[[0, -1]])
    if np.all(above >= -slack) and last <= slope + touching and first >= slope - touching:
        straight = float(above.max()) <= max(_STRAIGHT * abs(rise), slack)
        speed = math.sqrt(max(rise, 0.0) / ((ahead - behind) * density_kg_m3))
        loss = 0.0 if straight else _loss(curve, behind, ahead)
        part = WavePart(SHARP_FRONT if straight else SHOCK, ahead, behind, speed, speed, loss)
        return UnloadingWave(speed * (ahead - behind), speed, (part,))
    if np.all(np.diff(stress, 2) > slack) and last > slope > first:
        pieces = [(FAN, behind, ahead)]
    else:
        pieces = _envelope(curve, behind, ahead)
    particle, parts = 0.0, []
    for kind, low, high in reversed(pieces):
        if kind == FAN:
            particle += _fan(curve, low, high) / math.sqrt(density_kg_m3)
            head, tail = (math.sqrt(max(float(curve.tangent(end)), 0.0) / density_kg_m3) for end in (high, low))
            parts.append(WavePart(FAN, high, low, head, tail, 0.0))
            continue
        speed = math.sqrt(max(_chord(curve, low, high), 0.0) / density_kg_m3)
        particle += speed * (high - low)
        parts.append(WavePart(SHOCK, high, low, speed, speed, _loss(curve, low, high)))
    return UnloadingWave(particle, parts[0].front_speed_m_s, tuple(parts))


def _chord(curve: Curve, low: float, high: float) -> float:
    return (float(curve.stress(high)) - float(curve.stress(low))) / (high - low)


def _loss(curve: Curve, low: float, high: float) -> float:
    """Energy under the curve beyond that under its chord; rounding alone could make it negative."""
    mean = 0.5 * (float(curve.stress(high)) + float(curve.stress(low)))
    return max(float(curve.energy(high)) - float(curve.energy(low)) - mean * (high - low), 0.0)


@cache
def gauss_points() -> tuple[Array, Array]:
    """Nodes and weights of Gauss's rule between 0 and 1."""
    nodes, weights = np.polynomial.legendre.leggauss(_NODES)
    return 0.5 * (nodes + 1.0), 0.5 * weights


def _fan(curve: Curve, low: float, high: float) -> float:
    """Integral of sqrt(tangent) between two stretches."""
    nodes, weights = gauss_points()
    panels, before = 2, math.inf
    while True:
        width = (high - low) / panels
        at = low + width * (np.arange(panels)[:, None] + nodes)
        found = width * float(np.sum(np.sqrt(np.maximum(curve.tangent(at), 0.0)) @ weights))
        if abs(found - before) <= _FAN_ERROR * found or panels >= _MOST_PANELS:
            return found
        panels, before = 2 * panels, found


def _envelope(curve: Curve, behind: float, ahead: float) -> list[tuple[str, float, float]]:
    """Chords and fans of the lower convex envelope, upwards from ``behind``: (kind, lower end, upper end)."""
    stretch = np.linspace(behind, ahead, _FINE_PIECES + 1)
    corners = _corners(stretch, curve.stress(stretch))
    cell = (ahead - behind) / _FINE_PIECES
    chords = [
        _touching(curve, float(stretch[i]), float(stretch[j]), behind, ahead, cell)
        for i, j in itertools.pairwise(corners)
        if j > i + 1
    ]
    pieces, below = [], behind
    for low, high in chords:
        # Chords that meet within a cell: the curve between them is convex over less than the grid resolves.
        low = max(low, below)
        if low > below:
            pieces.append((FAN, below, low))
        if high > low:
            pieces.append((SHOCK, low, high))
            below = high
    if ahead > below:
        pieces.append((FAN, below, ahead))
    return pieces


def _touching(curve: Curve, low: float, high: float, behind: float, ahead: float, cell: float) -> tuple[float, float]:
    """A chord of the grid with those of its ends that lie between ``behind`` and ``ahead`` where it touches the curve.

    Each end is found with the other one fixed; at a chord that touches twice this converges with the second order.
    """

    def excess_at_top(x: float) -> float:
        return float(curve.tangent(x)) * (x - low) - (float(curve.stress(x)) - float(curve.stress(low)))

    def excess_at_bottom(x: float) -> float:
        return float(curve.tangent(x)) * (high - x) - (float(curve.stress(high)) - float(curve.stress(x)))

    for _ in range(20):
        before = (low, high)
        around = max(high - 2.0 * cell, low + 0.5 * cell), min(high + 2.0 * cell, ahead)
        high = _crossing(excess_at_top, high, around, ahead)
        around = max(low - 2.0 * cell, behind), min(low + 2.0 * cell, high - 0.5 * cell)
        low = _crossing(excess_at_bottom, low, around, behind)
        if abs(low - before[0]) + abs(high - before[1]) <= 1e-14 * high:
            break
    return low, high


def _crossing(function: Callable[[float], float], guess: float, around: tuple[float, float], end: float) -> float:
    """Where a function rises through zero; ``end`` if that lies beyond it, and the guess if it does not rise there."""
    low, high = around
    if not low < high:
        return guess
    at_low, at_high = function(low), function(high)
    if at_low < 0.0 < at_high:
        return root(function, low, high)
    beyond = (end == high and at_high <= 0.0) or (end == low and at_low >= 0.0)
    return end if beyond else guess


def _corners(x: Array, y: Array) -> list[int]:
    """Indices of the corners of the lower convex envelope of the points."""
    points = list(zip(x.tolist(), y.tolist(), strict=True))
    scale = abs(points[-1][1]) * (points[-1][0] - points[0][0])
    hull: list[int] = []
    for i, point in enumerate(points):
        # A corner on or above the chord of its neighbours is none; rounding must not keep it.
        while len(hull) > 1 and _turn(points[hull[-2]], points[hull[-1]], point) <= 1e-13 * scale:
            hull.pop()
        hull.append(i)
    return hull


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
