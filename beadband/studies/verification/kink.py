"""Rung ``kink``: a small corner in an unstretched strand, released at rest, against the linear beam."""

from __future__ import annotations

import math

import numpy as np

from beadband.analysis.curvature import curvatures
from beadband.studies.verification import specimen as specimens
from beadband.studies.verification.check import Check
from beadband.studies.verification.specimen import Array, bent, strand_of

_TURN = 1e-3
"""m: each half of the strand rises by this angle; linear theory holds to its square."""
_LATEST = 40.0
"""a_b t over w^2 at the end."""


def kink() -> list[Check]:
    """Curvature and travel of the corner of turning angle 2 m, released at rest.

    A sharp one has kappa = m/sqrt(2 pi a_b t) and travels m sqrt(2 a_b t/pi). As the mesh is refined its energy
    grows without bound, so the corner is rounded, kappa(s, 0) = 2 m exp(-s^2/(2 w^2))/(sqrt(2 pi) w), for which the
    beam equation gives, at any time,

        kappa(0, t) = m Re 1/sqrt(pi (w^2/2 + i a_b t)),  travel = 2 m/sqrt(pi) [Re sqrt(w^2/2 + i a_b t) - w/sqrt(2)],

    and which the sharp law follows once a_b t is large against w^2. On the lattice a corner within a single bead has
    the exact turning angle 2 m cos(x) J0(x), x = 2 a_b t/a^2: half of it rings for ever at the scale of the beads.
    """
    return _rounded() + _sharp()


def _rounded(half: int = 640, width: float = 4.0) -> list[Check]:
    strand = strand_of("III", "linear", 1e-3)
    a, diffusivity = strand.spacing_m, strand.bending_diffusivity_m2_s
    w = width * a
    along = a * np.arange(-half, half + 1)
    turning = np.exp(-0.5 * (along / w) ** 2)
    specimen = bent(strand, 2.0 * _TURN * turning / turning.sum())
    end = _LATEST * w * w / diffusivity  # before waves of the number 4/w are back from the ends
    step, every, frames = _steps(0.65 * strand.largest_step_s(0.0, 0.0, 1.0), end, 50)
    record = specimens.run(specimen, step, frames * every, every)
    kappa, travel = _tip(record.positions_m, half, a)
    checks = []
    for share, bounds in ((0.1, (2e-3, 1e-2)), (0.4, (2e-3, 5e-3)), (1.0, (2e-3, 5e-3))):
        frame = round(share * frames)
        spread = 0.5 * w * w + 1j * diffusivity * record.times_s[frame]
        exact = _TURN * (1.0 / np.sqrt(math.pi * spread)).real
        way = 2.0 * _TURN / math.sqrt(math.pi) * (np.sqrt(spread).real - w / math.sqrt(2.0))
        at = f"a_b t = {_LATEST * share:g} w^2"
        checks.append(Check("kink", f"rounded corner: curvature at {at} (1/m)", kappa[frame], float(exact), bounds[0]))
        checks.append(Check("kink", f"rounded corner: travel at {at} (m)", travel[frame], float(way), bounds[1]))
    time = float(record.times_s[-1])
    sharp = _TURN / math.sqrt(2.0 * math.pi * diffusivity * time)
    checks.append(Check("kink", "late curvature, m/sqrt(2 pi a_b t) (1/m)", kappa[-1], sharp, 2e-2))
    late = record.times_s >= 0.5 * time
    slope = np.polyfit(np.sqrt(record.times_s[late]), travel[late], 1)[0]
    way = _TURN * math.sqrt(2.0 * diffusivity / math.pi)
    checks.append(Check("kink", "late travel over sqrt(t), m sqrt(2 a_b/pi) (m/s^0.5)", float(slope), way, 2e-2))
    return checks


def _sharp(half: int = 60) -> list[Check]:
    from scipy.special import j0

    strand = strand_of("III", "linear", 1e-3)
    a = strand.spacing_m
    turning = np.zeros(2 * half + 1)
    turning[half] = 2.0 * _TURN
    end = 20.0 * a * a / (2.0 * strand.bending_diffusivity_m2_s)
    step, every, frames = _steps(0.02 * strand.largest_step_s(0.0, 0.0, 1.0), end, 80)
    record = specimens.run(bent(strand, turning), step, frames * every, every)
    kappa, _ = _tip(record.positions_m, half, a)
    x = 2.0 * strand.bending_diffusivity_m2_s * record.times_s / a**2
    worst = float(np.abs(a * kappa - 2.0 * _TURN * np.cos(x) * j0(x)).max()) / (2.0 * _TURN)
    return [Check("kink", "sharp corner: worst deviation from the lattice's cos(x) J0(x)", worst, 0.0, 1e-3)]


def _steps(largest_s: float, end_s: float, frames: int) -> tuple[float, int, int]:
    """Step, steps between frames and frames that end at a time."""
    every = math.ceil(end_s / frames / largest_s)
    return end_s / frames / every, every, frames


def _tip(positions_m: Array, tip: int, spacing_m: float) -> tuple[Array, Array]:
    """Signed curvature and travel of the middle bead over the frames."""
    before, at, after = (positions_m[:, tip + k] for k in (-1, 0, 1))
    first, second = at - before, after - at
    sign = np.sign(first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])
    return sign * curvatures(before, at, after, spacing_m), at[:, 1] - at[0, 1]
