"""What a peer is: another program, or another method, that computes the same release."""

from __future__ import annotations

import math
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Protocol, runtime_checkable

import numpy as np

from beadband.analysis.fits import Array, hann_mean, path_slope
from beadband.errors import RunError
from beadband.model.calibration import Strand
from beadband.model.scales import SPEED_WINDOW
from beadband.model.scene import Scene
from beadband.studies.pareto.outcomes import NOT_FINITE
from beadband.studies.pareto.runs import HALF_WIDTH, SHARES, Answer

SAMPLES = 240
"""Times at which a peer writes its rear; evenly from the release to the end of the speed's window."""


@dataclass(frozen=True)
class Trace:
    """What a peer gives back; arrays of shape (samples,), the first sample at the release."""

    times_s: Array
    tip_x_m: Array
    """Place of the tip along the mirror axis, towards the finger."""
    tip_curvature_1_m: Array
    """Turning angle at the tip per reference length."""
    loop_s: float
    """Wall time of the time steps alone."""
    whole_s: float
    """Wall time of everything in a warm process: building the model, its steps, reading the rear. Neither the import of
    the package nor the held shape, which every peer is given."""


@runtime_checkable
class Peer(Protocol):
    """An adapter. One instance serves all scenes; what it needs is imported when it runs."""

    @property
    def name(self) -> str:
        """As charts and tables name it."""

    @property
    def package(self) -> str | None:
        """The importable package that it needs; None for what beadband comes with."""

    @property
    def laws(self) -> tuple[str, ...] | None:
        """Laws that it can be given; None for all."""

    @property
    def ladder(self) -> tuple[int, ...]:
        """Elements of a leg, coarse to fine."""

    @property
    def quick(self) -> tuple[int, ...]:
        """The same for ``--quick``."""

    @property
    def note(self) -> str:
        """How it is set up, in one line."""

    def run(self, scene: Scene, elements: int) -> Trace:
        """Release a leg of so many elements; RunError, or what its package raises, when it fails."""


def installed(peer: Peer) -> bool:
    """Whether the package of a peer can be imported."""
    return peer.package is None or find_spec(peer.package) is not None


def end_s(scene: Scene) -> float:
    """When a peer may stop: the end of the window of the speed."""
    return (SPEED_WINDOW[1] + 0.01) * scene.scales.front_arrival_s


def leg_strand(scene: Scene, elements: int) -> Strand:
    """A leg from the tip to the finger as so many equal elements: mass, stiffness and angle coefficient of each."""
    strand = scene.strand(1000)
    return Strand(
        law=strand.law,
        spacing_m=scene.wedge.reference_leg_m / elements,
        area_m2=strand.area_m2,
        density_kg_m3=strand.density_kg_m3,
        modulus_pa=strand.modulus_pa,
        bending_stiffness_n_m2=strand.bending_stiffness_n_m2,
    )


def steps_of(scene: Scene, largest_s: float) -> tuple[int, int, float]:
    """Samples, steps between them, and the step in s, none longer than ``largest_s``."""
    between = max(1, math.ceil(end_s(scene) / SAMPLES / largest_s))
    step = min(largest_s, end_s(scene) / SAMPLES)
    samples = SAMPLES if between > 1 else math.ceil(end_s(scene) / step)
    return samples, between, end_s(scene) / (samples * between)


def answer_of(scene: Scene, trace: Trace) -> Answer:
    """Rebound speed and windowed tip curvatures of a trace, measured as beadband measures its own."""
    if not (np.all(np.isfinite(trace.tip_x_m)) and np.all(np.isfinite(trace.tip_curvature_1_m))):
        raise RunError("the positions are not finite", NOT_FINITE)
    arrival = scene.scales.front_arrival_s
    try:
        speed = path_slope(trace.times_s, trace.tip_x_m, *(share * arrival for share in SPEED_WINDOW))
        means = [
            hann_mean(trace.times_s, trace.tip_curvature_1_m, share * arrival, HALF_WIDTH * arrival) for share in SHARES
        ]
    except ValueError as error:
        raise RunError(str(error)) from error
    return Answer(speed, (means[0], means[1]))
