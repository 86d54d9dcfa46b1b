"""What a number of beads is worth: measured error curves, and what a run costs.

The curves come from tests/validation/error_curves.py: random scenes (all bands, both laws, strain 0.1-1.4, half-angle
5-30 degrees) released on one leg with 10 to 640 beads to the leg each, against their finest run. The error of
the rebound speed falls on one curve when the bead spacing is taken over the length of what moves at the rear: the
half of the rear segment that the kink has passed when the front arrives, and five times the length sqrt(a_b t_f) over
which bending spreads by then. The curves are the 95 % envelopes of the errors.
"""

from __future__ import annotations

import math

from beadband.law import root
from beadband.scales import bending_layer_m, front_arrival_s
from beadband.scene import Scene
from beadband.wedge import StringLimit

BENDING_SPREAD = 5.0
LEAST_RESOLUTION = 12.0
"""Beads in the rear from which on the curve of the speed is known."""

CURVATURE_SPACING = 0.6
"""Bead spacing over the bending layer at which the windowed tip curvature is right to about one per cent."""
TOLERANCE_OF_SPACING = 0.005
COARSEST_SPACING = 1.0
"""Beyond this share of the bending layer the tip curvature is not measured at all."""
_WIDEST_SPACING = 0.9
_FEW_ERROR = 0.12
_SHARE_OF_LEG = 0.7
_RING_COARSENESS = 1.6
_LAYER_WEIGHT = 10.0

_STEP_S = 10e-6
_BEAD_STEP_S = 0.17e-6
_FRAME_NUMBER_S = 0.6e-6
_COLUMNS = 11
_SETUP_S = {"leg": 0.004, "ring": 0.05}
"""Seconds on one core of a machine of 2024: of a step, a bead and step, a number written, and of beginning."""


def kink_way_m(scene: Scene) -> float:
    """Reference length that a kink has passed when the front arrives, half of the rear segment: l0 e sin/(1 - sin)."""
    sine = math.sin(scene.half_angle_rad)
    return scene.wedge.reference_leg_m * scene.strain * sine / (1.0 - sine)


def rear_length_m(scene: Scene, string: StringLimit) -> float:
    """Reference length of what the beads at the rear must resolve."""
    return kink_way_m(scene) + BENDING_SPREAD * math.sqrt(
        scene.bending_diffusivity_m2_s * front_arrival_s(scene, string)
    )


def leg_speed_error(beads_in_rear: float, beads_in_leg: float, coarseness: float = 1.0) -> float:
    """Relative error of the rebound speed on one leg that 95 % of the scenes stay below.

    The first part is the numerical loss, of the first order in the spacing, for the front has the leg to run along even
    where the rear is as long; the second is what single beads make of the kink (times ``coarseness``), until they are
    too few to be called a curve.
    """
    smooth = min(beads_in_rear, _SHARE_OF_LEG * beads_in_leg)
    error = 0.12 / smooth + coarseness * 0.010 * math.pow(22.0 / beads_in_rear, 4.2)
    # With fewer than a dozen beads errors no longer follow the curve; they grow less steeply.
    return min(error, _FEW_ERROR * math.pow(max(1.0, LEAST_RESOLUTION / beads_in_rear), 2.0))


def speed_error(scene: Scene, string: StringLimit, spacing_m: float, model: str) -> float:
    """Relative error of the rebound speed that 95 % of the scenes stay below, for beads of this spacing."""
    return _speed_error(*_lengths_m(scene, string), spacing_m, model)


def _lengths_m(scene: Scene, string: StringLimit) -> tuple[float, float, float]:
    """What the beads must resolve at the rear, the leg, and where the held ring is sharpest."""
    sharp = kink_way_m(scene) + _LAYER_WEIGHT * bending_layer_m(scene)
    return rear_length_m(scene, string), scene.wedge.reference_leg_m, sharp


def _speed_error(rear_m: float, leg_m: float, sharp_m: float, spacing_m: float, model: str) -> float:
    """The whole ring turns its tip at one bead where the leg turns it by halves.

    It is a little worse everywhere, and much where neither the bending layer nor the way of the kink spans some beads.
    """
    if model == "leg":
        return leg_speed_error(rear_m / spacing_m, leg_m / spacing_m)
    sharp = 0.015 * math.pow(7.0 * spacing_m / sharp_m, 3.0)
    return min(1.0, math.hypot(leg_speed_error(rear_m / spacing_m, leg_m / spacing_m, _RING_COARSENESS), sharp))


def beads_for(scene: Scene, string: StringLimit, model: str) -> float:
    """Beads of the whole ring for which :func:`speed_error` is the scene's tolerance (not rounded)."""
    length, tolerance = scene.band.circumference_m, scene.tolerance
    rear, leg, sharp = _lengths_m(scene, string)
    least = LEAST_RESOLUTION * length / rear

    def surplus(beads: float) -> float:
        return _speed_error(rear, leg, sharp, length / beads, model) - tolerance

    if surplus(least) <= 0.0:
        return least
    return root(surplus, least, 1000.0 * least / tolerance)


def curvature_error(scene: Scene, spacing_m: float) -> float | None:
    """Relative error of the window-averaged tip curvature that 90 % of the scenes stay below; None without a layer."""
    layer = bending_layer_m(scene)
    return 0.067 * (spacing_m / layer) ** 2 if layer > 0.0 and spacing_m <= COARSEST_SPACING * layer else None


def curvature_spacing_m(scene: Scene) -> float:
    """Spacing at which the tip curvature is as good as the tolerance asks; of the second order in the spacing."""
    finer = math.sqrt(scene.tolerance / TOLERANCE_OF_SPACING)
    return min(CURVATURE_SPACING * finer, _WIDEST_SPACING) * bending_layer_m(scene)


def seconds(model: str, beads: int, steps: int, frames: int) -> float:
    """Predicted seconds on one core for relaxing, setting up, integrating and writing frames of the whole ring."""
    return _SETUP_S[model] + steps * (_STEP_S + _BEAD_STEP_S * beads) + frames * beads * _COLUMNS * _FRAME_NUMBER_S
