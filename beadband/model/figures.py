"""What a designer asks of a held band beside its rebound speed, in closed form; floats or arrays of scenes.

The held band is a uniformly stretched string. The throw is that of :mod:`beadband.model.launch_string`, without
bending, which holds for one sharp front and half-angles below 30 degrees.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beadband.model.formula import longest_held, scenes_of, section_of
from beadband.model.launch_string import one_front, string_momentum_n_s
from beadband.model.laws import Law
from beadband.model.scene import Scene
from beadband.model.string_arrays import arrays_of, string_limits

_SCAN_UP_TO, _SCAN_STEP, _HALVINGS = 12.0, 0.05, 40
"""Stretches scanned for the peaks of many tensions, and halvings of the step that holds one."""

FIGURES = (
    "mass_kg",
    "stored_energy_j",
    "energy_density_j_kg",
    "tension_n",
    "pull_n",
    "held_length_m",
    "finger_radius_m",
    "throw_momentum_n_s",
    "throw_speed_m_s",
    "throw_efficiency",
)
"""Keys of the figures; what they are and their units stand in the table of observables."""
THROWS = FIGURES[-3:]
"""Those of the throw."""


def figures_of_scene(scene: Scene) -> dict[str, float | None]:
    """The figures of a scene by their keys, with ``peak_strain``, from which on it can't be held.

    None where there is no such strain, for the finger and the throw of a strip, and for a throw without a closed form.
    """
    given = {"strain": scene.strain, "half_angle_rad": scene.half_angle_rad, "leg_m": scene.wedge.reference_leg_m}
    given |= {key: getattr(scene.band, key) for key in ("circumference_m", "density_kg_m3")}
    string = scene.string
    found = _figures(
        scene, scene.material, scene.band.area_m2, given, string.front_speed_m_s, string.wave.mean_speed_ratio
    )
    found["peak_strain"] = _peak_strain(scene.material)
    return {key: float(value) if np.isfinite(value) else None for key, value in found.items()}


def figures(scene: Scene, varied: Mapping[str, Any]) -> dict[str, NDArray[np.float64]]:
    """The figures of copies of a scene, as :func:`beadband.model.formula.formula` varies it; arrays of one shape.

    NaN where :func:`figures_of_scene` gives None. UsageError where one of the
    scenes has no answer.
    """
    law, given = scenes_of(scene, varied)
    front: Any = np.nan
    ratio: Any = np.nan
    if not scene.is_strip:
        string = string_limits(law, given["density_kg_m3"], given["strain"], given["half_angle_rad"])
        front, ratio = string.front_speed_m_s, string.mean_speed_ratio
    found = _figures(scene, law, section_of(scene, given).area_m2, given, front, ratio)
    found["peak_strain"] = _peak_strain(law)
    return {key: np.broadcast_to(value, given["strain"].shape) for key, value in found.items()}


def _peak_strain(law: Law) -> Any:
    """Strain from which on a law can't be held, NaN without; of constants that are arrays an array.

    As :meth:`beadband.model.laws.Law.peak_stretch`, where the tension first stops to rise below a stretch of 12.
    """
    if not arrays_of(law):
        longest = longest_held(law)
        return longest - 1.0 if np.isfinite(longest) else np.nan
    with np.errstate(all="ignore"):
        low = np.asarray(law.tangent(1.0), dtype=np.float64) * 0.0 + 1.0
        high = np.full_like(low, np.nan)
        for stretch in np.arange(1.0, _SCAN_UP_TO, _SCAN_STEP):
            rising = np.asarray(law.tangent(stretch + _SCAN_STEP), dtype=np.float64) > 0.0
            high = np.where(np.isnan(high) & ~rising, stretch + _SCAN_STEP, high)
            low = np.where(np.isnan(high), stretch + _SCAN_STEP, low)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            rising = np.asarray(law.tangent(middle), dtype=np.float64) > 0.0
            low, high = np.where(rising, middle, low), np.where(rising, high, middle)
    return 0.5 * (low + high) - 1.0


def _figures(
    scene: Scene, law: Law, area_m2: Any, given: Mapping[str, Any], front_m_s: Any, mean_ratio: Any
) -> dict[str, Any]:
    strain, phi, leg, round_m = (given[key] for key in ("strain", "half_angle_rad", "leg_m", "circumference_m"))
    held, density = 1.0 + strain, given["density_kg_m3"]
    mass, energy = density * area_m2 * round_m, law.energy(held)
    stored, tension = area_m2 * round_m * energy, area_m2 * law.stress(held)
    momentum = string_momentum_n_s(tension, round_m, leg, front_m_s, phi)
    momentum = np.where(one_front(mean_ratio, phi) & (not scene.is_strip), momentum, np.nan)
    radius = np.nan if scene.is_strip else held * leg * np.tan(phi)
    values = (
        mass,
        stored,
        energy / density,
        tension,
        scene.legs * tension * np.cos(phi),
        held * leg * (1.0 / np.cos(phi) + np.tan(phi)),
        radius,
        momentum,
        momentum / mass,
        momentum**2 / (2.0 * mass * stored),
    )
    return dict(zip(FIGURES, values, strict=True))
