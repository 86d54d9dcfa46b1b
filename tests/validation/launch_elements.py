"""A second way to a launch, which shares nothing with the beads but the physics: C1 finite elements on rigid cylinders.

Half of the mirror-symmetric ring: S the reference arc length from the tip (S = 0) to the front (S = Cb/2), r(S, t) the
position, s = |r'| the stretch, k = (x' y'' - y' x'')/s^2 the turning per reference length. With W the law's energy,

    rho A r_tt = -dU/dr,   U = integral of A W(s) + EI/2 k^2 dS,   axial tension A dW/ds + E A tau ds/dt.

Cubic Hermite elements with four Gauss points and the consistent mass; both ends lie on the mirror axis (y = 0, x' = 0).
Leapfrog in time, viscous forces half a step late. A cylinder pushes the band out along its radius by a stiff
foundation: a line load k d at the depth d, at the Gauss points. There is no friction. Cylinders move, where they are
given a way or a mass: see :class:`Cylinder`.

The held shape comes from first integrals of the rod: force T along the leg, EI/2 a'^2 = W*(T) - W*(T cos a) for the
angle a to it, W* the complementary energy, from the tip (a = pi/2 - phi) to the edge of the finger, where the band has
the finger's curvature s/R and the tension T cos a; R is such that half of the band ends on the axis. It is then settled
on the elastic cylinder by Newton's method.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp
from scipy.linalg import cho_solve_banded, cholesky_banded, solve_banded
from scipy.optimize import brentq

from beadband.analysis.fits import Array
from beadband.studies.pareto.peers.elements import Elements, Rod, held_shape

_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(4)
_POINTS, _WEIGHTS = 0.5 + 0.5 * _POINTS, 0.5 * _WEIGHTS
_Z = _POINTS[:, None]
_VALUE = np.hstack([1 - 3 * _Z**2 + 2 * _Z**3, _Z - 2 * _Z**2 + _Z**3, 3 * _Z**2 - 2 * _Z**3, _Z**3 - _Z**2])
_FIRST = np.hstack([6 * _Z**2 - 6 * _Z, 1 - 4 * _Z + 3 * _Z**2, 6 * _Z - 6 * _Z**2, 3 * _Z**2 - 2 * _Z])
_SECOND = np.hstack([12 * _Z - 6, 6 * _Z - 4, 6 - 12 * _Z, 6 * _Z - 2])
_SHAPES = np.concatenate([_VALUE, _FIRST, _SECOND])  # (12, 4): by x, l x', x, l x' of an element of the length l
_HIGHEST = math.sqrt(8400.0)
"""Highest frequency of a free beam element over a_b/l^2; no mesh of such elements has a higher one."""


@dataclass
class Cylinder:
    """A rigid cylinder along z that pushes the band outwards; its axis is at (x_m, 0).

    It rests, unless ``mass_kg`` is finite: then ``mass_kg`` X'' = force(X, X') - (what it gives the whole band), X the
    way from the start, x_m + X its place.
    """

    x_m: float
    radius_m: float
    stiffness_n_m2: float
    """Line load over depth, for a unit of reference length."""
    mass_kg: float = math.inf
    force_n: Callable[[float, float], float] = field(default=lambda way, speed: 0.0)
    way_m: float = 0.0
    speed_m_s: float = 0.0


@dataclass(frozen=True)
class Launched:
    """The course of a launch of the whole band; arrays of shape (lines,)."""

    times_s: Array
    impulse_n_s: Array
    """(lines, cylinders): what each has given the band along x."""
    momentum_n_s: Array
    gap_m: Array
    """From the nose to the surface of the first cylinder; negative inside."""
    tip_x_m: Array
    way_m: Array
    """(lines, cylinders)"""
    stored_j: float
    mass_kg: float
    depth_m: float
    """Deepest point in a cylinder."""
    energy_j: Array
    """Kinetic and elastic energy of the band and its contact, and what was lost; constant where cylinders rest."""
    positions_m: Array
    """(lines, nodes, 2)"""


class _HeldRod:
    """First integrals of the held rod: angles ``a`` are those to the leg, which carries the tension T."""

    def __init__(self, rod: Rod, stretch: float) -> None:
        self.stiffness = rod.bending_stiffness_n_m2
        self.tension = rod.area_m2 * float(rod.stress_pa(np.array(stretch)))
        self.layer_m = math.sqrt(self.stiffness / (self.tension * stretch))

        def stretch_of(force: float) -> float:
            return float(brentq(lambda s: rod.area_m2 * float(rod.stress_pa(s)) - force, 0.9, stretch, xtol=1e-14))

        self.of_force = np.polynomial.Chebyshev.interpolate(np.vectorize(stretch_of), 24, domain=[0.0, self.tension])

    def stretch(self, a: Array | float) -> Any:
        return self.of_force(self.tension * np.cos(a))

    def turning(self, a: float) -> float:
        """|da/dS| = sqrt(2/EI x integral of the stretch over the force from T cos a to T)."""
        drop = self.tension * 2.0 * math.sin(0.5 * a) ** 2
        return math.sqrt(2.0 * drop * float(_WEIGHTS @ self.of_force(self.tension - drop * _POINTS)) / self.stiffness)


def closed_shape(rod: Rod, stretch: float, angle_rad: float, nodes_m: Array) -> tuple[Array, Array, float, float]:
    """Position and r' of the held half ring at ``nodes_m``, (nodes, 2) each; radius and centre of the rigid finger.

    The legs carry exactly this stretch and angle far from their ends; the tip is at the origin.
    """
    half, held = float(nodes_m[-1]), _HeldRod(rod, stretch)
    along = np.array([math.cos(angle_rad), math.sin(angle_rad)])
    across = np.array([-along[1], along[0]])
    reach = min(30.0 * held.layer_m, 0.3 * half)  # nothing is left of a bend beyond it
    tip = nodes_m < reach
    tip_r, tip_d = held_shape(rod, stretch, angle_rad, np.append(nodes_m[tip], reach))

    def lead_in(radius: float, back: Array) -> Array:
        """(a, x, y) at lengths ``back`` before the edge of the finger, x and y from there, along and across the leg."""
        edge = float(brentq(lambda a: held.turning(a) - held.stretch(a) / radius, 1e-9, 1.2, xtol=1e-14))

        def rate(_: float, state: Array) -> list[float]:
            a, s = float(state[0]), float(held.stretch(state[0]))
            return [-held.turning(a), -s * math.cos(a), s * math.sin(a)]

        ends = 0.0, max(float(back[-1]), reach)
        return solve_ivp(rate, ends, [edge, 0.0, 0.0], "DOP853", back, rtol=1e-11, atol=1e-14).y.T

    def closing(at: Array) -> tuple[Array, Array, Array, float, float]:
        """What is left of the length, height of the centre; edge, centre, angle a and stretch there."""
        radius, edge_m = at
        begin, end = lead_in(radius, np.array([0.0, reach]))
        straight = tip_r[-1] + stretch * (edge_m - 2.0 * reach) * along
        edge = straight - end[1] * along - end[2] * across
        heading = angle_rad - float(begin[0])
        centre = edge + radius * np.array([math.sin(heading), -math.cos(heading)])
        s = float(held.stretch(begin[0]))
        left = s * (half - edge_m) - radius * (0.5 * math.pi + heading)
        return np.array([left, centre[1]]), edge, centre, heading, s

    leg = half / (1.0 + math.tan(angle_rad) * (0.5 * math.pi + angle_rad))
    at = np.array([stretch * leg * math.tan(angle_rad), leg])
    for _ in range(30):
        misfit = closing(at)[0]
        steps = 1e-6 * at
        slopes = np.stack([(closing(at + steps * unit)[0] - misfit) / (steps @ unit) for unit in np.eye(2)], axis=1)
        at = at - np.linalg.solve(slopes, misfit)
        if float(np.abs(misfit).max()) < 1e-12 * half:
            break
    radius, edge_m = (float(one) for one in at)
    _, edge, centre, heading, s = closing(at)

    position, slope = np.empty((len(nodes_m), 2)), np.empty((len(nodes_m), 2))
    position[tip], slope[tip] = tip_r[:-1], tip_d[:-1]
    leg_nodes = ~tip & (nodes_m <= edge_m - reach)
    position[leg_nodes] = tip_r[-1] + stretch * (nodes_m[leg_nodes] - reach)[:, None] * along
    slope[leg_nodes] = stretch * along
    near = (nodes_m > edge_m - reach) & (nodes_m < edge_m)
    states = lead_in(radius, np.append(0.0, edge_m - nodes_m[near][::-1]))[:0:-1]
    position[near] = edge + states[:, 1:2] * along + states[:, 2:3] * across
    turned = angle_rad - states[:, 0]
    slope[near] = held.stretch(states[:, 0])[:, None] * np.stack([np.cos(turned), np.sin(turned)], axis=1)
    on = nodes_m >= edge_m
    turned = heading - s * (nodes_m[on] - edge_m) / radius
    position[on] = centre + radius * np.stack([-np.sin(turned), np.cos(turned)], axis=1)
    slope[on] = s * np.stack([np.cos(turned), np.sin(turned)], axis=1)
    return position, slope, radius, float(centre[0])


class HalfBand:
    """Forces of half a band of equal elements, for explicit steps.

    A state is an array (2, nodes, 2): x or y, the node, the value and the slope by S times the element's length, so
    that all elements have one table of shape functions. Forces are those on these unknowns.
    """

    def __init__(self, rod: Rod, nodes_m: Array, cylinders: Sequence[Cylinder]) -> None:
        self.rod, self.count, self.cylinders = rod, len(nodes_m) - 1, cylinders
        self.size_m = float(nodes_m[-1]) / self.count
        inertia = rod.density_kg_m3 * rod.area_m2 * self.size_m
        element = inertia * (_VALUE.T * _WEIGHTS) @ _VALUE
        self.mass = np.zeros((4, 2 * self.count + 2))  # lower band
        for row in range(4):
            for column in range(row + 1):
                self.mass[row - column, column : column + 2 * self.count : 2] += element[row, column]
        load = inertia * (_VALUE.T @ _WEIGHTS)
        self.load = np.zeros((self.count + 1, 2))  # times the speeds: the momentum
        self.load[:-1] += load[:2]
        self.load[1:] += load[2:]
        # On the axis the slope of x and the value of y stay zero.
        self.fixed = np.zeros((2, self.count + 1, 2), dtype=bool)
        self.fixed[0, [0, -1], 1] = self.fixed[1, [0, -1], 0] = True
        self.factors = []
        for fixed in self.fixed:
            own = self.mass.copy()
            for one in np.flatnonzero(fixed.ravel()):
                own[1:, one] = 0.0
                for k in range(1, min(4, one + 1)):
                    own[k, one - k] = 0.0
            self.factors.append((cholesky_banded(own, lower=True), True))
        # Of the last call of forces(): on the cylinders (x of this half), deepest point, power lost.
        self.pushes_n, self.depth_m, self.lost_w = np.zeros(len(cylinders)), 0.0, 0.0

    def at_points(self, state: Array, shapes: Array = _SHAPES) -> Array:
        """What the shape functions say at the Gauss points, (rows/4, 4, 2, elements)."""
        unknowns = np.stack([state[:, :-1, 0], state[:, :-1, 1], state[:, 1:, 0], state[:, 1:, 1]])
        return (shapes @ unknowns.reshape(4, -1)).reshape(-1, 4, 2, self.count)

    def forces(self, state: Array, rates: Array) -> Array:
        """On the unknowns; viscous and of the cylinders as well."""
        rod, size = self.rod, self.size_m
        value, p, q = self.at_points(state)
        square = p[:, 0] ** 2 + p[:, 1] ** 2
        length = np.sqrt(square)
        stretch = length / size
        v = self.at_points(rates, _FIRST)[0]
        loss = (p[:, 0] * v[:, 0] + p[:, 1] * v[:, 1]) / (length * size)
        tension = rod.area_m2 * (rod.stress_pa(stretch) + rod.viscosity_pa_s * loss)
        self.lost_w = rod.area_m2 * rod.viscosity_pa_s * size * float(_WEIGHTS @ np.sum(loss**2, axis=1))
        # k dS = (p x q)/|p|^2 in these units: turning over the element.
        k = (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]) / square
        moment = (rod.bending_stiffness_n_m2 / size) * k / square
        pull, turn = tension / length, 2.0 * moment * k
        dual = np.empty((3, 4, 2, self.count))
        dual[1, :, 0] = (pull - turn) * p[:, 0] + moment * q[:, 1]
        dual[1, :, 1] = (pull - turn) * p[:, 1] - moment * q[:, 0]
        dual[2, :, 0] = -moment * p[:, 1]
        dual[2, :, 1] = moment * p[:, 0]
        dual[0] = 0.0
        self.depth_m = 0.0
        for i, one in enumerate(self.cylinders):
            x = value[:, 0] - (one.x_m + one.way_m)
            distance = np.sqrt(x**2 + value[:, 1] ** 2)
            depth = np.maximum(one.radius_m - distance, 0.0)
            push = (one.stiffness_n_m2 * size) * depth / distance
            dual[0, :, 0] -= push * x
            dual[0, :, 1] -= push * value[:, 1]
            self.pushes_n[i] = -float(_WEIGHTS @ np.sum(push * x, axis=1))
            self.depth_m = max(self.depth_m, float(depth.max()))
        dual *= _WEIGHTS[:, None, None]
        inner = (_SHAPES.T @ dual.reshape(12, -1)).reshape(4, 2, self.count)
        total = np.zeros_like(state)
        total[:, :-1, 0] -= inner[0]
        total[:, :-1, 1] -= inner[1]
        total[:, 1:, 0] -= inner[2]
        total[:, 1:, 1] -= inner[3]
        total[self.fixed] = 0.0
        return total

    def accelerations(self, forces: Array) -> Array:
        found = [
            cho_solve_banded(factor, force.ravel(), overwrite_b=True, check_finite=False)
            for factor, force in zip(self.factors, forces, strict=True)
        ]
        return np.stack(found).reshape(forces.shape)

    def energy_j(self, state: Array, rates: Array, energy_j_m3: Callable[[Array], Array]) -> float:
        """Kinetic, elastic and contact energy of this half."""
        rod, size = self.rod, self.size_m
        value, p, q = self.at_points(state)
        square = p[:, 0] ** 2 + p[:, 1] ** 2
        k = (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]) / square
        density = size * rod.area_m2 * energy_j_m3(np.sqrt(square) / size)
        density += 0.5 * rod.bending_stiffness_n_m2 / size * k**2
        for one in self.cylinders:
            distance = np.hypot(value[:, 0] - (one.x_m + one.way_m), value[:, 1])
            density += 0.5 * one.stiffness_n_m2 * size * np.maximum(one.radius_m - distance, 0.0) ** 2
        speed = self.at_points(rates, _VALUE)[0]
        density += 0.5 * rod.density_kg_m3 * rod.area_m2 * size * (speed[:, 0] ** 2 + speed[:, 1] ** 2)
        return float(_WEIGHTS @ np.sum(density, axis=1))

    def largest_step_s(self, shortest: float, longest: float) -> float:
        """Of leapfrog, for stretches between these: the stiffest mode of a single free element bounds all."""
        rod, size = self.rod, self.size_m
        stretches = np.linspace(shortest, longest, 65)
        axial = _axial() / size**2
        rate2 = axial * float(np.max(rod.tangent_pa(stretches))) / rod.density_kg_m3
        lag = 0.5 * axial * rod.viscosity_pa_s / rod.density_kg_m3
        bent = math.sqrt(rod.bending_stiffness_n_m2 / (rod.density_kg_m3 * rod.area_m2)) * _HIGHEST / size**2
        across = bent**2 / shortest**2 + axial * float(np.max(rod.stress_pa(stretches) / stretches)) / rod.density_kg_m3
        return min(2.0 / (math.sqrt(rate2 + lag**2) + lag), 2.0 / math.sqrt(across))


def _axial() -> float:
    """Highest square of a frequency of a free element of the size, density and modulus 1 along itself."""
    from scipy.linalg import eigh

    return float(eigh((_FIRST.T * _WEIGHTS) @ _FIRST, (_VALUE.T * _WEIGHTS) @ _VALUE, eigvals_only=True)[-1])


def settled(band: HalfBand, state: Array, held: Array) -> Array:
    """The state in equilibrium, the unknowns ``held`` (like a state) where they are, by Newton's method.

    RuntimeError where it finds none.
    """
    count, size = band.count, band.size_m
    mesh = Elements(band.rod, size * np.arange(count + 1))
    order = np.array([0, 1, 0, 1]), np.array([0, 0, 1, 1])  # x, y, x', y' of a node in a state
    scales = np.array([1.0, 1.0, 1.0 / size, 1.0 / size])
    mesh.fixed[:] = (band.fixed | held)[order[0], :, order[1]].T.ravel()
    still = np.zeros_like(state)
    found = state.copy()
    for _ in range(60):
        force = np.where(held, 0.0, band.forces(found, still))
        unknowns = (found[order[0], :, order[1]].T * scales).ravel()
        matrix = mesh.stiffness(unknowns, np.zeros_like(unknowns), 1.0)
        _add_contacts(band, found, matrix)
        matrix[2 * 7, mesh.fixed] = 1e12 * np.abs(matrix[2 * 7]).max()
        right = (force[order[0], :, order[1]].T / scales).ravel()
        move = solve_banded((7, 7), matrix[7:], right)
        move[mesh.fixed] = 0.0
        step = (move.reshape(-1, 4) / scales).T
        share = min(1.0, 0.2 * size / max(float(np.abs(step).max()), 1e-300))
        for j in range(4):
            found[order[0][j], :, order[1][j]] += share * step[j]
        if share * float(np.abs(step).max()) < 1e-13 * size * count:
            return found
    raise RuntimeError("no equilibrium on the finger")


def _add_contacts(band: HalfBand, state: Array, matrix: Array) -> None:
    """The stiffness of the cylinders, in the band storage and the unknowns of :class:`Elements`."""
    size = band.size_m
    value = band.at_points(state, _VALUE)[0]
    scale = np.array([1.0, size, 1.0, size])
    shapes = _VALUE * scale
    for one in band.cylinders:
        away = value - np.array([one.x_m + one.way_m, 0.0])[:, None]
        distance = np.hypot(away[:, 0], away[:, 1])
        depth = np.maximum(one.radius_m - distance, 0.0)
        normal = away / distance[:, None]
        along = normal[:, :, None] * normal[:, None]  # (points, 2, 2, elements)
        pressed = np.where(depth > 0.0, 1.0, 0.0)[:, None, None]
        block = (
            one.stiffness_n_m2
            * size
            * (pressed * along - (depth / distance)[:, None, None] * (np.eye(2)[:, :, None] - along))
        )
        inner = np.einsum("g,ga,gb,gije->aibje", _WEIGHTS, shapes, shapes, block)
        for a in range(4):
            for b in range(4):
                for i in range(2):
                    for j in range(2):
                        row, column = 4 * (a // 2) + 2 * (a % 2) + i, 4 * (b // 2) + 2 * (b % 2) + j
                        matrix[14 + row - column, column : column + 4 * band.count : 4] += inner[a, i, b, j]


def launch(
    rod: Rod,
    energy_j_m3: Callable[[Array], Array],
    stretch: float,
    angle_rad: float,
    circumference_m: float,
    elements: int,
    end_s: float,
    nose_m: float,
    *,
    mass_kg: float = math.inf,
    force_n: Callable[[float, float], float] = lambda way, speed: 0.0,
    lines: int = 2000,
    shortest: float = 0.45,
) -> Launched:
    """Launch a band until its nose, the part within ``nose_m`` of the tip, reaches the finger, or to ``end_s``.

    ``mass_kg`` and ``force_n`` are those of a finger that moves (:class:`Cylinder`); ``shortest`` is the least stretch
    that the step is made for. RuntimeError where the step was too long.
    """
    nodes = np.linspace(0.0, 0.5 * circumference_m, elements + 1)
    position, slope, radius, centre = closed_shape(rod, stretch, angle_rad, nodes)
    finger = Cylinder(centre, radius, 0.0, mass_kg, force_n)
    band = HalfBand(rod, nodes, [finger])
    dt = 0.8 * band.largest_step_s(shortest, stretch)
    every = max(1, round(end_s / lines / dt))
    dt = min(dt, end_s / lines / every)
    inertia = rod.density_kg_m3 * rod.area_m2
    finger.stiffness_n_m2 = inertia * (0.3 / dt) ** 2
    u = np.stack([position, band.size_m * slope], axis=2).transpose(1, 0, 2)
    held = np.zeros_like(band.fixed)
    held[0, 0, 0] = True
    u = settled(band, np.ascontiguousarray(u), held)
    return follow(band, u, energy_j_m3, dt, every, end_s, nose_m)


def follow(
    band: HalfBand,
    state: Array,
    energy_j_m3: Callable[[Array], Array],
    step_s: float,
    every: int,
    end_s: float,
    nose_m: float,
) -> Launched:
    """The same from a state at rest; a line every so many steps."""
    u, v = state.copy(), np.zeros_like(state)
    nose = max(2, round(nose_m / band.size_m) + 1)
    given, lost, deepest = np.zeros(len(band.cylinders)), 0.0, 0.0
    lines: list[tuple[Any, ...]] = []
    start_j = 2.0 * band.energy_j(u, v, energy_j_m3)
    for i in range(math.ceil(end_s / step_s) + 1):
        a = band.accelerations(band.forces(u, v))
        pushes = 2.0 * band.pushes_n
        if i % every == 0:
            # v is that of half a step before.
            now = v + 0.5 * step_s * a if i else v
            total = 2.0 * band.energy_j(u, now, energy_j_m3) + lost
            if not total < 2.0 * start_j:
                raise RuntimeError(f"the step of {step_s:.3g} s is too long")
            finger = band.cylinders[0]
            gap = np.hypot(u[0, :nose, 0] - finger.x_m - finger.way_m, u[1, :nose, 0]).min() - finger.radius_m
            given_now = given + 0.5 * step_s * pushes if i else given
            momentum = 2.0 * float(np.sum(band.load * now[0]))
            ways = [one.way_m for one in band.cylinders]
            lines.append((i * step_s, -given_now, momentum, float(gap), u[0, 0, 0], ways, total, u[:, :, 0].T.copy()))
            if gap <= 0.0:
                break
        share = 1.0 if i else 0.5
        v += share * step_s * a
        u += step_s * v
        given = given + share * step_s * pushes
        for one, push in zip(band.cylinders, pushes, strict=True):
            if math.isfinite(one.mass_kg):
                one.speed_m_s += share * step_s * (one.force_n(one.way_m, one.speed_m_s) + push) / one.mass_kg
                one.way_m += step_s * one.speed_m_s
        lost += 2.0 * step_s * band.lost_w
        deepest = max(deepest, band.depth_m)
    columns = [np.array(column) for column in zip(*lines, strict=True)]
    mass = 2.0 * float(np.sum(band.load[:, 0]))
    more = {"energy_j": columns[6], "positions_m": columns[7]}
    return Launched(*columns[:6], stored_j=start_j, mass_kg=mass, depth_m=deepest, **more)
