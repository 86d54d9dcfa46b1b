"""Sobol' indices of first and total order from three sets of samples, with bootstrapped intervals."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

_AT_ONCE = 100
"""Resamples that are held in memory together."""


class Indices(NamedTuple):
    """Indices of each input; arrays of shape (inputs,), intervals (inputs, 2)."""

    first: Array
    """Share of the variance that goes when this input alone is known."""
    total: Array
    """Share that is left when all others are known."""
    first_interval: Array
    total_interval: Array


def indices(
    at_a: Array, at_b: Array, at_ab: Array, confidence: float = 0.95, resamples: int = 1000, seed: int = 0
) -> Indices:
    """Indices of a function of independent inputs.

    Parameters
    ----------
    at_a, at_b
        Values at two independent samples A and B, shape (points,).
    at_ab
        Values at A with one column taken from B, for each input: shape (inputs, points).
    confidence, resamples, seed
        Of the percentile intervals: whole rows of the samples are drawn again. Points that fill the box more evenly
        than independent ones have smaller errors than such intervals say.

    Raises
    ------
    ValueError
        The values do not vary.

    Notes
    -----
    Estimators of Saltelli et al., Comput. Phys. Commun. 181 (2010) 259, Table 2: (b) for the first order, with the mean
    taken off, and (f), Jansen's, for the total order.
    """
    middle = 0.5 * (at_a.mean() + at_b.mean())
    a, b, ab = at_a - middle, at_b - middle, at_ab - middle
    points = len(a)
    # What the indices are means of, one row for each point: every resample is then a product with its counts.
    terms = np.column_stack([0.5 * (a + b), 0.5 * (a**2 + b**2), (b * (ab - a)).T, 0.5 * ((a - ab) ** 2).T])
    if not terms[:, 1].mean() > 0.0:
        raise ValueError("the values do not vary: they have no indices")

    def of(means: Array) -> Array:
        variance = means[:, 1] - means[:, 0] ** 2
        return means[:, 2:] / variance[:, None]

    draws, found = np.random.default_rng(seed), []
    for start in range(0, resamples, _AT_ONCE):
        size = min(_AT_ONCE, resamples - start)
        chosen = draws.integers(points, size=(size, points)) + points * np.arange(size)[:, None]
        counts = np.bincount(chosen.ravel(), minlength=size * points).reshape(size, points)
        found.append(of(counts @ terms / points))
    tail = 50.0 * (1.0 - confidence)
    intervals = np.percentile(np.concatenate(found), [tail, 100.0 - tail], axis=0).T
    whole, inputs = of(terms.mean(axis=0)[None])[0], len(ab)
    return Indices(whole[:inputs], whole[inputs:], intervals[:inputs], intervals[inputs:])
