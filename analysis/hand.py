"""A hand that the band moves, measured: whether the rear hits it, when and how hard; arrays in, values out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from beadband.analysis.contact import rear_arrival_s, verlet_integral
from beadband.analysis.fits import Array, slope
from beadband.analysis.readers import HandPath, Watch

LATEST_HIT = 3.0
"""Times the arrival at a fixed finger after which a rear that has not come does not count."""
PEAK_SHARE = 0.03
"""Half-width of the window of a peak force, over the front's arrival: raw peaks belong to the contact."""
SPEED_SHARE = 0.25
"""Time before the hit whose gaps give its speed, over the front's arrival: in shorter ones the nose rings."""


@dataclass(frozen=True)
class HandMotion:
    """A hand with what acts on it; SI units."""

    mass_kg: float | None
    """None for a finger whose velocity is prescribed."""
    stiffness_n_m: float
    damping_n_s_m: float
    preload_n: float


@dataclass(frozen=True)
class HandMeasurement:
    """What the hand felt, from the release to the hit, or to the end of the run where it is not hit."""

    hit: bool
    hit_s: float | None
    hit_speed_m_s: float | None
    """Rate at which the gap between the rear and the finger closes before the hit; None without one."""
    peak_force_n: float
    impulse_n_s: float
    """Of the band on the hand, against the throw."""
    displacement_m: float
    """Of the hand along the throw."""
    velocity_m_s: float


def hand_energy_j(hand: HandMotion, path: HandPath, watch: Watch, timestep_s: float) -> Array:
    """Energy that the hand has taken from the band by each line, shape (lines,).

    M X'^2/2 + K X^2/2 - F_pre X and the damper's loss; for a prescribed velocity the band's work on it.
    """
    intervals = np.diff(path.steps, prepend=0) * timestep_s
    if hand.mass_kg is None:
        taken: Array = -np.cumsum(watch.mean_force_n * path.mean_velocity_m_s * intervals)
        return taken
    lost = hand.damping_n_s_m * np.cumsum(path.mean_square_m2_s2 * intervals)
    kept = 0.5 * hand.mass_kg * path.velocity_m_s**2 + 0.5 * hand.stiffness_n_m * path.x_m**2
    return np.asarray(kept + lost - hand.preload_n * path.x_m, dtype=np.float64)


def hand_impulse_n_s(hand: HandMotion, path: HandPath, timestep_s: float) -> float:
    """Impulse of the preload, the spring and the damper over the whole run, by the integrator's own sum."""
    way = verlet_integral(path.steps, path.mean_x_m, path.x_m, timestep_s)
    moved = verlet_integral(path.steps, path.mean_velocity_m_s, path.velocity_m_s, timestep_s)
    time = float(path.steps[-1]) * timestep_s
    return hand.preload_n * time - hand.stiffness_n_m * way - hand.damping_n_s_m * moved


def peak_n(times_s: Array, mean_force_n: Array, end_s: float, half_width_s: float) -> float:
    """Largest Hann mean of a force, of windows of +-``half_width_s`` that lie between 0 and ``end_s``.

    ``mean_force_n`` (lines,) are means over equal intervals that end at ``times_s``; the first line, at 0, has none.
    """
    force, interval = mean_force_n[1:][times_s[1:] <= end_s], float(times_s[1] - times_s[0])
    half = int(half_width_s / interval)
    window = np.cos(0.5 * np.pi * np.arange(-half, half + 1) * interval / half_width_s) ** 2
    if len(force) < len(window):
        return float(force.max())
    return float(np.convolve(force, window / window.sum(), "valid").max())


def measure_hand(
    path: HandPath, watch: Watch, timestep_s: float, margin_m: float, front_arrival_s: float
) -> HandMeasurement:
    """What the hand felt, from hand.dat and finger.dat; ``margin_m`` as :func:`rear_arrival_s` takes it.

    The rear's motion up to then does not know where the finger is, so that the arrival at a fixed one is when the rear
    comes to the place where the finger rested.
    """
    times = watch.times_s(timestep_s)
    arrival = rear_arrival_s(times, watch.gap_m, margin_m)
    fixed = rear_arrival_s(times, watch.gap_m + path.x_m, margin_m)
    hit = arrival is not None and (fixed is None or arrival < LATEST_HIT * fixed)
    end = arrival if hit and arrival is not None else float(times[-1])
    speed = None
    if hit:
        speed = -slope(times, watch.gap_m, end - SPEED_SHARE * front_arrival_s, end).value
    upto = times <= end
    # A run stops just before the hit; what is left is done at the last velocity and without a force.
    last = int(np.flatnonzero(upto)[-1])
    return HandMeasurement(
        hit=hit,
        hit_s=arrival if hit else None,
        hit_speed_m_s=speed,
        peak_force_n=peak_n(times, watch.mean_force_n, end, PEAK_SHARE * front_arrival_s),
        impulse_n_s=verlet_integral(watch.steps[upto], watch.mean_force_n[upto], watch.force_n[upto], timestep_s),
        displacement_m=float(path.x_m[last] + path.velocity_m_s[last] * (end - times[last])),
        velocity_m_s=float(path.velocity_m_s[last]),
    )
