"""What the inputs' errors do to V and the curvature: a few legs with the same beads and steps, or many drawn ones.

Derivatives are central differences between legs of the same discretisation, so that its errors cancel. Similarity
(:mod:`beadband.model.uncertainty`) says which of them must be run for.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from contextlib import nullcontext, suppress
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from beadband.errors import BeadbandError, UsageError, explain
from beadband.lammps.engine import Session
from beadband.model.scene import Scene
from beadband.model.uncertainty import BENDING, PEG, Array, Inputs, basis, changed, elasticities, inputs_of
from beadband.planning.plan import Plan, plan_of
from beadband.runs.batch import follow_rears
from beadband.runs.measurement import Measurement

TOLERANCE = 0.01
"""Tolerance for which the legs of the derivatives are planned: what is left of it cancels."""
_PEG_TOLERANCE = 0.002
"""The same of scenes with a peg, which need beads on it."""
_LEAST_STEP, _MOST_STEP = 0.003, 0.05
"""Steps of the logarithm of an input, between which its own error is taken as the step."""
_LONG_STEPS = {BENDING: 0.2, PEG: _MOST_STEP}
"""The same of EI, on which V depends so little that a small step drowns in what single beads make of the kink, and of
a peg's radius, which V follows by a wavy line, as one bead after the other comes to lie on the peg."""
_SPEED, _RATIO = 0.5, 0.0
"""Sums of the elasticities of all moduli: of a speed, and of a number without dimension."""


@dataclass(frozen=True)
class Sampled:
    """What draws of the inputs gave."""

    draws: int
    refused: int
    """Draws that had no answer; they are left out."""
    mean_m_s: float
    error_m_s: float
    """Standard deviation of V over the draws."""
    interval_95_m_s: tuple[float, float]


@dataclass(frozen=True)
class Budget:
    """Which input costs how much of the error."""

    inputs: Inputs
    sensitivities: Array
    """d ln V/d ln of each input, shape (inputs,)."""
    shares: Array
    """Share of each input in the variance of V, shape (inputs,); those of correlated ones are split evenly."""
    speed_error_m_s: float
    exponent_error: float | None
    eq7_ratio_error: float | None
    legs: int
    """Legs that were run for it."""
    sampled: Sampled | None = None

    def rows(self) -> list[dict[str, Any]]:
        """The inputs as results have them."""
        inputs = self.inputs
        columns = zip(inputs.names, inputs.values, inputs.errors, self.sensitivities, self.shares, strict=True)
        return [
            {"name": name, "value": value, "error": error, "sensitivity": slope, "share": share}
            for name, value, error, slope, share in ((n, *map(float, rest)) for n, *rest in columns)
        ]


@dataclass(frozen=True)
class _Answer:
    """Logarithm of the speed, exponent, and logarithm of the Eq. 7 ratio; NaN where there is none."""

    speed: float
    exponent: float
    ratio: float

    @classmethod
    def of(cls, found: Measurement) -> _Answer:
        decay = found.decay
        nan = math.nan
        return cls(
            math.log(found.fitted_speed_m_s.value),
            decay.exponent.value if decay else nan,
            math.log(decay.eq7_ratio.value) if decay else nan,
        )


_ANSWER = ("speed", "exponent", "ratio")
"""The parts of an answer, in their order."""


def budget_of(scene: Scene, speed_m_s: float, session: Session | None = None) -> Budget | None:
    """The part of the inputs in the error of V, and of the curvature where it is asked for; None without errors.

    ``speed_m_s`` is the answer that the errors belong to. A scene with ``samples`` is drawn as often, beside.
    UsageError where an input's error reaches a scene that has no answer.
    """
    inputs = inputs_of(scene)
    if inputs is None:
        return None
    with Session() if session is None else nullcontext(session) as own:
        bare = replace(
            scene.unplanned(), until="release", finger="stays", flight_s=0.0, errors=(), covariance=(), samples=0
        )
        tolerance = max(TOLERANCE, scene.tolerance) if scene.peg is None else _PEG_TOLERANCE
        base = plan_of(replace(bare, auto_tolerance=False, tolerance=tolerance), "leg")
        wanted = basis(scene, inputs.names)
        steps = dict(zip(inputs.names, np.abs(inputs.errors / inputs.values), strict=True))
        slopes = _derivatives(base, {name: steps.get(name, _MOST_STEP) for name in wanted}, own)
        drawn = _sampled(base, inputs, scene.samples, own) if scene.samples else None

    def joined(which: str, total: float) -> tuple[Array, Array, float]:
        found = elasticities(scene, inputs.names, {name: getattr(d, which) for name, d in slopes.items()}, total)
        parts = found * (inputs.relative_covariance @ found)
        variance = float(parts.sum())
        return found, parts / variance if variance > 0.0 else parts, math.sqrt(max(variance, 0.0))

    found, shares, relative = joined("speed", _SPEED)
    has_decay = scene.purpose == "curvature" and all(math.isfinite(one.exponent) for one in slopes.values())
    exponent = joined("exponent", _RATIO)[2] if has_decay else None
    ratio = joined("ratio", _RATIO)[2] if has_decay else None
    return Budget(
        inputs=inputs,
        sensitivities=found,
        shares=shares,
        speed_error_m_s=relative * abs(speed_m_s),
        exponent_error=exponent,
        eq7_ratio_error=ratio,
        legs=0 if _exact(base) else 2 * len(slopes),
        sampled=drawn,
    )


def same_discretisation(base: Plan, changes: Mapping[str, float]) -> Plan:
    """The plan of a changed scene with the beads, the steps and the samples of another."""
    scene = replace(changed(base.scene.unplanned(), changes), beads=base.beads)
    plan = plan_of(scene, base.model)
    timestep = base.timestep_s * plan.front_arrival_s / base.front_arrival_s
    return replace(
        plan,
        scene=replace(plan.scene, timestep_s=timestep, steps=base.steps, rear_steps=base.rear_steps),
        timestep_s=timestep,
        steps=base.steps,
        frame_steps=base.frame_steps,
        rear_steps=base.rear_steps,
        leg_bonds=base.leg_bonds,
    )


def _derivatives(base: Plan, errors: Mapping[str, float], session: Session) -> dict[str, _Answer]:
    """d ln V, d exponent and d ln ratio by d ln of inputs, from two legs for each; all are released together."""
    steps, plans = {}, []
    for name, error in errors.items():
        steps[name] = _LONG_STEPS.get(name, min(max(error, _LEAST_STEP), _MOST_STEP))
        plans += _ends(base, name, error, steps[name])
    answers = []
    for found in _answers(plans, session):
        if isinstance(found, BeadbandError):
            raise found
        answers.append(found)
    return {
        name: _Answer(*((getattr(high, each) - getattr(low, each)) / (2.0 * step) for each in _ANSWER))
        for (name, step), low, high in zip(steps.items(), answers[::2], answers[1::2], strict=True)
    }


def _answers(plans: Sequence[Plan], session: Session) -> list[_Answer | BeadbandError]:
    """What plans give, with the error in the place of one that failed; the exact speeds of strips need no run."""
    if plans and _exact(plans[0]):
        return [_Answer(math.log(plan.string.rear_speed_m_s), math.nan, math.nan) for plan in plans]
    released = follow_rears(plans, session)
    return [found if isinstance(found, BeadbandError) else _Answer.of(found) for found in released]


def _exact(plan: Plan) -> bool:
    """Whether the exact wave of a strip is the answer: its material has no loss of its own."""
    return plan.scene.is_strip and "loss_time_s" in plan.scene.planned


def _ends(base: Plan, name: str, error: float, step: float) -> list[Plan]:
    """Plans of the scenes with an input a step lower and higher; UsageError where one has no answer."""
    key, _, place = name.partition("[")
    given = base.scene.as_dict()[key]
    value = given[int(place[:-1])] if place else given
    try:
        return [same_discretisation(base, {name: value * math.exp(sign * step)}) for sign in (-1.0, 1.0)]
    except UsageError as refused:
        raise UsageError(
            explain(
                f"the error of {name} reaches a scene that has no answer",
                f"{name} {value:.6g} with an error of {error:.2g} of it ({refused})",
                "a scene further from the edge, or a smaller error",
                "change the scene",
            )
        ) from refused


def _sampled(base: Plan, inputs: Inputs, draws: int, session: Session, seed: int = 0) -> Sampled:
    """V of scenes drawn from the inputs' normal distribution, by a Latin hypercube."""
    from scipy.stats import norm, qmc

    values, vectors = np.linalg.eigh(inputs.covariance)
    root = vectors * np.sqrt(np.maximum(values, 0.0))
    normal = norm.ppf(qmc.LatinHypercube(len(inputs.names), seed=seed).random(draws))
    plans = []
    for point in inputs.values + normal @ root.T:
        with suppress(BeadbandError):
            plans.append(same_discretisation(base, dict(zip(inputs.names, point.tolist(), strict=True))))
    speeds = [math.exp(one.speed) for one in _answers(plans, session) if isinstance(one, _Answer)]
    if len(speeds) < max(2, draws // 2):
        raise UsageError(
            explain(
                "the inputs' errors are too large to draw from",
                f"{draws - len(speeds)} of {draws} draws without an answer",
                "at most half",
                "give smaller errors",
            )
        )
    found = np.array(speeds)
    low, high = np.percentile(found, [2.5, 97.5]).tolist()
    return Sampled(draws, draws - len(found), float(found.mean()), float(found.std(ddof=1)), (low, high))
