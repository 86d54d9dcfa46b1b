"""The paper's beam of section 2: a circular band, half-angle 11.6 degrees; how its closed forms are drawn."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from beadband.model import beam
from beadband.model.bands import CATALOGUE
from beadband.studies.reproduction.drawing import SERIES, Sheet

BAND = CATALOGUE["circular"]
PHI = math.radians(11.6)
STIFFNESS = BAND.modulus_pa * BAND.second_moment_m4
SPREAD = math.sqrt(STIFFNESS / BAND.mass_per_length_kg_m)
REACH = np.linspace(0.0, 0.04, 1601)
"""Arc lengths of the pictures, m."""
PLACES, INSTANTS = np.meshgrid(np.linspace(1e-3, 6e-3, 7), np.linspace(1e-3, 3e-3, 5))
"""Where equations are tested, m and s."""
ROUNDING = 1e-6
"""Relative error of central differences of first order that still counts as agreement."""
_TIMES = np.geomspace(2e-5, 6e-3, 4000)
_STEP = 1e-7


def theta(s: Any, t: Any) -> Any:
    return beam.angle(s, t, PHI, SPREAD)


def kappa(s: Any, t: Any) -> Any:
    return beam.curvature(s, t, PHI, SPREAD)


def moment(s: Any, t: Any) -> Any:
    return beam.moment(s, t, PHI, SPREAD, STIFFNESS)


def shear(s: Any, t: Any) -> Any:
    return beam.shear(s, t, PHI, SPREAD, STIFFNESS)


def shear_mn(s: Any, t: Any) -> Any:
    return shear(s, t) * 1e3


def along_band(function: Any, s: Any, t: Any) -> Any:
    """Derivative by arc length, by a central difference of 0.2 micrometres."""
    return (function(s + _STEP, t) - function(s - _STEP, t)) / (2.0 * _STEP)


def misfit(found: Any, expected: Any) -> float:
    """Largest difference over the largest expected value."""
    return float(np.abs(found - expected).max() / np.abs(expected).max())


def rate_ratio(function: Any, place: float, early: tuple[float, float], late: tuple[float, float]) -> float:
    """Mean rate of change in size over an early time and over a late one, the first over the second."""

    def mean(times: tuple[float, float]) -> float:
        values = function(place, np.linspace(*times, 2001))
        return float(np.abs(np.diff(values)).sum()) / (times[1] - times[0])

    return mean(early) / mean(late)


def draw_along(sheet: Sheet, name: str, function: Any, times: tuple[float, ...], label: str, title: str) -> None:
    """A picture over the arc length, one curve for each time."""
    figure, (axes,) = sheet.axes()
    for time, colour in zip(times, SERIES, strict=False):
        axes.plot(REACH * 1e3, function(REACH, time), color=colour, label=f"t = {time * 1e3:g} ms")
    axes.set(xlabel="arc length from the tip s (mm)", ylabel=label, title=title, xlim=(0.0, 40.0))
    axes.legend()
    sheet.save(figure, name)


def draw_over_time(sheet: Sheet, name: str, function: Any, places: tuple[float, ...], label: str, title: str) -> None:
    """A picture over time, one curve for each place."""
    figure, (axes,) = sheet.axes()
    for place, colour in zip(places, SERIES, strict=False):
        where = f"s = {place * 1e3:g} mm" if place > 1e-9 else "s = 0"
        axes.plot(_TIMES * 1e3, function(place, _TIMES), color=colour, label=where)
    axes.set(xlabel="time t (ms)", ylabel=label, title=title, xscale="log", xlim=(0.02, 6.0))
    axes.legend()
    sheet.save(figure, name)


def draw_surface(sheet: Sheet, name: str, function: Any, label: str, title: str, from_s: float) -> None:
    """A surface over arc length and time."""
    s, t = np.meshgrid(np.linspace(0.0, 0.015, 161), np.linspace(from_s, 5e-3, 161))
    figure, axes = sheet.surface()
    axes.plot_surface(s * 1e3, t * 1e3, function(s, t), cmap="viridis", linewidth=0, rcount=120, ccount=120)
    axes.set(xlabel="s (mm)", ylabel="t (ms)", zlabel=label, title=title)
    axes.view_init(elev=28, azim=-58)
    sheet.save(figure, name)
