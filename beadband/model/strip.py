"""The exact release of a strip: the wave that leaves its free end, at every time the same shape over distance/time."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from beadband.model.laws.unloading import FAN
from beadband.model.scene import Scene

Array = NDArray[np.float64]


def front_level(scene: Scene) -> float:
    """Stretch halfway through the foremost part of the wave: what is followed as its front."""
    part = scene.string.wave.parts[0]
    return 0.5 * (part.ahead + part.behind)


def front_speed_m_s(scene: Scene) -> float:
    """Speed of that stretch in reference length, m/s: of a shock its own, within a fan sqrt(tangent/density)."""
    part = scene.string.wave.parts[0]
    if part.kind != FAN:
        return part.front_speed_m_s
    return float(_fan_speed(scene, np.array(front_level(scene))))


def profile(scene: Scene, points: int = 100) -> tuple[Array, Array]:
    """The wave from its foremost point to the last: distance from the free end over time, m/s, and stretch there.

    Distances are those in the unstretched strip; a fan has so many ``points``, a shock two at one distance.
    """
    places, stretches = [], []
    for part in scene.string.wave.parts:
        count = points if part.kind == FAN else 2
        along = np.linspace(part.ahead, part.behind, count)
        stretches.append(along)
        places.append(_fan_speed(scene, along) if part.kind == FAN else np.full(count, part.front_speed_m_s))
    return np.concatenate(places), np.concatenate(stretches)


def _fan_speed(scene: Scene, stretch: Array) -> Array:
    tangent = np.asarray(scene.material.tangent(stretch), dtype=np.float64)
    return np.asarray(np.sqrt(np.maximum(tangent, 0.0) / scene.band.density_kg_m3), dtype=np.float64)
