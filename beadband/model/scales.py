"""Times and lengths of a scene that decide what can be measured, and how finely it must be computed."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from beadband.model.scene import Scene

# Shares of the front's arrival time over which the rebound speed is the slope of the rear's path.
SPEED_WINDOW = (0.4, 0.85)
LATE_WINDOW = (0.7, 0.85)
# Bending waves have forgotten the held shape after so many l^2/a_b, and feel the residual tension from this share of
# t_x on (see similarity_window).
FORGOTTEN_AFTER = 2.5
WINDOW_BEFORE = 0.25
SHORTEST_WINDOW = 1.5
"""Least ratio of the ends of a self-similar window in which a power law can be fitted."""
LONGEST_LAYER = 0.08
"""Bending layer over the leg beyond which the finger is felt at the tip, so that a leg alone won't do."""
BENDING_SPREAD = 5.0
"""Lengths sqrt(a_b t_f) that bending adds to what moves at the rear."""


@dataclass(frozen=True)
class SimilarityWindow:
    """When the tip's curvature may follow t^(-1/2); times in s, NaN without bending."""

    start_s: float
    end_s: float
    bending: bool = True

    @property
    def exists(self) -> bool:
        """Whether the window is long enough to fit a power law in it."""
        return self.bending and self.end_s >= SHORTEST_WINDOW * self.start_s

    @property
    def reason(self) -> str | None:
        """Why there is no window, if there is none."""
        if self.exists:
            return None
        if not self.bending:
            return "without bending there is no curvature to measure"
        return (
            f"no self-similar window: the held shape is forgotten only after {self.start_s:.3g} s, "
            f"and the residual tension is felt from {self.end_s:.3g} s on"
        )


@dataclass(frozen=True)
class Scales:
    """What a scene's answers depend on beside the numbers that were given; SI units, reference lengths."""

    bending_layer_m: float
    """Length over which the held tip turns into the straight leg, l = sqrt(EI/(T (1 + strain)))."""
    bending_diffusivity_m2_s: float
    """a_b = sqrt(EI/(density A))."""
    front_arrival_s: float
    """When the front of the string limit has run through a leg, t_f = l0/(front speed)."""
    bending_spread_m: float
    """sqrt(a_b t_f), over which bending spreads by then."""
    kink_way_m: float
    """Length that a kink has passed by then, half of the rear segment: l0 strain sin/(1 - sin) behind a sharp front."""
    rear_length_m: float
    """Length of what the beads at the rear must resolve: the kink's way and five times the bending spread; of a strip,
    which has neither, all of it."""
    remembered_m: float
    """Reference length over which the held tip is bent: what lies on its peg, and the bending layer."""
    peg_share: float
    """Radius of the peg over the way of a kink up to the front's arrival, r/(k1 t_f); 0 without one."""
    tip_sharpness: float
    """Curvature times half thickness at the held tip: on a peg that of the peg; at a point from the elastica,
    2 sin((pi/2 - phi)/2)/l h/2."""
    rear_arrival_share: float
    """When the rear of the string limit reaches the finger's near side, over t_f."""
    window: SimilarityWindow


def scales_of(scene: Scene) -> Scales:
    """Compute the scales of a scene; use ``scene.scales``, which keeps them."""
    string, wedge, phi = scene.string, scene.wedge, scene.half_angle_rad
    tension = scene.band.area_m2 * float(scene.material.stress(1.0 + scene.strain))
    layer = math.sqrt(scene.bending_stiffness_n_m2 / (tension * (1.0 + scene.strain)))
    diffusivity = scene.bending_diffusivity_m2_s
    arrival = wedge.reference_leg_m / string.front_speed_m_s
    spread = math.sqrt(diffusivity * arrival)
    sine = math.sin(phi)
    # Behind a fan the material is slower, over the speed of the foremost point.
    kink_way = wedge.reference_leg_m * scene.strain * sine / (1.0 - sine) * string.wave.mean_speed_ratio
    way = wedge.leg_m / math.cos(phi) - wedge.finger_radius_m
    peg, thickness, wrapped, share = scene.peg, scene.band.thickness_m, 0.0, 0.0
    if peg is None:
        sharpness = math.sin((math.pi / 2.0 - phi) / 2.0) * thickness / layer if layer > 0.0 else math.inf
    else:
        wrapped, sharpness = peg.wrapped_m, 0.5 * peg.curvature_1_m * thickness
        kink = math.sqrt(string.residual_stress_pa * (1.0 + string.residual_strain) / scene.band.density_kg_m3)
        share = peg.radius_m / (kink * arrival)
        # The straight part between peg and finger is that much shorter, and the way with it.
        way *= 1.0 - math.pi * peg.radius_m / (wedge.leg_m * (1.0 + math.tan(phi) * (math.pi / 2.0 + phi)))
    return Scales(
        bending_layer_m=layer,
        bending_diffusivity_m2_s=diffusivity,
        front_arrival_s=arrival,
        bending_spread_m=spread,
        kink_way_m=kink_way,
        rear_length_m=wedge.reference_leg_m if scene.is_strip else kink_way + BENDING_SPREAD * spread,
        remembered_m=layer + wrapped,
        peg_share=share,
        tip_sharpness=sharpness,
        rear_arrival_share=way / string.rear_speed_m_s / arrival,
        window=_similarity_window(scene, layer + wrapped, diffusivity, arrival),
    )


def _similarity_window(scene: Scene, remembered_m: float, diffusivity: float, arrival_s: float) -> SimilarityWindow:
    """The self-similar window from the physical scales alone.

    It opens once the beam is slender for its bending waves (h/c0) and has forgotten the held shape
    (2.5 l^2/a_b, l the length over which the held tip is bent), and closes at a quarter of
    t_x = a_b density (1 + strain1)/stress1, when the residual tension begins to pull the rear straight.
    """
    if scene.bending_stiffness_n_m2 == 0.0:
        return SimilarityWindow(math.nan, math.nan, bending=False)
    start = max(scene.band.thickness_m / scene.band.bar_speed_m_s, FORGOTTEN_AFTER * remembered_m**2 / diffusivity)
    string = scene.string
    crossover = diffusivity * scene.band.density_kg_m3 * (1.0 + string.residual_strain) / string.residual_stress_pa
    return SimilarityWindow(start, min(WINDOW_BEFORE * crossover, arrival_s))


def viscous_front_m(scene: Scene) -> float:
    """Width to which the scene's loss time spreads the front, viscosity over (density x front speed); 0 without one."""
    if scene.loss_time_s is None:
        return 0.0
    band = scene.band
    return band.modulus_pa * scene.loss_time_s / (band.density_kg_m3 * scene.string.front_speed_m_s)
