"""What a number of beads is worth: measured error curves, and what a run costs.

The curves come from tests/validation/error_curves.py: random scenes (all bands, both laws, strain 0.1-1.4, half-angle
5-30 degrees) released on one leg with 10 to 640 beads to the leg each, against their finest run. The error of
the rebound speed falls on one curve when the bead spacing is taken over the length of what moves at the rear: the
half of the rear segment that the kink has passed when the front arrives, and five times the length sqrt(a_b t_f) over
which bending spreads by then. The curves are the 95 % envelopes of the errors.
"""

from __future__ import annotations

import math

from beadband.model.roots import root
from beadband.model.scene import Scene

SHARE_OF_TOLERANCE = 0.5
"""Share of the tolerance that the curve may take: the bar that is stated joins it with the error of the fit and the
difference to the coarse run. With all of it 5 % of random scenes state a bar within a tolerance of 0.5 %; of a sweep of
1,008 scenes 65 % with a share of 0.7, and 93 % with this one, for a tenth more of its time."""
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

_SEVERAL_PARTS, _ONE_PART, _SECOND_ORDER = 0.22, 0.1, 2.45
"""Of a strip: errors times bonds behind a wave of several parts and of one, and the root of those times bonds^2."""

_FIT_ERROR = 0.012

_PEG_SPACING = 0.45
"""Spacing over the widest that a peg allows: half as many beads resolve it still."""
_PEG_MATTERS = 1.5

_STEP_S = 10e-6
_BEAD_STEP_S = 0.17e-6
_FRAME_NUMBER_S = 0.6e-6
_COLUMNS = 11
_SETUP_S = {"leg": 0.004, "ring": 0.05, "strip": 0.05}
"""Seconds on one core of a machine of 2024: of a step, a bead and step, a number written, and of beginning."""


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


def strip_speed_error(bonds: float, parts: int) -> float:
    """The same of the recoil speed of a strip of so many bonds (tests/validation/strip.py).

    Behind a wave of one part it is of the second order; the corners between shock and fan leave one of the first.
    """
    return _SEVERAL_PARTS / bonds if parts > 1 else min(_ONE_PART / bonds, (_SECOND_ORDER / bonds) ** 2)


def front_error(bonds: float) -> float:
    """The same of speed and arrival of the front of a strip, beside the difference to a coarse run."""
    return 0.1 / bonds


def speed_error(scene: Scene, spacing_m: float, model: str) -> float:
    """Relative error of the rebound speed that 95 % of the scenes stay below, for beads of this spacing."""
    if model == "strip":
        return strip_speed_error(scene.wedge.reference_leg_m / spacing_m, len(scene.string.wave.parts))
    return _speed_error(*_lengths_m(scene), spacing_m, model)


def _lengths_m(scene: Scene) -> tuple[float, float, float]:
    """What the beads must resolve at the rear, the leg, and where the held ring is sharpest."""
    scales = scene.scales
    sharp = scales.kink_way_m + _LAYER_WEIGHT * scales.bending_layer_m
    return scales.rear_length_m, scene.wedge.reference_leg_m, sharp


def _speed_error(rear_m: float, leg_m: float, sharp_m: float, spacing_m: float, model: str) -> float:
    """The whole ring turns its tip at one bead where the leg turns it by halves.

    It is a little worse everywhere, and much where neither the bending layer nor the way of the kink spans some beads.
    """
    if model == "leg":
        return leg_speed_error(rear_m / spacing_m, leg_m / spacing_m)
    sharp = 0.015 * math.pow(7.0 * spacing_m / sharp_m, 3.0)
    return min(1.0, math.hypot(leg_speed_error(rear_m / spacing_m, leg_m / spacing_m, _RING_COARSENESS), sharp))


def beads_for(scene: Scene, model: str) -> float:
    """Beads of the whole ring for which :func:`speed_error` is the scene's tolerance (not rounded)."""
    length, tolerance = scene.band.circumference_m, scene.tolerance
    if model == "strip":
        parts, share = len(scene.string.wave.parts), SHARE_OF_TOLERANCE * tolerance
        return _SEVERAL_PARTS / share if parts > 1 else min(_ONE_PART / share, _SECOND_ORDER / math.sqrt(share))
    rear, leg, sharp = _lengths_m(scene)
    least = LEAST_RESOLUTION * length / rear

    # Both as logarithms, in which the curve is nearly straight: a few steps find the root.
    def surplus(log_beads: float) -> float:
        return math.log(_speed_error(rear, leg, sharp, length / math.exp(log_beads), model) / share)

    share = SHARE_OF_TOLERANCE * tolerance
    if surplus(math.log(least)) <= 0.0:
        return least
    return math.exp(root(surplus, math.log(least), math.log(1000.0 * least / tolerance)))


def stated_error(scene: Scene, speed_error: float) -> float:
    """Relative error of the rebound speed that a result will state at least, for this error of its beads.

    However fine the beads, the speed of a bending tip is not quite uniform, and the fit of its path says so: by 0.012
    to 0.09 of the bending layer over the leg (random scenes with 1000 beads).
    """
    return math.hypot(speed_error, _FIT_ERROR * scene.scales.bending_layer_m / scene.wedge.reference_leg_m)


def curvature_error(scene: Scene, spacing_m: float) -> float | None:
    """Relative error of the window-averaged tip curvature that 90 % of the scenes stay below; None without a layer."""
    layer = scene.scales.bending_layer_m
    return 0.067 * (spacing_m / layer) ** 2 if layer > 0.0 and spacing_m <= COARSEST_SPACING * layer else None


def curvature_spacing_m(scene: Scene) -> float:
    """Spacing at which the tip curvature is as good as the tolerance asks; of the second order in the spacing."""
    finer = math.sqrt(scene.tolerance / TOLERANCE_OF_SPACING)
    return min(CURVATURE_SPACING * finer, _WIDEST_SPACING) * scene.scales.bending_layer_m


def peg_spacing_m(scene: Scene) -> float:
    """Spacing that the peg needs; inf where V depends on it by less than a quarter of the tolerance, or there is none.

    A peg of the share s = r/(k1 t_f) up to 0.3 changes V by at most 0.1 s^2 (Bands I to III, both laws, half-angles of
    8, 14 and 22 degrees).
    """
    peg, scales = scene.peg, scene.scales
    if peg is None or scales.peg_share <= _PEG_MATTERS * math.sqrt(scene.tolerance):
        return math.inf
    return _PEG_SPACING * peg.widest_m


def seconds(model: str, beads: int, steps: int, frames: int) -> float:
    """Predicted seconds on one core for relaxing, setting up, integrating and writing frames of the whole ring."""
    return _SETUP_S[model] + steps * (_STEP_S + _BEAD_STEP_S * beads) + frames * beads * _COLUMNS * _FRAME_NUMBER_S


_BYTES_A_BEAD = 115
_BYTES_A_REAR_FRAME = 330
_BYTES_A_RING_BEAD = 130
"""Text of a bead in a frame of the ring, of a frame of the rear, and of a bead in the data file (measured)."""


def disk_bytes(beads: int, frames: int, rear_frames: int) -> float:
    """Predicted size of the files of a run, bytes."""
    return beads * (_BYTES_A_BEAD * (frames + 1) + _BYTES_A_RING_BEAD) + _BYTES_A_REAR_FRAME * rear_frames + 250e3
