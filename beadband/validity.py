"""Where the model ends: scenes that it can't stand for are refused, those near its edge get a sentence with the number.

The model is a slender Euler-Bernoulli band of uniform stretch, wound round a finger and held at a point.
"""

from __future__ import annotations

import math

from beadband.errors import UsageError, explain
from beadband.scales import SPEED_WINDOW, bending_layer_m, front_arrival_s, viscous_front_m
from beadband.scene import Scene

SHARPEST = 0.5
"""Curvature times half thickness from which beam theory is not accurate."""
SLENDER = 10.0
"""Leg over thickness below which a band is no slender beam."""
WIDE = 5.0
"""Width over thickness from which a strip begins to bend like a plate."""
SMEARED = 0.1
"""Share of the leg over which a loss of the user's may spread the front without a word."""
SOFT = 0.05
"""Tangent modulus of the held band over that at rest below which it is next to its tension peak."""
FULL = 0.9
"""Share of the wedge's closing, (1 + strain) sin(half-angle), from which the rear hardly unloads."""
_POISSON = 0.5


def check_validity(scene: Scene) -> None:
    """Refuse a scene that the model can't stand for; UsageError with the number that decides.

    What has no answer at all (a wedge that does not close, a stretch beyond the tension peak) :func:`scene_of`
    refuses before.
    """
    if scene.bending_scale == 0.0:
        return  # a string has no thickness
    radius, half = scene.wedge.finger_radius_m, 0.5 * held_thickness_m(scene)
    if radius <= half:
        raise UsageError(
            explain(
                "the band is too thick for its finger",
                f"a radius of {radius:.3g} m to the middle of a band of half thickness {half:.3g} m",
                "a radius above the half thickness",
                "raise --half-angle or lower --thickness",
            )
        )
    leg, thickness = scene.wedge.reference_leg_m, scene.band.thickness_m
    if leg <= thickness:
        raise UsageError(
            explain(
                "the legs are shorter than the band is thick",
                f"a leg of {leg:.3g} m, thickness {thickness:.3g} m",
                f"a leg above the thickness, better {SLENDER:g} times it",
                "lower --thickness or --half-angle",
            )
        )


def validity_warnings(scene: Scene) -> tuple[str, ...]:
    """Sentences on how near a scene is to the edge of the model; UsageError where it is past it."""
    check_validity(scene)
    found: list[str] = []
    if scene.bending_scale > 0.0:
        found += _bending(scene)
    law, held = scene.material, 1.0 + scene.strain
    softness = float(law.tangent(held)) / law.rest_modulus_pa
    if softness < SOFT:
        found.append(
            f"the held band is next to its tension peak: its tangent modulus is {softness:.2g} of that at rest, and a "
            "small error of the law moves the answer much"
        )
    closing = held * math.sin(scene.half_angle_rad)
    if closing > FULL:
        found.append(
            f"the wedge is nearly as wide as it can be, (1 + strain) sin(half-angle) = {closing:.3g} of at most 1: the "
            "rear hardly unloads"
        )
    arrival, end = rear_arrival_share(scene), SPEED_WINDOW[1]
    if arrival < end:
        found.append(
            f"the rear would meet the finger at {arrival:.2f} of the front's arrival, before {end} of it, when its "
            "speed is known: what is released here passes through the finger"
        )
    if scene.loss_time_s and "loss_time_s" not in scene.planned:
        share = viscous_front_m(scene, scene.string) / scene.wedge.reference_leg_m
        if share > SMEARED:
            found.append(
                f"this loss spreads the unloading front over {share:.2g} of a leg: what is measured is a viscous band, "
                "not the limit of small loss"
            )
    return tuple(found)


def rear_arrival_share(scene: Scene) -> float:
    """When the rear of the string limit reaches the finger's near side, over the front's arrival at the finger."""
    wedge, string = scene.wedge, scene.string
    way = wedge.leg_m / math.cos(scene.half_angle_rad) - wedge.finger_radius_m
    return way / string.rear_speed_m_s / front_arrival_s(scene, string)


def _bending(scene: Scene) -> list[str]:
    found = []
    sharpness = held_tip_sharpness(scene)
    if sharpness > SHARPEST:
        found.append(
            f"the held tip has (curvature x half thickness) = {sharpness:.2g}: beam theory is not accurate for it "
            "until the curvature has fallen"
        )
    band, wedge = scene.band, scene.wedge
    thickness = held_thickness_m(scene)
    wrapped = 0.5 * thickness / wedge.finger_radius_m
    if wrapped > SHARPEST:
        found.append(
            f"the band is thick for its finger, (half thickness / radius) = {wrapped:.2g}: beam theory is not accurate "
            "there"
        )
    slender = wedge.reference_leg_m / band.thickness_m
    if slender < SLENDER:
        found.append(f"the legs are only {slender:.2g} times as long as the band is thick: it is no slender beam")
    layer = bending_layer_m(scene) / wedge.reference_leg_m
    if layer > 0.25:
        found.append(
            f"the held tip bends over {layer:.2g} of a leg: its legs are nowhere straight, and the wedge and its "
            f"string "
            "limit are not this band's"
        )
    if band.width_m is not None and band.width_m > WIDE * band.thickness_m:
        plate = 1.0 / (1.0 - _POISSON**2)
        found.append(
            f"the band is {band.width_m / band.thickness_m:.2g} times as wide as thick and may bend like a plate, up "
            f"to {plate:.2g} times as stiffly as the beam computed here"
        )
    return found


def held_thickness_m(scene: Scene) -> float:
    """Thickness of the stretched band, incompressible: h/sqrt(1 + strain)."""
    return scene.band.thickness_m / math.sqrt(1.0 + scene.strain)


def held_tip_sharpness(scene: Scene) -> float:
    """Curvature times half thickness at the point-held tip, from the elastica: 2 sin((pi/2 - phi)/2)/l x h/2."""
    return math.sin((math.pi / 2.0 - scene.half_angle_rad) / 2.0) * scene.band.thickness_m / bending_layer_m(scene)
