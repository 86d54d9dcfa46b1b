"""A curve through points that has a continuous slope and rises where they rise, with its exact integral."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]


class Curve:
    """Piecewise cubic y(x) through points, continued straight beyond both ends.

    The slopes are those of the cubic spline of continuous curvature, limited so that between two points the curve
    never leaves the range of the two (Hyman 1983): no wiggle, and fourth order where the points are smooth.
    """

    def __init__(self, x: Array, y: Array) -> None:
        """``x`` rising strictly, shape (points,); ``y`` of the same shape."""
        self.x, self.y = np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)
        width, rise = np.diff(self.x), np.diff(self.y)
        chord = rise / width
        slope = _limited(_spline_slopes(width, chord), chord)
        # Rows (c0, c1, c2, c3) of c0 + c1 t + c2 t^2 + c3 t^3, t from the left point; straight in the first and last.
        inner = np.stack(
            [
                self.y[:-1],
                slope[:-1],
                (3.0 * chord - 2.0 * slope[:-1] - slope[1:]) / width,
                (slope[:-1] + slope[1:] - 2.0 * chord) / width**2,
            ],
            axis=1,
        )
        below, above = [[y_end, k, 0.0, 0.0] for y_end, k in ((self.y[0], slope[0]), (self.y[-1], slope[-1]))]
        self._pieces = np.concatenate([[below], inner, [above]])
        self._starts = np.concatenate([self.x[:1], self.x])
        areas = width * sum(inner[:, n] * width**n / (n + 1) for n in range(4))
        self._areas = np.concatenate([[0.0, 0.0], np.cumsum(areas)])
        self.slope = slope

    def _at(self, x: Any) -> tuple[Array, Any, Array]:
        piece = np.searchsorted(self.x, np.real(x), side="right")
        return np.moveaxis(self._pieces[piece], -1, 0), x - self._starts[piece], self._areas[piece]

    def value(self, x: Any) -> Any:
        """y(x)."""
        (c0, c1, c2, c3), t, _ = self._at(x)
        return c0 + t * (c1 + t * (c2 + t * c3))

    def derivative(self, x: Any) -> Any:
        """dy/dx."""
        (_, c1, c2, c3), t, _ = self._at(x)
        return c1 + t * (2.0 * c2 + t * 3.0 * c3)

    def integral(self, x: Any) -> Any:
        """Integral of y from the first point to x."""
        (c0, c1, c2, c3), t, area = self._at(x)
        return area + t * (c0 + t * (c1 / 2.0 + t * (c2 / 3.0 + t * c3 / 4.0)))


def _spline_slopes(width: Array, chord: Array) -> Array:
    """Slopes at the points of the cubic spline whose third derivative is continuous next to the ends (not a knot)."""
    n = len(width) + 1
    if n == 2:
        return np.array([chord[0], chord[0]])
    if n == 3:
        # The parabola through the three.
        bend = (chord[1] - chord[0]) / (width[0] + width[1])
        return np.array([chord[0] - bend * width[0], chord[0] + bend * width[0], chord[1] + bend * width[1]])
    matrix, right = np.zeros((n, n)), np.zeros(n)
    inner = np.arange(1, n - 1)
    matrix[inner, inner - 1], matrix[inner, inner + 1] = width[1:], width[:-1]
    matrix[inner, inner] = 2.0 * (width[:-1] + width[1:])
    right[1:-1] = 3.0 * (width[1:] * chord[:-1] + width[:-1] * chord[1:])
    for row, (a, b), (s, t) in (
        (0, width[:2], chord[:2]),
        (n - 1, width[:-3:-1], chord[:-3:-1]),
    ):
        sign = 1 if row == 0 else -1
        matrix[row, row], matrix[row, row + sign] = b, a + b
        right[row] = ((a + 2.0 * (a + b)) * b * s + a**2 * t) / (a + b)
    return np.linalg.solve(matrix, right)


def _limited(slope: Array, chord: Array) -> Array:
    """Slopes cut back to three times the smaller chord beside them; flat at a local extremum of the points."""
    before, after = np.concatenate([chord[:1], chord]), np.concatenate([chord, chord[-1:]])
    most = 3.0 * np.minimum(np.abs(before), np.abs(after))
    sign = np.where(before * after > 0.0, np.sign(before), 0.0)
    limited: Array = sign * np.clip(sign * slope, 0.0, most)
    return limited
