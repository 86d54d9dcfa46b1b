"""Colours of the band, the same in the page and in the movie.

Every colour is of middling lightness, so that the band stands out on light and on dark ground, and neither scale leans
on telling red from green.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

NAMES = ("stretch", "curvature")

_ANCHORS = {
    "stretch": ("#2b7bba", "#5f86c6", "#9a86bd", "#c97f9a", "#df7350", "#d9560f"),
    "curvature": ("#0b7a75", "#3d9b95", "#8f9aa0", "#c4708f", "#b0246f"),
}


@dataclass(frozen=True)
class Scale:
    """From a value to a place between 0 and 1 on a row of colours."""

    name: str
    label: str
    unit: str
    low: float
    high: float
    soft: float
    """0 for an even scale; else values beyond it are squeezed as asinh(value/soft)."""

    @property
    def anchors(self) -> tuple[str, ...]:
        """Colours at equal distances from ``low`` to ``high``."""
        return _ANCHORS[self.name]

    def place(self, values: Array) -> Array:
        """Place of each value on the row, 0 to 1; any shape."""
        bend = np.arcsinh(values / self.soft) if self.soft else values
        low, high = (math.asinh(end / self.soft) if self.soft else end for end in (self.low, self.high))
        return np.asarray(np.clip((bend - low) / (high - low), 0.0, 1.0), dtype=np.float64)


def stretch_scale(stretch: Array) -> Scale:
    """An even scale from the least to the largest stretch of a run."""
    low, high = float(stretch.min()), float(stretch.max())
    return Scale("stretch", "stretch", "", low, max(high, low + 1e-6), 0.0)


def curvature_scale(curvature_1_m: Array, finger_radius_m: float) -> Scale:
    """A scale the same on both sides of zero, even up to the curvature of the finger and squeezed beyond.

    The held tip is bent dozens of times more than the finger bends the band, the waves in the legs less than that.
    """
    soft = 1.0 / finger_radius_m
    most = max(float(np.abs(curvature_1_m).max()), soft)
    return Scale("curvature", "curvature", "1/m", -most, most, soft)
