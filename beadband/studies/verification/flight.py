"""Rung ``flight``: the flight to the ground against what is exact, and the air across a band against a circle's."""

from __future__ import annotations

import math

import numpy as np

from beadband.analysis.drag import cross_flow_m3_s2
from beadband.model.flight import CIRCLE, GRAVITY_M_S2, fly
from beadband.studies.verification.check import Check


def flight() -> list[Check]:
    """Without air V^2 sin(2 theta)/g; straight up (L/2) ln(1 + V^2/(g L)); from high up sqrt(g L); a circle in air."""
    speed, theta, length = 12.6, math.radians(20.0), 3.85
    angle = np.linspace(0.0, 2.0 * math.pi, 521)[:-1]
    ring = 0.05 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    moved = np.stack([ring, ring + np.array([speed * 1e-5, 0.0])])
    across = cross_flow_m3_s2(np.array([0.0, 1e-5]), moved)[0, 0] / (2.0 * math.pi * 0.05 * speed**2)
    exact = speed**2 * math.sin(2.0 * theta) / GRAVITY_M_S2
    top = 0.5 * length * math.log(1.0 + speed**2 / (GRAVITY_M_S2 * length))
    terminal = math.sqrt(GRAVITY_M_S2 * length)
    upward, fall = fly(speed, math.radians(89.99), 0.0, length), fly(speed, theta, 100.0, length)
    return [
        Check("flight", "range without air (m)", fly(speed, theta).range_m, exact, 1e-10),
        Check("flight", "highest point of a throw straight up, in air (m)", upward.top_m, top, 1e-6),
        Check("flight", "speed after a long fall (m/s)", fall.landing_speed_m_s, terminal, 1e-6),
        Check("flight", "share of a circle that lies across its flight", float(across), CIRCLE, 1e-4),
    ]
