"""The answers against which errors are taken: finer than any run that is compared, and with uncertainties."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

from beadband.lammps.engine import Session
from beadband.model.scene import Scene
from beadband.planning.plan import Plan
from beadband.studies.pareto.methods import LINEAR, LOSSY, MAIN, STRING, Method, leg_plan, physical_loss_s
from beadband.studies.pareto.runs import Answer, run_once

QUANTITIES = ("speed", "curvature_01", "curvature_03")
_WORST = 0.05
"""Relative uncertainty of a curvature above which it is no reference: too few beads, or a value near zero."""
_ORDERS = (1, 2, 2)
"""Of the error in the spacing: that of the numerical loss is of the first order, but small for the curvature."""


@dataclass(frozen=True)
class Reference:
    """V in m/s and the two curvatures in 1/m, each with its uncertainty; NaN where it is not known."""

    name: str
    values: tuple[float, float, float]
    uncertainties: tuple[float, float, float]
    beads: tuple[int, ...]
    """Of its runs; empty for a closed form."""

    def errors(self, answer: Answer) -> tuple[float, float, float]:
        """Relative errors of an answer."""
        found = quantities(answer)
        first, second, third = (abs(a / b - 1.0) for a, b in zip(found, self.values, strict=True))
        return first, second, third

    def as_dict(self) -> dict[str, Any]:
        """Beads of its runs, and value and uncertainty of each quantity that is known."""
        known = [i for i, value in enumerate(self.values) if math.isfinite(value)]
        values = {QUANTITIES[i]: {"value": self.values[i], "uncertainty": self.uncertainties[i]} for i in known}
        return {"beads": list(self.beads), **values}

    def relative(self, index: int) -> float:
        """Relative uncertainty of a quantity."""
        return self.uncertainties[index] / abs(self.values[index])


def quantities(answer: Answer) -> tuple[float, float, float]:
    """Speed and curvatures in the order of :data:`QUANTITIES`."""
    return answer.speed_m_s, *answer.curvature_1_m


def references(scene: Scene, finest: int, session: Session, kinds: Sequence[str]) -> dict[str, Reference]:
    """The reference of each kind, by its name; RunError when one of its runs fails.

    ``finest`` is the largest bead count that is compared with the references.
    """
    found = {}
    for kind in kinds:
        if kind == STRING:
            unknown = (math.nan, math.nan)
            found[kind] = Reference(kind, (scene.string.rear_speed_m_s, *unknown), (0.0, *unknown), ())
            continue
        # All errors are taken against this limit, so it is computed with twice as many beads as the others.
        top = 2 * finest if kind == MAIN else finest
        counts = (top // 2, round(top / 8**0.5) * 2, top)
        plans = [_plan(scene, kind, count) for count in counts]
        answers = [run_once(Method("reference", kind, plan), session)[0] for plan in plans]
        # A loss of the material's own, or a law without a shock, leaves no error of the first order.
        smooth = kind == LOSSY or not plans[-1].string.wave.shocks
        orders = (2, 2, 2) if smooth else _ORDERS
        one = extrapolated(kind, [plan.beads for plan in plans], [quantities(one) for one in answers], orders)
        found[kind] = _without_unknown(one, scene.bending_stiffness_n_m2 == 0.0)
    return found


def _without_unknown(reference: Reference, straight: bool) -> Reference:
    """The same with NaN for curvatures that are too uncertain, and for all where there is no bending."""
    values, spreads = list(reference.values), list(reference.uncertainties)
    for index in (1, 2):
        if straight or not spreads[index] <= _WORST * abs(values[index]):
            values[index] = spreads[index] = math.nan
    return replace(
        reference, values=(values[0], values[1], values[2]), uncertainties=(spreads[0], spreads[1], spreads[2])
    )


def _plan(scene: Scene, kind: str, beads: int) -> Plan:
    """A leg up to the finger, so that its end is farther away than in any run that is compared."""
    chosen = scene.with_law("linear") if kind == LINEAR else scene
    plan = leg_plan(chosen, beads, loss_time_s=physical_loss_s(scene) if kind == LOSSY else None)
    whole = math.ceil(scene.wedge.reference_leg_m / chosen.strand(beads).spacing_m)
    return replace(plan, leg_bonds=max(whole, plan.leg_bonds))


def extrapolated(
    name: str, beads: Sequence[int], answers: Sequence[tuple[float, float, float]], orders: Sequence[int]
) -> Reference:
    """Three runs, coarse to fine, extrapolated to no spacing from the last two.

    The uncertainty is the greater of the distance to the same from the first two, and half of that to the finest run.
    """
    values, spreads = [], []
    for index, order in enumerate(orders):
        first, second, third = (answer[index] for answer in answers)
        limit = richardson_limit(beads[1], second, beads[2], third, order)
        before = richardson_limit(beads[0], first, beads[1], second, order)
        values.append(limit)
        spreads.append(max(abs(limit - before), 0.5 * abs(limit - third)))
    return Reference(name, (values[0], values[1], values[2]), (spreads[0], spreads[1], spreads[2]), tuple(beads))


def richardson_limit(coarse_beads: int, coarse: float, fine_beads: int, fine: float, order: int) -> float:
    """Richardson's limit of two values whose error goes as (1/beads)^order."""
    ratio = (fine_beads / coarse_beads) ** order
    return (ratio * fine - coarse) / (ratio - 1.0)
