"""Sobol' indices against those of functions that have exact ones, and the coverage of their intervals."""

from __future__ import annotations

import math

import numpy as np
import pytest

from beadband.analysis.sobol import Indices, indices
from beadband.studies.samples import unit_points


def of(function: object, inputs: int, points: int, seed: int = 0, kind: str = "sobol") -> Indices:
    """Indices of a function of points in the unit box."""
    places = unit_points(kind, points, 2 * inputs, seed)
    a, b = places[:, :inputs], places[:, inputs:]
    mixed = np.repeat(a[None], inputs, axis=0)
    for at in range(inputs):
        mixed[at, :, at] = b[:, at]
    assert callable(function)
    return indices(function(a), function(b), np.array([function(one) for one in mixed]), seed=seed)


def ishigami(places: np.ndarray) -> np.ndarray:
    x = (2.0 * places - 1.0) * np.pi
    value: np.ndarray = np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])
    return value


def test_the_function_of_ishigami_and_homma() -> None:
    """Exact, for a = 7 and b = 0.1: sums of powers of pi."""
    first = 0.5 * (1.0 + 0.1 * math.pi**4 / 5.0) ** 2
    second, joint = 49.0 / 8.0, 0.01 * math.pi**8 * (1.0 / 18.0 - 1.0 / 50.0)
    variance = first + second + joint
    found = of(ishigami, 3, 4096)
    assert found.first == pytest.approx([first / variance, second / variance, 0.0], abs=0.005)
    assert found.total == pytest.approx([(first + joint) / variance, second / variance, joint / variance], abs=0.005)


def test_intervals_hold_the_exact_indices_of_random_points() -> None:
    """x + 2 y, independent draws: shares 1/5 and 4/5; of 95 % intervals some in twenty may miss."""
    held = []
    for seed in range(40):
        found = of(lambda places: places[:, 0] + 2.0 * places[:, 1], 2, 256, seed, "random")
        for interval in (found.first_interval, found.total_interval):
            held += [low <= exact <= high for (low, high), exact in zip(interval, (0.2, 0.8), strict=True)]
    assert 0.87 <= np.mean(held) <= 1.0
    even = of(lambda places: places[:, 0] + 2.0 * places[:, 1], 2, 4096)
    assert np.all(even.first_interval[:, 1] - even.first_interval[:, 0] < 0.1)


def test_values_that_do_not_vary_have_none() -> None:
    with pytest.raises(ValueError, match="do not vary"):
        of(lambda places: np.ones(len(places)), 2, 64)
