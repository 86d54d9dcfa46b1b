"""The string limit of many wedges of one law at once.

The equations are those of :mod:`beadband.model.wedge` and :mod:`beadband.model.laws.unloading`; what differs is that
they are solved for arrays. With S the slope of that piece of the envelope which starts at the stretch s1 behind the
wave, the particle speed u falls with s1 as du/ds1 = -(S + tangent(s1))/(2 sqrt(S density)), whatever the envelope is
made of: the chord moves with its lower end alone, for at its upper end it touches the curve.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beadband.model.laws import Law
from beadband.model.laws.unloading import gauss_points
from beadband.model.wedge import rear_speed_m_s, string_limit, strip_limit

Array = NDArray[np.float64]

_GRID = 1024
"""Cells into which the stretches of a law are cut to see its shape."""
_FLAT = 1e-12
"""Change of the tangent from cell to cell, over the largest, below which the law counts as straight there."""
_SOFTENING_POINTS = 128
"""Stretches of each scene at which laws that differ from scene to scene are looked at."""
_FAN_PANELS = 3
_MOST_STEPS = 60
_LAST_STEP = 1e-9
"""Step over the strain after which Newton's method, of the second order, is there to the last digits."""


class StringLimits(NamedTuple):
    """String limits as arrays of one shape; the fields of :class:`beadband.model.wedge.StringLimit`."""

    residual_strain: Array
    residual_stress_pa: Array
    rear_speed_m_s: Array
    front_speed_m_s: Array
    mean_speed_ratio: Array
    """Of the unloading wave."""


def string_limits(law: Law, density_kg_m3: Any, strain: Any, half_angle_rad: Any) -> StringLimits:
    """String limits of wedges of one law; arguments but the law are floats or arrays that broadcast.

    Equal to :func:`beadband.model.wedge.string_limit` one by one, which also serves here for laws that change from
    softening to stiffening more than once. The strains are those of scenes that have an answer. Constants of the law
    may be arrays of the shape that the others broadcast to, where :func:`softens` holds.
    """
    density, strains, angles = np.broadcast_arrays(
        *(np.asarray(one, dtype=np.float64) for one in (density_kg_m3, strain, half_angle_rad))
    )
    shape, root = strains.shape, np.sqrt(density)
    held, sine = 1.0 + strains.ravel(), np.sin(angles.ravel())
    law, turn = _flat(law, strains)
    if turn is None:
        pairs = zip(strains.ravel().tolist(), angles.ravel().tolist(), strict=True)
        single = [string_limit(law, 1.0, *pair) for pair in pairs]
        behind = np.array([one.residual_strain for one in single])
        stress = np.array([one.residual_stress_pa for one in single])
        speed = np.array([one.rear_speed_m_s for one in single])
        front = np.array([one.front_speed_m_s for one in single])
        mean = np.array([one.wave.mean_speed_ratio for one in single])
    else:
        wave = _Waves(law, held, turn)
        stretch = _behind(wave, sine) if np.isfinite(turn) else _behind_chord(law, held, sine)
        behind, stress = stretch - 1.0, np.asarray(law.stress(stretch), dtype=np.float64)
        particle, _, front = wave.unloaded_to(stretch)
        speed = rear_speed_m_s(particle, sine, np.cos(angles.ravel()))
        mean = particle / (front * (held - stretch)) if np.isfinite(turn) else np.ones_like(sine)
    behind, stress, speed, front, mean = (one.reshape(shape) for one in (behind, stress, speed, front, mean))
    return StringLimits(behind, stress, speed / root, front / root, mean)


def strip_limits(law: Law, density_kg_m3: Any, strain: Any) -> StringLimits:
    """Exact releases of strips: :func:`beadband.model.wedge.strip_limit` for arrays as of :func:`string_limits`."""
    density, strains = np.broadcast_arrays(*(np.asarray(one, dtype=np.float64) for one in (density_kg_m3, strain)))
    shape, root = strains.shape, np.sqrt(density)
    held, (law, turn) = 1.0 + strains.ravel(), _flat(law, strains)
    behind = np.full_like(held, law.unstressed_stretch)
    if turn is None or (held.size == 1 and not arrays_of(law)):
        single = [strip_limit(law, 1.0, one) for one in strains.ravel().tolist()]
        speed, front = (np.array([getattr(one, f"{name}_speed_m_s") for one in single]) for name in ("rear", "front"))
    else:
        speed, _, front = _Waves(law, held, turn).unloaded_to(behind)
    mean = speed / (front * (held - behind))
    behind, speed, front, mean = (one.reshape(shape) for one in (behind, speed, front, mean))
    return StringLimits(behind - 1.0, np.zeros(shape), speed / root, front / root, mean)


def _flat(law: Law, strains: Array) -> tuple[Law, float | None]:
    """The law with its arrays of one dimension, and where it turns (:func:`_turn`)."""
    many = arrays_of(law)
    if many:
        flat = {key: one.ravel() if one.size > 1 else one.item() for key, one in many.items()}
        return replace(law, **flat), math.inf  # type: ignore[type-var]
    return law, _turn(law, 1.0 + float(strains.max(initial=0.0)))


def arrays_of(law: Law) -> dict[str, Array]:
    """Constants of a law that are arrays, a number for each scene."""
    return {key: one for key, one in law.values().items() if isinstance(one, np.ndarray)}


def softens(law: Law, strain: Array) -> bool:
    """Whether the tangent of a law falls, or stays, and is above 0 from rest to each held strain.

    ``strain`` has the shape of the law's constants.
    """
    before = np.asarray(law.tangent(1.0 + 0.0 * strain), dtype=np.float64)
    allowed = _FLAT * np.abs(before)
    for share in np.arange(1, _SOFTENING_POINTS + 1) / _SOFTENING_POINTS:
        tangent = np.asarray(law.tangent(1.0 + share * strain), dtype=np.float64)
        if not np.all(tangent - before <= allowed):
            return False
        before = tangent
    return True


def _turn(law: Law, longest: float) -> float | None:
    """As :func:`_turn_before`, over a round range of stretches so that scenes of one law share the answer."""
    return _turn_before(law, longest if law.longest_stretch() is not None else math.ceil(4.0 * longest) / 4.0)


@lru_cache(maxsize=1024)
def _turn_before(law: Law, longest: float) -> float | None:
    """Stretch from which on a law stiffens, having softened before; None where it turns more than once.

    Infinite for a law that only softens, or is straight, and 1 for one that only stiffens.
    """
    stretch = np.linspace(1.0, longest, _GRID + 1)
    tangent = np.broadcast_to(np.asarray(law.tangent(stretch), dtype=np.float64), stretch.shape)
    change = np.diff(tangent)
    signs = np.where(np.abs(change) <= _FLAT * np.abs(tangent).max(), 0.0, np.sign(change))
    turns = np.flatnonzero(signs)
    if len(turns) == 0 or np.all(signs <= 0.0):
        return math.inf
    if np.all(signs >= 0.0):
        return 1.0 if len(turns) == _GRID else None
    first = int(np.flatnonzero(signs > 0.0)[0])
    if np.any(signs[first:] < 0.0) or np.any(signs[:first] > 0.0):
        return None
    return float(stretch[first])


@dataclass(frozen=True)
class _Waves:
    """Unloading waves from the stretches ``held`` (scenes,), of unit density, of a law that softens up to ``turn``."""

    law: Law
    held: Array
    turn: float

    def unloaded_to(self, behind: Array) -> tuple[Array, Array, Array]:
        """Particle speed, its derivative by ``behind``, and the speed of the foremost point; shape (scenes,)."""
        law, held = self.law, self.held
        touch = self._touching(behind)
        chord = touch > behind
        width = np.where(chord, touch - behind, 1.0)
        slope = np.where(chord, (law.stress(touch) - law.stress(behind)) / width, law.tangent(behind))
        root = np.sqrt(np.maximum(slope, 0.0))
        particle = root * (touch - behind)
        front = root
        fan = touch < held
        if np.any(fan):
            nodes, weights = gauss_points()
            share = (np.arange(_FAN_PANELS)[:, None] + nodes).ravel() / _FAN_PANELS
            low, span = touch[fan], (held - touch)[fan]
            tangent = np.maximum(law.tangent(low[:, None] + span[:, None] * share), 0.0)
            particle[fan] += span * (np.sqrt(tangent) @ np.tile(weights, _FAN_PANELS)) / _FAN_PANELS
            front = np.where(fan, np.sqrt(np.maximum(law.tangent(held), 0.0)), root)
        rate = -0.5 * (slope + law.tangent(behind)) / np.maximum(root, 1e-300)
        return particle, rate, front

    def _touching(self, behind: Array) -> Array:
        """Where the chord from ``behind`` touches the curve, at most at the held stretch."""
        touch = self.held.copy()
        if self.turn == 1.0:
            return behind.copy()
        law, beyond = self.law, np.flatnonzero(self.held > self.turn)
        if len(beyond) == 0:
            return touch
        start, stress = behind[beyond], law.stress(behind[beyond])

        def excess(x: Array) -> Array:
            found: Array = law.tangent(x) * (x - start) - (law.stress(x) - stress)
            return found

        high = self.held[beyond]
        touches = excess(high) > 0.0
        low = np.maximum(self.turn - (self.held.max() - 1.0) / _GRID, start)
        touch[beyond] = np.where(touches, _bisected(excess, low, high), high)
        return touch


def _behind_chord(law: Law, held: Any, sine: Any) -> Any:
    """Stretch behind the shock or sharp front of a law that does not stiffen, for which the kink keeps up.

    Newton's method from the unstretched state on (u sin)^2 = (k (1 - sin))^2 with u^2 = (stress0 - stress)(held - s)
    and k^2 = stress s, unit density: nearly straight in the stretch s. Floats or arrays.
    """
    if isinstance(held, np.ndarray) and held.size == 1:
        # Floats are much quicker than arrays of one.
        return np.array([_behind_chord(law, held.item(), sine.item())])
    largest = abs if isinstance(held, float) else _largest
    tip, most = sine * sine, law.stress(held)
    back = (1.0 - sine) ** 2
    stretch = 1.0 + 0.0 * held
    for _ in range(_MOST_STEPS):
        stress, tangent = law.stress(stretch), law.tangent(stretch)
        drop, way = most - stress, held - stretch
        excess = drop * way * tip - stress * stretch * back
        step = excess / ((tangent * way + drop) * tip + (tangent * stretch + stress) * back)
        stretch = stretch + step
        if largest(step / (stretch - 1.0)) <= _LAST_STEP:
            break
    return stretch


def _largest(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))


def _bisected(function: Callable[[Array], Array], low: Array, high: Array) -> Array:
    """Where functions rise through zero, to the last digits; regula falsi with halved weights (Illinois), in arrays."""
    at_low, at_high = function(low), function(high)
    guess = high
    for _ in range(_MOST_STEPS):
        before = guess
        span = at_high - at_low
        guess = np.where(span > 0.0, (low * at_high - high * at_low) / np.where(span > 0.0, span, 1.0), high)
        guess = np.where((guess <= low) | (guess >= high), 0.5 * (low + high), guess)
        value = function(guess)
        up = value > 0.0
        at_low, at_high = np.where(up, 0.5 * at_low, value), np.where(up, value, 0.5 * at_high)
        low, high = np.where(up, low, guess), np.where(up, guess, high)
        if np.all(np.abs(guess - before) <= 4e-16 * guess):
            break
    return guess


def _behind(waves: _Waves, sine: Array) -> Array:
    """The stretch behind each wave for which the kink travels with the wedge, by Newton's method in brackets.

    The squares of both sides of u sin = k (1 - sin) are nearly straight in the stretch.
    """
    law = waves.law
    low, high = np.ones_like(sine), waves.held.copy()
    stretch = np.ones_like(sine)
    for _ in range(_MOST_STEPS):
        particle, rate, _ = waves.unloaded_to(stretch)
        stress, tangent = law.stress(stretch), law.tangent(stretch)
        excess = (particle * sine) ** 2 - stress * stretch * (1.0 - sine) ** 2
        slope = 2.0 * particle * rate * sine**2 - (tangent * stretch + stress) * (1.0 - sine) ** 2
        low, high = np.where(excess > 0.0, stretch, low), np.where(excess > 0.0, high, stretch)
        better = stretch - excess / slope
        better = np.where((better <= low) | (better >= high), 0.5 * (low + high), better)
        done = np.abs(better - stretch) <= _LAST_STEP * (better - 1.0)
        stretch = better
        if np.all(done):
            break
    return stretch
