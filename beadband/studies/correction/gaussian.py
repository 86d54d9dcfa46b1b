"""Gaussian process regression with a Matern function and one length for each input, and its sparse form."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from beadband.model.correction import Array, matern

Indices = NDArray[np.intp]

_LONGEST, _SHORTEST = 5.0, -2.0
_USUAL, _SPREAD = 1.0, 1.5
"""Logarithms of lengths, over the scatter of the inputs: their bounds, and the weak prior that keeps them apart."""
_ITERATIONS = 40
_JITTER = 1e-8


@dataclass(frozen=True)
class Kernel:
    """What the marginal likelihood chooses; ``lengths`` in the units of the inputs."""

    lengths: Array
    amplitude: float
    noise: float
    """Standard deviation of what no smooth function has, beyond each value's own error."""

    def between(self, first: Array, second: Array) -> Array:
        """Covariance of two sets of inputs, shape (first, second)."""
        return self.amplitude**2 * matern(squared_distances(first / self.lengths, second / self.lengths))


def squared_distances(first: Array, second: Array) -> Array:
    """Shape (first, second); 0 at least."""
    squares = np.einsum("ij,ij->i", first, first)[:, None] + np.einsum("ij,ij->i", second, second)
    away2: Array = np.maximum(squares - 2.0 * first @ second.T, 0.0)
    return away2


def likely_kernel(inputs: Array, values: Array, errors: Array) -> Kernel:
    """The kernel of largest marginal likelihood for values of mean 0 and scatter 1; inputs of scatter 1."""
    from scipy.optimize import minimize

    count = inputs.shape[1]
    start = np.concatenate([np.full(count, _USUAL), [0.0, -4.0]])
    bounds = [(_SHORTEST, _LONGEST)] * count + [(-4.0, 4.0), (-10.0, 1.0)]
    found = minimize(
        _cost, start, (inputs, values, errors**2), jac=True, method="L-BFGS-B", bounds=bounds,
        options={"maxiter": _ITERATIONS},
    ).x  # fmt: skip
    return Kernel(np.exp(found[:count]), float(np.exp(found[count])), float(np.exp(found[count + 1])))


def _cost(logs: Array, inputs: Array, values: Array, variances: Array) -> tuple[float, Array]:
    """Negative logarithm of the marginal likelihood and the prior, with its gradient, at logarithms of the kernel."""
    from scipy.linalg import cho_solve

    count = inputs.shape[1]
    lengths, amplitude2, noise2 = np.exp(logs[:count]), np.exp(2.0 * logs[count]), np.exp(2.0 * logs[count + 1])
    d = np.sqrt(5.0 * squared_distances(inputs / lengths, inputs / lengths))
    decay = amplitude2 * np.exp(-d)
    covariance = decay * (1.0 + d * (1.0 + d / 3.0))
    try:
        factor = np.linalg.cholesky(covariance + np.diag(noise2 + variances))
    except np.linalg.LinAlgError:
        return 1e10, np.zeros_like(logs)
    inverse = cho_solve((factor, True), np.eye(len(inputs)))
    weights = inverse @ values
    away = (logs[:count] - _USUAL) / _SPREAD
    cost = 0.5 * float(values @ weights) + float(np.log(np.diag(factor)).sum()) + 0.5 * float(away @ away)
    slack = inverse - np.outer(weights, weights)
    by_distance = slack * decay * (5.0 / 3.0) * (1.0 + d)
    gradient = np.empty_like(logs)
    for column in range(count):
        apart = (inputs[:, None, column] - inputs[None, :, column]) / lengths[column]
        gradient[column] = 0.5 * np.sum(by_distance * apart**2) + away[column] / _SPREAD
    gradient[count] = np.sum(slack * covariance)
    gradient[count + 1] = np.trace(slack) * noise2
    return cost, gradient


def chosen_centres(kernel: Kernel, inputs: Array, count: int) -> Indices:
    """Indices of the inputs that tell most of all others: each next one where the least is known (pivoted Cholesky)."""
    left: Array = np.full(len(inputs), kernel.amplitude**2)
    factor, chosen = np.zeros((len(inputs), count)), []
    for column in range(count):
        pivot = int(np.argmax(left))
        chosen.append(pivot)
        covariance = kernel.between(inputs, inputs[pivot : pivot + 1])[:, 0]
        factor[:, column] = (covariance - factor[:, :column] @ factor[pivot, :column]) / np.sqrt(left[pivot])
        left = np.maximum(left - factor[:, column] ** 2, 0.0)
    return np.array(chosen)


def sparse_weights(kernel: Kernel, inputs: Array, centres: Array, values: Array, variances: Array) -> Array:
    """Weights of the kernel about the centres, shape (centres,), from all values: the subset of regressors."""
    wide = kernel.between(inputs, centres)
    matrix = wide.T @ (wide / variances[:, None]) + kernel.between(centres, centres)
    matrix[np.diag_indices(len(centres))] += _JITTER * kernel.amplitude**2
    weights: Array = np.linalg.solve(matrix, wide.T @ (values / variances))
    return weights
