"""The launch of a string (EI -> 0), in closed form: what the beads are checked against.

Behind its single front the band has the string's residual strain and runs along itself at u. On the finger the
residual tension can hold it against its own inertia only if the kink's speed k = sqrt(stress1 stretch1/density)
exceeds u; from u sin(phi) = k (1 - sin(phi)) follows that below a half-angle of 30 degrees it does not: the band comes
off where the front passes, and the finger carries the tension T of what the front has not reached, over an arc whose
ends stand at the angles +-theta from the axis,

    F = 2 T cos(phi) until the front arrives, then 2 T sin(theta), theta = (pi/2 + phi)(Cb/2 - S)/(Cb/2 - l0),

with S the front's way in reference length. The two fronts meet at S = Cb/2: the finger is free. The momentum of the
band is the integral of F; what happens among the beads after the fronts have met can't change it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beadband.model.scene import Scene

Array = NDArray[np.float64]
HIT_SHARE = 0.25
"""Time before a hit whose gaps give its speed, over the front's arrival: in shorter ones the nose of a band rings."""


@dataclass(frozen=True)
class StringLaunch:
    """A launch without bending; speeds in m/s, times in s."""

    tension_n: float
    """Tension T of a leg."""
    momentum_n_s: float
    """Impulse of the finger until it is free."""
    centre_of_mass_speed_m_s: float
    stored_j: float
    efficiency: float
    """Translation of the centre of mass over the stored energy."""
    finger_free_s: float
    """When the fronts meet, (Cb/2)/(front speed)."""
    turning_1_s: float
    """Rate at which the angle theta of what lies on the finger falls once the front has arrived there."""
    rear_arrival_s: float
    """When the rear, at its constant speed, has come from the tip to the finger's surface, (L/cos(phi) - R)/V."""
    exact: bool
    """Whether the premises hold: one sharp front, and a half-angle below 30 degrees."""

    @property
    def pause_s(self) -> float:
        """From the finger's freedom to the rear's arrival; negative where the rear comes first."""
        return self.rear_arrival_s - self.finger_free_s


def one_front(mean_speed_ratio: Any, half_angle_rad: Any) -> Any:
    """Whether the premises hold: one sharp front, and a half-angle below 30 degrees; floats or arrays."""
    return (np.abs(mean_speed_ratio - 1.0) < 1e-6) & (np.sin(half_angle_rad) < 0.5)


def string_momentum_n_s(tension_n: Any, circumference_m: Any, leg_m: Any, front_m_s: Any, half_angle_rad: Any) -> Any:
    """Impulse of the finger until it is free, the integral of its force; ``leg_m`` is l0. Floats or arrays."""
    arrival, on_finger = leg_m / front_m_s, (0.5 * circumference_m - leg_m) / front_m_s
    turned = (1.0 + np.sin(half_angle_rad)) / (0.5 * math.pi + half_angle_rad)
    return 2.0 * tension_n * (arrival * np.cos(half_angle_rad) + on_finger * turned)


def string_launch(scene: Scene) -> StringLaunch:
    """The string's launch of a scene."""
    band, string, wedge, phi = scene.band, scene.string, scene.wedge, scene.half_angle_rad
    law, held = scene.material, 1.0 + scene.strain
    tension = band.area_m2 * float(law.stress(held))
    on_finger = (0.5 * band.circumference_m - wedge.reference_leg_m) / string.front_speed_m_s
    arrival = wedge.reference_leg_m / string.front_speed_m_s
    momentum = float(
        string_momentum_n_s(tension, band.circumference_m, wedge.reference_leg_m, string.front_speed_m_s, phi)
    )
    mass = band.mass_per_length_kg_m * band.circumference_m
    stored = band.area_m2 * band.circumference_m * float(law.energy(held))
    return StringLaunch(
        tension_n=tension,
        momentum_n_s=momentum,
        centre_of_mass_speed_m_s=momentum / mass,
        stored_j=stored,
        efficiency=momentum**2 / (2.0 * mass * stored),
        finger_free_s=arrival + on_finger,
        turning_1_s=(math.pi / 2.0 + phi) / on_finger,
        rear_arrival_s=(wedge.leg_m / math.cos(phi) - wedge.finger_radius_m) / string.rear_speed_m_s,
        exact=bool(one_front(string.wave.mean_speed_ratio, phi)),
    )


def finger_force_n(scene: Scene, times_s: Array) -> Array:
    """Force of the finger on the string over time (times,), N, along the axis."""
    band, wedge, phi = scene.band, scene.wedge, scene.half_angle_rad
    tension = band.area_m2 * float(scene.material.stress(1.0 + scene.strain))
    half = 0.5 * band.circumference_m
    front = scene.string.front_speed_m_s * np.asarray(times_s, dtype=np.float64)
    left = np.clip((half - front) / (half - wedge.reference_leg_m), 0.0, 1.0)
    force: Array = 2.0 * tension * np.sin((math.pi / 2.0 + phi) * left)
    return force


@dataclass(frozen=True)
class StringHit:
    """A hand under the force of the string; None for what does not happen before three times the rear's arrival."""

    hit_s: float | None
    hit_speed_m_s: float | None
    displacement_m: float | None


def hand_under_string(scene: Scene, times_s: Array) -> Array:
    """Place of the scene's hand under the string's force on a finger that stays, at rising times from 0 on (times,), m.

    The finger's motion changes the string's force by 2 x (mass per length) x (wave speed) x (its speed) at most: this
    is the limit of a hand that is slow against the waves.
    """
    from scipy.integrate import solve_ivp

    hand = scene.hand
    if hand is None or hand.mass_kg is None:
        return np.asarray((hand.velocity_m_s if hand else 0.0) * times_s, dtype=np.float64)
    mass, string = hand.mass_kg, string_launch(scene)
    pull = float(finger_force_n(scene, np.zeros(1))[0])
    preload = pull if hand.preload_n is None else hand.preload_n

    def rate(time: float, state: Array) -> list[float]:
        push = float(finger_force_n(scene, np.array([time]))[0])
        force = preload - hand.stiffness_n_m * state[0] - hand.damping_n_s_m * state[1] - push
        return [float(state[1]), force / mass]

    # The force has corners where the front reaches the finger and where the fronts meet.
    corners = [scene.scales.front_arrival_s, string.finger_free_s]
    ends = [0.0, *(corner for corner in corners if corner < times_s[-1]), float(times_s[-1])]
    places, state = np.zeros(len(times_s)), np.zeros(2)
    for start, end in pairwise(ends):
        inside = (times_s >= start) & (times_s <= end)
        found = solve_ivp(rate, (start, end), state, "DOP853", dense_output=True, rtol=1e-9, atol=1e-13)
        places[inside], state = found.sol(times_s[inside])[0], found.y[:, -1]
    return places


def hit_by_string(scene: Scene, points: int = 2001) -> StringHit:
    """When and how fast the string's rear, at its constant speed, comes to the surface of the scene's hand."""
    string, speed = string_launch(scene), scene.string.rear_speed_m_s
    times = np.linspace(0.0, 3.0 * string.rear_arrival_s, points)
    places = hand_under_string(scene, times)
    gaps = speed * (string.rear_arrival_s - times) + places
    past = np.flatnonzero(gaps <= 0.0)
    if len(past) == 0:
        return StringHit(None, None, None)
    last = int(past[0])
    time = float(times[last] + gaps[last] * (times[last] - times[last - 1]) / (gaps[last - 1] - gaps[last]))
    before = (times <= time) & (times >= time - HIT_SHARE * scene.scales.front_arrival_s)
    rate = -float(np.polyfit(times[before] - time, gaps[before], 1)[0])
    return StringHit(time, rate, float(np.interp(time, times, places)))
