"""Material laws: energy, stress and tangent belong together, and waves unload as the shape of the law demands."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from beadband import parameters
from beadband.errors import UsageError
from beadband.model import scene as scenes
from beadband.model.bands import CATALOGUE, known_values, laws_of
from beadband.model.laws import LAWS, Law, Linear, MooneyRivlin, constant, law_of, register, registry
from beadband.model.roots import root
from beadband.model.scene import scene_of
from beadband.planning.plan import plan_of
from beadband.runs.rear_run import follow_rear


@dataclass(frozen=True)
class Stiffening(Law):
    """E e + k e^2: convex, unloads in a fan."""

    name = "stiffening"
    modulus_pa: float = constant("E", "Pa", "modulus at rest", above=0.0)
    hardening_pa: float = constant("k", "Pa", "hardening")

    def energy(self, stretch: Any) -> Any:
        return 0.5 * self.modulus_pa * (stretch - 1.0) ** 2 + self.hardening_pa / 3.0 * (stretch - 1.0) ** 3

    def stress(self, stretch: Any) -> Any:
        return self.modulus_pa * (stretch - 1.0) + self.hardening_pa * (stretch - 1.0) ** 2

    def tangent(self, stretch: Any) -> Any:
        return self.modulus_pa + 2.0 * self.hardening_pa * (stretch - 1.0)


STIFFENING = Stiffening(1.0e6, 0.8e6)
ALL = [law_of(law, known_values(band)) for band in CATALOGUE for law in laws_of(band)] + [STIFFENING]


@pytest.mark.parametrize("law", ALL, ids=lambda law: f"{law.name}-{law.rest_modulus_pa:.3g}")
def test_stress_and_tangent_are_derivatives_of_the_energy(law: Law) -> None:
    stretch = np.linspace(0.4, 2.4, 41) + 0.0j
    step = 1e-30j
    scale = law.rest_modulus_pa
    assert np.allclose(
        np.imag(law.energy(stretch + step)) / 1e-30, law.stress(stretch).real, rtol=1e-12, atol=1e-12 * scale
    )
    assert np.allclose(
        np.imag(law.stress(stretch + step)) / 1e-30, law.tangent(stretch).real, rtol=1e-12, atol=1e-12 * scale
    )
    assert law.energy(1.0) == 0.0
    assert law.stress(1.0) == 0.0


def test_mooney_rivlin_rest_modulus_is_six_times_the_sum() -> None:
    for band, modulus in {"I": 3.93e6, "II": 1.494e6, "III": 1.854e6, "IV": 1.896e6}.items():
        assert law_of("mooney-rivlin", known_values(band)).rest_modulus_pa == pytest.approx(modulus, rel=1e-12)
        assert CATALOGUE[band].rest_modulus_pa == pytest.approx(modulus, rel=1e-12)


def test_only_band_four_has_a_tension_peak() -> None:
    peaks = {name: band.rubber.peak_stretch() for name, band in CATALOGUE.items()}
    assert peaks.pop("IV") == pytest.approx(2.475, abs=5e-4)
    assert set(peaks.values()) == {None}
    law = CATALOGUE["IV"].rubber
    assert law.stress(2.4754264) == pytest.approx(0.524e6, rel=1e-3)


@pytest.mark.parametrize("law", ALL, ids=lambda law: f"{law.name}-{law.rest_modulus_pa:.3g}")
def test_stretch_at_inverts_the_stress(law: Law) -> None:
    for stretch in (1.0 + 1e-9, 1.01, 1.3, 2.2):
        assert law.stretch_at(float(law.stress(stretch)), 2.3) == pytest.approx(stretch, rel=1e-13)


def test_concave_law_unloads_through_one_shock() -> None:
    law = CATALOGUE["III"].rubber
    wave = law.unloading_wave(1.476, 1.0134, 1300.0)
    rise, drop = law.stress(1.476) - law.stress(1.0134), 1.476 - 1.0134
    assert wave.particle_speed_m_s == pytest.approx(math.sqrt(rise * drop / 1300.0), rel=1e-13)
    assert wave.front_speed_m_s == pytest.approx(math.sqrt(rise / drop / 1300.0), rel=1e-13)


def test_linear_law_unloads_at_the_bar_speed() -> None:
    wave = Linear(1.1e6).unloading_wave(1.5, 1.02, 1300.0)
    speed = math.sqrt(1.1e6 / 1300.0)
    assert wave.front_speed_m_s == pytest.approx(speed, rel=1e-12)
    assert wave.particle_speed_m_s == pytest.approx(speed * 0.48, rel=1e-12)


def test_stiffening_law_unloads_in_a_fan() -> None:
    law, density = STIFFENING, 1000.0
    wave = law.unloading_wave(1.6, 1.1, density)

    def integral(strain: float) -> float:  # of sqrt(tangent)
        return (law.modulus_pa + 2.0 * law.hardening_pa * strain) ** 1.5 / (3.0 * law.hardening_pa)

    exact = (integral(0.6) - integral(0.1)) / math.sqrt(density)
    assert wave.kind == "fan"
    assert wave.particle_speed_m_s == pytest.approx(exact, rel=1e-12)
    assert wave.front_speed_m_s == pytest.approx(math.sqrt(law.tangent(1.6) / density), rel=1e-12)


@pytest.fixture
def stiffening(monkeypatch: pytest.MonkeyPatch) -> type[Law]:
    """The class above, registered for the time of a test."""
    monkeypatch.setattr(parameters, "TABLE", dict(parameters.TABLE))
    for where in (scenes, registry):
        monkeypatch.setattr(where, "TABLE", parameters.TABLE, raising=False)
    monkeypatch.setitem(parameters._words, "law", list(parameters.words("law")))
    monkeypatch.setitem(LAWS, "stiffening", Stiffening)
    return register(Stiffening)


def test_a_registered_law_is_usable_at_once(stiffening: type[Law]) -> None:
    values = {"law": "stiffening", "modulus_pa": 1.0e6, "hardening_pa": 0.8e6, "bending_scale": 1e-4, "beads": 300}
    plan = plan_of(scene_of(values))
    assert follow_rear(plan).fitted_speed_m_s.value == pytest.approx(plan.string.rear_speed_m_s, rel=3e-3)
    with pytest.raises(UsageError, match="lacks a constant"):
        scene_of({"law": "stiffening"})
    with pytest.raises(UsageError, match="--hardening is not used by the law linear"):
        scene_of({"law": "linear", "hardening_pa": 1e5})


def test_a_name_that_is_taken_is_refused() -> None:
    with pytest.raises(ValueError, match="registered already"):

        @register
        @dataclass(frozen=True)
        class Other(Law):
            name = "linear"


def test_the_expression_for_lammps_is_the_energy() -> None:
    for law in (Linear(1.1e6), MooneyRivlin(0.187e6, 0.122e6)):
        for s in (0.6, 1.3, 2.2):
            formula = law.lammps_expression().replace("^", "**")
            assert eval(formula, {"s": s}) == pytest.approx(law.energy(s), rel=1e-12)


def test_a_law_without_stiffness_is_refused() -> None:
    with pytest.raises(UsageError, match="no stiffness at rest"):
        scene_of({"c10_pa": -1e6})


def test_mooney_rivlin_energy_keeps_its_digits_at_small_strain() -> None:
    law = MooneyRivlin(0.187e6, 0.122e6)
    assert law.energy(1.0 + 1e-7) == pytest.approx(0.5 * law.rest_modulus_pa * 1e-14, rel=1e-6)


def test_root_finds_the_last_digits() -> None:
    assert root(lambda x: x**3 - 2.0, 0.0, 2.0) == pytest.approx(2.0 ** (1.0 / 3.0), rel=1e-15)
    assert root(lambda x: math.expm1(30.0 * (x - 0.999)), 0.0, 1.0) == pytest.approx(0.999, rel=1e-14)
    with pytest.raises(ValueError, match="no change of sign"):
        root(lambda x: x * x + 1.0, -1.0, 1.0)
