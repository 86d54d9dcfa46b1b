"""What a plan or a result reports: a code and its numbers, and one table of the sentences made of them.

A notice is a value. Programs decide on its code and its numbers; the sentence is made where a person reads it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cache
from string import Formatter
from typing import Any


@dataclass(frozen=True)
class Notice:
    """One warning, reason or failed check: ``code`` is a key of :data:`SENTENCES`, ``values`` fill its sentence.

    By convention ``value`` is the number that decided and ``limit`` what it was compared with.
    """

    code: str
    values: Mapping[str, Any] = field(default_factory=dict)

    @property
    def sentence(self) -> str:
        """The notice as a person reads it."""
        return _FORMATTER.vformat(SENTENCES[self.code], (), self.values)

    def __str__(self) -> str:
        return self.sentence

    def __hash__(self) -> int:
        return hash((self.code, tuple(sorted(self.values.items()))))


def percent(value: float, digits: int = 2) -> str:
    """A share as a percentage to so many significant digits: "0.018 %"."""
    places = digits - 1 - math.floor(math.log10(abs(100.0 * value))) if value and math.isfinite(value) else 0
    return f"{100.0 * value:.{max(0, places)}f} %"


def distinct_digits(value: float, limit: float, fewest: int = 2) -> int:
    """Significant digits, ``fewest`` or more, from which a value and its limit read differently as percentages."""
    return next((n for n in range(fewest, 15) if percent(value, n) != percent(limit, n)), fewest)


class _Formatter(Formatter):
    """Formats as ``str.format`` does, and ``{share:2p}`` as a percentage to two significant digits."""

    def format_field(self, value: Any, format_spec: str) -> Any:
        if format_spec.endswith("p"):
            return percent(value, int(format_spec[:-1]))
        return super().format_field(value, format_spec)


_FORMATTER = _Formatter()


def notice(code: str, **values: Any) -> Notice:
    """A notice of the table; KeyError for a code that it does not hold."""
    # A value that its sentence lacks shows here, not at the reader's; the sentence itself is made there.
    lacking = _needed(code) - values.keys()
    if lacking:
        raise KeyError(*sorted(lacking))
    return Notice(code, values)


@cache
def _needed(code: str) -> frozenset[str]:
    """Names of the values in the sentence of a code."""
    return frozenset(name for _, name, _, _ in _FORMATTER.parse(SENTENCES[code]) if name)


def sentences(notices: tuple[Notice, ...] | list[Notice]) -> list[str]:
    """The notices as people read them."""
    return [one.sentence for one in notices]


SENTENCES: dict[str, str] = {
    # The plan's reasons
    "beads-for-curvature": "{beads} beads: the held tip bends over a layer of {layer_mm:.3g} mm, and the tip curvature "
    "needs beads closer than {value:.2g} of it ({spacing_mm:.3g} mm); the speed alone needs {for_speed}",
    "beads-for-launch": "{beads} beads: the numerical loss spreads a front that is no shock, and they keep what it "
    "takes from the throw below {limit:.2g} % of its energy",
    "beads-for-speed": "{beads} beads: the moving rear is {rear_mm:.3g} mm long, and the rebound speed needs "
    "{value:.3g} beads in it for {limit:.2g} %",
    "beads-for-peg": "{beads} beads: V depends on the peg, which needs beads every {value:.3g} mm round it; the moving "
    "rear alone needs {for_speed}",
    "beads-for-hand": "{beads} beads: the peak force on the hand needs them",
    "tolerance-auto": "tolerance {value:.2g} %: a fifth of the error of V from the inputs, {limit:.2g} %; the "
    "usual 0.5 % would take {saved:.2g} times the beads for V",
    "beads-for-strip": "{beads} bonds over {rear_mm:.3g} mm of strip: the recoil speed needs {value:.3g} for "
    "{limit:.2g} %",
    "strip": "the whole strip, straight: after the arrival of the front at the held end the strip would be compressed "
    "and buckle, so the run ends there",
    "loss": "loss time {value:.3g} s: {limit} of the front's time from bead to bead, enough to give it a smooth "
    "profile of a few beads, and vanishing with the mesh",
    "loss-without-shock": "loss time {value:.3g} s: {limit:.2g} of the front's time from bead to bead; this law "
    "unloads without a shock, so the loss vanishes with the square of the spacing",
    "step": "step {step_s:.3g} s: {value:.2f} of the largest stable one, {steps} steps to {end_s:.4g} s, {end:.2f} of "
    "the front's arrival",
    "no-bending": "no bending: --bending-scale is 0",
    "bending-for-curvature": "bending is kept: the tip curvature is governed by bending, which spreads over "
    "{value:.3g} mm by the front's arrival, against {limit:.3g} mm of rear; without it V would be the string's, "
    "{string:.4g} m/s",
    "bending-for-speed": "bending is kept: it rounds the kinks, and spreads over {value:.3g} mm by the front's "
    "arrival, against {limit:.3g} mm of rear; without it V would be the string's, {string:.4g} m/s",
    "on-peg": "the tip lies on a peg of {radius_mm:.3g} mm radius, {value:.2g} of each leg, and leaves it at "
    "{angle:.3g} deg to the leg; by itself a point-held tip bends to {limit:.3g} mm",
    "peg-at-tip": "the peg of {radius_mm:.3g} mm radius touches the tip alone, which bends to {limit:.3g} mm by itself "
    "and is held as at a point",
    "peg-unresolved": "the beads are {value:.3g} mm apart, too far for a peg of {radius_mm:.3g} mm radius, which needs "
    "{limit:.3g} mm: the tip is held as at a point",
    "one-leg": "one leg, {bonds} of the {beads} bonds: the other is its mirror image, and what lies beyond "
    "{value:.2f} of the leg is outside the domain of dependence; no finger, no wrapped arc, no contact",
    "whole-ring": "the whole ring, because the trajectory is written; the beads on the finger stay where they are and "
    "no contact is computed, since the disturbance arrives there with the front (V alone needs one leg up to "
    "{value:.2f})",
    "frames": "{frames} frames of the whole band, and {rear} of its rear, each an average over {value} steps, because "
    "bead-scale modes would alias",
    "samples": "{rear} frames of the rear, each an average over {value} steps, because bead-scale modes would alias",
    "launch-step": "step {step_s:.3g} s: {value:.2f} of the largest stable one for bonds as short as {limit:.2f} of "
    "their length, where the two fronts meet, and beads on the finger",
    "finger-stiffness": "finger: {value:.3g} N/m for each bead, {phase:.2f} of a radian in a step",
    "self-contact": "contact of the band with itself at {thickness_mm:.3g} mm, {stiffness:.3g} N/m for two beads, from "
    "{value:.3g} s on: before the fronts meet all of the band is pulled, and no two parts can touch",
    "self-contact-coarse": "no contact of the band with itself: its beads are {value:.2g} of the thickness apart; up "
    "to {limit:g} they keep its parts from passing between each other",
    "self-contact-many": "no contact of the band with itself: {value:.0f} beads, and it is computed for up to {limit}",
    "self-contact-never": "no contact of the band with itself: the rear arrives at {value:.3g} s, before the fronts "
    "meet at {limit:.3g} s and parts of the band can touch",
    "launch-frames": "{frames:.0f} frames of the ring, and {rear:.0f} of its rear and of the finger, until the "
    "string's rear arrives; at most {steps} steps",
    "tensile-curve": "tensile test: smoothed with a strength of {value:.2g}, which leaves the curve {freedom:.1f} "
    "degrees of freedom; its points scatter by {scatter:.2g} MPa about it, {share:.1e} of the held stress",
    "lost-in-material": "{value:.3g} J/m3 lies between the loading and the unloading curve, {share:2p} of the energy "
    "of loading: it stays in the material and is not part of the stored energy",
    # Validity of the model
    "unusual-size": "the {name} ({value:.4g} {unit}) is not that of a rubber band, usually {low:.4g} to {limit:.4g} "
    "{unit}: sizes are in SI units; check {flag}",
    "soft-at-strain": "the held band is next to its tension peak: its tangent modulus is {value:.2g} of that at rest, "
    "so a small error of the law has a large effect",
    "wedge-nearly-closed": "the wedge is nearly as wide as it can be, (1 + strain) sin(half-angle) = {value:.3g} of at "
    "most 1: the rear hardly unloads",
    "rear-arrives-early": "the rear would meet the finger at {value:.2f} of the front's arrival, before {limit} of it, "
    "when its speed is measured: in this model the rear passes through the finger",
    "viscous-front": "this loss spreads the unloading front over {value:.2g} of a leg: what is measured is a viscous "
    "band, not the limit of small loss",
    "sharp-tip": "the held tip has (curvature x half thickness) = {value:.2g}: beam theory is not accurate for it "
    "until the curvature has fallen",
    "large-peg": "the peg is large, (radius / way of a kink up to the front's arrival) = {value:.2g} of at most "
    "{limit:.2g}: the speed of the rear still changes while it is measured (see the late speed)",
    "thick-on-finger": "the band is thick for its finger, (half thickness / radius) = {value:.2g}: beam theory is not "
    "accurate there",
    "not-slender": "the legs are only {value:.2g} times as long as the band is thick: it is not a slender beam",
    "bent-legs": "the held tip bends over {value:.2g} of a leg: its legs are straight nowhere, so the wedge and its "
    "string limit do not describe this band",
    "wide-band": "the band is {value:.2g} times as wide as thick and may bend like a plate, up to {stiffer:.2g} times "
    "as stiffly as the beam computed here",
    "tensile-origin": "the band unloads to a stretch of {value:.4g}, below the first measured one, {limit:.4g}: from "
    "rest to there the stress is that of the smoothed curve through zero",
    "tensile-compression": "the band is compressed to a stretch of {value:.3g}, and the tensile test begins at "
    "{limit:.4g}: the stress is continued with the slope there",
    "tensile-unloading-end": "the band unloads to a stretch of {value:.4g}, below the last point of the unloading "
    "curve, {limit:.4g}: the stress is continued with the slope there",
    # The plan's warnings
    "unresolved-layer": "the bending layer of the held tip ({layer_mm:.3g} mm) is finer than the beads "
    "({spacing_mm:.3g} mm): the tip curvature is not resolved",
    "layer-needs-more-beads": "the bending layer of the held tip is only {layer_mm:.3g} mm: the tip curvature would "
    "need {value:.0f} beads and is not resolved (set --beads to override)",
    "speed-needs-more-beads": "the rebound speed would need {value:.0f} beads for {tolerance:.2g} %; the "
    "plan stops at {limit} (set --beads to override)",
    "tolerance-not-expected": "the error expected of the rebound speed, {value:{digits}p}, is above the tolerance "
    "of {limit:{digits}p}",
    "frames-adjusted": "{value} frames instead of {limit}: the {steps} steps are divided evenly among the frames",
    "lossless-shock": "this law unloads through a shock, and a loss of {value:.2g} of the front's time from bead to "
    "bead does not resolve it: it rings, and the rebound speed is about 1 % too low whatever the number of beads",
    "hand-is-hit": "without bending the rear would arrive {value:.3g} s before the finger is free: the hand is hit",
    # Results
    "no-second-run": "the error of the rebound speed is the expected one, because there is no coarse run to estimate "
    "it from ({why})",
    "above-tolerance": "the error of the rebound speed, {value:{digits}p}, is above the tolerance of {limit:{digits}p}",
    "ladder-ends": "the error of the answer, {value:{digits}p}, is above the tolerance of {limit:{digits}p}: it is the "
    "best to be had, with {beads:.0f} beads; a finer level would take too long",
    "several-roots": "{value} values of {name} give this speed: this is the lowest; the next is near {limit:.4g}",
    "no-arrival": "the rear did not reach the finger within {value:.4g} s: there is no pause to report",
    "hit-while-loaded": "the rear reached the finger before the finger had been free of load for {value:.3g} s: there "
    "is no pause, the hand is hit",
    "hand-hit": "the rear hits the hand at {value:.2f} m/s, after {time_s:.4g} s and {way_mm:.3g} mm of its way",
    "hand-not-hit": "the rear did not hit the hand within {limit:g} times its arrival at a fixed finger",
    "hand-hit-unsure": "with {beads} beads the hand is {other}: it is close to the line between hit and not hit, and "
    "what it felt has no error",
    "finger-not-cleared": "the finger was never free of load and was not taken away: the flight is left out",
    "touched-again": "the band touched the free finger again, {count} time(s) from {start_s:.4g} s on, and {way} "
    "{value:2p} of its momentum",
    "no-flight": "no flight is computed: the finger was never free of the band, which is not thrown",
    "touches-itself": "parts of the band touch each other from {value:.4g} s on",
    "crosses-itself": "the band crosses itself from {value:.4g} s on: contact between its parts is off",
    "buckled-aside": "the compressed band buckled to one side: its rear left the axis by up to {value:.3g} m",
    # Studies of many scenes
    "indices-of-errors": "single values have errors of up to {value:.2g} of their standard deviation over the ranges: "
    "the indices are in part those of these errors; lower --tolerance or widen the ranges",
    "design-on-bound": "{name} is at the {value} end of its range, {limit}: a better band may lie beyond",
    "design-at-edge": "the optimum lies {value:.2g} from the edge of what can be held or described: a better band may "
    "lie beyond it",
    "design-indifferent": "{name} changes neither the goal nor what is kept: its value is arbitrary",
    "throw-without-bending": "the throw was made best in the string limit, without bending; a run of it with bending "
    "gives {value:.4g}{unit}, {share:+.1%}",
    "design-not-confirmed": "the optimum was had as {value:.4g}{unit}, and a run of it gives {limit:.4g}{unit}: more "
    "than both errors apart",
    # Fits of laws to a tensile test
    "fit-undetermined": "the test does not determine {name}: its standard error is {value:.2g} of it",
    "fit-peak": "the tension of this fit peaks at a stretch of {value:.4g}, within the test, which goes to "
    "{limit:.4g}: scenes held beyond it are refused",
    "fit-poor": "the fit is off by {value:+.1%} of the stress at a stretch of {stretch:.3g}, more than the "
    "{limit:.1%} that noise explains: V goes by the stress there",
    # Methods of the pareto study
    "other-limit-by-design": "converges to the {limit} by construction, V {gap:+.3%}; {value:.3%} from that at its "
    "finest",
    "stalled-off-limit": "its two finest runs differ by {change:.3%} and stay {value:.3%} from the limit",
    "not-improving": "still {value:.3%} from the limit with {beads} beads, {coarse:.3%} with {coarse_beads}",
    "fails-when-refined": "fails from {value} beads on",
    "unstable-unnoticed": "V is wrong by {value:.0%}: the step is beyond the largest stable one",
    # Launch maps
    "hit-before-free": "the rear reached the finger {value:.3g} s before the string's finger is free: the hand is hit",
    "hit-before-idle": "the rear reached the finger before the finger had been free of load for {value:.3g} s: the "
    "pause is counted from the time at which the string's finger is free",
    # Failed checks of physics
    "energy-unbalanced": "energy is not balanced: {value:.2g} of the stored energy is unaccounted for, allowed "
    "{limit:.2g}",
    "asymmetric": "the release is not symmetric: the tip left the axis by {value:.2g} of the leg, allowed {limit:.2g}",
    "not-converged": "the rebound speed is not converged: with {beads} beads its error is {value:.2g} of it, allowed "
    "{limit:.2g}; raise --beads or leave it out",
    "too-deep": "beads sink into the finger by {value:2p} of the thickness, allowed {limit:2p}: lower --timestep for "
    "a stiffer finger",
    "overlaps-itself": "parts of the band overlap by {value:2p} of the thickness, allowed {limit:2p}: lower --timestep "
    "for a stiffer contact",
    "crossed-itself": "the band crosses itself in {value:.0f} frame(s) in spite of the contact between its parts, "
    "allowed {limit:.0f}: raise --beads or lower --timestep",
    "momentum-unbalanced": "the momentum and the impulse of what holds the band differ by {value:.2g} of the "
    "momentum, allowed {limit:.2g}",
    "hand-unbalanced": "momentum and impulses of the hand differ by {value:.2g} of the band's momentum, allowed "
    "{limit:.2g}",
    # Likely causes of a divergence
    "step-beyond-limit": "a time step beyond the limit of stability (it is {value:.3g} of the predicted one)",
    "step-at-limit": "a time step at the limit of stability (bonds alternate in {way} from bead to bead)",
    "bead-scale-ringing": "ringing or compression at the scale of the beads, which a front leaves behind where the "
    "loss is too small",
    "overstretched": "a stretch that the held band never had: bending stiffer than its bonds, or a start out of "
    "balance",
}
"""Every sentence that a plan or a result can carry, by its code."""
