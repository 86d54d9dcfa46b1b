"""The first invariant of an incompressible strand in uniaxial tension: what laws in I1 alone are made of."""

from __future__ import annotations

from typing import Any


def excess(stretch: Any) -> Any:
    """I1 - 3 = s^2 + 2/s - 3, factored so that small strains do not cancel."""
    return (stretch - 1.0) ** 2 * (stretch + 2.0) / stretch


def slope(stretch: Any) -> Any:
    """d I1/ds = 2 (s - 1/s^2)."""
    return 2.0 * (stretch - 1.0) * (1.0 + (1.0 + 1.0 / stretch) / stretch)


def curvature(stretch: Any) -> Any:
    """d2 I1/ds2 = 2 (1 + 2/s^3)."""
    return 2.0 * (1.0 + 2.0 * stretch**-3)
