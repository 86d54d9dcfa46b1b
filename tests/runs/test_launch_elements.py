"""Launches by beads against finite elements on a rigid cylinder, which share nothing with them but the physics.

A loss time of the band's own makes both solve one smooth problem. Planned launches: tests/validation/launches.py.
"""

from __future__ import annotations

import importlib
import math
import sys
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beadband.model.scene import Scene, scene_of
from beadband.planning.launch_plan import launch_plan_of
from beadband.runs import launch
from beadband.studies.pareto.peers.elements import Rod

sys.path.insert(0, str(Path(__file__).parents[1] / "validation"))
elements = importlib.import_module("launch_elements")

LOSS_TIME_S = 1e-5
FEW, MANY = 24, 48
"""Elements of a half."""


def scene(**values: Any) -> Scene:
    return scene_of({"until": "launch", "beads": 400, "for": "speed", "loss_time_s": LOSS_TIME_S, **values})


def rod_of(one: Scene) -> Rod:
    band, law = one.band, one.material
    viscosity = band.modulus_pa * LOSS_TIME_S
    return Rod(law.stress, law.tangent, band.area_m2, band.density_kg_m3, one.bending_stiffness_n_m2, viscosity)


@cache
def by_elements(law: str, count: int, mass_kg: float = math.inf) -> Any:
    one = scene(law=law)
    plan = launch_plan_of(one)
    nose_m = plan.nose_beads * plan.strand.spacing_m
    shape = 1.0 + one.strain, one.half_angle_rad, one.band.circumference_m
    # The hand's preload balances the band before the release.
    pull_n = 2.0 * plan.string.tension_n * math.cos(one.half_angle_rad)
    more = {"mass_kg": mass_kg, "force_n": lambda way, speed: pull_n}
    return elements.launch(rod_of(one), one.material.energy, *shape, count, 8e-3, nose_m, lines=400, **more)


def arrival_s(found: Any) -> float:
    return float(np.interp(0.0, -found.gap_m[-2:], found.times_s[-2:]))


def throw_m_s(found: Any) -> float:
    """Before the rear's blow."""
    return float(found.momentum_n_s[found.times_s < 0.99 * arrival_s(found)][-1]) / found.mass_kg


@pytest.mark.parametrize("law", ["linear", "mooney-rivlin"])
def test_elements_keep_momentum_and_energy_and_are_converged(law: str) -> None:
    few, many = by_elements(law, FEW), by_elements(law, MANY)
    for found in (few, many):
        assert found.impulse_n_s[-1, 0] == pytest.approx(found.momentum_n_s[-1], rel=1e-11)
        assert np.ptp(found.energy_j) < 2e-3 * found.stored_j
        assert found.gap_m[0] > 10.0 * found.gap_m[-2] > 0.0
    assert arrival_s(few) == pytest.approx(arrival_s(many), rel=2e-3)
    assert throw_m_s(few) == pytest.approx(throw_m_s(many), rel=5e-3)


@pytest.mark.parametrize("law", ["linear", "mooney-rivlin"])
def test_the_held_shape_rests(law: str) -> None:
    """Its first integrals leave no force on the elements, and its finger is the one on which the beads lie."""
    one = scene(law=law)
    nodes = np.linspace(0.0, 0.5 * one.band.circumference_m, 401)
    position, slope, radius, centre = elements.closed_shape(rod_of(one), 1.0 + one.strain, one.half_angle_rad, nodes)
    ring, _ = launch_plan_of(one).held()
    assert radius == pytest.approx(ring.finger_radius_m, rel=1e-3)
    assert centre == pytest.approx(ring.finger_centre_m, rel=1e-3)
    finger = elements.Cylinder(centre, radius, 1e9)
    band = elements.HalfBand(rod_of(one), nodes, [finger])
    state = np.stack([position, band.size_m * slope], axis=2).transpose(1, 0, 2)
    held = np.zeros_like(band.fixed)
    held[0, 0, 0] = True
    settled = elements.settled(band, np.ascontiguousarray(state), held)
    assert np.abs(settled - state)[:, :, 0].max() < 2e-4 * radius
    assert np.abs(np.where(held, 0.0, band.forces(settled, 0.0 * settled))).max() < 1e-8 * ring.tension_n


@pytest.mark.parametrize("law", ["linear", "mooney-rivlin"])
def test_beads_agree_with_elements(law: str) -> None:
    _, found, watch = launch.follow_launch(scene(law=law))
    true = by_elements(law, MANY)
    assert found.rear_arrival_s == pytest.approx(arrival_s(true), rel=2e-3)
    assert found.centre_of_mass_speed_m_s == pytest.approx(throw_m_s(true), rel=5e-3)
    assert watch.stretching_j[0] + watch.bending_j[0] == pytest.approx(true.stored_j, rel=2e-3)


def test_a_hand_that_moves_agrees_with_elements() -> None:
    """A free mass with a preload that balances the band: when it is hit, how far it has moved, what it was given."""
    mass_kg = 0.01
    _, _, _, hand = launch.follow_hand(scene(law="mooney-rivlin", hand_mass_kg=mass_kg))
    true = by_elements("mooney-rivlin", MANY, mass_kg)
    assert hand.found.hit_s == pytest.approx(arrival_s(true), rel=3e-3)
    assert hand.found.displacement_m == pytest.approx(true.way_m[-2, 0], rel=0.03)
    assert hand.found.impulse_n_s == pytest.approx(true.impulse_n_s[-2, 0], rel=0.02)
