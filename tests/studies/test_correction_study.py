"""How the correction's map is made: limits of releases, training, and the way from scenes to a calibrated file."""

from __future__ import annotations

import math

import numpy as np
import pytest

from beadband.errors import UsageError
from beadband.model import correction
from beadband.model.correction import bending_share, corrected, map_of, network
from beadband.model.scales import LONGEST_LAYER
from beadband.studies import correction as study
from beadband.studies.correction import fit, runs, training
from beadband.studies.correction.fit import relative_miss
from beadband.studies.correction.runs import Released, Sample, limit
from beadband.studies.correction.scenes import LAW_DRAWS, any_band, catalogue_band, drawn


@pytest.mark.parametrize("order", [1, 2])
def test_errors_of_their_order_are_taken_off_whole(order):
    beads = (100, 142, 200)
    value, error = limit(beads, [0.03 + 5.0 / n**order for n in beads], order)
    assert value == pytest.approx(0.03, abs=1e-12)
    assert error < 0.2 * 5.0 / 200**order + 3e-4


def test_another_order_stays_within_a_few_errors():
    value, error = limit((100, 142, 200), [0.03 + 20.0 / n**1.5 for n in (100, 142, 200)], 1)
    assert abs(value - 0.03) < 2.5 * error


def test_what_was_not_measured_stays_unknown():
    assert all(math.isnan(each) for each in limit((100, 142, 200), (0.03, math.nan, 0.03), 1))


def test_draws_repeat_and_can_be_run():
    first, second = drawn(any_band, 60, 4), drawn(any_band, 60, 4)
    assert [one.as_dict() for one in first] == [one.as_dict() for one in second]
    assert {one.band.name.removeprefix("drawn, ") for one in first} == set(LAW_DRAWS)
    assert all(one.scales.bending_layer_m <= LONGEST_LAYER * one.wedge.reference_leg_m for one in first)


def test_the_jacobian_is_that_of_differences():
    rng = np.random.default_rng(0)
    inputs, shapes = rng.normal(size=(7, 3)), [(3, 4), (4, 5), (5, 1)]
    flat = rng.normal(size=sum(a * b + b for a, b in shapes))
    jacobian = training._jacobian(training._layers(flat, shapes), inputs)
    for column in range(len(flat)):
        step = np.zeros(len(flat))
        step[column] = 1e-6
        up, down = (network(training._layers(flat + sign * step, shapes), inputs) for sign in (1.0, -1.0))
        assert jacobian[:, column] == pytest.approx((up - down) / 2e-6, abs=1e-8)


def test_a_network_finds_a_smooth_function_under_noise():
    rng = np.random.default_rng(1)

    def truth(at):
        return np.sin(2.0 * at[:, 0]) * np.exp(0.3 * at[:, 1]) / (1.0 + at[:, 2] ** 2)

    inputs, fresh = rng.normal(size=(400, 3)), rng.normal(size=(200, 3))
    noise = 0.02
    values = truth(inputs) + noise * rng.normal(size=400)
    layers = training.trained(training.Task(inputs, values, np.full(400, noise), (8, 8), 0, 40))
    missed = network(layers, fresh) - truth(fresh)
    assert np.median(np.abs(missed)) < noise


def _known(numbers):
    """A correction in closed form, in place of releases."""
    at = {name: numbers[:, index] for index, name in enumerate(correction.FEATURES)}
    pull = 1.0 / (1.0 + np.exp(-at["ln_crossover"]))
    return bending_share(numbers) * (0.3 * pull * np.cos(3.0 * at["half_angle_rad"]) - 0.05)


def _release(scene):
    delta = float(_known(correction.features(scene)[None])[0])
    beads = (100, 142, 200)
    ratio = 0.6 + delta if scene.scales.window.exists else math.nan
    return Released(beads, tuple(delta + 0.1 / n for n in beads), (ratio,) * 3)


def test_the_whole_way_gives_a_map_whose_bar_holds(tmp_path, monkeypatch):
    monkeypatch.setattr(runs, "release", _release)
    monkeypatch.setattr(fit, "HIDDEN", {"speed": (6, 6), "curvature": (4, 4)})
    monkeypatch.setattr(fit, "STEPS", 30)
    path = study.make(tmp_path, scenes=250, catalogue=100, held=100, held_catalogue=100, seed=3, jobs=1, families=False)
    sample = Sample.read(next(tmp_path.glob("test-*.npz")))
    assert sample.delta == pytest.approx(_known(sample.features), abs=1e-9)
    table = study.json.loads(path.read_text())["maps"]["speed"]
    found = corrected("speed", map_of(table), sample.features)
    missed = np.abs(relative_miss("speed", found.delta, sample))[found.inside]
    assert found.inside.mean() > 0.9
    assert np.median(missed) < 0.1 * np.median(np.abs(sample.delta))
    assert np.mean(missed <= found.error[found.inside]) > 0.95
    # Releases that are there are not made again, and the same numbers give the same file.
    monkeypatch.setattr(runs, "release", None)
    before = path.read_text()
    assert (
        study.make(tmp_path, scenes=250, catalogue=100, held=100, held_catalogue=100, seed=3, jobs=1, families=False)
        == path
    )
    assert path.read_text() == before


def test_too_few_scenes_are_refused(tmp_path):
    with pytest.raises(UsageError, match="too few scenes"):
        study.make(tmp_path, scenes=20)


def test_scenes_like_the_catalogue_are_told_apart():
    scenes = drawn(catalogue_band, 20, 9)
    assert {one.law for one in scenes} == {"linear", "mooney-rivlin"}
