"""Points that fill a box evenly: a few of them stand for all of its scenes."""

from __future__ import annotations

import warnings

import numpy as np
from numpy.typing import NDArray

from beadband.errors import UsageError, explain

Array = NDArray[np.float64]

SAMPLES = ("random", "latin-hypercube", "sobol")
"""Kinds of samples: of independent draws, with one point in each of N slices of every input, and of low discrepancy."""


def check_sample(kind: str) -> None:
    """UsageError for an unknown kind of sample."""
    if kind not in SAMPLES:
        raise UsageError(explain("unknown kind of sample", repr(kind), ", ".join(SAMPLES), "change --sample"))


def unit_points(kind: str, count: int, inputs: int, seed: int) -> Array:
    """Points of the unit box, shape (count, inputs), each coordinate at least 0 and below 1.

    "latin-hypercube" (McKay, Beckman, Conover 1979) has one point in each of ``count`` slices of every coordinate;
    "sobol" is Sobol's sequence (1967), scrambled as Owen's (1998), best with a power of two of points. The same seed
    gives the same points. UsageError for an unknown kind.
    """
    check_sample(kind)
    if kind == "random" or inputs == 0:
        return np.random.default_rng(seed).random((count, inputs))
    from scipy.stats import qmc

    engine = {"latin-hypercube": qmc.LatinHypercube, "sobol": qmc.Sobol}[kind](inputs, seed=seed)
    with warnings.catch_warnings():
        # Any number of points is allowed; the documents say which are best.
        warnings.simplefilter("ignore", UserWarning)
        points = engine.random(count)
    # Rounding may make a one of what is just below it.
    below: Array = np.minimum(points, np.nextafter(1.0, 0.0))
    return below
