"""Times and lengths of a scene that decide what can be measured, and how finely it must be computed."""

from __future__ import annotations

import math
from dataclasses import dataclass

from beadband.scene import Scene
from beadband.wedge import StringLimit

# Shares of the front's arrival time over which the rebound speed is the slope of the rear's path.
SPEED_WINDOW = (0.4, 0.85)
# Bending waves have forgotten the held shape after so many l^2/a_b, and feel the residual tension from this share of
# t_x on (see similarity_window).
FORGOTTEN_AFTER = 2.5
WINDOW_BEFORE = 0.25


@dataclass(frozen=True)
class SimilarityWindow:
    """When the tip's curvature may follow t^(-1/2); times in s, NaN without bending."""

    start_s: float
    end_s: float
    reason: str | None
    """Why there is no window, if there is none."""


def similarity_window(scene: Scene, string: StringLimit) -> SimilarityWindow:
    """The self-similar window from the physical scales alone.

    It opens once the beam is slender for its bending waves (h/c0) and has forgotten the held shape
    (2.5 l^2/a_b, l the length of the held bending layer), and closes at a quarter of
    t_x = a_b density (1 + strain1)/stress1, when the residual tension begins to pull the rear straight.
    """
    if scene.bending_stiffness_n_m2 == 0.0:
        return SimilarityWindow(math.nan, math.nan, "without bending there is no curvature to follow")
    diffusivity = scene.bending_diffusivity_m2_s
    start = max(
        scene.band.thickness_m / scene.band.bar_speed_m_s,
        FORGOTTEN_AFTER * bending_layer_m(scene) ** 2 / diffusivity,
    )
    crossover = diffusivity * scene.band.density_kg_m3 * (1.0 + string.residual_strain) / string.residual_stress_pa
    end = min(WINDOW_BEFORE * crossover, front_arrival_s(scene, string))
    if end < 1.5 * start:
        return SimilarityWindow(
            start,
            end,
            f"no self-similar window: the held shape is forgotten only after {start:.3g} s, "
            f"and the residual tension is felt from {end:.3g} s on",
        )
    return SimilarityWindow(start, end, None)


def bending_layer_m(scene: Scene) -> float:
    """Reference length over which the held tip turns into the straight leg, l = sqrt(EI/(T (1 + strain)))."""
    tension = scene.band.area_m2 * float(scene.material.stress(1.0 + scene.strain))
    return math.sqrt(scene.bending_stiffness_n_m2 / (tension * (1.0 + scene.strain)))


def front_arrival_s(scene: Scene, string: StringLimit) -> float:
    """When the front of the string limit has run through a leg, t_f = l0/(front speed)."""
    return scene.wedge.reference_leg_m / string.front_speed_m_s


def viscous_front_m(scene: Scene, string: StringLimit) -> float:
    """Width to which the scene's loss time spreads the front, viscosity over (density x front speed); 0 without one."""
    if scene.loss_time_s is None:
        return 0.0
    band = scene.band
    return band.modulus_pa * scene.loss_time_s / (band.density_kg_m3 * string.front_speed_m_s)
