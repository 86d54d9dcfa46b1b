"""From releases to a map: lengths, centres, weights, the bar and the region, and what held-out scenes say of it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from beadband.model.correction import FEATURES, Array, bending_share, corrected, map_of
from beadband.studies.correction.gaussian import (
    Kernel,
    chosen_centres,
    likely_kernel,
    sparse_weights,
    squared_distances,
)

COLUMNS = {
    "speed": (
        "ln_crossover", "half_angle_rad", "ln_strain", "ln_stiffness_behind", "stiffness_ahead", "ln_mean_speed",
        "ln_secant", "ln_spread",
    ),
    "curvature": (
        "ln_crossover", "half_angle_rad", "ln_strain", "ln_stiffness_behind", "stiffness_ahead", "ln_mean_speed",
        "ln_secant", "ln_spread", "ln_window_start", "ln_window_end",
    ),
}  # fmt: skip
"""Features that each map depends on."""
CENTRES = {"speed": 600, "curvature": 300}
COVERED = 0.98
"""Share of the true values that a bar is to hold."""
_FOR_LENGTHS = 900
"""Scenes from which the lengths are found: the work goes as their cube."""
_FOLDS = 5
_MEDIAN_LOG, _SCATTER_LOG = -0.635, 1.11
"""Mean and standard deviation of ln|x| of a normal variable of scatter 1."""
_REACH = 0.995
"""Quantile of the held-out scenes' distances to their nearest centres that the region includes."""
_MARGIN = 0.005
"""Share of a feature's range by which the box of the region exceeds the scenes that were fitted."""
_FEWEST = 40
"""Scenes of a group below which its own quantile is not asked for."""

Booleans = NDArray[np.bool_]


@dataclass(frozen=True)
class Sample:
    """Released scenes; arrays of shape (scenes,), features (scenes, features)."""

    features: Array
    delta: Array
    delta_error: Array
    ratio: Array
    """Mean curvature over Eq. 7; NaN where it was not measured."""
    ratio_error: Array
    kind: NDArray[np.str_]
    """Of the unloading wave."""
    catalogue: Booleans
    """Whether drawn like the catalogue's scenes."""

    def of(self, kind: str) -> tuple[Array, Array, Array, Booleans]:
        """Features, values that the map of this kind is fitted to, their errors, and which scenes these are.

        Of the speed delta over the share of bending, of the curvature the logarithm of its ratio.
        """
        if kind == "speed":
            share = bending_share(self.features)
            return self.features, self.delta / share, self.delta_error / share, np.isfinite(self.delta)
        known = np.isfinite(self.ratio)
        numbers, ratio = self.features[known], self.ratio[known]
        return numbers, np.log(ratio), self.ratio_error[known] / ratio, known


def fitted(kind: str, train: Sample, calibration: Sample, floor: float, seed: int) -> dict[str, Any]:
    """The table of a map, as ``correction.json`` has it."""
    numbers, values, errors, _ = train.of(kind)
    columns = [FEATURES.index(name) for name in COLUMNS[kind]]
    given = numbers[:, columns]
    origin, scatter = given.mean(axis=0), given.std(axis=0)
    inputs = (given - origin) / scatter
    mean, size = float(values.mean()), float(values.std())
    reduced, reduced_errors = (values - mean) / size, errors / size
    rng = np.random.default_rng(seed)
    some = rng.permutation(len(inputs))[:_FOR_LENGTHS]
    kernel = likely_kernel(inputs[some], reduced[some], reduced_errors[some])
    # As the file has them: what is rounded is fitted.
    length = np.array([_rounded(each, 6) for each in scatter * kernel.lengths])
    origin = np.array([_rounded(each, 6) for each in origin])
    here = (given - origin) / length
    unit = Kernel(np.ones(len(columns)), kernel.amplitude, kernel.noise)
    chosen = chosen_centres(unit, here, min(CENTRES[kind], len(here)))
    centres = np.round(here[chosen], 4)
    variances = reduced_errors**2 + kernel.noise**2
    weights = size * unit.amplitude**2 * sparse_weights(unit, here, centres, reduced, variances)
    # The bar: a smooth size of what values that were left out are missed by.
    missed = np.empty(len(here))
    fold = rng.permutation(len(here)) % _FOLDS
    for one in range(_FOLDS):
        kept, out = fold != one, fold == one
        found = sparse_weights(unit, here[kept], centres, reduced[kept], variances[kept])
        missed[out] = unit.between(here[out], centres) @ found - reduced[out]
    logs = np.log(np.hypot(size * missed, 0.3 * errors)) - _MEDIAN_LOG
    level = float(logs.mean())
    beyond = _MARGIN * np.ptp(given, axis=0)
    bars = Kernel(unit.lengths, 1.0, _SCATTER_LOG)
    log_weights = sparse_weights(bars, here, centres, logs - level, np.full(len(here), _SCATTER_LOG**2))
    table: dict[str, Any] = {
        "columns": list(COLUMNS[kind]),
        "origin": origin.tolist(),
        "length": length.tolist(),
        "centres": centres.tolist(),
        "weights": [[_rounded(a, 8), _rounded(b, 4)] for a, b in zip(weights, log_weights, strict=True)],
        "offset": [_rounded(mean, 8), _rounded(level, 5)],
        "low": [_rounded(each, 6) for each in given.min(axis=0) - beyond],
        "high": [_rounded(each, 6) for each in given.max(axis=0) + beyond],
        "farthest": math.inf,
        "factor": 1.0,
        "floor": floor,
    }
    return _calibrated(kind, table, calibration, origin, length, centres)


def _calibrated(
    kind: str, table: dict[str, Any], calibration: Sample, origin: Array, length: Array, centres: Array
) -> dict[str, Any]:
    """The table with the reach of its region and the factor of its bar from scenes that it was not fitted to."""
    numbers, _, _, known = calibration.of(kind)
    here = (numbers[:, [FEATURES.index(name) for name in table["columns"]]] - origin) / length
    nearest = np.sqrt(squared_distances(here, centres).min(axis=1))
    table = table | {"farthest": _rounded(float(np.quantile(nearest, _REACH)), 4)}
    bare = corrected(kind, map_of(table | {"floor": 0.0}), numbers)
    misses = np.abs(relative_miss(kind, bare.delta, calibration)) / bare.error
    factors = {
        name: float(np.quantile(misses[group[known] & bare.inside], COVERED, method="higher"))
        for name, group in groups(kind, calibration, table).items()
        if (group[known] & bare.inside).sum() >= _FEWEST
    }
    return table | {"factor": _rounded(max(factors.values()), 4)}


def relative_miss(kind: str, delta: Any, sample: Sample) -> Array:
    """Corrected value over the true one, less 1, of the scenes for which it is known."""
    *_, known = sample.of(kind)
    true = sample.delta if kind == "speed" else sample.ratio[known] - 1.0
    missed: Array = (1.0 + delta) / (1.0 + true) - 1.0
    return missed


def groups(kind: str, sample: Sample, table: Mapping[str, Any]) -> dict[str, Booleans]:
    """Scenes by what their bars are looked at for: all, by their wave, those like the catalogue's, and at the edges."""
    columns = [FEATURES.index(name) for name in table["columns"]]
    low, high = np.array(table["low"]), np.array(table["high"])
    margin = 0.05 * (high - low)
    given = sample.features[:, columns[:3]]
    edge = np.any((given < (low + margin)[:3]) | (given > (high - margin)[:3]), axis=1)
    return {
        "all": np.ones(len(sample.delta), dtype=bool),
        "catalogue": sample.catalogue,
        "shock": sample.kind == "shock",
        "sharp front": sample.kind == "sharp front",
        "fan": np.char.find(sample.kind, "fan") >= 0,
        "edge": edge,
    }


def held_out(kind: str, table: Mapping[str, Any], sample: Sample) -> dict[str, dict[str, float]]:
    """Relative errors and bars on held-out scenes, by group: shares and quantiles."""
    numbers, *_, known = sample.of(kind)
    found = corrected(kind, map_of(table), numbers)
    missed = np.abs(relative_miss(kind, found.delta, sample))
    rows = {}
    for name, members in groups(kind, sample, table).items():
        group = members[known]
        inside = group & found.inside
        if not inside.any():
            continue
        error, bar = missed[inside], found.error[inside]
        rows[name] = {
            "scenes": int(group.sum()),
            "inside": _rounded(float(inside.sum() / group.sum()), 4),
            "median": _rounded(float(np.median(error)), 3),
            "p90": _rounded(float(np.quantile(error, 0.9)), 3),
            "p99": _rounded(float(np.quantile(error, 0.99)), 3),
            "worst": _rounded(float(error.max()), 3),
            "bar_median": _rounded(float(np.median(bar)), 3),
            "bar_p95": _rounded(float(np.quantile(bar, 0.95)), 3),
            "within_bar": _rounded(float(np.mean(error <= bar)), 4),
            "bar_below_0.5_percent": _rounded(float(np.sum(bar <= 0.005) / group.sum()), 4),
        }
    return rows


def _rounded(value: float, digits: int) -> float:
    return float(f"{value:.{digits}g}")
