"""One leg in place of the ring: its equilibrium, its agreement with the ring, and its silent end."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest

from beadband.analysis.fits import hann_mean
from beadband.errors import RunError
from beadband.lammps.engine import Session
from beadband.model.scene import scene_of
from beadband.planning.plan import Plan, plan_of
from beadband.runs.rear_run import follow_rear
from beadband.statics.leg import _solve_tridiagonal, held_leg
from beadband.statics.ring import stretched_ring


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    with Session() as opened:
        yield opened


def leg_plan(**values: object) -> Plan:
    return plan_of(scene_of({"for": "speed", **values}), "leg")


@pytest.mark.parametrize("law", ["mooney-rivlin", "linear"])
def test_held_leg_tends_to_the_held_ring(law: str) -> None:
    scene = scene_of({"law": law})
    gaps = []
    for beads in (240, 480, 960):
        strand = scene.strand(beads)
        leg = held_leg(strand, beads // 4, scene.strain, scene.half_angle_rad)
        ring = stretched_ring(strand, beads, scene.strain, scene.half_angle_rad)
        assert leg.net_force < 1e-11
        apart = leg.positions_m - ring.positions_m[: len(leg.positions_m)]
        gaps.append(float(np.hypot(*apart.T).max()) / scene.band.circumference_m)
    # The tips differ in how they turn one sharp angle: of the third order in the spacing.
    orders = np.log2(np.array(gaps[:-1]) / np.array(gaps[1:]))
    assert gaps[-1] < 2e-6
    assert orders.min() > 1.8


def test_without_bending_the_leg_is_straight() -> None:
    scene = scene_of({"bending_scale": 0.0})
    leg = held_leg(scene.strand(200), 40, scene.strain, scene.half_angle_rad)
    bonds = np.diff(leg.positions_m, axis=0)
    assert np.hypot(*bonds.T) == pytest.approx(np.full(40, scene.strand(200).spacing_m * 1.476), rel=1e-14)
    assert np.arctan2(bonds[:, 1], bonds[:, 0]) == pytest.approx(np.full(40, scene.half_angle_rad), rel=1e-14)


@pytest.mark.parametrize("size", [1, 2, 3, 7, 64, 100])
def test_tridiagonal_systems_side_by_side(size: int) -> None:
    rng = np.random.default_rng(size)
    beside, right = rng.uniform(-1.0, 1.0, (3, size - 1)), rng.normal(size=(3, size))
    diagonal = rng.uniform(2.0, 3.0, (3, size))
    found = _solve_tridiagonal(diagonal, beside, right)
    for row in range(3):
        matrix = np.diag(diagonal[row]) + np.diag(beside[row], 1) + np.diag(beside[row], -1)
        assert found[row] == pytest.approx(np.linalg.solve(matrix, right[row]), rel=1e-12, abs=1e-13)


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"law": "linear"},
        {"band": "IV", "strain": 1.2, "half_angle_deg": 20.0},
        {"band": "I", "strain": 0.1, "half_angle_deg": 5.0},
    ],
    ids=lambda values: "-".join(str(value) for value in values.values()) or "default",
)
def test_leg_gives_the_speed_of_the_ring(values: dict[str, object], session: Session) -> None:
    scene = scene_of({**values, "beads": 360, "for": "speed"})
    ring, leg = plan_of(scene), plan_of(scene, "leg")
    assert leg.model == "leg"
    speeds = [follow_rear(plan, session).fitted_speed_m_s.value for plan in (ring, leg)]
    assert speeds[1] == pytest.approx(speeds[0], rel=6e-4)
    assert leg.bead_steps < 0.4 * ring.bead_steps


def test_leg_gives_the_curvature_of_the_ring(session: Session) -> None:
    found = {}
    for model in ("ring", "leg"):
        plan = plan_of(scene_of({"beads": 520}), model)
        rear, arrival = follow_rear(plan, session).rear, plan.front_arrival_s
        found[model] = [
            hann_mean(rear.times_s, rear.tip_curvature_1_m, share * arrival, 0.03 * arrival) for share in (0.1, 0.3)
        ]
    assert found["leg"] == pytest.approx(found["ring"], rel=3e-3)


@pytest.mark.parametrize("law", ["mooney-rivlin", "linear"])
def test_nothing_comes_back_from_the_end(law: str, session: Session) -> None:
    """A leg three times as long, which the front never leaves, gives the same speed."""
    plan = leg_plan(law=law, beads=240)
    longer = replace(plan, leg_bonds=3 * plan.leg_bonds)
    short, long = (follow_rear(one, session).fitted_speed_m_s.value for one in (plan, longer))
    assert short == pytest.approx(long, rel=1e-4)
    # Much shorter, and the echo is there: the bound above says something.
    deaf = replace(plan, leg_bonds=plan.leg_bonds // 2)
    assert abs(follow_rear(deaf, session).fitted_speed_m_s.value / long - 1.0) > 1e-3


def test_runs_of_a_session_do_not_see_each_other(session: Session) -> None:
    plan, other = leg_plan(beads=120), leg_plan(band="I", law="linear", beads=160)
    first = follow_rear(plan, session).fitted_speed_m_s
    follow_rear(other, session)
    assert follow_rear(plan, session).fitted_speed_m_s == first


def test_session_survives_a_failed_run(session: Session) -> None:
    with pytest.raises(RunError):
        session.run("no_such_command", {})
    assert math.isfinite(follow_rear(leg_plan(beads=120), session).fitted_speed_m_s.value)


@pytest.mark.parametrize(("strain", "half_angle"), [(1.1, 5.0), (1.2, 15.0)])
def test_a_fine_leg_near_the_peak_of_its_tension_is_held(strain: float, half_angle: float) -> None:
    """Short steps of the stretches lead astray there; the leg is solved again with whole ones."""
    scene = scene_of({"band": "IV", "strain": strain, "half_angle_deg": half_angle})
    strand = scene.strand(2000)
    bonds = int(scene.wedge.reference_leg_m / strand.spacing_m)
    assert held_leg(strand, bonds, strain, scene.half_angle_rad).net_force < 1e-8
