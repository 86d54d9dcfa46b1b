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

import numpy as np
from numpy.typing import NDArray

from beadband.model.scene import Scene

Array = NDArray[np.float64]


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


def string_launch(scene: Scene) -> StringLaunch:
    """The string's launch of a scene."""
    band, string, wedge, phi = scene.band, scene.string, scene.wedge, scene.half_angle_rad
    law, held, behind = scene.material, 1.0 + scene.strain, 1.0 + scene.string.residual_strain
    tension = band.area_m2 * float(law.stress(held))
    on_finger = (0.5 * band.circumference_m - wedge.reference_leg_m) / string.front_speed_m_s
    arrival = wedge.reference_leg_m / string.front_speed_m_s
    momentum = 2.0 * tension * (arrival * math.cos(phi) + on_finger * (1.0 + math.sin(phi)) / (math.pi / 2.0 + phi))
    mass = band.mass_per_length_kg_m * band.circumference_m
    stored = band.area_m2 * band.circumference_m * float(law.energy(held))
    chord = (float(law.stress(held)) - string.residual_stress_pa) / ((held - behind) * band.density_kg_m3)
    return StringLaunch(
        tension_n=tension,
        momentum_n_s=momentum,
        centre_of_mass_speed_m_s=momentum / mass,
        stored_j=stored,
        efficiency=momentum**2 / (2.0 * mass * stored),
        finger_free_s=arrival + on_finger,
        turning_1_s=(math.pi / 2.0 + phi) / on_finger,
        rear_arrival_s=(wedge.leg_m / math.cos(phi) - wedge.finger_radius_m) / string.rear_speed_m_s,
        exact=abs(chord / string.front_speed_m_s**2 - 1.0) < 1e-6 and math.sin(phi) < 0.5,
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
