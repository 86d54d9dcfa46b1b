"""Angle forms: their derivatives, their common limit, and what LAMMPS is given of them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from beadband.model.angle_forms import ANGLE_FORMS, FOURIER, QUARTIC


@pytest.mark.parametrize("name", list(ANGLE_FORMS))
def test_angle_forms_have_their_derivatives_and_one_limit(name: str) -> None:
    form = ANGLE_FORMS[name]
    psi, step = np.linspace(0.05, 2.0, 40), 1e-6
    for energies, at in ((form.by_angle, psi), (form.by_cosine, np.cos(psi))):
        energy, slope, curve = energies(at)
        above, below = energies(at + step), energies(at - step)
        assert (above[0] - below[0]) / (2.0 * step) == pytest.approx(slope, rel=1e-6)
        assert (above[1] - below[1]) / (2.0 * step) == pytest.approx(curve, rel=1e-5, abs=1e-8)
        assert energy.min() > 0.0
    assert form.by_cosine(np.cos(psi))[0] == pytest.approx(form.by_angle(psi)[0], rel=1e-12)
    small = np.array([1e-3])
    assert form.by_angle(small)[0] == pytest.approx(0.5 * small**2, rel=1e-6)


def test_fourier_coefficients_are_the_quartic_form() -> None:
    theta = math.pi - np.linspace(0.0, 3.0, 30)
    c0, c1, c2 = FOURIER.values()
    assert c0 + c1 * np.cos(theta) + c2 * np.cos(2.0 * theta) == pytest.approx(
        QUARTIC.by_angle(math.pi - theta)[0], abs=1e-14
    )
    assert [float(word) for word in QUARTIC.coefficients(0.1).split()] == [0.1, c0, c1, c2]


def test_angle_table_is_the_energy_and_its_force() -> None:
    rod = ANGLE_FORMS["rod_table"]
    text = rod.table({"LEG": 3.0, "TIP": 6.0})
    rows = [line.split() for line in text.split("TIP")[0].splitlines() if line[:1].isdigit()]
    theta, energy, force = np.array(rows, dtype=float)[1200:, 1:].T
    turning = np.pi - np.radians(theta)
    assert energy == pytest.approx(3.0 * rod.by_angle(turning)[0], rel=1e-9, abs=1e-15)
    assert -np.gradient(energy, theta)[1:-1] == pytest.approx(force[1:-1], rel=1e-4, abs=1e-6)
