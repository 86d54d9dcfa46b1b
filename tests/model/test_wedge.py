"""The string limit against its published and tabulated values, and the catalogue's derived columns."""

from __future__ import annotations

import math

import pytest

from beadband.errors import UsageError
from beadband.model.bands import CATALOGUE, band_of
from beadband.model.laws import Gent, Law, Linear, Yeoh
from beadband.model.wedge import published_ratio, string_limit, wave_speeds, wedge_of

PHI = math.radians(14.0)


@pytest.mark.parametrize(
    ("band", "speed", "residual", "front"),
    [
        ("I", 29.363, 0.01102, 49.34),
        ("II", 16.937, 0.01436, 28.67),
        ("III", 17.480, 0.01339, 29.52),
        ("IV", 16.678, 0.01014, 27.97),
    ],
)
def test_mooney_rivlin_string(band: str, speed: float, residual: float, front: float) -> None:
    found = string_limit(CATALOGUE[band].rubber, CATALOGUE[band].density_kg_m3, 0.476, PHI)
    assert found.rear_speed_m_s == pytest.approx(speed, abs=6e-4)
    assert found.residual_strain == pytest.approx(residual, abs=6e-6)
    assert found.front_speed_m_s == pytest.approx(front, abs=6e-3)


def test_linear_string_in_closed_form() -> None:
    band = CATALOGUE["III"]
    found = string_limit(Linear(band.modulus_pa), band.density_kg_m3, 0.476, PHI)
    assert found.residual_strain == pytest.approx(0.02068, abs=5e-6)
    assert found.rear_speed_m_s / band.bar_speed_m_s == pytest.approx(0.58278, abs=5e-6)
    # (e - e1) sin = sqrt(e1 (1 + e1)) (1 - sin) is a quadratic in e1.
    q = ((1.0 - math.sin(PHI)) / math.sin(PHI)) ** 2
    exact = min(
        (2 * 0.476 + q - sign * math.sqrt((2 * 0.476 + q) ** 2 - 4 * (1 - q) * 0.476**2)) / (2 * (1 - q))
        for sign in (1.0, -1.0)
        if (2 * 0.476 + q - sign * math.sqrt((2 * 0.476 + q) ** 2 - 4 * (1 - q) * 0.476**2)) / (2 * (1 - q)) > 0.0
    )
    assert found.residual_strain == pytest.approx(exact, rel=1e-12)


@pytest.mark.parametrize(
    ("law", "kind"),
    [
        (CATALOGUE["III"].rubber, "shock"),
        (Linear(1.1e6), "sharp front"),
        (Yeoh(2e5, 1e4, 5e3), "shock and fan"),
        (Gent(3e5, 8.0), "shock and fan"),
    ],
    ids=lambda one: getattr(one, "name", one),
)
def test_the_limit_holds_for_the_admissible_wave(law: Law, kind: str) -> None:
    """u sin(phi) = k (1 - sin(phi)) with u of the wave by the envelope, whichever way the limit was found."""
    strain, phi, density = 1.0, math.radians(14.0), 1100.0
    limit = string_limit(law, density, strain, phi)
    behind = 1.0 + limit.residual_strain
    wave = law.unloading_wave(1.0 + strain, behind, density)
    assert wave.kind == kind
    kink = math.sqrt(float(law.stress(behind)) * behind / density)
    assert wave.particle_speed_m_s * math.sin(phi) == pytest.approx(kink * (1.0 - math.sin(phi)), rel=1e-10)


def test_kink_condition_and_momentum_hold() -> None:
    band = CATALOGUE["III"]
    law = band.rubber
    found = string_limit(law, band.density_kg_m3, 0.8, math.radians(20.0))
    kink = math.sqrt(found.residual_stress_pa * (1.0 + found.residual_strain) / band.density_kg_m3)
    sine = math.sin(math.radians(20.0))
    assert found.leg_speed_m_s * sine == pytest.approx(kink * (1.0 - sine), rel=1e-11)


def test_alpha_depends_on_the_wave_speed_meant() -> None:
    band = CATALOGUE["III"]
    found = string_limit(band.rubber, band.density_kg_m3, 0.476, PHI)
    speeds = wave_speeds(band, found.front_speed_m_s, 0.476, PHI)
    alpha = {key: found.rear_speed_m_s / speed / published_ratio(0.476, PHI) for key, speed in speeds.items()}
    assert alpha == pytest.approx({"bar": 1.413, "rest": 1.088, "front_horizontal": 0.972}, abs=6e-4)


def test_wedge_closes() -> None:
    wedge = wedge_of(0.204, 0.476, PHI)
    assert wedge.reference_leg_m == pytest.approx(0.0702, abs=5e-5)
    assert wedge.finger_radius_m == pytest.approx(wedge.leg_m * math.tan(PHI), rel=1e-15)
    length = 2.0 * wedge.leg_m + (math.pi + 2.0 * PHI) * wedge.finger_radius_m
    assert length == pytest.approx(1.476 * 0.204, rel=1e-14)


def test_catalogue_sections() -> None:
    third, circle = CATALOGUE["III"], CATALOGUE["circular"]
    assert third.area_m2 == pytest.approx(3.2e-6)
    assert third.second_moment_m4 == pytest.approx(1.6e-3 * 2.0e-3**3 / 12.0)
    assert circle.area_m2 == pytest.approx(math.pi * 0.8e-3**2)
    assert circle.second_moment_m4 == pytest.approx(math.pi / 4.0 * 0.8e-3**4)
    assert circle.circumference_m == pytest.approx(math.pi * 0.064)


def test_overrides_and_their_refusals() -> None:
    assert band_of("III", {"thickness_m": 1.9e-3}).area_m2 == pytest.approx(3.04e-6)
    for wrong in ({"thickness_m": 0.0}, {"density_kg_m3": math.nan}, {"c10_pa": math.inf}):
        with pytest.raises(UsageError):
            band_of("III", wrong)
    with pytest.raises(UsageError, match="unknown band"):
        band_of("V")
    with pytest.raises(UsageError, match="no width"):
        band_of("circular", {"width_m": 1e-3})
