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
from beadband.model.string_arrays import string_limits

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

    None where there is no such strain, and for those of the throw where its closed form does not hold.
    """
    given = {"strain": scene.strain, "half_angle_rad": scene.half_angle_rad, "leg_m": scene.wedge.reference_leg_m}
    given |= {key: getattr(scene.band, key) for key in ("circumference_m", "density_kg_m3")}
    found = _figures(
        scene.material, scene.band.area_m2, given, scene.string.front_speed_m_s, scene.string.wave.mean_speed_ratio
    )
    found["peak_strain"] = longest_held(scene.material) - 1.0
    return {key: float(value) if np.isfinite(value) else None for key, value in found.items()}


def figures(scene: Scene, varied: Mapping[str, Any]) -> dict[str, NDArray[np.float64]]:
    """The figures of copies of a scene, as :func:`beadband.model.formula.formula` varies it; arrays of one shape.

    Those of the throw are NaN where its closed form does not hold. UsageError where one of the scenes has no answer.
    """
    law, given = scenes_of(scene, varied)
    string = string_limits(law, given["density_kg_m3"], given["strain"], given["half_angle_rad"])
    found = _figures(law, section_of(scene, given).area_m2, given, string.front_speed_m_s, string.mean_speed_ratio)
    return {key: np.broadcast_to(value, given["strain"].shape) for key, value in found.items()}


def _figures(law: Law, area_m2: Any, given: Mapping[str, Any], front_m_s: Any, mean_ratio: Any) -> dict[str, Any]:
    strain, phi, leg, round_m = (given[key] for key in ("strain", "half_angle_rad", "leg_m", "circumference_m"))
    held, density = 1.0 + strain, given["density_kg_m3"]
    mass, energy = density * area_m2 * round_m, law.energy(held)
    stored, tension = area_m2 * round_m * energy, area_m2 * law.stress(held)
    momentum = string_momentum_n_s(tension, round_m, leg, front_m_s, phi)
    momentum = np.where(one_front(mean_ratio, phi), momentum, np.nan)
    values = (
        mass,
        stored,
        energy / density,
        tension,
        2.0 * tension * np.cos(phi),
        held * leg * (1.0 / np.cos(phi) + np.tan(phi)),
        held * leg * np.tan(phi),
        momentum,
        momentum / mass,
        momentum**2 / (2.0 * mass * stored),
    )
    return dict(zip(FIGURES, values, strict=True))
