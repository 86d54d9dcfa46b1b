"""A second way to the same release, for comparison: C1 finite elements in space, an implicit method in time.

One leg of a planar extensible rod: S the reference arc length from the tip, r(S, t) the position, s = |r'| the stretch,
k = (x' y'' - y' x'')/s^2 the turning per reference length. With W the energy density of the law and tau a loss time,

    rho A r_tt = -dU/dr,   U = integral of A W(s) + EI/2 k^2 dS,   axial tension A dW/ds + E A tau ds/dt

On the mirror axis x' = 0 and y = 0; the far end is clamped. Cubic Hermite elements with four Gauss points and a
consistent mass; Alexander's L-stable diagonally implicit Runge-Kutta method of order 3, each stage by Newton's method.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import lapack
from scipy.optimize import brentq

Array = NDArray[np.float64]
Function = Callable[[Array], Array]

_GAUSS, _WEIGHT = np.polynomial.legendre.leggauss(4)
_GAUSS, _WEIGHT = 0.5 + 0.5 * _GAUSS, 0.5 * _WEIGHT
_BAND = 7  # unknowns of an element: two nodes, each x, y, x', y'

# Alexander's method: gamma is the middle root of g^3 - 3 g^2 + 3 g/2 - 1/6.
_GAMMA = float(np.sort(np.roots([1.0, -3.0, 1.5, -1.0 / 6.0]).real)[1])
_STAGES = np.array(
    [
        [_GAMMA, 0.0, 0.0],
        [0.5 * (1.0 - _GAMMA), _GAMMA, 0.0],
        [-1.5 * _GAMMA**2 + 4.0 * _GAMMA - 0.25, 1.5 * _GAMMA**2 - 5.0 * _GAMMA + 1.25, _GAMMA],
    ]
)


@dataclass(frozen=True)
class Rod:
    """The band as a rod; the law as nominal stress and tangent modulus over the stretch."""

    stress_pa: Function
    tangent_pa: Function
    area_m2: float
    density_kg_m3: float
    bending_stiffness_n_m2: float
    viscosity_pa_s: float
    """E tau."""


class Released(NamedTuple):
    """The tip over time; arrays of shape (steps + 1,)."""

    times_s: Array
    tip_x_m: Array
    tip_curvature_1_m: Array


def held_shape(
    rod: Rod, held_stretch: float, half_angle_rad: float, places_m: Array, peg_radius_m: float = 0.0
) -> tuple[Array, Array]:
    """Position and r' of the leg at reference lengths ``places_m`` from the tip, in equilibrium; shape (nodes, 2).

    The internal force is T along the leg everywhere, so with alpha the angle to the leg the stretch is s(T cos alpha)
    and EI/2 (d alpha/dS)^2 = integral of s(N) dN from T cos alpha to T. Where that bends it more than a peg
    of radius r, d alpha/dS = s/r, the band lies on the peg, with one stretch.
    """
    tension = rod.area_m2 * float(rod.stress_pa(np.array(held_stretch)))
    scale = math.sqrt(2.0 * tension / rod.bending_stiffness_n_m2)

    def stretch(force: float) -> float:
        return float(brentq(lambda s: rod.area_m2 * float(rod.stress_pa(s)) - force, 0.9, held_stretch, xtol=1e-14))

    # s as a polynomial of the force: smooth, so that Chebyshev points give it to rounding.
    fit = np.polynomial.Chebyshev.interpolate(np.vectorize(stretch), 24, domain=[0.0, tension])
    mean = fit.integ(lbnd=tension)

    def rate(_: float, state: Array) -> list[float]:
        alpha = math.exp(state[0])
        force = tension * math.cos(alpha)
        drop = 2.0 * math.sin(0.5 * alpha) ** 2  # 1 - cos alpha
        work = -mean(force) / tension if drop > 1e-4 else drop * fit(tension * (1.0 - 0.5 * drop))
        s, theta = fit(force), half_angle_rad + alpha
        return [-scale * math.sqrt(work) / alpha, s * math.cos(theta), s * math.sin(theta)]

    def tighter(log_alpha: float) -> float:
        """Turning that the leg would have there, over that on the peg, less 1."""
        slope = rate(0.0, np.array([log_alpha]))[0] * math.exp(log_alpha)
        return -slope * peg_radius_m / float(fit(tension * math.cos(math.exp(log_alpha)))) - 1.0

    opening, wrapped, lift_off = 0.5 * math.pi - half_angle_rad, 0.0, math.log(0.5 * math.pi - half_angle_rad)
    places, slopes = np.zeros((0, 2)), np.zeros((0, 2))
    if peg_radius_m > 0.0 and tighter(lift_off) > 0.0:
        lift_off = float(brentq(tighter, math.log(1e-9), lift_off, xtol=1e-14))
        around = float(fit(tension * math.cos(math.exp(lift_off)))) / peg_radius_m
        wrapped = (opening - math.exp(lift_off)) / around
        turned = around * np.append(places_m[places_m <= wrapped], wrapped)
        places = peg_radius_m * np.stack([1.0 - np.cos(turned), np.sin(turned)], axis=1)
        slopes = peg_radius_m * around * np.stack([np.sin(turned), np.cos(turned)], axis=1)[:-1]
    start = [lift_off, *(places[-1] if len(places) else (0.0, 0.0))]
    free = places_m[len(slopes) :]
    found = solve_ivp(rate, (wrapped, float(free[-1])), start, "DOP853", free, rtol=1e-11, atol=1e-13)
    alpha = np.exp(found.y[0])
    s, theta = fit(tension * np.cos(alpha)), half_angle_rad + alpha
    slopes = np.concatenate([slopes, np.stack([s * np.cos(theta), s * np.sin(theta)], axis=1)])
    return np.concatenate([places[:-1], found.y[1:].T]), slopes


def graded_nodes(length_m: float, elements: int, growth: float) -> Array:
    """Nodes from 0 to ``length_m``; element lengths grow linearly to ``growth`` times that of the first."""
    even = np.linspace(0.0, 1.0, elements + 1)
    return length_m * (even + 0.5 * (growth - 1.0) * even**2) / (1.0 + 0.5 * (growth - 1.0))


class Elements:
    """Forces and stiffness of a rod on given nodes. Unknowns of a node are x, y, x', y', one node after the other."""

    def __init__(self, rod: Rod, nodes_m: Array) -> None:
        self.rod, self.count = rod, len(nodes_m) - 1
        z, size = _GAUSS[None, :], np.diff(nodes_m)[:, None]
        value = [1 - 3 * z**2 + 2 * z**3, size * (z - 2 * z**2 + z**3), 3 * z**2 - 2 * z**3, size * (z**3 - z**2)]
        first = [(6 * z**2 - 6 * z) / size, 1 - 4 * z + 3 * z**2, (6 * z - 6 * z**2) / size, 3 * z**2 - 2 * z]
        second = [(12 * z - 6) / size**2, (6 * z - 4) / size, (6 - 12 * z) / size**2, (6 * z - 2) / size]
        self.weight = size * _WEIGHT[None, :]

        def wide(shapes: list[Array]) -> Array:
            """For x and y alike: shape (elements, points, 2, 8)."""
            table = np.stack([np.broadcast_to(shape, self.weight.shape) for shape in shapes], axis=-1)
            both: Array = np.einsum("epa,ij->epiaj", table, np.eye(2)).reshape(self.count, len(_GAUSS), 2, 8)
            return both

        # (elements, points, 4, 8): from the unknowns of an element to x', y', x'', y'' at its Gauss points.
        self.gradients = np.concatenate([wide(first), wide(second)], axis=2)
        self.flat = self.gradients.reshape(self.count, -1, 8)
        inertia = rod.density_kg_m3 * rod.area_m2 * self.weight[:, :, None, None]
        spread = wide(value)
        self.mass = np.sum(spread.transpose(0, 1, 3, 2) @ (inertia * spread), axis=1)
        self.fixed = np.zeros(4 * self.count + 4, dtype=bool)
        self.fixed[[1, 2]] = self.fixed[-4:] = True

    def at_points(self, unknowns: Array) -> Array:
        """x', y', x'', y'' at the Gauss points, shape (elements, points, 4)."""
        return (self.flat @ self.of_elements(unknowns)[:, :, None]).reshape(self.count, len(_GAUSS), 4)

    def of_elements(self, unknowns: Array) -> Array:
        found: Array = np.lib.stride_tricks.sliding_window_view(unknowns, 8)[::4]
        return found

    def loads(self, unknowns: Array, rates: Array, accelerations: Array) -> Array:
        """M r_tt + dU/dr + losses; zero where the motion is right, and at fixed unknowns."""
        rod, g = self.rod, self.at_points(unknowns)
        p, q = g[..., :2], g[..., 2:]
        stretch = np.hypot(p[..., 0], p[..., 1])
        loss = np.sum(p * self.at_points(rates)[..., :2], axis=-1) / stretch
        tension = rod.area_m2 * (rod.stress_pa(stretch) + rod.viscosity_pa_s * loss)
        k, slope = _turning(p, q, stretch)
        dual = rod.bending_stiffness_n_m2 * k[..., None] * slope
        dual[..., :2] += (tension / stretch)[..., None] * p
        dual *= self.weight[..., None]
        inner = (dual.reshape(self.count, 1, -1) @ self.flat)[:, 0]
        inner += (self.mass @ self.of_elements(accelerations)[:, :, None])[:, :, 0]
        total = np.zeros_like(unknowns)
        total[:-4] += inner[:, :4].ravel()
        total[4:] += inner[:, 4:].ravel()
        total[self.fixed] = 0.0
        return total

    def stiffness(self, unknowns: Array, rates: Array, step_s: float) -> Array:
        """M + step C + step^2 K in LAPACK's band storage, K and C the derivatives of the loads."""
        rod, g, v = self.rod, self.at_points(unknowns), self.at_points(rates)[..., :2]
        p, q = g[..., :2], g[..., 2:]
        stretch = np.hypot(p[..., 0], p[..., 1])
        k, slope = _turning(p, q, stretch)
        square = (stretch**2)[..., None, None]
        along = p[..., :, None] * p[..., None, :] / square
        across = np.eye(2) - along
        normal = np.stack([-p[..., 1], p[..., 0]], axis=-1)
        twist = np.stack([q[..., 1], -q[..., 0]], axis=-1)
        mixed = twist[..., :, None] * p[..., None, :]
        kk = k[..., None, None]
        bend = np.zeros((*stretch.shape, 4, 4))  # second derivatives of k, then of k^2/2
        mixed = -2.0 * (mixed + mixed.swapaxes(-1, -2)) / square
        bend[..., :2, :2] = (mixed + kk * (8.0 * along - 2.0 * np.eye(2))) / square
        crossed = p[..., :, None] * normal[..., None, :] / square
        bend[..., :2, 2:] = (np.array([[0.0, 1.0], [-1.0, 0.0]]) - 2.0 * crossed) / square
        bend[..., 2:, :2] = bend[..., :2, 2:].swapaxes(-1, -2)
        bend = step_s**2 * rod.bending_stiffness_n_m2 * (slope[..., :, None] * slope[..., None, :] + kk * bend)
        loss = rod.viscosity_pa_s * np.sum(p * v, axis=-1) / stretch
        tension = ((rod.stress_pa(stretch) + loss) / stretch)[..., None, None]
        swing = p[..., :, None] * (across @ v[..., None]).swapaxes(-1, -2) / square
        axial = rod.tangent_pa(stretch)[..., None, None] * along + tension * across + rod.viscosity_pa_s * swing
        bend[..., :2, :2] += rod.area_m2 * (step_s**2 * axial + step_s * rod.viscosity_pa_s * along)
        bend *= self.weight[..., None, None]
        inner = self.flat.swapaxes(-1, -2) @ (bend @ self.gradients).reshape(self.count, -1, 8) + self.mass
        band = np.zeros((3 * _BAND + 1, len(unknowns)))
        for row in range(8):
            for column in range(8):
                band[2 * _BAND + row - column, column : column + 4 * self.count : 4] += inner[:, row, column]
        band[2 * _BAND, self.fixed] *= 1e12
        return band


def _turning(p: Array, q: Array, stretch: Array) -> tuple[Array, Array]:
    """k = (x' y'' - y' x'')/s^2 and its derivatives by x', y', x'', y''."""
    square = stretch**2
    k = (p[..., 0] * q[..., 1] - p[..., 1] * q[..., 0]) / square
    parts = [q[..., 1] - 2.0 * k * p[..., 0], -q[..., 0] - 2.0 * k * p[..., 1], -p[..., 1], p[..., 0]]
    return k, np.stack(parts, axis=-1) / square[..., None]


def release(
    rod: Rod,
    held_stretch: float,
    half_angle_rad: float,
    nodes_m: Array,
    end_s: float,
    steps: int,
    peg_radius_m: float = 0.0,
) -> Released:
    """Release the tip of the held leg at t = 0 and follow it to ``end_s``."""
    shape = held_shape(rod, held_stretch, half_angle_rad, nodes_m, peg_radius_m)
    return follow(Elements(rod, nodes_m), shape, nodes_m, end_s, steps)


def follow(mesh: Elements, shape: tuple[Array, Array], nodes_m: Array, end_s: float, steps: int) -> Released:
    """The same from a shape (position and r', each (nodes, 2)); RuntimeError where Newton's method fails."""
    u = np.concatenate(shape, axis=1).ravel()
    v = np.zeros_like(u)
    times = np.linspace(0.0, end_s, steps + 1)
    tip_x, curvature = np.zeros(steps + 1), np.zeros(steps + 1)
    size = float(nodes_m[1])
    factors: tuple[Array, Array] | None = None
    factored_s = 0.0
    a = v.copy()
    for i in range(steps + 1):
        # On the axis k = -x''/y', with x'' that of the first element at its end.
        tip_x[i] = u[0]
        curvature[i] = ((6.0 * (u[4] - u[0]) / size - 2.0 * u[6]) / size) / u[3]
        if i == steps:
            break
        dt = times[i + 1] - times[i]
        speeds: list[Array] = []
        pushes: list[Array] = []
        for stage in range(3):
            weights = dt * _STAGES[stage, :stage]
            base_u = u + sum(w * s for w, s in zip(weights, speeds, strict=True))
            base_v = v + sum(w * s for w, s in zip(weights, pushes, strict=True))
            own = _GAMMA * dt
            for tries in range(20):
                new_v = base_v + own * a
                new_u = base_u + own * new_v
                if factors is None or factored_s != own or tries in (5, 10):
                    lu, pivots, _ = lapack.dgbtrf(mesh.stiffness(new_u, new_v, own), _BAND, _BAND)
                    factors, factored_s = (lu, pivots), own
                change, _ = lapack.dgbtrs(factors[0], _BAND, _BAND, mesh.loads(new_u, new_v, a), factors[1])
                change[mesh.fixed] = 0.0
                a = a - change
                if own**2 * float(np.abs(change).max()) < 1e-9:  # m, and stretches, which are stricter
                    break
            else:
                raise RuntimeError(f"Newton's method failed at {times[i]:.4g} s")
            speeds.append(base_v + own * a)
            pushes.append(a)
        u, v = base_u + own * speeds[-1], speeds[-1]
    return Released(times, tip_x, curvature)
