"""The released ring of beads against a second method for the same rod, which shares nothing with it but the physics.

A loss time of the material's own makes both solve one smooth problem, at any number of beads.
"""

from __future__ import annotations

import math
from functools import cache
from typing import NamedTuple

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from beadband.analysis.fits import Array, hann_mean, slope
from beadband.runs.held import hold
from beadband.studies.pareto.peers.elements import Elements, Released, Rod, graded_nodes, held_shape, release
from conftest import rear_of

# Band III and its wedge.
MODULUS_PA, C10_PA, C01_PA = 1.1e6, 0.187e6, 0.122e6
WIDTH_M, THICKNESS_M, CIRCUMFERENCE_M, DENSITY_KG_M3 = 1.6e-3, 2.0e-3, 0.204, 1300.0
STRETCH, HALF_ANGLE = 1.476, math.radians(14.0)
LEG_M = CIRCUMFERENCE_M / (2.0 + math.tan(HALF_ANGLE) * (math.pi + 2.0 * HALF_ANGLE))
LOSS_TIME_S = 2e-5

LAWS = {
    "linear": (lambda s: MODULUS_PA * (s - 1.0), lambda s: MODULUS_PA + 0.0 * s),
    "mooney-rivlin": (
        lambda s: 2.0 * (s - s**-2) * (C10_PA + C01_PA / s),
        lambda s: 2.0 * (C10_PA * (1.0 + 2.0 * s**-3) + 3.0 * C01_PA * s**-4),
    ),
}
COARSE, FINE = (60, 300), (120, 600)
"""Elements and steps of the second method."""
FEW, MANY = 400, 800
"""Beads."""
SHARES = (0.1, 0.2, 0.3)
END_SHARE = 0.9

each_law = pytest.mark.parametrize("law", list(LAWS))


class Rebound(NamedTuple):
    """What is compared: rebound speed, mean tip curvatures at :data:`SHARES` of t_f, the tip's path."""

    speed_m_s: float
    curvatures_1_m: Array
    path_m: Array


def rod_of(law: str) -> Rod:
    stress, tangent = LAWS[law]
    stiffness = MODULUS_PA * WIDTH_M * THICKNESS_M**3 / 12.0
    return Rod(stress, tangent, WIDTH_M * THICKNESS_M, DENSITY_KG_M3, stiffness, MODULUS_PA * LOSS_TIME_S)


def rebound(times_s: Array, tip_x_m: Array, curvature_1_m: Array, arrival_s: float) -> Rebound:
    speed = slope(times_s, tip_x_m, 0.4 * arrival_s, 0.85 * arrival_s).value
    half_width = 0.03 * arrival_s
    means = [hann_mean(times_s, curvature_1_m, share * arrival_s, half_width) for share in SHARES]
    return Rebound(speed, np.array(means), np.interp(np.linspace(0.05, 0.85, 81) * arrival_s, times_s, tip_x_m))


@cache
def by_beads(law: str, beads: int) -> Rebound:
    plan, found = rear_of(law=law, beads=beads, loss_time_s=LOSS_TIME_S)
    rear = found.rear
    return rebound(rear.times_s, rear.tip_x_m, rear.tip_curvature_1_m, plan.front_arrival_s)


@cache
def by_elements(law: str, elements: int, steps: int) -> Rebound:
    arrival = rear_of(law=law, beads=MANY, loss_time_s=LOSS_TIME_S)[0].front_arrival_s
    nodes = graded_nodes(LEG_M, elements, 4.0)
    found: Released = release(rod_of(law), STRETCH, HALF_ANGLE, nodes, END_SHARE * arrival, steps)
    return rebound(*found, arrival)


def differences(one: Rebound, other: Rebound) -> tuple[float, float, float]:
    """Relative differences of the speeds, of the curvatures and of the paths, the last over the whole way."""
    return (
        abs(one.speed_m_s / other.speed_m_s - 1.0),
        float(np.abs(one.curvatures_1_m / other.curvatures_1_m - 1.0).max()),
        float(np.abs(one.path_m - other.path_m).max() / other.path_m[-1]),
    )


@each_law
def test_held_tip_is_bent_as_the_continuum_says(law: str) -> None:
    """EI/2 k^2 at the tip is the integral of the stretch over the force, from T sin(phi) to T."""
    rod = rod_of(law)
    tension = rod.area_m2 * float(rod.stress_pa(STRETCH))

    def stretch(force: float) -> float:
        return brentq(lambda s: rod.area_m2 * float(rod.stress_pa(s)) - force, 0.9, STRETCH, xtol=1e-14)

    work = quad(stretch, tension * math.sin(HALF_ANGLE), tension)[0]
    exact = math.sqrt(2.0 * work / rod.bending_stiffness_n_m2)
    errors = []
    for beads in (FEW, MANY):
        plan, found = rear_of(law=law, beads=beads, loss_time_s=LOSS_TIME_S)
        assert hold(plan).tension_n == pytest.approx(tension, rel=1e-9)
        errors.append(abs(found.rear.tip_curvature_1_m[0] / exact - 1.0))
    assert errors[1] < 0.006
    assert errors[1] < 0.6 * errors[0]


@each_law
def test_second_method_starts_in_equilibrium(law: str) -> None:
    """The hold on the tip bears T cos(phi) of each leg, and nothing else is out of balance."""
    rod, nodes = rod_of(law), graded_nodes(LEG_M, 240, 4.0)
    mesh = Elements(rod, nodes)
    held = np.concatenate(held_shape(rod, STRETCH, HALF_ANGLE, nodes), axis=1).ravel()
    forces = mesh.loads(held, 0.0 * held, 0.0 * held).reshape(-1, 4)[:, :2]
    tension = rod.area_m2 * float(rod.stress_pa(STRETCH))
    assert forces[0, 0] == pytest.approx(-tension * math.cos(HALF_ANGLE), rel=0.01)
    assert np.abs(forces[1:]).max() < 0.01 * tension


@each_law
def test_second_method_is_converged(law: str) -> None:
    speed, curvature, path = differences(by_elements(law, *COARSE), by_elements(law, *FINE))
    assert speed < 1e-4
    assert curvature < 4e-3
    assert path < 3e-4


@each_law
def test_beads_agree_with_the_second_method(law: str) -> None:
    speed, curvature, path = differences(by_beads(law, MANY), by_elements(law, *FINE))
    assert speed < 5e-4
    assert curvature < 5e-3
    assert path < 1e-3


@each_law
def test_beads_draw_nearer_to_the_second_method(law: str) -> None:
    few, many = (differences(by_beads(law, beads), by_elements(law, *FINE)) for beads in (FEW, MANY))
    assert all(fine < 0.6 * coarse for fine, coarse in zip(many, few, strict=True))


@each_law
def test_extrapolated_beads_meet_the_second_method(law: str) -> None:
    """Without the errors of second order in the spacing: value(2N) + (value(2N) - value(N))/3."""
    few, many = by_beads(law, FEW), by_beads(law, MANY)
    limit = Rebound(*(fine + (fine - coarse) / 3.0 for fine, coarse in zip(many, few, strict=True)))
    speed, curvature, path = differences(limit, by_elements(law, *FINE))
    assert speed < 2e-4
    assert curvature < 1.5e-3
    assert path < 5e-4
