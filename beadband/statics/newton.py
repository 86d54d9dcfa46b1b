"""Newton's method with steps cut back until the residual falls, and coordinates that stay fixed."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
State = TypeVar("State")

BOUND = 1e-8
"""Largest residual of an equilibrium: a net force over the tension."""
_MOST_STEPS = 80
_SHORTEST = 1e-3
"""Share of a step below which it is cut back no further."""


def damped_newton(
    state: State,
    residual: Callable[[State], float],
    step: Callable[[State], tuple[float, Callable[[float], State]]],
    goal: float,
    bound: float = BOUND,
) -> tuple[State, float]:
    """The state of vanishing ``residual``, or as near to it as the method came, and its residual.

    ``step`` gives the share of Newton's step to begin with, and the state after a share of it; it may raise
    numpy.linalg.LinAlgError, which ends the search. ``bound`` is the largest residual of an equilibrium. Near a tension
    peak, on a coarse chain, or where a contact opens, whole steps overshoot: they are halved until the residual falls.
    """
    error = residual(state)
    for _ in range(_MOST_STEPS):
        try:
            share, moved = step(state)
        except np.linalg.LinAlgError:
            break
        while True:
            tried = moved(share)
            tried_error = residual(tried)
            if tried_error < error or share < _SHORTEST:
                break
            share *= 0.5
        stalled = tried_error >= 0.5 * error
        if tried_error < error or error > bound:
            state, error = tried, tried_error
        if error <= goal or (stalled and error <= bound):
            break
    return state, error


def fix(blocks: Array, fixed: NDArray[np.bool_]) -> None:
    """Take the coordinates ``fixed`` (beads, 2) out of the Hessian blocks (3, beads, 2, 2), in place."""
    count = len(fixed)
    for k in range(3):
        for axis in range(2):
            blocks[k, : count - k][fixed[: count - k, axis], axis, :] = 0.0
            blocks[k, : count - k][fixed[k:, axis], :, axis] = 0.0
    for axis in range(2):
        blocks[0, fixed[:, axis], axis, axis] = 1.0
