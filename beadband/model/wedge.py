"""The scene as geometry, and its exact answer without bending: the string limit (EI -> 0)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from beadband.model.bands import Band
from beadband.model.laws import Law, UnloadingWave
from beadband.model.roots import root


@dataclass(frozen=True)
class Wedge:
    """A uniformly stretched string around a finger, held at a point (lengths in m).

    Legs of stretched length L leave the tip at the half-angle to both sides and touch the finger tangentially.
    """

    leg_m: float
    """Stretched leg L, from the tip to where it touches the finger."""
    reference_leg_m: float
    """The same leg unstretched, l0 = L/(1 + strain)."""
    finger_radius_m: float
    """R = L tan(half-angle)."""


def wedge_of(circumference_m: float, strain: float, half_angle_rad: float) -> Wedge:
    """Close the band around the finger: (1+strain) Cb = L [2 + tan(phi) (pi + 2 phi)]."""
    slope = math.tan(half_angle_rad)
    leg = (1.0 + strain) * circumference_m / (2.0 + slope * (math.pi + 2.0 * half_angle_rad))
    return Wedge(leg, leg / (1.0 + strain), leg * slope)


@dataclass(frozen=True)
class StringLimit:
    """Exact self-similar release of a string wedge; speeds in m/s."""

    residual_strain: float
    """Strain behind the front, kept up by the kink."""
    residual_stress_pa: float
    leg_speed_m_s: float
    """Speed of the leg along itself behind the front, u."""
    rear_speed_m_s: float
    """Speed of the rear segment, V = u cos(phi)/(1 - sin(phi))."""
    front_speed_m_s: float
    """Speed of the unloading front in reference length."""
    wave: UnloadingWave
    """The whole unloading wave, of which the front is the foremost point."""


def rear_speed_m_s(particle_m_s: Any, sine: Any, cosine: Any) -> Any:
    """V = u cos(phi)/(1 - sin(phi)), u the speed of the leg along itself; floats or arrays."""
    return particle_m_s * cosine / (1.0 - sine)


@lru_cache(maxsize=256)
def string_limit(law: Law, density_kg_m3: float, strain: float, half_angle_rad: float) -> StringLimit:
    """Solve u sin(phi) = k (1 - sin(phi)), k = sqrt(stress1 stretch1/density), for the stretch behind the front.

    The residual tension is always positive: without it the kink could not travel.
    """
    sine = math.sin(half_angle_rad)
    held = 1.0 + strain

    held_pa = float(law.stress(held))

    def surplus(behind: float, stress_pa: float, leg_speed: float) -> float:
        return leg_speed * sine - math.sqrt(max(stress_pa, 0.0) * behind / density_kg_m3) * (1.0 - sine)

    def behind_one_front(behind: float) -> float:
        stress = float(law.stress(behind))
        return surplus(behind, stress, math.sqrt(max((held_pa - stress) * (held - behind), 0.0) / density_kg_m3))

    def behind_the_wave(behind: float) -> float:
        wave = law.unloading_wave(held, behind, density_kg_m3)
        return surplus(behind, float(law.stress(behind)), wave.particle_speed_m_s)

    # Most waves are one front, whose speed has a closed form. Where that is not the admissible wave the envelope of
    # the law decides at every step of the search.
    behind = root(behind_one_front, 1.0, held)
    wave = law.unloading_wave(held, behind, density_kg_m3)
    if len(wave.parts) != 1 or wave.tail_speed_m_s != wave.front_speed_m_s:
        behind = root(behind_the_wave, 1.0, held)
        wave = law.unloading_wave(held, behind, density_kg_m3)
    return StringLimit(
        residual_strain=behind - 1.0,
        residual_stress_pa=float(law.stress(behind)),
        leg_speed_m_s=wave.particle_speed_m_s,
        rear_speed_m_s=rear_speed_m_s(wave.particle_speed_m_s, sine, math.cos(half_angle_rad)),
        front_speed_m_s=wave.front_speed_m_s,
        wave=wave,
    )


def strip_limit(law: Law, density_kg_m3: float, strain: float) -> StringLimit:
    """Exact release of one end of a straight strip: the wedge closed to a half-angle of 0.

    The free end carries no tension, so the wave takes the stretch down to where the stress ends, and the end moves as
    fast as the material behind the wave.
    """
    behind = law.unstressed_stretch
    wave = law.unloading_wave(1.0 + strain, behind, density_kg_m3)
    speed = wave.particle_speed_m_s
    return StringLimit(behind - 1.0, 0.0, speed, speed, wave.front_speed_m_s, wave)


def published_ratio(strain: Any, half_angle_rad: Any) -> Any:
    """V/C of the published formula, [strain/(1+strain)]/(1 - sin phi): the limit of no residual tension.

    Floats or arrays.
    """
    sine = math.sin(half_angle_rad) if isinstance(half_angle_rad, float) else np.sin(half_angle_rad)
    return strain / (1.0 + strain) / (1.0 - sine)


def wave_speeds(band: Band, front_speed_m_s: Any, strain: Any, half_angle_rad: Any) -> dict[str, Any]:
    """The three speeds that a rebound is divided by, in m/s; floats or arrays.

    ``bar`` is sqrt(E/density), ``rest`` sqrt(E0/density), ``front_horizontal`` the speed in space at which the
    front runs towards the finger, (1+strain) cos(phi) times its speed in reference length.
    """
    cosine = math.cos(half_angle_rad) if isinstance(half_angle_rad, float) else np.cos(half_angle_rad)
    return {
        "bar": band.bar_speed_m_s,
        "rest": band.rest_speed_m_s,
        "front_horizontal": (1.0 + strain) * front_speed_m_s * cosine,
    }
