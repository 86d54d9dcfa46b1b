"""Leg and ring on a peg: the exact elastica, the engine's own forces, and what a run makes of them."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from beadband.errors import RunError, UsageError
from beadband.lammps.engine import Session, load
from beadband.lammps.scripts import write_ring
from beadband.model.peg import own_radius_m
from beadband.model.scene import Scene, scene_of
from beadband.planning.plan import Plan, plan_of
from beadband.runs import folder as files
from beadband.runs.held import hold, hold_leg
from beadband.runs.rear_run import follow_rear
from beadband.statics.chain import HalfRing
from beadband.statics.leg import LegRequest, held_leg
from beadband.statics.peg import peg_leg
from beadband.statics.ring import UPPER, WRAPPED
from beadband.studies.pareto.peers.elements import Rod, held_shape


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    with Session() as opened:
        yield opened


def planned(radius: float, beads: int, model: str = "leg", **values: object) -> Plan:
    return plan_of(scene_of({"tip_radius_m": radius, "beads": beads, **values}), model)


def exact_leg(scene: Scene, places: np.ndarray) -> np.ndarray:
    """Positions by the second method's own solution, which shares nothing with the beads."""
    strand = scene.strand(100)
    rod = Rod(
        strand.law.stress, strand.law.tangent, strand.area_m2, strand.density_kg_m3, strand.bending_stiffness_n_m2, 0.0
    )
    return held_shape(rod, 1.0 + scene.strain, scene.half_angle_rad, places, scene.tip_radius_m)[0]


@pytest.mark.parametrize("law", ["linear", "mooney-rivlin"])
@pytest.mark.parametrize("radius", [1e-3, 2e-3, 4e-3])
def test_held_leg_tends_to_the_exact_shape(radius: float, law: str) -> None:
    """Of the second order, up to where between two beads the band happens to leave the peg."""
    scene = scene_of({"tip_radius_m": radius, "law": law})
    errors = []
    for beads in (400, 800, 1600, 3200):
        strand = scene.strand(beads)
        held, on_peg = peg_leg(LegRequest(strand, beads // 4, scene.strain, scene.half_angle_rad), scene.peg)
        assert held.net_force < 1e-10
        apart = held.positions_m - exact_leg(scene, np.arange(beads // 4 + 1) * strand.spacing_m)
        errors.append(float(np.hypot(*apart.T).max()) / scene.wedge.leg_m)
        away = np.hypot(held.positions_m[:, 0] - radius, held.positions_m[:, 1]) / radius
        assert away[:on_peg] == pytest.approx(1.0, abs=1e-12)
        assert away[on_peg:].min() > 1.0 - 1e-12
    assert errors[-1] < 1e-5
    assert math.log2(errors[0] / errors[-1]) / 3.0 > 1.7


def test_without_a_peg_both_solvers_find_the_same_leg() -> None:
    scene = scene_of({})
    strand = scene.strand(400)
    request = LegRequest(strand, 100, scene.strain, scene.half_angle_rad)
    other = held_leg(strand, 100, scene.strain, scene.half_angle_rad)
    assert peg_leg(request, None).leg.positions_m == pytest.approx(other.positions_m, abs=1e-14)


@pytest.mark.parametrize(("radius", "beads"), [(7e-4, 120), (1e-3, 301), (3e-3, 600), (8e-3, 240)])
def test_ring_on_a_peg_is_in_equilibrium(radius: float, beads: int) -> None:
    """The peg pushes, along its radius; both halves together carry 2 T cos(phi)."""
    plan = planned(radius, beads, "ring")
    ring, phi = hold(plan), plan.scene.half_angle_rad
    assert ring.net_force < 1e-11
    assert np.array_equal(ring.positions_m[0], [0.0, 0.0])
    half = ring.positions_m[: beads // 2 + 1]
    gradient = HalfRing(plan.strand, crossing=beads % 2 == 1).gradient(half)
    outward = half - np.array([radius, 0.0])
    away = np.hypot(*outward.T)
    assert away.min() > radius * (1.0 - 1e-11)
    on_peg = away < radius * (1.0 + 1e-11)
    # The gradient is the force that holds a bead.
    push = np.sum(gradient * outward, axis=1)[on_peg] / radius
    assert push.min() > 0.0
    across = (gradient[:, 0] * outward[:, 1] - gradient[:, 1] * outward[:, 0])[on_peg][1:] / radius
    assert np.abs(across).max(initial=0.0) < 1e-11 * ring.tension_n
    assert gradient[on_peg, 0].sum() == pytest.approx(-ring.tension_n * math.cos(phi), rel=1e-9)
    around = ring.types == WRAPPED
    finger = np.hypot(ring.positions_m[:, 0] - ring.finger_centre_m, ring.positions_m[:, 1])
    assert finger[around] == pytest.approx(ring.finger_radius_m, rel=1e-12)
    assert finger.min() > ring.finger_radius_m * (1.0 - 1e-12)
    middle = half[beads // 7 : beads // 7 + 2]
    bond = middle[1] - middle[0]
    assert math.atan2(bond[1], bond[0]) == pytest.approx(phi, abs=1e-8)
    assert np.hypot(*bond) / plan.strand.spacing_m == pytest.approx(1.476, rel=1e-8)


def test_lammps_feels_the_same_equilibrium(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = planned(2e-3, 401, "ring")
    ring = hold(plan)
    write_ring(tmp_path, plan, ring)
    monkeypatch.chdir(tmp_path)
    text = Path(files.SCRIPT).read_text()
    instance = load().lammps(cmdargs=["-screen", "none", "-log", "none", "-nocite"])
    try:
        instance.commands_string(text[: text.index("undump          held")])
        force = instance.numpy.extract_atom("f")[: plan.beads][np.argsort(instance.numpy.extract_atom("id"))]
    finally:
        instance.close()
    outward = ring.positions_m - np.array([2e-3, 0.0])
    free = (ring.types == UPPER) & (np.hypot(*outward.T) > 2e-3 * (1.0 + 1e-9))
    assert np.abs(force[free]).max() < 1e-8 * ring.tension_n
    on_peg = (ring.types == UPPER) & ~free
    assert on_peg.sum() >= 3
    turned = force[on_peg, 0] * outward[on_peg, 1] - force[on_peg, 1] * outward[on_peg, 0]
    assert np.abs(turned).max() < 1e-8 * ring.tension_n * 2e-3


def test_a_leg_that_ends_on_its_peg_is_refused() -> None:
    scene = scene_of({"tip_radius_m": 8e-3})
    with pytest.raises(RunError, match="ends on its peg"):
        peg_leg(LegRequest(scene.strand(1000), 20, scene.strain, scene.half_angle_rad), scene.peg)


def test_beads_too_far_apart_hold_the_tip_as_at_a_point() -> None:
    plan = planned(2e-3, 120)
    assert "peg-unresolved" in {one.code for one in plan.warnings}
    point = hold_leg(planned(0.0, 120)).positions_m[:20]
    assert hold_leg(plan).positions_m[:20] == pytest.approx(point, abs=1e-8)
    # Its own plan has beads for the peg, next to a tension peak too; the coarse run has as many as are needed.
    for values in ({"tip_radius_m": 2e-3}, {"tip_radius_m": 7e-3, "band": "IV", "strain": 0.95, "half_angle_deg": 6.0}):
        plan = plan_of(scene_of({**values, "for": "speed"}), "leg")
        assert plan.scene.peg is not None
        assert 2.0 * plan.strand.spacing_m < plan.scene.peg.widest_m
        assert plan.reasons[0].code == "beads-for-peg"
        bonds = np.hypot(*np.diff(hold_leg(plan).positions_m, axis=0).T) / plan.strand.spacing_m
        assert bonds.max() < 1.02 * (1.0 + plan.scene.strain)


def test_legs_that_are_straight_nowhere_are_refused() -> None:
    with pytest.raises(UsageError, match="legs are too short"):
        hold(planned(8e-3, 400, "ring", bending_scale=30.0))


def test_below_its_own_radius_a_peg_changes_nothing(session: Session) -> None:
    point, small = planned(0.0, 240), planned(4e-4, 240)
    assert np.array_equal(hold_leg(point).positions_m, hold_leg(small).positions_m)
    assert np.array_equal(hold(point).positions_m, hold(small).positions_m)
    paths = [follow_rear(plan, session).rear.tip_x_m for plan in (point, small)]
    assert np.array_equal(*paths)


def test_just_above_it_hardly_anything_changes(session: Session) -> None:
    own = own_radius_m(scene_of({}).strand(1), 0.476, math.radians(14.0))
    point, peg = (follow_rear(planned(radius, 1200), session) for radius in (0.0, 1.01 * own))
    assert peg.fitted_speed_m_s.value == pytest.approx(point.fitted_speed_m_s.value, rel=1e-4)
    assert peg.decay is not None
    assert point.decay is not None
    assert peg.decay.eq7_ratio.value == pytest.approx(point.decay.eq7_ratio.value, rel=0.01)


@pytest.mark.parametrize("radius", [1e-3, 5e-3])
def test_leg_gives_the_speed_of_the_ring(radius: float, session: Session) -> None:
    leg, ring = (follow_rear(planned(radius, 360, model, **{"for": "speed"}), session) for model in ("leg", "ring"))
    assert leg.fitted_speed_m_s.value == pytest.approx(ring.fitted_speed_m_s.value, rel=5e-4)
