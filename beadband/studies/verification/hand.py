"""Rung ``hand``: a finger that the band moves, against the string's force, an oscillator, and the finger that stays."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from beadband.analysis.energy import launch_balance
from beadband.model.bands import laws_of
from beadband.model.launch_string import hand_under_string, hit_by_string
from beadband.model.scene import scene_of
from beadband.runs.launch import follow_hand, follow_launch
from beadband.runs.launch_results import SCATTER, WEIGHTS
from beadband.studies.verification.check import Check

_SCENE: dict[str, Any] = {"until": "launch", "for": "speed", "beads": 400}


def hand() -> list[Check]:
    """Limits, an exact motion, and what is kept.

    * Next to no bending and a heavy hand: the string's force on a finger that stays, integrated twice. The band touches
      the finger once more after its fronts have met, which the string does not: under 1 % of the impulse.
    * A hand that the band has left: mass, spring, damper and preload in closed form.
    * A very heavy hand: arrival, impulse and force of the finger that stays.
    * A hand that moves by a millimetre: its momentum, and the energy of band and hand.
    """
    return [*_string(), _oscillator(), *_heavy(), *_kept()]


def _string() -> list[Check]:
    checks = []
    for law in laws_of("III"):
        scene = scene_of(_SCENE | {"law": law, "bending_scale": 1e-4, "hand_mass_kg": 0.1})
        plan, _, _, moved = follow_hand(scene)
        times = np.asarray(moved.path.steps * plan.timestep_s, dtype=np.float64)
        way, string = hand_under_string(scene, times), hit_by_string(scene)
        apart = float(np.abs(moved.path.x_m - way).max()) / float(way[-1])
        found = moved.found
        checks += [
            Check("hand", f"{law}: largest error of the way (of that to the hit)", apart, 0.0, 0.025),
            Check("hand", f"{law}: time of the hit (s)", found.hit_s or 0.0, string.hit_s or 0.0, 2e-3),
            Check("hand", f"{law}: its speed (m/s)", found.hit_speed_m_s or 0.0, string.hit_speed_m_s or 0.0, 5e-4),
        ]
    return checks


def _oscillator() -> Check:
    mass, stiffness, damping = 0.01, 2e4, 3.0
    values = {"hand_mass_kg": mass, "hand_stiffness_n_m": stiffness, "hand_damping_n_s_m": damping}
    plan, _, watch, moved = follow_hand(scene_of(_SCENE | values))
    first = int(np.flatnonzero(watch.mean_force_n)[-1]) + 1
    path = moved.path
    times = (path.steps[first:] - path.steps[first]) * plan.timestep_s
    rest = moved.motion.preload_n / stiffness
    roots = np.roots([mass, damping, stiffness]).astype(complex)
    parts = np.linalg.solve(np.array([[1.0, 1.0], roots]), [path.x_m[first] - rest, path.velocity_m_s[first]])
    exact = rest + (parts @ np.exp(np.outer(roots, times))).real
    apart = float(np.abs(path.x_m[first:] - exact).max()) / float(np.ptp(exact))
    return Check("hand", "left by the band: largest error of the way (of itself)", apart, 0.0, 1e-4)


def _heavy() -> list[Check]:
    scene = scene_of(_SCENE)
    _, found, _ = follow_launch(scene)
    moved = follow_hand(replace(scene, hand_mass_kg=1e6))[3].found
    note, late = "bound: the scatter of a band that rattles", WEIGHTS["rear_arrival_s"] * SCATTER
    return [
        Check("hand", "1000 t: time of the hit (s)", moved.hit_s or 0.0, found.rear_arrival_s or 0.0, late, note),
        Check("hand", "1000 t: impulse (N s)", moved.impulse_n_s, found.impulse_n_s, SCATTER, note),
    ]


def _kept() -> list[Check]:
    values = {"hand_mass_kg": 4e-3, "hand_stiffness_n_m": 300.0, "hand_damping_n_s_m": 1.0}
    plan, _, watch, moved = follow_hand(scene_of(_SCENE | values))
    momentum = moved.checks(float(watch.momentum_n_s[-1]))["hand"].value
    energy = launch_balance(watch, plan.timestep_s, moved.energy_j).error
    return [
        Check("hand", "momentum less impulses (of the band's momentum)", momentum, 0.0, 1e-10),
        Check("hand", "unbalanced energy of band and hand (of the stored)", energy, 0.0, 1e-3),
    ]
