"""The ladder to one number: what each level of beads would cost and state, and which one to run next.

A level is a number of beads, four of them to a factor of two. What the errors of a level are like was measured on 110
random scenes (all bands, both laws, half of them of another thickness) released with 24 to 1300 beads in the rear
(tests/validation/level_errors.py): one part falls smoothly, with a clean order at first (the first where a shock needs
loss, the second elsewhere) and another above it; the rest changes from level to level as if by chance, and less the
better the bending layer is resolved. :func:`beadband.analysis.convergence.limit_of` joins the levels: their mean is
carried on to no spacing as far as the smooth part stands out of the rest.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from beadband.analysis.convergence import Limit, limit_of
from beadband.model.scales import LONGEST_LAYER
from beadband.planning import error_curves
from beadband.planning.plan import FEWEST_LEG_BONDS, Plan, plan_of

if TYPE_CHECKING:
    from beadband.model.scene import Scene

Array = NDArray[np.float64]

COVERS = 4.0
"""Standard errors in a stated error: so many hold 99 % of the true ones, whose distribution has long tails."""
FORMULA_COVERS = 2.4
"""The same in the bar of the formula."""
AIM = 0.95
"""Share of the tolerance that a level is expected to state before it is run: levels may scatter more than expected."""
MOST_BEADS = 24_000
MOST_SECONDS = 120.0
"""Beads and predicted seconds of a level beyond which the ladder ends, unless less is asked for."""


@dataclass(frozen=True)
class LevelErrors:
    """Relative standard errors of V with 100 beads in the rear, one to the bending layer, and a rear of 0.3 legs."""

    smooth: float
    """Falls with the order of the clean part."""
    higher: float
    """Falls with the order above it."""
    noise: float
    noise_order: float
    unresolved: float
    resolved: float
    """Powers of the spacing over the bending layer with which the noise falls besides, above one and below."""
    rear: float
    """Power of the rear over the leg."""


LEVEL_ERRORS = {
    1.0: LevelErrors(2.2e-4, 1.5e-4, 7.9e-5, 1.29, 0.74, 1.20, 0.6),
    2.0: LevelErrors(2.1e-4, 4.2e-5, 1.2e-4, 1.06, 0.68, 1.11, 0.5),
}
"""By the order of the clean part: bands that lose less ring more. By maximum likelihood."""
_BEADS_IN_REAR, _REAR_OF_LEG = 100.0, 0.3
_ALIKE, _RANGE = 0.5, 0.45
"""Correlation of the noise of neighbouring levels, and the difference in ln(beads) over which it is lost."""
_CURVATURE_NOISE, _CURVATURE_DRIFT = 0.010, 0.006
"""The same of the windowed tip curvature with one bead to the bending layer; both fall with the second order."""
_RING_COARSENESS = 1.6
"""Errors of a ring, which turns its tip at one bead, over those of a leg."""
_PEG_COARSENESS = 2.0
"""Errors of scenes with a peg, on which bead after bead comes to lie, over those of others: 1.2 to 2.4 at the spacings
of answers to 0.5 and 0.2 % (70 random scenes)."""
_LEG_ERRORS = {"cut": 1.6e-4, "whole": 7e-5}
_LEG_SPREAD, _LEG_POWER = 0.09, 2.3
_MODEL_SHARE = {"cut": 0.35, "whole": 0.5}
"""Bounds of the difference of V between one leg and the ring, cut where the disturbance ends or whole up to the finger,
where the bending spread is 0.09 of the leg; its power; and the share of the tolerance that it may take. Short bending
waves run ahead of the front and come back from the finger. Measured with up to 1600 beads: whole legs differ by 0.3e-4
to 0.9e-4 at a spread of 0.09 to 0.1, cut ones by 1.3e-4, 3e-4 and 1e-3 at 0.083, 0.14 and 0.21."""
THREE_FROM = 1e-3
"""Tolerance below which three levels must agree."""
_OCTAVE = 4
"""Levels from a number of beads to its double."""


@dataclass(frozen=True)
class Question:
    """One number of a scene, and how well it is asked for."""

    scene: Scene
    """Without beads or steps."""
    quantity: str
    """"speed" or "curvature"."""
    tolerance: float
    most_seconds: float = MOST_SECONDS
    """Predicted seconds of a level beyond which the ladder ends."""

    @property
    def reach(self) -> str:
        """The cheapest that will do: a leg "cut" or "whole", or the "ring"."""
        scales, leg = self.scene.scales, self.scene.wedge.reference_leg_m
        if scales.bending_layer_m > LONGEST_LAYER * leg:
            return "ring"
        if self.quantity == "curvature":
            return "cut"
        fitting = (one for one, share in _MODEL_SHARE.items() if self._leg_error(one) <= share * self.tolerance)
        return next(fitting, "ring")

    @property
    def model(self) -> str:
        """The model of its plans, "leg" or "ring"."""
        return "ring" if self.reach == "ring" else "leg"

    def _leg_error(self, reach: str) -> float:
        spread = self.scene.scales.bending_spread_m / self.scene.wedge.reference_leg_m
        return _LEG_ERRORS[reach] * float(max(spread / _LEG_SPREAD, 0.3) ** _LEG_POWER)

    @property
    def model_error(self) -> float:
        """Relative error bound of the number from the model alone."""
        reach = self.reach
        return 0.0 if reach == "ring" or self.quantity == "curvature" else self._leg_error(reach)

    @property
    def order(self) -> float:
        """Order of the clean part of the errors."""
        return 1.0 if self.quantity == "speed" and self.scene.string.wave.shocks else 2.0

    @property
    def least_beads(self) -> int:
        """Beads of the coarsest level."""
        scene, length = self.scene, self.scene.band.circumference_m
        fewest = [FEWEST_LEG_BONDS * length / scene.wedge.reference_leg_m, 24.0]
        fewest.append(0.5 * length / error_curves.peg_spacing_m(scene))
        if self.quantity == "speed":
            fewest.append(2.0 * error_curves.LEAST_RESOLUTION * length / scene.scales.rear_length_m)
        else:
            fewest.append(length / (error_curves.COARSEST_SPACING * scene.scales.bending_layer_m))
        return 2 * math.ceil(0.5 * max(fewest))

    def beads(self, level: int) -> int:
        """Beads of a level, from 0."""
        return 2 * round(0.5 * self.least_beads * float(2.0 ** (level / _OCTAVE)))

    def covariance(self, beads: Array) -> Array:
        """Of the relative errors of levels with so many beads (levels,); shape (levels, levels)."""
        scene = self.scene
        spacing, layer = scene.band.circumference_m / beads, scene.scales.bending_layer_m
        if self.quantity == "curvature":
            squared = (spacing / layer) ** 2
            return np.outer(squared, squared) * _CURVATURE_DRIFT**2 + np.diag((_CURVATURE_NOISE * squared) ** 2)
        rear, errors = scene.scales.rear_length_m, LEVEL_ERRORS[self.order]
        coarse = _BEADS_IN_REAR * spacing / rear
        share = spacing / layer if layer > 0.0 else np.ones_like(spacing)
        noise = errors.noise * coarse**errors.noise_order
        noise = noise * share ** np.where(share > 1.0, errors.unresolved, errors.resolved)
        noise = noise * (rear / (_REAR_OF_LEG * scene.wedge.reference_leg_m)) ** errors.rear
        apart = np.log(beads[:, None] / beads) / _RANGE
        alike = _ALIKE * np.exp(-0.5 * apart**2) + (1.0 - _ALIKE) * np.eye(len(beads))
        smooth, higher = errors.smooth * coarse**self.order, errors.higher * coarse ** (self.order + 1.0)
        found = np.outer(smooth, smooth) + np.outer(higher, higher) + np.outer(noise, noise) * alike
        worse = (_RING_COARSENESS if self.model == "ring" else 1.0) * (_PEG_COARSENESS if scene.peg else 1.0)
        return np.asarray(worse**2 * found, dtype=np.float64)

    def limit(self, beads: Array, values: Array, known: tuple[float, float] | None = None) -> Limit:
        """What levels with so many beads say, finest first; ``known`` is the formula's value and standard error."""
        return limit_of(values, self.covariance(beads), known)

    def stated(self, limit: Limit) -> float:
        """The error that an answer states, in the unit of its value."""
        return math.hypot(COVERS * limit.error, self.model_error * abs(limit.value))

    def expected(self, levels: tuple[int, ...], known: float | None) -> float:
        """Relative error that levels would state if they scattered as expected, beside a formula's standard error."""
        beads = np.array([self.beads(one) for one in levels], dtype=np.float64)
        limit = self.limit(beads, np.ones(len(beads)), None if known is None else (1.0, known))
        return self.stated(limit)

    def plan(self, level: int) -> Plan:
        """The plan of a level."""
        wanted = replace(self.scene, purpose=self.quantity, tolerance=max(self.tolerance, 1e-6))
        plan = plan_of(wanted.with_beads(self.beads(level)), self.model)
        if plan.model == "leg" and self.reach == "whole":
            whole = math.ceil(self.scene.wedge.reference_leg_m / plan.strand.spacing_m)
            plan = replace(plan, leg_bonds=max(plan.leg_bonds, whole))
        return plan

    def seconds(self, level: int) -> float:
        """Predicted seconds of a level, without making its plan: beads x steps, and steps by the stiffest mode."""
        strand = self.scene.strand(self.beads(level))
        largest = strand.largest_step_s(0.0, self.scene.strain, 0.75)
        steps = self.scene.scales.front_arrival_s / (0.6 * largest)
        share = 1.0 if self.model == "ring" else self.scene.wedge.reference_leg_m / self.scene.band.circumference_m
        return error_curves.seconds(self.model, round(share * self.beads(level)), round(steps), 0)


@dataclass(frozen=True)
class Step:
    """What to run next."""

    levels: tuple[int, ...]
    """Coarsest first."""
    error: float
    """Relative error that is expected to be stated after it."""
    seconds: float


def next_step(question: Question, done: tuple[int, ...], known: float | None) -> Step | None:
    """The cheapest levels, beyond those done, that are expected to state the tolerance; None at the ladder's end.

    The first time the finest level comes with that of half its beads, and below :data:`THREE_FROM` with the one between
    them. Later it is a finer level, whatever was expected: the levels at hand know better.
    """
    if done:
        finer = max(done) + _OCTAVE // 2
        if not _affordable(question, finer):
            return None
        levels = (finer, *sorted(done, reverse=True))
        return Step((finer,), question.expected(levels, known), question.seconds(finer))
    best: Step | None = None
    for level in range(_OCTAVE, 20 * _OCTAVE):
        if not _affordable(question, level):
            break
        half = level - _OCTAVE
        levels = (half, level) if question.tolerance >= THREE_FROM else (half, level - _OCTAVE // 2, level)
        error = question.expected(levels[::-1], known)
        if error <= AIM * question.tolerance or not _affordable(question, level + 1):
            best = Step(levels, error, sum(question.seconds(one) for one in levels))
            break
    return best


def _affordable(question: Question, level: int) -> bool:
    return question.beads(level) <= MOST_BEADS and question.seconds(level) <= question.most_seconds
