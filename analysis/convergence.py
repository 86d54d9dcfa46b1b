"""From the same number at several bead spacings to its limit and the error of that: the one rule for every error.

Two rules, after what is known of the errors of the levels.

*Measured curves* (:func:`limit_of`): how large the relative errors of the levels are, and how far they go together, is
known from what many converged scenes have shown (planning.ladder): a smooth part that falls with the order of the
method, and one that changes from level to level. The limit is the generalized least squares mean, so levels that fall
together are carried on to no spacing, and where noise is as large as their drift they are not. Other, independent
answers to the same question (a formula with a bar) join as further observations. Where the levels differ by more than
their sizes allow the error grows with them (Birge ratio).

*Nothing but the levels* (:func:`plain_error`): "the finer run is closer than the difference" holds from the first
order on alone. An order of at least 1/2 is taken for granted; every coarser level says how far off the finest may be,
and the largest of these counts, so that two levels which agree by chance do not set it; a floor stands for what no
difference shows.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from beadband.analysis.fits import Array

LEAST_ORDER = 0.5
"""Order of convergence that :func:`plain_error` takes for granted; the least that was measured is 0.8."""
_PRIOR_FREEDOM = 4.0
"""Degrees of freedom that the sizes of the errors are worth, beside those of the levels at hand."""


class Limit(NamedTuple):
    """Limit of a number for beads without end."""

    value: float
    error: float
    """Standard error, with the excess of the scatter over what was expected."""
    excess: float
    """Birge ratio: scatter of the levels over the expected one, at least 1."""
    weights: Array
    """What each observation counts; shape (levels,), or one more where something is known beside them."""


def limit_of(values: Array, covariance: Array, known: tuple[float, float] | None = None) -> Limit:
    """Limit of ``values`` (levels,) for beads without end, and its standard error.

    Parameters
    ----------
    values
        Of one sign, any unit; at least one.
    covariance
        Of the relative errors of the levels, shape (levels, levels).
    known
        Value and standard error of an independent answer.
    """
    scale, ratios = float(values[0]), values / values[0]
    if known is not None:
        size = len(values)
        wider = np.zeros((size + 1, size + 1))
        wider[:size, :size], wider[size, size] = covariance, (known[1] / scale) ** 2
        covariance, ratios = wider, np.append(ratios, known[0] / scale)
    ones = np.ones(len(ratios))
    weights = np.asarray(np.linalg.solve(covariance, ones), dtype=np.float64)
    variance = 1.0 / float(weights.sum())
    weights = np.asarray(weights * variance, dtype=np.float64)
    mean = float(weights @ ratios)
    apart = ratios - mean
    chi2 = float(apart @ np.linalg.solve(covariance, apart))
    excess = math.sqrt(max(1.0, (chi2 + _PRIOR_FREEDOM) / (len(ratios) - 1 + _PRIOR_FREEDOM)))
    return Limit(scale * mean, abs(scale) * math.sqrt(variance) * excess, excess, weights)


def plain_error(spacing: Array, values: Array, floor: float = 0.0, least_order: float = LEAST_ORDER) -> float:
    """Error bound of ``values[0]`` from the other levels alone; in the unit of the values.

    Errors that fall as spacing^q with q of at least ``least_order`` leave a value within
    |difference to level k| / |(h_k/h_0)^q - 1| of the limit, whether level k is coarser or finer. The largest of these
    and ``floor`` join. A single level has no error but the floor. ValueError for two levels of the same spacing.
    """
    ratios: Array = spacing[1:] / spacing[0]
    if np.any(ratios == 1.0):
        raise ValueError(f"levels of the same spacing: {spacing}")
    bounds = np.abs(values[1:] - values[0]) / np.abs(ratios**least_order - 1.0)
    return float(math.hypot(bounds.max(initial=0.0), floor))


def observed_order(spacing: Array, values: Array) -> float | None:
    """Order with which the first three levels, finest first, converge; None where their differences change sign.

    Solves (v1 - v0)/(v2 - v1) = (h1^p - h0^p)/(h2^p - h1^p) by bisection for p between 0.05 and 8.
    """
    first, second = float(values[1] - values[0]), float(values[2] - values[1])
    if first * second <= 0.0:
        return None
    fine, middle, coarse = (float(one) for one in spacing[:3] / spacing[0])

    def excess(p: float) -> float:
        return float((middle**p - fine**p) / (coarse**p - middle**p) - first / second)

    low, high = 0.05, 8.0
    if excess(low) * excess(high) > 0.0:
        return None
    rising = excess(high) > 0.0
    for _ in range(60):
        half = 0.5 * (low + high)
        low, high = (low, half) if (excess(half) > 0.0) is rising else (half, high)
    return 0.5 * (low + high)
