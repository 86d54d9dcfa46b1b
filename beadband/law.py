"""Material laws of a strand in uniaxial tension, per unit of reference volume.

A law is energy, nominal stress and tangent as functions of the stretch, written with plain arithmetic so that
floats and numpy arrays both pass. To add one, subclass :class:`Law` and add a line to :data:`LAWS`.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from beadband.errors import UsageError, explain

if TYPE_CHECKING:
    from beadband.band import Band

Array = NDArray[Any]

# Stretches scanned for a tension peak; rubber breaks well before the upper end.
_SCAN_UP_TO = 12.0
_SCAN_STEP = 0.01
_PIECES = 128
"""Into which the way down of an unloading wave is cut."""


class UnloadingWave(NamedTuple):
    """What a strand does when the stretch ahead of a wave drops to a lower one behind it."""

    particle_speed_m_s: float
    """Speed of the material behind the wave, along the strand."""
    front_speed_m_s: float
    """Speed of the foremost point of the wave, in reference length."""


class Law:
    """One uniaxial law; stretches are dimensionless, stresses (nominal) and energies in Pa = J/m3."""

    name: str

    def energy(self, stretch: Any) -> Any:
        """Strain energy density W, zero at stretch 1."""
        raise NotImplementedError

    def stress(self, stretch: Any) -> Any:
        """Nominal stress dW/dstretch."""
        raise NotImplementedError

    def tangent(self, stretch: Any) -> Any:
        """Tangent modulus d(stress)/dstretch."""
        raise NotImplementedError

    @property
    def rest_modulus_pa(self) -> float:
        """Tangent modulus of the unstretched material."""
        return float(self.tangent(1.0))

    def peak_stretch(self) -> float | None:
        """Stretch at which the tension stops to rise, or None below a stretch of 12.

        Beyond it a uniformly held stretch is unstable: the law is valid from compression up to here.
        """
        steps = int((_SCAN_UP_TO - 1.0) / _SCAN_STEP)
        stretches = 1.0 + _SCAN_STEP * np.arange(steps + 1)
        falling = np.flatnonzero(self.tangent(stretches) <= 0.0)
        if not len(falling):
            return None
        first = int(falling[0])
        return root(self.tangent, float(stretches[first - 1]), float(stretches[first])) if first else 1.0

    def stretch_at(self, stress_pa: float, at_most: float) -> float:
        """Stretch that carries a nominal stress between 0 and that of ``at_most`` (Newton, bracketed)."""
        low, high = 1.0, at_most
        stretch = 1.0 + (at_most - 1.0) * stress_pa / float(self.stress(at_most))
        for _ in range(100):
            excess = float(self.stress(stretch)) - stress_pa
            if excess > 0.0:
                high = stretch
            else:
                low = stretch
            step = excess / float(self.tangent(stretch))
            stretch -= step
            if abs(step) <= 1e-15 * stretch:
                break
            if not low <= stretch <= high:
                stretch = 0.5 * (low + high)
        return stretch

    def unloading_wave(self, ahead: float, behind: float, density_kg_m3: float) -> UnloadingWave:
        """The wave that takes the stretch from ``ahead`` down to ``behind`` in a strand at rest.

        The admissible wave follows the lower convex envelope of the stress between the two stretches: a concave
        law (Mooney-Rivlin) gives one shock along the chord, a stiffening one a fan along the curve itself, and a
        law that is neither a mixture. The material speed is the integral of sqrt(slope/density) along it.
        """
        if not behind < ahead:
            return UnloadingWave(0.0, math.sqrt(self.tangent(ahead) / density_kg_m3))
        stretch = np.linspace(behind, ahead, _PIECES + 1)
        stress = self.stress(stretch)
        # Corners of the envelope: for most laws the chord alone (the curve stays above) or all of the curve (convex).
        slopes = np.diff(stress)
        slack = 1e-13 * abs(float(stress[-1]))
        if np.all(stress[1:-1] >= np.interp(stretch[1:-1], [behind, ahead], stress[[0, -1]]) - slack):
            corners = np.array([0, _PIECES])
        elif np.all(np.diff(slopes) > slack):
            corners = np.arange(_PIECES + 1)
        else:
            corners = _lower_envelope(stretch, stress)
        strains, stresses = np.diff(stretch[corners]), np.diff(stress[corners])
        speeds = np.sqrt(stresses / (strains * density_kg_m3))
        return UnloadingWave(float(np.sum(speeds * strains)), float(speeds[-1]))


def _lower_envelope(x: Array, y: Array) -> Array:
    """Indices of the corners of the lower convex envelope of the points."""
    points = list(zip(x.tolist(), y.tolist(), strict=True))
    scale = abs(points[-1][1]) * (points[-1][0] - points[0][0])
    hull: list[int] = []
    for i, point in enumerate(points):
        # A corner on or above the chord of its neighbours is none; rounding must not keep it.
        while len(hull) > 1 and _turn(points[hull[-2]], points[hull[-1]], point) <= 1e-13 * scale:
            hull.pop()
        hull.append(i)
    return np.array(hull)


def _turn(a: tuple[float, float], b: tuple[float, float], c: tuple[float, float]) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def root(function: Callable[[float], float], low: float, high: float) -> float:
    """Root of a continuous function with opposite signs at ``low`` and ``high``, to the last digits (Ridders).

    Kept here because importing an optimizer would take longer than releasing a band.
    """
    at_low, at_high = function(low), function(high)
    if at_low == 0.0:
        return low
    if at_high == 0.0:
        return high
    if at_low * at_high > 0.0:
        raise ValueError(f"no change of sign between {low} and {high}")
    guess = math.inf
    for _ in range(100):
        middle = 0.5 * (low + high)
        at_middle = function(middle)
        bend = math.sqrt(at_middle * at_middle - at_low * at_high)
        last, guess = guess, middle + (middle - low) * math.copysign(1.0, at_low - at_high) * at_middle / bend
        value = function(guess)
        if value == 0.0 or abs(guess - last) <= 4e-16 * abs(guess) or not low < middle < high:
            return guess
        for point, at_point in ((middle, at_middle), (guess, value)):
            if low < point < high:
                if at_point * at_low > 0.0:
                    low, at_low = point, at_point
                else:
                    high, at_high = point, at_point
        if at_high == 0.0:
            return high
    return guess


@dataclass(frozen=True)
class Linear(Law):
    """Nominal stress proportional to strain: W = E/2 (stretch - 1)^2."""

    modulus_pa: float
    name = "linear"

    @classmethod
    def of(cls, band: Band) -> Linear:
        return cls(band.modulus_pa)

    def energy(self, stretch: Any) -> Any:
        return 0.5 * self.modulus_pa * (stretch - 1.0) ** 2

    def stress(self, stretch: Any) -> Any:
        return self.modulus_pa * (stretch - 1.0)

    def tangent(self, stretch: Any) -> Any:
        return self.modulus_pa + 0.0 * stretch


@dataclass(frozen=True)
class MooneyRivlin(Law):
    """Incompressible, uniaxial: W = C10 (s^2 + 2/s - 3) + C01 (2 s + 1/s^2 - 3), s the stretch."""

    c10_pa: float
    c01_pa: float
    name = "mooney-rivlin"

    @classmethod
    def of(cls, band: Band) -> MooneyRivlin:
        return cls(band.c10_pa, band.c01_pa)

    def energy(self, stretch: Any) -> Any:
        # Factored so that small strains do not cancel: s^2 + 2/s - 3 = (s-1)^2 (s+2)/s, and the like for C01.
        shape = (stretch - 1.0) ** 2 / stretch
        return shape * (self.c10_pa * (stretch + 2.0) + self.c01_pa * (2.0 * stretch + 1.0) / stretch)

    def stress(self, stretch: Any) -> Any:
        return 2.0 * (stretch - stretch**-2) * (self.c10_pa + self.c01_pa / stretch)

    def tangent(self, stretch: Any) -> Any:
        return 2.0 * (self.c10_pa * (1.0 + 2.0 * stretch**-3) + 3.0 * self.c01_pa * stretch**-4)


LAWS: dict[str, Callable[[Band], Law]] = {
    Linear.name: Linear.of,
    MooneyRivlin.name: MooneyRivlin.of,
}


def law_of(name: str, band: Band) -> Law:
    """The law called ``name`` with the constants of ``band``; UsageError when unknown or soft at rest."""
    if name not in LAWS:
        raise UsageError(explain("unknown material law", repr(name), ", ".join(LAWS), "choose one with --law"))
    law = LAWS[name](band)
    if not law.rest_modulus_pa > 0.0:
        raise UsageError(
            explain(
                f"the {name} law has no stiffness at rest",
                f"a rest modulus of {law.rest_modulus_pa:.4g} Pa",
                "a positive one",
                "raise --modulus (linear) or --c10 + --c01 (mooney-rivlin)",
            )
        )
    return law
