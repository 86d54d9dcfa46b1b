"""The ladder: finer levels state less and cost more, the first step is the cheapest that will do, and it ends."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from beadband.analysis.convergence import observed_order
from beadband.lammps.engine import Session
from beadband.model.scene import scene_of
from beadband.planning import ladder
from beadband.planning.ladder import Question, next_step
from beadband.planning.plan import LOSS_BEADS, SMOOTH_RESOLUTION, plan_of
from beadband.runs.ask import question_of
from beadband.runs.rear_run import follow_rear


def question(tolerance: float = 1e-3, quantity: str = "speed", **values: Any) -> Question:
    return question_of(scene_of({**values, "tolerance": tolerance}), quantity)


@pytest.mark.parametrize("quantity", ["speed", "curvature"])
def test_finer_levels_state_less_and_cost_more(quantity: str) -> None:
    asked = question(quantity=quantity)
    errors = [asked.expected((level,), None) for level in range(0, 20, 4)]
    seconds = [asked.seconds(level) for level in range(0, 20, 4)]
    assert errors == sorted(errors, reverse=True)
    assert seconds == sorted(seconds)
    assert asked.beads(4) == pytest.approx(2 * asked.beads(0), abs=2)


def test_the_first_step_is_the_coarsest_that_will_do() -> None:
    finest = []
    for tolerance in (0.01, 1e-3, 3e-4, 1e-4):
        asked = question(tolerance)
        step = next_step(asked, (), None)
        assert step is not None
        assert step.error <= ladder.AIM * tolerance
        assert len(step.levels) == (2 if tolerance >= ladder.THREE_FROM else 3)
        coarser = tuple(level - 1 for level in step.levels)
        if coarser[0] >= 0:
            assert asked.expected(coarser[::-1], None) > ladder.AIM * tolerance
        finest.append(asked.beads(step.levels[-1]))
    assert finest == sorted(finest)
    # What the formula knows saves beads.
    asked = question(1e-3)
    with_it, without = next_step(asked, (), 2.5e-4), next_step(asked, (), None)
    assert with_it is not None
    assert without is not None
    assert with_it.seconds < without.seconds


def test_a_later_step_is_finer_and_the_ladder_ends(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = question(1e-3)
    first = next_step(asked, (), None)
    assert first is not None
    second = next_step(asked, first.levels, None)
    assert second is not None
    assert second.levels > (max(first.levels),)
    assert second.error < first.error
    monkeypatch.setattr(ladder, "MOST_BEADS", asked.beads(max(first.levels)))
    assert next_step(asked, first.levels, None) is None
    # From the start the finest level that can be had is taken, though it is not expected to do.
    monkeypatch.setattr(ladder, "MOST_BEADS", asked.beads(6))
    best = next_step(asked, (), None)
    assert best is not None
    assert best.levels[-1] == 6
    assert best.error > asked.tolerance


def test_a_leg_that_will_not_do_is_a_ring() -> None:
    reaches = [question(tolerance).reach for tolerance in (1e-3, 2e-4, 1e-5)]
    assert reaches == ["cut", "whole", "ring"]
    assert question(1e-3).model_error > question(2e-4).model_error > question(1e-5).model_error == 0.0
    assert question(1e-3, thickness_m=0.02).model == "ring"


def loss_over_front(beads: int, **values: Any) -> float:
    """Numerical loss of a plan, in units of the front's time from bead to bead."""
    plan = plan_of(scene_of({**values, "for": "speed"}).with_beads(beads), "leg")
    band, wave = plan.scene.band, plan.string.wave
    return plan.loss_time_s * band.modulus_pa / (plan.strand.spacing_m * band.density_kg_m3 * wave.tail_speed_m_s)


def test_the_loss_of_a_law_without_a_shock_is_of_the_second_order() -> None:
    for values in ({}, {"law": "gent", "mu_pa": 3.5e5, "jm": 9.0, "strain": 1.2, "half_angle_deg": 12.0}):
        assert loss_over_front(800, **values) == pytest.approx(LOSS_BEADS, rel=1e-12)
    for values in ({"law": "linear"}, {"law": "ogden", "mu_pa": (1e5,), "alpha": (6.0,), "strain": 0.8}):
        coarse, fine = loss_over_front(400, **values), loss_over_front(800, **values)
        assert coarse < LOSS_BEADS
        assert fine == pytest.approx(0.5 * coarse, rel=1e-12)
        rear = scene_of(values).scales.rear_length_m / scene_of(values).band.circumference_m
        assert loss_over_front(int(0.9 * SMOOTH_RESOLUTION / rear), **values) == pytest.approx(LOSS_BEADS, rel=1e-12)


def test_and_so_is_its_error() -> None:
    """Linear law, whole legs: the order with that loss, and the error of one of the first order at equal beads."""
    asked = question(2e-4, law="linear")
    assert asked.reach == "whole"
    beads, speeds, first = [], [], []
    with Session() as session:
        for level in (10, 8, 6):
            plan = asked.plan(level)
            beads.append(plan.beads)
            speeds.append(follow_rear(plan, session).fitted_speed_m_s.value)
            full = plan.loss_time_s / loss_over_front(plan.beads, law="linear") * LOSS_BEADS
            first.append(follow_rear(replace(plan, loss_time_s=full), session).fitted_speed_m_s.value)
    limit = asked.limit(np.array(beads, dtype=np.float64), np.array(speeds)).value
    order = observed_order(1.0 / np.array(beads), np.array(speeds))
    assert order is not None
    assert 1.5 < order < 3.5
    assert limit == pytest.approx(16.742, abs=0.002)  # 16.7419 by finite elements
    assert abs(first[0] - limit) > 2.0 * abs(speeds[0] - limit)
