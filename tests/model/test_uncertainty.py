"""Errors of inputs: read from flags and files, and what similarity makes of them."""

from __future__ import annotations

import math
import tomllib
from typing import Any

import numpy as np
import pytest

from beadband.errors import UsageError
from beadband.model.scene import Scene, printed_errors, scene_of
from beadband.model.scenefile import flat_scene, scene_text
from beadband.model.uncertainty import basis, changed, elasticities, inputs_of
from beadband.parameters import Uncertain, parsed


def test_errors_are_read_from_texts_and_tables() -> None:
    assert parsed("thickness_m", "2.0e-3 +/- 5e-5") == Uncertain(2.0e-3, 5e-5)
    assert parsed("thickness_m", "2.0e-3+/-2.5%") == Uncertain(2.0e-3, pytest.approx(5e-5))
    assert parsed("c10_pa", "-2.4e4 ± 2 %") == Uncertain(-2.4e4, pytest.approx(480.0))
    scene = scene_of({"thickness_m": {"value": 2.0e-3, "error": 5e-5}, "strain": "0.476 +/- 0.01"})
    assert scene.errors == (("strain", 0.01), ("thickness_m", 5e-5))
    assert scene_of(flat_scene(tomllib.loads(scene_text(scene)), "a file")) == scene
    assert inputs_of(scene_of({})) is None


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"strain": "0.4 +/- x"}, "not a number with an error"),
        ({"strain": {"value": 0.4}}, "not a number with an error"),
        ({"strain": Uncertain(0.4, -0.1)}, "out of range"),
        ({"strain": Uncertain(0.4, math.inf)}, "out of range"),
        ({"beads": "200 +/- 3"}, "takes no uncertainty"),
        ({"tolerance": "0.01 +/- 1%"}, "takes no uncertainty"),
        ({"band": {"value": 1.0, "error": 0.1}}, "takes no uncertainty"),
    ],
)
def test_errors_that_are_none_are_refused(values: dict[str, Any], said: str) -> None:
    with pytest.raises(UsageError, match=said):
        scene_of(values)


@pytest.mark.parametrize(
    ("rows", "said"),
    [
        ([[1.0, 0.0]], "no matrix"),
        ([[1.0]], "shape"),
        ([[1.0, 0.5], [0.4, 1.0]], "not symmetric"),
        ([[1.0, 2.0], [2.0, 1.0]], "negative eigenvalue"),
    ],
)
def test_a_covariance_must_be_one(rows: list[list[float]], said: str) -> None:
    with pytest.raises(UsageError, match=said):
        inputs_of(scene_of({"covariance": rows}))


def test_a_covariance_and_errors_that_differ_are_refused() -> None:
    rows = [[1e6, 0.0], [0.0, 4e6]]
    found = inputs_of(scene_of({"covariance": rows, "c10_pa": Uncertain(0.187e6, 1e3), "strain": Uncertain(0.4, 0.01)}))
    assert found is not None
    assert found.names == ("strain", "c10_pa", "c01_pa")
    assert found.errors == pytest.approx([0.01, 1e3, 2e3])
    with pytest.raises(UsageError, match="where its error is"):
        inputs_of(scene_of({"covariance": rows, "c10_pa": Uncertain(0.187e6, 2e3)}))


def test_a_catalogue_band_as_printed_needs_two_derivatives() -> None:
    scene = scene_of({})
    printed = printed_errors(scene)
    assert printed["density_kg_m3"] == 50.0
    assert printed["c10_pa"] == 500.0
    values = scene.as_dict()
    inputs = inputs_of(scene_of({key: Uncertain(values[key], error) for key, error in printed.items()}))
    assert inputs is not None
    assert basis(scene, inputs.names) == ["bending_scale", "c10_pa"]
    everything = ("strain", "half_angle_deg", *inputs.names)
    assert len(basis(scene, everything)) == 4
    assert len(basis(scene_of({"loss_time_s": 1e-5}), everything)) == len(everything)  # another scale of time


def slope(scene: Scene, name: str) -> float:
    """d ln/d ln of a speed that has bending in it, V_string (1 + spread/leg), by central differences."""

    def speed(factor: float) -> float:
        at = changed(scene, {name: scene.as_dict()[name] * factor})
        return math.log(at.string.rear_speed_m_s * (1.0 + at.scales.bending_spread_m / at.wedge.reference_leg_m))

    return (speed(1.0 + 1e-5) - speed(1.0 - 1e-5)) / 2e-5


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"law": "linear"},
        {"band": "circular"},
        {"band": "IV", "strain": 0.9},
        {"bending_modulus": "rest"},
        {"section": "tube", "wall_m": 4e-4},
        {"section": "given", "area_m2": 3e-6, "second_moment_m4": 1e-12},
    ],
    ids=lambda values: "-".join(f"{v}" for v in values.values()) or "default",
)
def test_similarity_gives_what_differences_give(values: dict[str, Any]) -> None:
    """Any speed that follows from the same numbers must obey the rules; this one is had without a run."""
    scene = scene_of(values)
    known = {*scene.band.properties(), *scene.material.values()} - {"section"}
    names = ["strain", "half_angle_deg", *sorted(known)]
    had = {name: slope(scene, name) for name in basis(scene, names)}
    assert len(had) < len(names) - 3
    found = elasticities(scene, names, had, 0.5)
    assert found == pytest.approx([slope(scene, name) for name in names], abs=2e-5)
    assert found[names.index("density_kg_m3")] == -0.5
    moduli = [name for name in names if name.endswith("_pa")]
    assert np.sum(found[[names.index(name) for name in moduli]]) == pytest.approx(0.5, abs=1e-12)
