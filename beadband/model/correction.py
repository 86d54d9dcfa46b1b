"""What bending makes of the exact string limit, without a run: a map fitted to accurate releases.

The released rear of a scene is the answer to a dimensionless problem: lengths over the leg, times over the front's
arrival, stresses over density times (front speed)^2. What is left are the strain, the half-angle, how far bending
spreads, and numbers of the law's shape (:data:`FEATURES`). The map is the mean of a few small networks;
``correction.json`` holds it with the record of how it was fitted and tried. Evaluating needs numpy alone.
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

from beadband.model.scales import LONGEST_LAYER, SHORTEST_WINDOW

if TYPE_CHECKING:
    from beadband.model.scene import Scene

Array = NDArray[np.float64]
Layers = tuple[tuple[Array, Array], ...]
"""Matrix and bias of each layer of a network; a matrix has the shape (inputs, outputs)."""

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
_FILE = "correction.json"
_CHUNK = 2048
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
    return features_of(
        strain=scene.strain,
        half_angle_rad=scene.half_angle_rad,
        leg_m=scene.wedge.reference_leg_m,
        density_kg_m3=scene.band.density_kg_m3,
        diffusivity_m2_s=scales.bending_diffusivity_m2_s,
        front_speed_m_s=string.front_speed_m_s,
        mean_speed_ratio=string.wave.mean_speed_ratio,
        residual_strain=string.residual_strain,
        residual_stress_pa=string.residual_stress_pa,
        held_stress_pa=float(law.stress(1.0 + scene.strain)),
        held_tangent_pa=float(law.tangent(1.0 + scene.strain)),
        residual_tangent_pa=float(law.tangent(1.0 + string.residual_strain)),
        window_start_s=scales.window.start_s,
        window_end_s=scales.window.end_s,
    )


def features_of(
    *,
    strain: ArrayLike,
    half_angle_rad: ArrayLike,
    leg_m: ArrayLike,
    density_kg_m3: ArrayLike,
    diffusivity_m2_s: ArrayLike,
    front_speed_m_s: ArrayLike,
    mean_speed_ratio: ArrayLike,
    residual_strain: ArrayLike,
    residual_stress_pa: ArrayLike,
    held_stress_pa: ArrayLike,
    held_tangent_pa: ArrayLike,
    residual_tangent_pa: ArrayLike,
    window_start_s: ArrayLike,
    window_end_s: ArrayLike,
) -> Array:
    """:func:`features` of many scenes from arrays that broadcast to (scenes,): shape (scenes, features).

    ``leg_m`` is the reference leg l0, ``diffusivity_m2_s`` a_b; stresses are nominal, the tangents those of the held
    stretch and of the one behind the wave.
    """
    density, speed, leg = np.asarray(density_kg_m3), np.asarray(front_speed_m_s), np.asarray(leg_m)
    diffusivity, behind = np.asarray(diffusivity_m2_s), 1.0 + np.asarray(residual_strain)
    inertia, arrival = density * speed**2, leg / speed
    with np.errstate(divide="ignore"):
        columns = (
            np.log(strain),
            half_angle_rad,
            0.5 * np.log(diffusivity / (leg * speed)),
            np.log(residual_strain),
            np.log(held_stress_pa / (inertia * strain)),
            np.log(diffusivity * density * behind / (residual_stress_pa * arrival)),
            np.log(residual_tangent_pa / inertia),
            held_tangent_pa / inertia,
            np.log(mean_speed_ratio),
            np.log(window_start_s / arrival),
            np.log(window_end_s / arrival),
        )
    return np.stack(np.broadcast_arrays(*columns), axis=-1).astype(np.float64)


def applies(scene: Scene) -> bool:
    """Whether the map's question is the scene's: a release whose loss vanishes, but for that of its shocks.

    A launch is another question, a loss time of the user's makes another rubber, and a peg another held shape.
    """
    numerical = scene.loss_time_s is None or "loss_time_s" in scene.planned
    return scene.until == "release" and numerical and scene.peg is None


def speed_correction(numbers: ArrayLike) -> Correction:
    """Rebound speed over that of the string limit, less 1, for features of shape (scenes, features) or (features,).

    Exactly 0 without bending, and in proportion to :func:`bending_share` as bending vanishes.
    """
    return _corrected("speed", numbers)


def curvature_correction(numbers: ArrayLike) -> Correction:
    """Mean tip curvature over that of Eq. 7 in the self-similar window, less 1; outside where there is no window."""
    return _corrected("curvature", numbers)


def bending_share(numbers: Array) -> Array:
    """B/(1 + B), B the speed sqrt(a_b/t_f) of a bending kink over that of the string's rear; shape (scenes,).

    The string's kink runs at V tan(phi), so that B = tan(phi) sqrt(t_x/t_f)/(1 + residual strain).
    """
    behind = 1.0 + np.exp(numbers[:, _AT["ln_residual_strain"]])
    bending = np.tan(numbers[:, _AT["half_angle_rad"]]) * np.exp(0.5 * numbers[:, _AT["ln_crossover"]]) / behind
    share: Array = bending / (1.0 + bending)
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
    """Mean of the scenes that were fitted, shape (columns,)."""
    scatter: Array
    networks: tuple[Layers, ...]
    """Fitted alike from different starts: the value is their mean, and where they part little is known."""
    mean: float
    size: float
    """Mean and scatter of the values, which the networks give as numbers of mean 0 and scatter 1."""
    bar: Array
    """Coefficients of the logarithm of the bar, shape (2 + columns,): 1, logarithm of the networks' scatter, inputs."""
    least_scatter: float
    """Added to the networks' scatter, in squares."""
    low: Array
    high: Array
    """The box of the region, for each column."""
    covariance_inverse: Array
    farthest: float
    """Mahalanobis distance to the mean of the scenes up to which another is inside."""
    widest: float
    """Scatter of the networks up to which a scene is inside."""
    floor: float
    """Least bar, that of the runs themselves."""

    def __call__(self, numbers: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
        """Function, bar and whether it is inside, each of shape (scenes,), before what its values are multiplied by."""
        value, bar, inside = np.empty(len(numbers)), np.empty(len(numbers)), np.empty(len(numbers), dtype=bool)
        for start in range(0, len(numbers), _CHUNK):
            chunk = slice(start, start + _CHUNK)
            given = numbers[chunk][:, self.columns]
            inputs = (given - self.origin) / self.scatter
            value[chunk], parting = self.parting(inputs)
            bar[chunk] = np.exp(bar_terms(inputs, parting, self.least_scatter) @ self.bar)
            boxed = np.all((given >= self.low) & (given <= self.high), axis=1)
            near = np.einsum("ij,jk,ik->i", inputs, self.covariance_inverse, inputs) <= self.farthest**2
            inside[chunk] = boxed & near & (parting <= self.widest)
        return value, bar, inside

    def parting(self, inputs: Array) -> tuple[Array, Array]:
        """Mean of the networks, and their standard deviation, each of shape (scenes,)."""
        found = np.array([network(layers, inputs) for layers in self.networks])
        value: Array = self.mean + self.size * found.mean(axis=0)
        return value, self.size * found.std(axis=0, ddof=1)


def bar_terms(inputs: Array, parting: Array, least: float) -> Array:
    """What the logarithm of the bar is linear in, shape (scenes, 2 + columns)."""
    return np.column_stack([np.ones(len(inputs)), np.log(np.hypot(parting, least)), inputs])


def network(layers: Layers, inputs: Array) -> Array:
    """Output of a network of tanh layers and a last linear one, shape (scenes,)."""
    state = inputs
    for matrix, bias in layers[:-1]:
        state = state @ matrix
        state += bias
        np.tanh(state, out=state)
    matrix, bias = layers[-1]
    out: Array = (state @ matrix)[:, 0] + bias[0]
    return out


def map_of(values: Mapping[str, Any]) -> Map:
    """A map from its table in the file."""

    def array(key: str) -> Array:
        return np.asarray(values[key], dtype=np.float64)

    return Map(
        columns=tuple(_AT[name] for name in values["columns"]),
        origin=array("origin"),
        scatter=array("scatter"),
        networks=tuple(
            tuple((np.asarray(layer["matrix"]), np.asarray(layer["bias"])) for layer in one)
            for one in values["networks"]
        ),
        mean=values["mean"],
        size=values["size"],
        bar=array("bar"),
        least_scatter=values["least_scatter"],
        low=array("low"),
        high=array("high"),
        covariance_inverse=array("covariance_inverse"),
        farthest=values["farthest"],
        widest=values["widest"],
        floor=values["floor"],
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
    if kind == "speed":
        value, bar, within = _from_thickest(chosen, known)
        bar, within = bar / (1.0 + value), within & (layer_share(known) <= LONGEST_LAYER)
    else:
        ratio, bar, within = chosen(known)
        value = np.expm1(ratio)
        lasting = known[:, _AT["ln_window_end"]] - known[:, _AT["ln_window_start"]] >= math.log(SHORTEST_WINDOW)
        within = within & lasting
    inside[finite] = within
    delta[finite] = np.where(within, value, 0.0)
    error[finite] = np.where(within, np.hypot(bar, chosen.floor), np.inf)
    if kind == "speed":
        error[straight], inside[straight] = 0.0, True
    if given.ndim == 1:
        return Correction(float(delta[0]), float(error[0]), bool(inside[0]))
    return Correction(delta, error, inside)


def _from_thickest(chosen: Map, numbers: Array) -> tuple[Array, Array, NDArray[np.bool_]]:
    """V/V_string - 1, its bar over V_string, and whether it is inside.

    Below the least spread or crossover that was fitted the correction falls at least as the share of bending does: it
    is taken to fall so from the nearest thicker band that was, and all of it is added to the bar.
    """
    spread, crossover = (chosen.low[chosen.columns.index(_AT[name])] for name in ("ln_spread", "ln_crossover"))
    short = np.maximum(spread - numbers[:, _AT["ln_spread"]], 0.5 * (crossover - numbers[:, _AT["ln_crossover"]]))
    short = np.maximum(short, 0.0)
    there = numbers.copy()
    there[:, _AT["ln_spread"]] += short
    there[:, _AT["ln_crossover"]] += 2.0 * short
    value, bar, inside = chosen(there)
    share = bending_share(numbers)
    return share * value, share * (bar + np.where(short > 0.0, np.abs(value), 0.0)), inside


def _corrected(kind: str, numbers: ArrayLike) -> Correction:
    return corrected(kind, _maps()[kind], numbers)


@cache
def _file() -> dict[str, Any]:
    found: dict[str, Any] = json.loads((files("beadband.model") / _FILE).read_text())
    return found


def table(kind: str) -> Mapping[str, Any]:
    """The map of one kind, "speed" or "curvature", as its file has it."""
    found: Mapping[str, Any] = _file()["maps"][kind]
    return found


@cache
def _maps() -> dict[str, Map]:
    return {kind: map_of(values) for kind, values in _file()["maps"].items()}
