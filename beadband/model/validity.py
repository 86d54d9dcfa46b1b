"""Where the model ends: scenes that it can't stand for are refused, those near its edge get a notice.

The model is a slender Euler-Bernoulli band of uniform stretch, wound round a finger and held at a point.
"""

from __future__ import annotations

import math

from beadband.errors import UsageError, explain
from beadband.model.laws import Law, Softened, Tensile, Unloading
from beadband.model.scales import SPEED_WINDOW, viscous_front_m
from beadband.model.scene import Scene
from beadband.notices import Notice, notice
from beadband.parameters import TABLE

SHARPEST = 0.5
"""Curvature times half thickness from which beam theory is not accurate."""
SLENDER = 10.0
"""Leg over thickness below which a band is no slender beam."""
WIDE = 5.0
"""Width over thickness from which a strip begins to bend like a plate."""
SMEARED = 0.1
"""Share of the leg over which a loss of the user's may spread the front without a notice."""
SOFT = 0.05
"""Tangent modulus of the held band over that at rest below which it is next to its tension peak."""
FULL = 0.9
"""Share of the wedge's closing, (1 + strain) sin(half-angle), from which the rear hardly unloads."""
LARGE_PEG = 0.2
"""Radius of the peg over the way of a kink up to the front's arrival from which the rear still gains speed then."""
LONG_LAYER = 0.25
"""Share of the leg over which the held tip may bend without a notice."""
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


def validity_notices(scene: Scene) -> tuple[Notice, ...]:
    """How near a scene is to the edge of the model; UsageError where it is past it."""
    check_validity(scene)
    found = _sizes(scene)
    if scene.bending_scale > 0.0:
        found += _bending(scene)
    law, held = scene.material, 1.0 + scene.strain
    found += outside_test(scene, 1.0 + scene.string.residual_strain)
    softness = float(law.tangent(held)) / law.rest_modulus_pa
    if softness < SOFT:
        found.append(notice("soft-at-strain", value=softness, limit=SOFT))
    closing = held * math.sin(scene.half_angle_rad)
    if closing > FULL:
        found.append(notice("wedge-nearly-closed", value=closing, limit=FULL))
    arrival, end = scene.scales.rear_arrival_share, SPEED_WINDOW[1]
    if arrival < end:
        found.append(notice("rear-arrives-early", value=arrival, limit=end))
    if scene.loss_time_s and "loss_time_s" not in scene.planned:
        share = viscous_front_m(scene) / scene.wedge.reference_leg_m
        if share > SMEARED:
            found.append(notice("viscous-front", value=share, limit=SMEARED))
    return tuple(found)


def law_reasons(scene: Scene) -> list[Notice]:
    """How the curve of a tensile test was made, and what the material keeps of the energy put in."""
    found, law, held = [], scene.material, 1.0 + scene.strain
    test = _test_of(law)
    stress = float(law.stress(held))
    if test is not None and test.freedom:
        share = test.scatter_pa / stress
        scatter = test.scatter_pa * 1e-6
        found.append(notice("tensile-curve", value=test.smoothing, freedom=test.freedom, scatter=scatter, share=share))
    lost = law.lost_density_pa(held)
    if lost:
        found.append(notice("lost-in-material", value=lost, share=lost / (lost + float(law.energy(held)))))
    return found


def outside_test(scene: Scene, lowest: float) -> list[Notice]:
    """What a run that unloads to the stretch ``lowest`` needs below the points of its tensile test."""
    law = scene.material.primary if isinstance(scene.material, Softened) else scene.material
    if isinstance(law, Unloading):
        first = law.stretches[0]
        return [notice("tensile-unloading-end", value=lowest, limit=first)] if lowest < first else []
    if not isinstance(law, Tensile) or lowest >= law.measured_from:
        return []
    first = min(law.measured_from, 1.0) if lowest < 1.0 else law.measured_from
    return [notice("tensile-compression" if lowest < 1.0 else "tensile-origin", value=lowest, limit=first)]


def _test_of(law: Law) -> Tensile | None:
    """The tensile test that a law is made of."""
    if isinstance(law, Softened):
        return _test_of(law.primary)
    return law.loading if isinstance(law, Unloading) else law if isinstance(law, Tensile) else None


def _sizes(scene: Scene) -> list[Notice]:
    """Values that can't be a rubber band's: most likely they were given in another unit."""
    found = []
    for key, value in scene.band.properties().items():
        one = TABLE[key]
        if one.usual is not None and not one.usual[0] <= value <= one.usual[1]:
            low, high = one.usual
            name = one.help.split(",")[0].split(";")[0]
            found.append(
                notice("unusual-size", name=name, value=value, low=low, limit=high, unit=one.unit, flag=one.flag)
            )
    return found


def _bending(scene: Scene) -> list[Notice]:
    found = []
    scales, band, wedge = scene.scales, scene.band, scene.wedge
    if scales.tip_sharpness > SHARPEST:
        found.append(notice("sharp-tip", value=scales.tip_sharpness, limit=SHARPEST))
    if scales.peg_share > LARGE_PEG:
        found.append(notice("large-peg", value=scales.peg_share, limit=LARGE_PEG))
    wrapped = 0.5 * held_thickness_m(scene) / wedge.finger_radius_m
    if wrapped > SHARPEST:
        found.append(notice("thick-on-finger", value=wrapped, limit=SHARPEST))
    slender = wedge.reference_leg_m / band.thickness_m
    if slender < SLENDER:
        found.append(notice("not-slender", value=slender, limit=SLENDER))
    layer = scales.bending_layer_m / wedge.reference_leg_m
    if layer > LONG_LAYER:
        found.append(notice("bent-legs", value=layer, limit=LONG_LAYER))
    if band.width_m is not None and band.width_m > WIDE * band.thickness_m:
        stiffer = 1.0 / (1.0 - _POISSON**2)
        found.append(notice("wide-band", value=band.width_m / band.thickness_m, limit=WIDE, stiffer=stiffer))
    return found


def held_thickness_m(scene: Scene) -> float:
    """Thickness of the stretched band, incompressible: h/sqrt(1 + strain)."""
    return scene.band.thickness_m / math.sqrt(1.0 + scene.strain)
