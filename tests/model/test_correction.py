"""The correction of the string limit: exact limits, similarity, refusals, and its bar against fresh releases."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from beadband.model import correction
from beadband.model.correction import FEATURES, curvature_correction, features, speed_correction
from beadband.model.scene import scene_of
from beadband.studies.correction.runs import release
from beadband.studies.correction.scenes import any_band, catalogue_band, drawn
from beadband.studies.pool import close_session

AT = {name: index for index, name in enumerate(FEATURES)}


@pytest.fixture(scope="module")
def numbers():
    """Features of scenes of every kind, shape (scenes, features)."""
    scenes = drawn(any_band, 150, 31) + drawn(catalogue_band, 50, 31)
    return np.array([features(scene) for scene in scenes])


def test_without_bending_the_string_limit_is_exact():
    found = speed_correction(features(scene_of({"bending_scale": 0.0})))
    assert (found.delta, found.error, found.inside) == (0.0, 0.0, True)


def test_the_correction_vanishes_with_bending():
    scales = np.array([1.0, 1e-2, 1e-4, 1e-6, 1e-8, 1e-10])
    rows = np.array([features(scene_of({"bending_scale": float(scale)})) for scale in scales])
    found, share = speed_correction(rows), correction.bending_share(rows)
    assert found.inside.all()
    assert np.all(np.abs(found.delta) < 0.2 * share)
    assert np.all(np.diff(found.error[2:]) < 0.0)
    # As the root of a_b, which is the root of EI.
    assert share[2] / share[1] == pytest.approx(1e-2**0.25, rel=0.05)


def test_the_share_of_bending_is_its_kink_over_the_rear():
    scenes = drawn(any_band, 40, 5)
    shares = correction.bending_share(np.array([features(scene) for scene in scenes]))
    for scene, share in zip(scenes, shares, strict=True):
        kink = np.sqrt(scene.bending_diffusivity_m2_s / scene.scales.front_arrival_s)
        assert share == pytest.approx(kink / (kink + scene.string.rear_speed_m_s), rel=1e-8)


def test_thinner_than_fitted_the_bar_holds_all_of_the_correction():
    rows = np.array([features(scene_of({"bending_scale": scale, "band": "IV"})) for scale in (1e-6, 1e-7)])
    found = speed_correction(rows)
    assert found.inside.all()
    assert np.all(found.error > np.abs(found.delta) * 0.99)
    share = correction.bending_share(rows)
    assert found.delta[1] / found.delta[0] == pytest.approx(share[1] / share[0], rel=1e-3)


def test_the_features_are_those_of_similar_scenes():
    """Length, density and modulus scaled together change no dimensionless number."""
    one = {"circumference_m": 0.2, "width_m": 1e-3, "thickness_m": 1.5e-3, "density_kg_m3": 1000.0}
    other = {"circumference_m": 0.6, "width_m": 7e-3, "thickness_m": 4.5e-3, "density_kg_m3": 2500.0}
    law = {"band": "mine", "law": "mooney-rivlin", "strain": 0.7, "half_angle_deg": 11.0}
    soft = {"c10_pa": 0.2e6, "c01_pa": 0.1e6, "modulus_pa": 1.2e6}
    stiff = {key: 3.0 * value for key, value in soft.items()}
    first, second = (features(scene_of(law | band)) for band in (one | soft, other | stiff))
    assert second == pytest.approx(first, rel=1e-9)


def test_features_of_arrays_are_those_of_scenes():
    scenes = drawn(any_band, 5, 7)
    rows = [features(scene) for scene in scenes]
    arrays = {
        "strain": [scene.strain for scene in scenes],
        "half_angle_rad": [scene.half_angle_rad for scene in scenes],
        "leg_m": [scene.wedge.reference_leg_m for scene in scenes],
        "density_kg_m3": 1000.0,
        "diffusivity_m2_s": [scene.bending_diffusivity_m2_s for scene in scenes],
        "front_speed_m_s": [scene.string.front_speed_m_s for scene in scenes],
        "mean_speed_ratio": [scene.string.wave.mean_speed_ratio for scene in scenes],
        "residual_strain": [scene.string.residual_strain for scene in scenes],
        "residual_stress_pa": [scene.string.residual_stress_pa for scene in scenes],
        "held_stress_pa": [float(scene.material.stress(1.0 + scene.strain)) for scene in scenes],
        "held_tangent_pa": [float(scene.material.tangent(1.0 + scene.strain)) for scene in scenes],
        "residual_tangent_pa": [float(one.material.tangent(1.0 + one.string.residual_strain)) for one in scenes],
        "window_start_s": [scene.scales.window.start_s for scene in scenes],
        "window_end_s": [scene.scales.window.end_s for scene in scenes],
    }
    assert correction.features_of(**{key: np.array(value) for key, value in arrays.items()}) == pytest.approx(
        np.array(rows), rel=1e-12
    )


@pytest.mark.parametrize("function", [speed_correction, curvature_correction])
def test_many_scenes_at_once_are_the_scenes_one_by_one(numbers, function):
    many = function(numbers)
    ones = [function(row) for row in numbers[:40]]
    assert [one.inside for one in ones] == list(many.inside[:40])
    assert [one.delta for one in ones] == pytest.approx(many.delta[:40], rel=1e-9, abs=1e-12)
    assert [one.error for one in ones] == pytest.approx(many.error[:40], rel=1e-9)
    again = function(np.tile(numbers, (30, 1)))
    assert again.delta == pytest.approx(np.tile(many.delta, 30), rel=1e-9, abs=1e-12)


def test_the_correction_is_smooth():
    """Its second difference falls with the square of the step, on a path through strain and angle."""
    fine = np.linspace(0.0, 1.0, 65)
    rows = np.array([features(scene_of({"strain": 0.3 + 0.6 * t, "half_angle_deg": 8.0 + 12.0 * t})) for t in fine])
    delta = speed_correction(rows).delta
    second = [np.abs(np.diff(delta[::step], 2)).max() for step in (4, 2, 1)]
    assert second[0] / second[1] == pytest.approx(4.0, rel=0.25)
    assert second[1] / second[2] == pytest.approx(4.0, rel=0.25)


@pytest.mark.parametrize(
    "changes",
    [
        {"half_angle_deg": 50.0, "strain": 0.1},
        {"law": "linear", "strain": 6.0, "half_angle_deg": 5.0},
        {"strain": 0.003},
        {"band": "I", "bending_scale": 60.0},
    ],
    ids=["wide", "long", "hardly stretched", "bent legs"],
)
def test_outside_its_region_it_refuses(changes):
    found = speed_correction(features(scene_of(changes)))
    assert not found.inside
    assert found.error == np.inf
    assert found.delta == 0.0


def test_another_question_is_not_answered():
    scene = scene_of({})
    assert correction.applies(scene)
    assert not correction.applies(scene_of({"until": "launch"}))
    assert not correction.applies(scene_of({"loss_time_s": 2e-5}))
    assert correction.applies(replace(scene, loss_time_s=2e-6, planned=("loss_time_s",)))


def test_without_a_window_there_is_no_curvature(numbers):
    closed = numbers[:, AT["ln_window_end"]] < numbers[:, AT["ln_window_start"]] + np.log(1.5)
    assert 0.2 < closed.mean() < 0.8
    assert not curvature_correction(numbers).inside[closed].any()


def test_fresh_releases_lie_within_the_bar():
    """Scenes that no fit has seen, released at three levels here and now."""
    scenes = drawn(catalogue_band, 14, 77) + drawn(any_band, 10, 78)
    try:
        found = [release(scene) for scene in scenes]
    finally:
        close_session()
    rows = np.array([features(scene) for scene in scenes])
    speed, curvature = speed_correction(rows), curvature_correction(rows)
    true = np.array([one.delta[0] for one in found])
    missed = np.abs((1.0 + speed.delta) / (1.0 + true) - 1.0)
    assert speed.inside[:14].all()
    assert np.sum(missed[speed.inside] > speed.error[speed.inside]) <= 2
    assert np.median(missed[speed.inside]) < 0.1 * np.median(np.abs(true))
    ratio = np.array([one.ratio[0] for one in found])
    known = np.isfinite(ratio) & curvature.inside
    assert known.sum() >= 4
    gone = np.abs((1.0 + curvature.delta[known]) / ratio[known] - 1.0)
    assert np.sum(gone > curvature.error[known]) <= 1


def test_the_record_says_what_the_map_is_worth():
    record = correction.record()
    assert record["features"] == list(FEATURES)
    speed = record["held_out"]["speed"]
    assert speed["catalogue"]["bar_below_0.5_percent"] >= 0.95
    assert all(row["within_bar"] >= record["covered"] for row in speed.values())
