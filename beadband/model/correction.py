"""What bending makes of the exact string limit, without a run: a map fitted to accurate releases.

The released rear of a scene is the answer to a dimensionless problem: lengths over the leg, times over the front's
arrival, stresses over density times (front speed)^2. What is left are the strain, the half-angle, how far bending
spreads, and numbers of the law's shape (:data:`FEATURES`). The map is a sum of Matern functions about a few hundred
centres; ``correction.json`` holds it with the record of how it was fitted and tried. Evaluating needs numpy alone.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from beadband.model.scene import Scene

Array = NDArray[np.float64]

FEATURES = (
    "ln_strain",
    "half_angle_rad",
    "ln_spread",
    "ln_residual_strain",
    "ln_secant",
    "ln_crossover",
    "ln_stiffness_behind",
    "stiffness_ahead",
    "ln_mean_speed",
    "ln_window_start",
    "ln_window_end",
)
"""Names of the numbers of a scene, in the order of :func:`features`.

With density rho, front speed c, leg l0 and t_f = l0/c: strain; half-angle; sqrt(a_b t_f)/l0; residual strain of the
string limit; held stress over (rho c^2 strain); t_x/t_f, t_x = a_b rho stretch1/stress1; tangent modulus behind the
wave, and of the held band, over rho c^2; mean speed of the wave over c; start and end of the self-similar window over
t_f. Everything that the law adds is a number of its shape alone: no stated modulus enters but through EI.
"""
LONGEST_LAYER = 0.08
"""Bending layer over the leg up to which the map was fitted: beyond it the finger is felt at the tip."""
_FILE = "correction.json"
_CHUNK = 4096
_AT = {name: index for index, name in enumerate(FEATURES)}


@dataclass(frozen=True)
class Correction:
    """Arrays of shape (scenes,), or numbers for one scene."""

    delta: Any
    """The value is that of the closed form times 1 + delta; 0 where ``inside`` is false."""
    error: Any
    """98 % of the true values lie within this share of the corrected one; infinite where ``inside`` is false."""
    inside: Any
    """Whether the scene lies within the region that the map was fitted in."""


def features(scene: Scene) -> Array:
    """The numbers of a scene, shape (features,), in the order of :data:`FEATURES`.

    Without bending those that its spread is part of are -inf, and the window's NaN.
    """
    string, scales, law = scene.string, scene.scales, scene.material
    held, behind = 1.0 + scene.strain, 1.0 + string.residual_strain
    inertia = scene.band.density_kg_m3 * string.front_speed_m_s**2
    arrival, window = scales.front_arrival_s, scales.window
    crossover = scales.bending_diffusivity_m2_s * scene.band.density_kg_m3 * behind / string.residual_stress_pa
    return np.array(
        [
            math.log(scene.strain),
            scene.half_angle_rad,
            _log(scales.bending_spread_m / scene.wedge.reference_leg_m),
            math.log(string.residual_strain),
            math.log(float(law.stress(held)) / (inertia * scene.strain)),
            _log(crossover / arrival),
            math.log(float(law.tangent(behind)) / inertia),
            float(law.tangent(held)) / inertia,
            math.log(string.wave.mean_speed_ratio),
            _log(window.start_s / arrival),
            _log(window.end_s / arrival),
        ]
    )


def speed_correction(numbers: ArrayLike) -> Correction:
    """Rebound speed over that of the string limit, less 1, for features of shape (scenes, features) or (features,).

    Exactly 0 without bending, and in proportion to :func:`bending_share` as bending vanishes.
    """
    return _corrected("speed", numbers)


def curvature_correction(numbers: ArrayLike) -> Correction:
    """Mean tip curvature over that of Eq. 7 in the self-similar window, less 1; outside where there is no window."""
    return _corrected("curvature", numbers)


def bending_share(numbers: Array) -> Array:
    """B/(1 + B), B the speed sqrt(a_b/t_f) of a bending kink over that of the string's rear; shape (scenes,)."""
    strain, phi = np.exp(numbers[:, _AT["ln_strain"]]), numbers[:, _AT["half_angle_rad"]]
    fall = (strain - np.exp(numbers[:, _AT["ln_residual_strain"]])) * np.exp(numbers[:, _AT["ln_mean_speed"]])
    rear = fall * np.cos(phi) / (1.0 - np.sin(phi))
    bending = np.exp(numbers[:, _AT["ln_spread"]])
    share: Array = bending / (bending + rear)
    return share


def layer_share(numbers: Array) -> Array:
    """Bending layer of the held tip over the leg; shape (scenes,)."""
    strain = np.exp(numbers[:, _AT["ln_strain"]])
    stress = strain * np.exp(numbers[:, _AT["ln_secant"]])
    share: Array = np.exp(2.0 * numbers[:, _AT["ln_spread"]]) / np.sqrt(stress * (1.0 + strain))
    return share


def record() -> Mapping[str, Any]:
    """How the map was fitted and tried: seed, runs, region, calibration and held-out errors, as its file has them."""
    return {key: value for key, value in _file().items() if key != "maps"}


@dataclass(frozen=True)
class Map:
    """A fitted function of some features, its bar and its region; ``columns`` are indices into the features."""

    columns: tuple[int, ...]
    origin: Array
    """Shape (columns,)."""
    length: Array
    """Length over which the function varies in each feature."""
    centres: Array
    """Shape (centres, columns), from the origin and in lengths."""
    weights: Array
    """Shape (centres, 2): of the function, and of the logarithm of its bar."""
    offset: Array
    """Shape (2,), what both are far from all centres."""
    low: Array
    high: Array
    """The box of the region, for each column."""
    farthest: float
    """Distance to the nearest centre, in lengths, up to which a scene is inside."""
    factor: float
    """By which the bar is multiplied to hold 98 % of held-out scenes."""
    floor: float
    """Least bar, that of the runs themselves."""

    def __call__(self, numbers: Array) -> tuple[Array, Array, Array]:
        """Function, bar and whether it is inside, each of shape (scenes,), before what its values are multiplied by."""
        value, bar, inside = np.empty(len(numbers)), np.empty(len(numbers)), np.empty(len(numbers), dtype=bool)
        squares = np.einsum("ij,ij->i", self.centres, self.centres)
        for start in range(0, len(numbers), _CHUNK):
            chunk = slice(start, start + _CHUNK)
            given = numbers[chunk][:, self.columns]
            here = (given - self.origin) / self.length
            away2 = np.einsum("ij,ij->i", here, here)[:, None] + squares - 2.0 * here @ self.centres.T
            np.maximum(away2, 0.0, out=away2)
            found = matern(away2) @ self.weights + self.offset
            value[chunk], bar[chunk] = found[:, 0], self.factor * np.exp(found[:, 1])
            boxed = np.all((given >= self.low) & (given <= self.high), axis=1)
            inside[chunk] = boxed & (away2.min(axis=1) <= self.farthest**2)
        return value, bar, inside


def matern(away2: Array) -> Array:
    """The Matern function of order 5/2, (1 + d + d^2/3) exp(-d), d^2 = 5 times a squared distance in lengths."""
    d = np.sqrt(5.0 * away2)
    value: Array = (1.0 + d * (1.0 + d / 3.0)) * np.exp(-d)
    return value


def map_of(values: Mapping[str, Any]) -> Map:
    """A map from its table in the file."""
    arrays = {key: np.asarray(values[key], dtype=np.float64) for key in ("origin", "length", "weights", "offset")}
    return Map(
        columns=tuple(_AT[name] for name in values["columns"]),
        centres=np.asarray(values["centres"], dtype=np.float64),
        low=np.asarray(values["low"], dtype=np.float64),
        high=np.asarray(values["high"], dtype=np.float64),
        farthest=values["farthest"],
        factor=values["factor"],
        floor=values["floor"],
        **arrays,
    )


def corrected(kind: str, chosen: Map, numbers: ArrayLike) -> Correction:
    """The correction of one kind, "speed" or "curvature", by a map."""
    given = np.asarray(numbers, dtype=np.float64)
    rows = np.atleast_2d(given)
    straight = np.isneginf(rows[:, _AT["ln_spread"]])
    finite = np.isfinite(rows[:, chosen.columns]).all(axis=1)
    delta, error = np.zeros(len(rows)), np.full(len(rows), np.inf)
    inside = np.zeros(len(rows), dtype=bool)
    known = rows[finite]
    value, bar, within = chosen(known)
    if kind == "speed":
        share = bending_share(known)
        delta[finite], bar = share * value, share * bar / (1.0 + share * value)
        within = within & (layer_share(known) <= LONGEST_LAYER)
    else:
        delta[finite] = np.expm1(value)
        lasting = known[:, _AT["ln_window_end"]] >= known[:, _AT["ln_window_start"]] + math.log(1.5)
        within = within & lasting
    error[finite], inside[finite] = np.hypot(bar, chosen.floor), within
    delta[~inside], error[~inside] = 0.0, np.inf
    if kind == "speed":
        error[straight], inside[straight] = 0.0, True
    if given.ndim == 1:
        return Correction(float(delta[0]), float(error[0]), bool(inside[0]))
    return Correction(delta, error, inside)


def _corrected(kind: str, numbers: ArrayLike) -> Correction:
    return corrected(kind, _maps()[kind], numbers)


def _log(value: float) -> float:
    return math.log(value) if value > 0.0 else -math.inf if value == 0.0 else math.nan


@cache
def _file() -> dict[str, Any]:
    found: dict[str, Any] = json.loads((files("beadband.model") / _FILE).read_text())
    return found


@cache
def _maps() -> dict[str, Map]:
    return {kind: map_of(values) for kind, values in _file()["maps"].items()}
