"""Networks fitted by Levenberg and Marquardt's method, their weights held down by as much as the evidence asks for.

A small network of two hidden layers takes the place of a Gaussian process: a process over the same inputs needs all of
its thousands of scenes as centres to be as near, a network a few hundred numbers.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from beadband.model.correction import Array, Layers, network

_FIRST_HOLD, _FIRST_TRUST = 0.1, 1e-3
_DAMPING, _LEAST_DAMPING, _EASE, _TIGHTEN, _MOST_TRIES = 1.0, 1e-10, 0.2, 4.0, 12
_EVERY = 3
"""Steps from one estimate of hold and trust to the next."""


@dataclass(frozen=True)
class Task:
    """One network to fit: inputs of shape (scenes, columns) and values of mean 0 and scatter 1, with their errors."""

    inputs: Array
    values: Array
    errors: Array
    hidden: tuple[int, ...]
    seed: int
    steps: int


def trained(task: Task) -> Layers:
    """The layers of a network, from its own random start (MacKay's evidence: Neural Comput. 4, 1992, 448)."""
    from scipy.linalg import cho_factor, cho_solve

    rng = np.random.default_rng(task.seed)
    sizes = (task.inputs.shape[1], *task.hidden, 1)
    shapes = list(pairwise(sizes))
    parts = [(rng.normal(size=(a, b)) / np.sqrt(a), 0.5 * rng.normal(size=b)) for a, b in shapes]
    now = np.concatenate([np.concatenate([matrix.ravel(), bias]) for matrix, bias in parts])
    count, one = len(now), np.eye(len(now))
    hold, trust, damping = _FIRST_HOLD, _FIRST_TRUST, _DAMPING

    def missed(at: Array) -> Array:
        found: Array = (network(_layers(at, shapes), task.inputs) - task.values) / task.errors
        return found

    for step in range(task.steps):
        jacobian = _jacobian(_layers(now, shapes), task.inputs) / task.errors[:, None]
        miss = missed(now)
        curvature, slope = jacobian.T @ jacobian, jacobian.T @ miss
        cost = trust * float(miss @ miss) + hold * float(now @ now)
        for _ in range(_MOST_TRIES):
            factor = cho_factor(trust * curvature + (hold + damping) * one)
            tried = now - cho_solve(factor, trust * slope + hold * now)
            left = missed(tried)
            if trust * float(left @ left) + hold * float(tried @ tried) < cost:
                damping = max(_EASE * damping, _LEAST_DAMPING)
                break
            damping *= _TIGHTEN
        else:
            break
        now = tried
        if step % _EVERY == _EVERY - 1:
            inverse = cho_solve(cho_factor(trust * curvature + hold * one), one)
            determined = count - hold * float(np.trace(inverse))
            hold = determined / (2.0 * float(now @ now))
            trust = min(1.0, max(len(miss) - determined, 1.0) / (2.0 * float(left @ left)))
    return _layers(now, shapes)


def _layers(flat: Array, shapes: list[tuple[int, int]]) -> Layers:
    layers, start = [], 0
    for a, b in shapes:
        middle, end = start + a * b, start + a * b + b
        layers.append((flat[start:middle].reshape(a, b), flat[middle:end]))
        start = end
    return tuple(layers)


def _jacobian(layers: Layers, inputs: Array) -> Array:
    """Derivatives of the output by all weights and biases, shape (scenes, numbers)."""
    states = [inputs]
    for matrix, bias in layers[:-1]:
        states.append(np.tanh(states[-1] @ matrix + bias))
    blocks: list[Array] = []
    back = np.ones((len(inputs), 1))
    for (matrix, _), state in zip(reversed(layers), reversed(states), strict=True):
        products = (state[:, :, None] * back[:, None, :]).reshape(len(inputs), -1)
        blocks[:0] = [products, back]
        back = (back @ matrix.T) * (1.0 - state**2)
    return np.concatenate(blocks, axis=1)
