"""A root finder: importing an optimizer would take longer than releasing a band."""

from __future__ import annotations

import math
from collections.abc import Callable


def root(function: Callable[[float], float], low: float, high: float) -> float:
    """Root of a continuous function with opposite signs at ``low`` and ``high``, to the last digits (Ridders).

    ValueError where the signs agree.
    """
    at_low, at_high = function(low), function(high)
    if at_low == 0.0:
        return low
    if at_high == 0.0:
        return high
    if at_low * at_high > 0.0:
        raise ValueError(f"no change of sign between {low} and {high}")
    guess = math.inf
    for _ in range(100):
        middle = 0.5 * (low + high)
        at_middle = function(middle)
        bend = math.sqrt(at_middle * at_middle - at_low * at_high)
        last, guess = guess, middle + (middle - low) * math.copysign(1.0, at_low - at_high) * at_middle / bend
        value = function(guess)
        if value == 0.0 or abs(guess - last) <= 4e-16 * abs(guess) or not low < middle < high:
            return guess
        for point, at_point in ((middle, at_middle), (guess, value)):
            if low < point < high:
                if at_point * at_low > 0.0:
                    low, at_low = point, at_point
                else:
                    high, at_high = point, at_point
        if at_high == 0.0:
            return high
    return guess
