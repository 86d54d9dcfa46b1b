"""The tip on a peg: held shape, force and release, by the second method's own solutions of the same band."""

from __future__ import annotations

import math

import numpy as np

from beadband.analysis.fits import path_slope
from beadband.model.scales import SPEED_WINDOW
from beadband.model.scene import Scene, scene_of
from beadband.planning.plan import plan_of
from beadband.runs.held import hold
from beadband.runs.rear_run import follow_rear
from beadband.statics.chain import HalfRing
from beadband.statics.leg import LegRequest
from beadband.statics.peg import peg_leg
from beadband.studies.pareto.peers.elements import Rod, graded_nodes, held_shape, release
from beadband.studies.verification.check import Check

_RADIUS_M = 4e-3
_FEW, _MANY = 500, 2000
_LOSS_TIME_S, _ELEMENTS, _STEPS = 2e-5, 60, 300


def peg() -> list[Check]:
    """Leg and ring of a peg of 4 mm.

    The held leg of 2000 beads against the elastica, of the second order; the force that the ring bears on its peg,
    2 T cos(phi); V of a band with a loss time, so that beads and elements solve one smooth problem.
    """
    checks = []
    for law in ("linear", "mooney-rivlin"):
        scene = scene_of({"law": law, "tip_radius_m": _RADIUS_M, "for": "speed", "loss_time_s": _LOSS_TIME_S})
        few, many = (_distance(scene, beads) for beads in (_FEW, _MANY))
        order = math.log(few / many) / math.log(_MANY / _FEW)
        speed, exact = _speeds(scene)
        where = f"{law}, 4 mm"
        checks += [
            Check("peg", f"{where}: held leg, farthest from the elastica (of it)", many, 0.0, 1e-5),
            Check("peg", f"{where}: order of that distance", order, 2.0, 0.15),
            Check("peg", f"{where}: force on the peg (N)", *_forces(scene), 1e-8),
            Check("peg", f"{where}: V, by finite elements (m/s)", speed, exact, 5e-4),
        ]
    return checks


def _rod(scene: Scene) -> Rod:
    strand = scene.strand(1)
    viscosity = scene.band.modulus_pa * _LOSS_TIME_S
    return Rod(
        strand.law.stress,
        strand.law.tangent,
        strand.area_m2,
        strand.density_kg_m3,
        strand.bending_stiffness_n_m2,
        viscosity,
    )


def _distance(scene: Scene, beads: int) -> float:
    """Largest distance of a bead of the held leg from its place, over the leg."""
    strand, bonds = scene.strand(beads), beads // 4
    held, _ = peg_leg(LegRequest(strand, bonds, scene.strain, scene.half_angle_rad), scene.peg)
    places = np.linspace(0.0, bonds * strand.spacing_m, bonds + 1)
    exact, _ = held_shape(_rod(scene), 1.0 + scene.strain, scene.half_angle_rad, places, _RADIUS_M)
    return float(np.hypot(*(held.positions_m - exact).T).max()) / scene.wedge.leg_m


def _forces(scene: Scene) -> tuple[float, float]:
    """Force of a ring on its peg along the axis, and that of its two legs."""
    plan = plan_of(scene.with_beads(_FEW))
    ring = hold(plan)
    half = ring.positions_m[: plan.beads // 2 + 1]
    gradient = HalfRing(plan.strand, crossing=plan.beads % 2 == 1).gradient(half)
    on_peg = np.hypot(half[:, 0] - _RADIUS_M, half[:, 1]) < _RADIUS_M * (1.0 + 1e-9)
    return -2.0 * float(gradient[on_peg, 0].sum()), 2.0 * ring.tension_n * math.cos(scene.half_angle_rad)


def _speeds(scene: Scene) -> tuple[float, float]:
    """V of a leg of beads and of finite elements."""
    arrival = scene.scales.front_arrival_s
    start, end = (share * arrival for share in SPEED_WINDOW)
    nodes = graded_nodes(scene.wedge.reference_leg_m, _ELEMENTS, 4.0)
    held = 1.0 + scene.strain
    found = release(_rod(scene), held, scene.half_angle_rad, nodes, 0.9 * arrival, _STEPS, _RADIUS_M)
    by_beads = follow_rear(plan_of(scene.with_beads(2 * _FEW), "leg")).fitted_speed_m_s.value
    return by_beads, path_slope(found.times_s, found.tip_x_m, start, end)
