"""String limits of many wedges at once against those of one, and the formula's numbers against the map's."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from beadband.errors import UsageError
from beadband.model import correction, formula
from beadband.model.scene import scene_of
from beadband.model.string_arrays import string_limits
from beadband.model.wedge import string_limit

LAWS: list[tuple[dict[str, Any], set[str]]] = [
    ({}, {"shock"}),
    ({"band": "IV"}, {"shock"}),
    ({"law": "linear"}, {"sharp front"}),
    ({"law": "gent", "mu_pa": 3.5e5, "jm": 4.0}, {"shock", "shock and fan", "fan"}),
    ({"law": "ogden", "mu_pa": (1e5, 2e4), "alpha": (2.5, 4.5)}, {"shock", "shock and fan", "fan"}),
    ({"law": "yeoh", "c1_pa": 2e5, "c2_pa": -1e4, "c3_pa": 3e3}, {"shock", "shock and fan"}),
    ({"law": "ogden", "mu_pa": (1e5,), "alpha": (6.0,)}, {"fan", "shock and fan", "shock"}),
]


@pytest.mark.parametrize(("values", "kinds"), LAWS, ids=lambda one: str(one)[:40])
def test_many_string_limits_are_those_of_one(values: dict[str, Any], kinds: set[str]) -> None:
    law = scene_of({**values, "strain": 0.3}).material
    rng = np.random.default_rng(3)
    strain, angle = rng.uniform(0.05, 1.2, 25), np.radians(rng.uniform(3.0, 24.0, 25))
    found = string_limits(law, 960.0, strain, angle)
    single = [string_limit(law, 960.0, *pair) for pair in zip(strain.tolist(), angle.tolist(), strict=True)]
    assert {one.wave.kind for one in single} <= kinds
    for name in ("residual_strain", "residual_stress_pa"):
        assert getattr(found, name) == pytest.approx([getattr(one, name) for one in single], rel=5e-9)
    for name in ("rear_speed_m_s", "front_speed_m_s"):
        assert getattr(found, name) == pytest.approx([getattr(one, name) for one in single], rel=1e-9)
    assert found.mean_speed_ratio == pytest.approx([one.wave.mean_speed_ratio for one in single], rel=1e-9)


def test_arguments_broadcast_and_density_scales() -> None:
    law = scene_of({}).material
    found = string_limits(law, np.array([900.0, 1600.0]), np.array([[0.3], [0.6], [0.9]]), 0.2)
    assert found.rear_speed_m_s.shape == (3, 2)
    assert found.rear_speed_m_s[:, 0] / found.rear_speed_m_s[:, 1] == pytest.approx(4.0 / 3.0, rel=1e-12)


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"law": "linear", "strain": 0.7},
        {"band": "IV", "strain": 1.2},
        {"law": "ogden", "mu_pa": (1e5, 2e4), "alpha": (2.5, 4.5), "strain": 1.1},
        {"section": "circle", "thickness_m": 1.5e-3},
        {"bending_scale": 0.0},
    ],
    ids=str,
)
def test_the_numbers_of_arrays_are_the_maps_features(values: dict[str, Any]) -> None:
    scene = scene_of(values)
    numbers, speed = formula._numbers(scene, *formula.scenes_of(scene, {}))
    assert numbers[0] == pytest.approx(correction.features(scene), rel=1e-9, nan_ok=True)
    assert float(speed) == pytest.approx(scene.string.rear_speed_m_s, rel=1e-12)


def test_arrays_of_scenes_are_refused_by_the_one_that_has_no_answer() -> None:
    scene = scene_of({"band": "IV"})
    with pytest.raises(UsageError, match="tension peaks"):
        formula.formula(scene, "speed", {"strain": np.array([0.5, 1.0, 1.6])})
    with pytest.raises(UsageError, match="too wide for its strain"):
        formula.formula(scene, "speed", {"half_angle_deg": np.array([10.0, 70.0])})
    with pytest.raises(UsageError, match="too thick for its finger"):
        formula.formula(scene, "speed", {"half_angle_deg": np.array([10.0, 0.01])})


def test_without_bending_the_formula_is_the_string_limit() -> None:
    scene = scene_of({"bending_scale": 0.0})
    found = formula.formula(scene, "speed")
    assert float(found.value) == pytest.approx(scene.string.rear_speed_m_s, rel=1e-12)
    assert float(found.error) == 0.0
