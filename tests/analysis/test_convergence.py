"""The rule of errors on levels whose limit is known, and slopes that do not depend on where the frames lie."""

from __future__ import annotations

import math

import numpy as np
import pytest

from beadband.analysis.convergence import limit_of, observed_order, plain_error
from beadband.analysis.fits import Array, path_mean, path_slope

SPACING = np.array([1.0, math.sqrt(2.0), 2.0])


def covariance(noise: Array, drift: float, order: float) -> Array:
    """Of errors that go together with the order, and of noise."""
    common = drift * SPACING**order
    return np.outer(common, common) + np.diag(noise**2)


@pytest.mark.parametrize("order", [1.0, 2.0])
def test_levels_with_a_clean_order_are_carried_on(order: float) -> None:
    values = 17.0 * (1.0 - 3e-3 * SPACING**order)
    found = limit_of(values, covariance(np.full(3, 1e-7), 1e-2, order))
    assert found.value == pytest.approx(17.0, rel=1e-6)
    assert abs(found.value - 17.0) < 3.0 * found.error
    assert found.error < 1e-3 * abs(values[0] - 17.0)
    assert found.excess == 1.0


def test_levels_that_scatter_are_not() -> None:
    """Where noise is all that there is the limit is the mean with the weights of the noise."""
    values, noise = np.array([17.01, 16.99, 17.03]), np.array([1e-3, 2e-3, 4e-3])
    found = limit_of(values, covariance(noise, 1e-9, 1.0))
    weights = noise**-2.0 / np.sum(noise**-2.0)
    assert found.value == pytest.approx(float(weights @ values), rel=1e-9)
    assert found.error == pytest.approx(values[0] * np.sum(noise**-2.0) ** -0.5, rel=1e-9)
    assert found.weights == pytest.approx(weights, rel=1e-6)


def test_more_scatter_than_expected_is_stated() -> None:
    values, noise = np.array([17.0, 17.3, 16.8]), np.full(3, 1e-3)
    found = limit_of(values, covariance(noise, 1e-9, 1.0))
    assert found.excess > 5.0
    assert found.error == pytest.approx(found.excess * 17.0 * 1e-3 / math.sqrt(3.0), rel=1e-2)


def test_an_independent_answer_joins() -> None:
    values, noise = np.array([17.02]), np.array([1e-3])
    found = limit_of(values, np.diag(noise**2), known=(17.0, 17.02e-3))
    assert found.value == pytest.approx(17.01, rel=1e-6)
    assert found.error == pytest.approx(17.02e-3 / math.sqrt(2.0), rel=1e-6)


@pytest.mark.parametrize("order", [0.5, 0.8, 1.0, 2.0])
@pytest.mark.parametrize("other", [280.0, 1120.0])
def test_the_plain_error_is_sound_for_every_order(order: float, other: float) -> None:
    """A launch converges with the order 0.8: half of the difference, or all of it, would be too little."""
    beads = np.array([560.0, other])
    values = 2.0 + 5.0 * beads**-order
    stated, true = plain_error(1.0 / beads, values), abs(values[0] - 2.0)
    assert true <= stated * (1.0 + 1e-9)
    assert stated == pytest.approx(true, rel=1e-9) if order == 0.5 else stated > true


def test_levels_that_agree_by_chance_do_not_set_the_error() -> None:
    spacing, values = np.array([1.0, 2.0, 4.0]), np.array([2.01, 2.01, 2.08])
    assert plain_error(spacing[:2], values[:2]) == 0.0
    assert plain_error(spacing, values) >= 0.07
    assert plain_error(spacing[:2], values[:2], floor=0.03) == 0.03
    with pytest.raises(ValueError, match="same spacing"):
        plain_error(np.array([1.0, 1.0]), values[:2])


@pytest.mark.parametrize("order", [0.8, 1.0, 2.3])
def test_the_order_is_found(order: float) -> None:
    spacing = np.array([1.0, 1.3, 2.1])
    assert observed_order(spacing, 4.0 - 0.1 * spacing**order) == pytest.approx(order, rel=1e-9)
    assert observed_order(spacing, np.array([1.0, 1.1, 1.05])) is None


def test_the_slope_of_a_path_is_that_of_all_its_times() -> None:
    """For x = t^3 over [a, b] least squares give a slope in closed form; frames may lie anywhere."""
    a, b = 0.4, 0.85
    middle, half = 0.5 * (a + b), 0.5 * (b - a)
    exact = 3.0 * middle**2 + 3.0 / 5.0 * half**2
    slopes = []
    for count, shift in ((240, 0.0), (240, 0.4), (171, 0.2)):
        times = (np.arange(count + 2) - shift) / count
        slopes.append(path_slope(times, times**3, a, b))
    assert slopes == pytest.approx([exact] * 3, rel=2e-5)
    assert path_slope(times, 2.0 - 3.0 * times, a, b) == pytest.approx(-3.0, rel=1e-12)
    assert path_mean(times, times, a, b) == pytest.approx(middle, rel=1e-12)
    # Means over intervals end half of one too early.
    short = times[times < b - 1e-3]
    assert path_slope(short, 2.0 - 3.0 * short, a, b) == pytest.approx(-3.0, rel=1e-12)
    with pytest.raises(ValueError, match="do not cover"):
        path_slope(times[times < 0.8], times[times < 0.8], a, b)
