"""A smooth curve through the points of a tensile test, as smooth as their own noise asks for.

What is smoothed is the reduced stress g, the nominal stress over (s - 1/s^2), against s - 1/s: it hardly changes
for rubber, and the curve passes through (1, 0) by itself. g is a quintic spline that minimises

    sum of ((stress - (s - 1/s^2) g)/noise)^2 + strength x integral of (third derivative of g)^2.

The strength is that of the largest restricted likelihood. The noise is taken as constant, as proportional to
(s - 1/s^2), or as one of two mixtures, whichever makes the test most likely.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beadband.errors import UsageError, explain
from beadband.model.tensile_test import TensileTest

Array = NDArray[np.float64]

_MOST_POINTS = 200
"""Points that are smoothed; longer tests are averaged over so many equal steps of the stretch."""
_KNOTS = 81
_ORDER = 3
"""Of the derivative in the penalty: parabolas are not bent."""
_CONSTANT_SHARES = (0.003, 0.03, 0.3, 30.0)
"""Constant part of the noise, over what grows with the strain at the last point."""
_REAL_FALL = 25.0
"""By how much a curve that rises throughout may be less likely, in twice the logarithm, for a fall to be noise."""
_STRONGEST = 1e20


@dataclass(frozen=True)
class Smoothed:
    """The curve at its knots, and how it was smoothed."""

    stretch: Array
    stress_pa: Array
    measured_from: float
    """Lowest measured stretch."""
    strength: float
    """Weight of the penalty, the stress and the range of s - 1/s scaled to 1."""
    freedom: float
    """Degrees of freedom that it leaves the curve."""
    scatter_pa: float
    """Root mean square of the points about the curve, one measurement each."""


def smoothed(test: TensileTest, from_rest: bool = True) -> Smoothed:
    """Smooth a test; ``from_rest`` is a curve that begins at (1, 0), the other may have any beginning.

    UsageError where no smoothing makes the stress rise from the first point.
    """
    stretch, stress, repeats = _binned(test)
    shape = stretch - stretch**-2 if from_rest else np.ones_like(stretch)
    scale = float(np.abs(stress).max())
    shares = _CONSTANT_SHARES if from_rest else (1.0,)
    fits = [_Fit(stretch, stress / scale, shape, share, repeats) for share in shares]
    fit = min(fits, key=lambda one: one.unlikeliness)
    knots = _knots(float(stretch[0]), float(stretch[-1]), from_rest)
    factor = knots - knots**-2 if from_rest else np.ones_like(knots)
    strength = fit.strength
    while not np.all(np.diff(curve := factor * fit.at(knots, strength)) > 0.0):
        strength *= 3.0
        if strength < _STRONGEST * fit.strength and fit.unlikeliness_at(strength) < fit.unlikeliness + _REAL_FALL:
            continue
        strength = fit.strength
        curve = factor * fit.at(knots, strength)
        rising = _rising(knots, curve)
        if fit.excess(np.interp(stretch, knots, rising)) < fit.excess(np.interp(stretch, knots, curve)) + _REAL_FALL:
            curve = rising
            break
        # No rising curve is at all likely: the tension has a peak.
        if curve[1] > curve[0]:
            break
        raise UsageError(
            explain(
                f"tensile test {test.source!r}: the stress does not rise from its first point",
                f"a scatter of {fit.scatter(strength) * scale:.3g} Pa of {scale:.3g} Pa",
                "a stress that rises with the stretch",
                "check the columns, or measure with less noise",
            ),
            code="tensile-test",
        )
    scatter = fit.scatter(strength)
    return Smoothed(knots, scale * curve, float(test.stretch[0]), strength, fit.freedom(strength), scale * scatter)


def _binned(test: TensileTest) -> tuple[Array, Array, Array]:
    stretch, stress, repeats = test.stretch, test.stress_pa, test.repeats
    if len(stretch) <= _MOST_POINTS:
        return stretch, stress, repeats
    place = np.minimum(
        ((stretch - stretch[0]) / (stretch[-1] - stretch[0]) * _MOST_POINTS).astype(int), _MOST_POINTS - 1
    )
    count = np.bincount(place, repeats)
    used = count > 0.0
    means = [np.bincount(place, repeats * values)[used] / count[used] for values in (stretch, stress)]
    # The first and the last point keep their stretch: the curve ends where the test does.
    ends = (stretch[:1], means[0], stretch[-1:]), (stress[:1], means[1], stress[-1:])
    some = np.concatenate([repeats[:1], count[used], repeats[-1:]])
    joined = np.concatenate(ends[0])
    distinct = np.concatenate([[True], np.diff(joined) > 1e-9])
    if not distinct[-1]:
        distinct[-2:] = False, True
    return joined[distinct], np.concatenate(ends[1])[distinct], some[distinct]


def _knots(first: float, last: float, from_rest: bool) -> Array:
    """Stretches of the curve's knots: closer at rest, where the stress bends most."""
    if not from_rest:
        return np.linspace(first, last, _KNOTS)
    tension = 1.0 + (last - 1.0) * np.linspace(0.0, 1.0, _KNOTS) ** 1.5
    tension[-1] = last
    return tension if first >= 1.0 else np.concatenate([np.linspace(first, 1.0, _KNOTS // 4)[:-1], tension])


def _rising(knots: Array, curve: Array) -> Array:
    """The nearest curve that rises by at least a hundredth of its mean slope (pool adjacent violators)."""
    least = 0.01 * float(np.ptp(curve)) * (knots - knots[0]) / (knots[-1] - knots[0])
    pools: list[tuple[float, int]] = []
    for value in (curve - least).tolist():
        pools.append((value, 1))
        while len(pools) > 1 and pools[-2][0] >= pools[-1][0]:
            (one, n), (other, m) = pools[-2:]
            pools[-2:] = [((n * one + m * other) / (n + m), n + m)]
    found: Array = np.repeat([value for value, _ in pools], [count for _, count in pools]) + least
    at_rest = np.flatnonzero(knots == 1.0)
    return found - found[at_rest[0]] if len(at_rest) and curve[at_rest[0]] == 0.0 else found


def _coordinate(stretch: Any) -> Any:
    """What the reduced stress is smooth in: like 1/s near rest, and like s far from it."""
    return stretch - 1.0 / stretch


class _Fit:
    """The penalised least squares of one model of the noise, for any strength.

    Its minimum is a parabola and a combination of the kernel's columns, so that a decomposition of the kernel, with
    the parabola projected out, gives all strengths at once.
    """

    def __init__(self, stretch: Array, stress: Array, shape: Array, share: float, repeats: Array) -> None:
        self._low, self._high = _coordinate(stretch[0]), _coordinate(stretch[-1])
        # A point at rest says nothing about the reduced stress.
        some = np.abs(shape) > 1e-9
        shape, stress, repeats = shape[some], stress[some], repeats[some]
        self._place = self._placed(stretch[some])
        noise = np.sqrt((share * shape[-1]) ** 2 + shape**2) if share < 1.0 else np.ones_like(shape)
        self._noise, self._repeats = noise, repeats
        self._weight = np.sqrt(repeats) / noise
        self._some = some
        self._shape = shape * self._weight
        self._target = stress * self._weight
        parabola, self._triangle = np.linalg.qr(self._shape[:, None] * _parabola(self._place), mode="complete")
        self._flat, rest = parabola[:, :_ORDER], parabola[:, _ORDER:]
        self._gram = self._shape[:, None] * _kernel(self._place, self._place) * self._shape
        size, modes = np.linalg.eigh(rest.T @ self._gram @ rest)
        self._size, self._modes = np.maximum(size, 0.0), rest @ modes
        self._pushed = self._modes.T @ self._target
        # Of the noise and of the parabola, for models of the noise to be compared.
        self._log_size = -2.0 * float(
            np.sum(np.log(self._weight)) - np.sum(np.log(np.abs(np.diag(self._triangle)[:_ORDER])))
        )
        self._choose()

    def _placed(self, stretch: Array) -> Array:
        place: Array = (_coordinate(stretch) - self._low) / (self._high - self._low)
        return place

    def _left(self, strength: float) -> Array:
        """What of each mode the curve leaves to the noise."""
        left: Array = strength / (strength + self._size)
        return left

    def _choose(self) -> None:
        """The strength of the largest restricted likelihood."""
        strengths = self._size.max() * 10.0 ** np.linspace(-13.0, 3.0, 97)
        found = [self.unlikeliness_at(float(strength)) for strength in strengths]
        self.unlikeliness, self.strength = min(found), float(strengths[int(np.argmin(found))])

    def unlikeliness_at(self, strength: float) -> float:
        """Minus twice the logarithm of the restricted likelihood, but for a constant."""
        left, free = self._left(strength), len(self._pushed)
        misfit = float(np.sum(left * self._pushed**2)) / free
        return float(free * np.log(misfit + 1e-30) - np.sum(np.log(left)) + self._log_size)

    def excess(self, curve: Array) -> float:
        """The same measure of the misfit of any curve, given at all stretches, shape (points,)."""
        apart = self._target - curve[self._some] * self._weight
        return float(len(apart) * np.log(np.mean(apart**2) + 1e-12))

    def freedom(self, strength: float) -> float:
        """Degrees of freedom."""
        return _ORDER + float(np.sum(1.0 - self._left(strength)))

    def _residual(self, strength: float) -> Array:
        residual: Array = self._modes @ (self._left(strength) * self._pushed)
        return residual

    def at(self, stretch: Array, strength: float) -> Array:
        """The reduced stress."""
        columns = self._residual(strength) / strength
        parabola = np.linalg.solve(self._triangle[:_ORDER], self._flat.T @ (self._target - self._gram @ columns))
        place = self._placed(stretch)
        found: Array = _parabola(place) @ parabola + _kernel(place, self._place) @ (self._shape * columns)
        return found

    def scatter(self, strength: float) -> float:
        """Root mean square of single measurements about the curve."""
        apart = self._residual(strength) * self._noise
        return float(np.sqrt(np.sum(apart**2) / max(len(apart) - self.freedom(strength), 1.0)))


def _parabola(place: Array) -> Array:
    """1, x and x^2, shape (points, 3): what the penalty leaves free."""
    return np.stack([np.ones_like(place), place, place**2], axis=1)


def _kernel(one: Array, other: Array) -> Array:
    """Integral of (x - u)^2 (y - u)^2/4 over u from 0 to the smaller of the two, shape (one, other)."""
    low, high = np.minimum(one[:, None], other), np.maximum(one[:, None], other)
    apart = high - low
    found: Array = low**3 * (low**2 / 5.0 + apart * low / 2.0 + apart**2 / 3.0) / 4.0
    return found
