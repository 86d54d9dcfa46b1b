"""From releases to a map: its networks, the bar and the region, and what held-out scenes say of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np

from beadband.model.correction import FEATURES, Array, bar_terms, bending_share, corrected, map_of
from beadband.studies import pool
from beadband.studies.correction.runs import Booleans, Sample
from beadband.studies.correction.training import Task, trained

_SHAPE = (
    "ln_crossover", "half_angle_rad", "ln_strain", "ln_stiffness_behind", "stiffness_ahead", "ln_mean_speed",
    "ln_secant", "ln_spread",
)  # fmt: skip
COLUMNS = {"speed": _SHAPE, "curvature": (*_SHAPE, "ln_window_start", "ln_window_end")}
"""Features that each map depends on."""
HIDDEN = {"speed": (22, 22), "curvature": (14, 14)}
NETWORKS, STEPS = 4, 100
COVERED, AIMED = 0.98, 0.99
"""Share of the true values that a bar is to hold, and the share of the scenes that it is calibrated on: its shape is
fitted to the same scenes, and others lie a little farther off."""
FLOOR = {"speed": 1e-4, "curvature": 5e-4}
"""Least bar: the errors of the releases themselves."""
_LEAST_ERROR = 0.002
"""Least error of a value over the scatter of all."""
_MEDIAN_LOG = -0.635
"""Mean of ln|x| of a normal variable of scatter 1."""
_HOLD = 3.0
"""By which the coefficients of the bar are held down: so many scenes are needed to move one by its scatter."""
_MARGIN = 0.005
"""Share of a feature's range by which the box of the region exceeds the scenes that were fitted."""
_EDGE = 0.05
"""Share of a range next to its ends that counts as the edge."""
_FARTHEST, _WIDEST = 1.02, 0.99
"""Reach of the region beyond the farthest scene that was fitted, and the quantile of the networks' scatter it keeps."""
_FEWEST = 60
"""Scenes of a group below which its own quantile is not asked for."""


_CATALOGUE = {"catalogue", "linear", "mooney-rivlin"}
"""Families that the catalogue's scenes are of too, so that they can't be left out."""


def values_of(kind: str, sample: Sample) -> tuple[Array, Array, Array, Booleans]:
    """Features, values that the map of this kind is fitted to, their errors, and which scenes these are.

    Of the speed delta over the share of bending, of the curvature the logarithm of its ratio.
    """
    if kind == "speed":
        share = bending_share(sample.features)
        return sample.features, sample.delta / share, sample.delta_error / share, np.isfinite(sample.delta)
    known = np.isfinite(sample.ratio)
    ratio = sample.ratio[known]
    return sample.features[known], np.log(ratio), sample.ratio_error[known] / ratio, known


def fitted(kind: str, train: Sample, calibration: Sample, seed: int, jobs: int | None = None) -> dict[str, Any]:
    """The table of a map, as ``correction.json`` has it."""
    numbers, values, errors, _ = values_of(kind, train)
    given = numbers[:, [FEATURES.index(name) for name in COLUMNS[kind]]]
    origin, scatter = (np.array(_rounded(each, 7)) for each in (given.mean(axis=0), given.std(axis=0)))
    mean, size = _rounded(float(values.mean()), 7), _rounded(float(values.std()), 7)
    inputs = (given - origin) / scatter
    reduced, uncertain = (values - mean) / size, np.hypot(errors / size, _LEAST_ERROR)
    tasks = [Task(inputs, reduced, uncertain, HIDDEN[kind], 100 * seed + one, STEPS) for one in range(NETWORKS)]
    networks = pool.run_all(trained, tasks, jobs=jobs)
    beyond = _MARGIN * np.ptp(given, axis=0)
    inverse = np.linalg.inv(np.cov(inputs.T))
    distance = np.sqrt(np.einsum("ij,jk,ik->i", inputs, inverse, inputs))
    table: dict[str, Any] = {
        "columns": list(COLUMNS[kind]),
        "origin": origin.tolist(),
        "scatter": scatter.tolist(),
        "mean": mean,
        "size": size,
        "networks": [
            [{"matrix": _rounded(matrix, 7), "bias": _rounded(bias, 7)} for matrix, bias in layers]
            for layers in networks
            if not isinstance(layers, pool.Failed)
        ],
        "bar": [0.0] * (2 + len(origin)),
        "least_scatter": _rounded(0.1 * float(np.median(errors)), 3),
        "low": _rounded(given.min(axis=0) - beyond, 6),
        "high": _rounded(given.max(axis=0) + beyond, 6),
        "covariance_inverse": _rounded(inverse, 6),
        "farthest": _rounded(_FARTHEST * float(distance.max()), 5),
        "widest": math.inf,
        "floor": FLOOR[kind],
    }
    return _calibrated(kind, table, calibration)


def _calibrated(kind: str, table: dict[str, Any], calibration: Sample) -> dict[str, Any]:
    """The table with its bar from scenes that it was not fitted to.

    The logarithm of the misses is a linear function of that of the networks' scatter and of the inputs; what multiplies
    it is the least factor with which every group of scenes has its share within.
    """
    numbers, values, _, known = values_of(kind, calibration)
    raw = map_of(table)
    inputs = (numbers[:, raw.columns] - raw.origin) / raw.scatter
    found, parting = raw.parting(inputs)
    terms = bar_terms(inputs, parting, raw.least_scatter)
    logs = np.log(np.maximum(np.abs(found - values), raw.least_scatter)) - _MEDIAN_LOG
    level = terms[:, 1].mean()
    terms[:, 1] -= level
    matrix = terms.T @ terms + _HOLD * np.diag([0.0, 0.0, *np.ones(terms.shape[1] - 2)])
    bar = np.linalg.solve(matrix, terms.T @ logs)
    bar[0] -= bar[1] * level
    table = table | {
        "widest": _rounded(float(np.quantile(parting, _WIDEST)), 4),
        "bar": _rounded(bar, 5),
    }
    bare = corrected(kind, map_of(table | {"floor": 0.0}), numbers)
    misses = np.abs(relative_miss(kind, bare.delta, calibration)) / bare.error
    inside = {name: group[known] & bare.inside for name, group in groups(calibration, table).items()}
    factor = max(
        float(np.quantile(misses[group], AIMED, method="higher")) for group in inside.values() if group.sum() >= _FEWEST
    )
    bar[0] += math.log(factor)
    return table | {"bar": _rounded(bar, 5)}


def relative_miss(kind: str, delta: Any, sample: Sample) -> Array:
    """Corrected value over the true one, less 1, of the scenes for which it is known."""
    *_, known = values_of(kind, sample)
    true = sample.delta if kind == "speed" else sample.ratio[known] - 1.0
    missed: Array = (1.0 + delta) / (1.0 + true) - 1.0
    return missed


def groups(sample: Sample, table: Mapping[str, Any]) -> dict[str, Booleans]:
    """Scenes by what their bars are tried on: all, by their wave, those like the catalogue's, and at the edges."""
    first = [FEATURES.index(name) for name in ("ln_strain", "half_angle_rad", "ln_spread")]
    places = [table["columns"].index(FEATURES[column]) for column in first]
    low, high = np.array(table["low"])[places], np.array(table["high"])[places]
    given, margin = sample.features[:, first], _EDGE * (high - low)
    return {
        "all": np.ones(len(sample), dtype=bool),
        "catalogue": sample.catalogue,
        "shock": sample.kind == "shock",
        "sharp front": sample.kind == "sharp front",
        "fan": np.char.find(sample.kind, "fan") >= 0,
        "edge": np.any((given < low + margin) | (given > high - margin), axis=1),
    }


def held_out(kind: str, table: Mapping[str, Any], sample: Sample) -> dict[str, dict[str, float]]:
    """Relative errors and bars on held-out scenes, by group: shares and quantiles; groups without any are left out."""
    return _rows(kind, table, sample, groups(sample, table))


def left_out(train: Sample, calibration: Sample, test: Sample, seed: int, jobs: int | None) -> dict[str, Any]:
    """The speed of each family of laws by a map that was not shown it, as rows of :func:`held_out`."""
    rows: dict[str, Any] = {}
    for family in sorted(set(train.family.tolist()) - _CATALOGUE):
        shown, tried = (one.where(one.family != family) for one in (train, calibration))
        table = fitted("speed", shown, tried, seed, jobs)
        apart = Sample.joined([one.where(one.family == family) for one in (train, calibration, test)])
        rows |= _rows("speed", table, apart, {family: np.ones(len(apart), dtype=bool)})
    return rows


def _rows(
    kind: str, table: Mapping[str, Any], sample: Sample, members: Mapping[str, Booleans]
) -> dict[str, dict[str, float]]:
    numbers, *_, known = values_of(kind, sample)
    found = corrected(kind, map_of(table), numbers)
    missed = np.abs(relative_miss(kind, found.delta, sample))
    rows = {}
    for name, all_of_it in members.items():
        group = all_of_it[known]
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
            "bar_below_0.1_percent": _rounded(float(np.sum(bar <= 0.001) / group.sum()), 4),
            "bar_below_0.5_percent": _rounded(float(np.sum(bar <= 0.005) / group.sum()), 4),
        }
    return rows


def _rounded(value: Any, digits: int) -> Any:
    """A number, or nested lists of an array's numbers, to so many digits."""
    if isinstance(value, np.ndarray):
        return [_rounded(each, digits) for each in value]
    return float(f"{float(value):.{digits}g}")
