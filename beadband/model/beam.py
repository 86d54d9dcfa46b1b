"""Closed forms of the released beam kink: the paper's Eqs. 3 to 9, corrected, and the linear beam released at rest.

s is the arc length from the rear tip, t the time since the release, phi the half-angle of the wedge and
a_b = sqrt(EI/(density A)); xi = s/sqrt(a_b t) is the similarity variable. Angles in rad, SI units. Every function takes
floats or arrays that broadcast.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

ROOT_TWO_PI = math.sqrt(2.0 * math.pi)
# 2F3 is summed as a series whose terms reach exp(2 sqrt|z|): beyond this the digits are gone.
_LARGEST_SERIES = 100.0


def similarity(s_m: Any, time_s: Any, diffusivity_m2_s: float) -> Any:
    """xi = s/sqrt(a_b t), dimensionless."""
    return s_m / (diffusivity_m2_s * time_s) ** 0.5


def general_angle(s_m: Any, time_s: Any, diffusivity_m2_s: float, constants: tuple[float, float, float, float]) -> Any:
    """General self-similar solution of Eq. 2, Eq. 3: C1 (s^2/t) 2F3(...) + C2 FresnelS + C3 FresnelC + C4.

    C1 has the unit s/m2, the others are angles. ValueError where xi^4/64 is above 100, out of reach of the series.
    """
    from scipy.special import fresnel

    c1, c2, c3, c4 = constants
    xi = similarity(s_m, time_s, diffusivity_m2_s)
    sine, cosine = fresnel(xi / ROOT_TWO_PI)
    angle = c2 * sine + c3 * cosine + c4
    return angle + c1 * np.square(s_m) / time_s * _hypergeometric(-(xi**4) / 64.0) if c1 else angle


def _hypergeometric(z: Any) -> Any:
    """2F3(1/2, 1; 3/4, 5/4, 3/2; z) by its series."""
    if np.max(np.abs(z)) > _LARGEST_SERIES:
        raise ValueError(f"the series of 2F3 is good for |z| up to {_LARGEST_SERIES}, given {np.max(np.abs(z)):.3g}")
    term = total = np.ones_like(np.asarray(z, dtype=np.float64))
    for n in range(200):
        term = term * z * (0.5 + n) / ((0.75 + n) * (1.25 + n) * (1.5 + n))  # (1)_n cancels n!
        total = total + term
    return total


def angle(s_m: Any, time_s: Any, half_angle_rad: float, diffusivity_m2_s: float) -> Any:
    """Direction of the band, Eq. 4: theta = pi/2 - (pi - 2 phi) FresnelC(xi/sqrt(2 pi))."""
    return math.pi / 2.0 - complement(similarity(s_m, time_s, diffusivity_m2_s), half_angle_rad)


def complement(xi: Any, half_angle_rad: float) -> Any:
    """Complementary angle pi/2 - theta of Eq. 5: (pi - 2 phi) FresnelC(xi/sqrt(2 pi))."""
    from scipy.special import fresnel

    return (math.pi - 2.0 * half_angle_rad) * fresnel(xi / ROOT_TWO_PI)[1]


def complement_slope(xi: Any, half_angle_rad: float) -> Any:
    """Its derivative by xi, (pi - 2 phi) cos(xi^2/4)/sqrt(2 pi); the paper prints sqrt(pi)."""
    return (math.pi - 2.0 * half_angle_rad) * np.cos(np.square(xi) / 4.0) / ROOT_TWO_PI


def curvature(s_m: Any, time_s: Any, half_angle_rad: float, diffusivity_m2_s: float) -> Any:
    """Curvature -d(theta)/ds of Eq. 6, 1/m, counted positive; it falls as t^(-1/2) where the paper prints t^(1/2)."""
    phase = np.square(s_m) / (4.0 * diffusivity_m2_s * time_s)
    return eq7_curvature(time_s, half_angle_rad, diffusivity_m2_s) * np.cos(phase)


def eq7_curvature(time_s: Any, half_angle_rad: float, diffusivity_m2_s: float) -> Any:
    """Tip curvature of Eq. 7, (pi - 2 phi)/sqrt(2 pi) / sqrt(a_b t), 1/m, counted positive."""
    return (math.pi - 2.0 * half_angle_rad) / (2.0 * math.pi * diffusivity_m2_s * time_s) ** 0.5


def moment(s_m: Any, time_s: Any, half_angle_rad: float, diffusivity_m2_s: float, bending_stiffness_n_m2: float) -> Any:
    """Bending moment M = -EI d(theta)/ds of Eq. 8, N m."""
    return bending_stiffness_n_m2 * curvature(s_m, time_s, half_angle_rad, diffusivity_m2_s)


def shear(s_m: Any, time_s: Any, half_angle_rad: float, diffusivity_m2_s: float, bending_stiffness_n_m2: float) -> Any:
    """Shear force Q = -dM/ds, N. Eq. 9 has its magnitude; its sign there is that of +dM/ds."""
    phase = np.square(s_m) / (4.0 * diffusivity_m2_s * time_s)
    scale = bending_stiffness_n_m2 * eq7_curvature(time_s, half_angle_rad, diffusivity_m2_s)
    return scale * np.sin(phase) * s_m / (2.0 * diffusivity_m2_s * time_s)


def at_rest_curvature(time_s: Any, half_angle_rad: float, diffusivity_m2_s: float) -> Any:
    """Tip curvature of a linear beam kink released at rest: exactly half of Eq. 7, 1/m."""
    return 0.5 * eq7_curvature(time_s, half_angle_rad, diffusivity_m2_s)


def equation_defect(theta: Callable[[Any, Any], Any], s_m: Any, time_s: Any, diffusivity_m2_s: float) -> float:
    """Largest |a_b^2 theta_ssss + theta_tt| over the largest |theta_tt|: what Eq. 2 leaves of an angle theta(s, t).

    By central differences, whose own error is about 1 % for s of some mm and t of some ms; a form that does not solve
    the equation leaves a number of order one.
    """
    h, k = 2e-4, 4e-5
    fourth = sum(w * theta(s_m + i * h, time_s) for i, w in zip(range(-2, 3), (1, -4, 6, -4, 1), strict=True)) / h**4
    second = (theta(s_m, time_s + k) - 2.0 * theta(s_m, time_s) + theta(s_m, time_s - k)) / k**2
    return float(np.abs(diffusivity_m2_s**2 * fourth + second).max() / np.abs(second).max())


def at_rest_share(rounding: float = 1e-3) -> float:
    """Tip curvature of a linear beam kink released at rest over that of Eq. 7, by its Fourier integral.

    The integral over wave numbers q of exp(-rounding q^2/2) cos(a_b q^2 t), for a kink whose corner is a Gaussian with
    the variance rounding x a_b t.
    """
    q = np.linspace(0.0, math.sqrt(80.0 / rounding), 1_000_001)
    integral = np.trapezoid(np.exp(-0.5 * rounding * q * q) * np.cos(q * q), q)
    return float(integral / math.pi * ROOT_TWO_PI)
