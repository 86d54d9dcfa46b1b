"""Measuring functions on made-up paths whose answer is known."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from beadband.analysis.curvature import curvatures, decay
from beadband.analysis.fits import Measured, hann_mean, slope
from beadband.analysis.readers import ReadError, Trajectory, averaged_rear, read, read_rears


def test_slope_of_a_line_is_exact() -> None:
    t = np.linspace(0.0, 1.0, 50)
    found = slope(t, 3.0 + 17.5 * t, 0.2, 0.8)
    assert found.value == pytest.approx(17.5, rel=1e-13)
    assert found.error < 1e-12


def test_slope_error_covers_correlated_noise() -> None:
    random = np.random.default_rng(5)
    t = np.linspace(0.0, 1.0, 300)
    inside = 0
    for _ in range(200):
        noise = np.convolve(random.normal(size=330), np.ones(10) / 10.0, mode="valid")[:300]
        found = slope(t, 2.0 * t + 0.1 * noise, 0.0, 1.0)
        inside += abs(found.value - 2.0) < 2.0 * found.error
    assert inside > 180  # two standard errors of a white-noise formula would hold only about half of them


def test_a_frame_at_the_end_of_the_interval_counts_however_its_time_is_rounded() -> None:
    times = np.linspace(0.0, 1.0, 21)
    values = times**3
    fits = {slope(times * (1.0 + shift), values, 0.4, 0.85).value for shift in (-2e-16, 0.0, 2e-16, 1e-15)}
    assert max(fits) - min(fits) < 1e-12
    inner = slope(times, values, 0.401, 0.849).value
    assert abs(inner - max(fits)) > 1e-3


def test_slope_needs_frames() -> None:
    with pytest.raises(ValueError, match="needs 4"):
        slope(np.arange(3.0), np.arange(3.0), 0.0, 2.0)


def test_curvature_of_beads_on_a_circle() -> None:
    radius, spacing = 0.02, 1e-3
    turn = 2.0 * math.asin(spacing / (2.0 * radius))
    points = [radius * np.array([[math.cos(a), math.sin(a)]]) for a in (-turn, 0.0, turn)]
    assert curvatures(*points, spacing)[0] == pytest.approx(turn / spacing, rel=1e-12)
    assert curvatures(*points, spacing)[0] == pytest.approx(1.0 / radius, rel=2e-4)


def test_decay_of_a_power_law() -> None:
    t = np.geomspace(1e-5, 1e-3, 400)
    found = decay(t, 0.7 * t**-0.5, t**-0.5, 5e-5, 5e-4)
    assert found.exponent.value == pytest.approx(-0.5, abs=1e-12)
    assert found.eq7_ratio.value == pytest.approx(0.7, rel=1e-12)
    with pytest.raises(ValueError, match="needs 4"):
        decay(t, t, t, 0.5, 0.6)


def test_hann_mean_of_a_line_is_its_value_at_the_centre() -> None:
    t = np.linspace(0.0, 1.0, 1001)
    assert hann_mean(t, 5.0 * t + 1.0, 0.5, 0.03) == pytest.approx(3.5, rel=1e-12)
    with pytest.raises(ValueError, match="no frame"):
        hann_mean(t, t, 2.0, 0.03)


def test_the_rear_of_a_leg_is_averaged_and_mirrored() -> None:
    path = np.random.default_rng(1).normal(size=(13, 2, 2))
    path[:, 0, 1] = 0.0
    found = averaged_rear(path, 3, 40)
    assert found.steps.tolist() == [0, 3, 6, 9, 12]
    assert found.ids.tolist() == [1, 2, 40]
    assert np.array_equal(found.positions_m[0], [path[0, 0], path[0, 1], path[0, 1] * [1.0, -1.0]])
    assert found.positions_m[2, 0] == pytest.approx(path[4:7, 0].mean(axis=0), rel=1e-14)
    assert found.positions_m[4, 1] == pytest.approx(path[10:13, 1].mean(axis=0), rel=1e-14)
    assert np.array_equal(found.positions_m[:, 2], found.positions_m[:, 1] * [1.0, -1.0])


def test_averaged_frames_have_the_time_of_their_middle() -> None:
    steps = np.array([0, 4, 8, 12])
    frames = Trajectory(steps, np.array([1]), np.zeros((4, 1, 2)))
    averaged = [np.mean(np.arange(last - 3, last + 1)) for last in steps[1:]]
    assert np.allclose(frames.times_s(0.5)[1:], 0.5 * np.array(averaged))
    assert frames.times_s(0.5)[0] == 0.0


def test_values_format_with_their_errors() -> None:
    speed = Measured(17.31627, 0.02106)
    assert str(speed) == "17.316 +/- 0.021"
    assert f"{speed}" == "17.316 +/- 0.021"
    assert f"{speed:.2f}" == "17.32 +/- 0.02"
    assert str(Measured(0.0045, 1e-5).scaled(1e3)) == "4.500 +/- 0.010"
    assert str(Measured(123456.0, 1234.0)) == "123456 +/- 1234"
    assert str(Measured(2.5, 0.0)) == "2.5 +/- 0"


def test_a_cut_dump_is_refused_wherever_it_ends(tmp_path: Path) -> None:
    head = "ITEM: NUMBER OF ATOMS\n2\nITEM: BOX BOUNDS ff ff pp\n0 1\n0 1\n0 1\nITEM: ATOMS id type xu yu zu\n"
    whole = "".join(f"ITEM: TIMESTEP\n{step}\n{head}1 1 0.25 0 0\n2 2 1.25 0.5 0\n" for step in (0, 4))
    path = tmp_path / "rear.lammpstrj"
    path.write_text(whole)
    assert read(path).positions_m.shape == (2, 2, 2)
    for cut in (1, 3, 12, 20, 60, 100):
        path.write_text(whole[:-cut])
        with pytest.raises(ReadError, match=r"rear\.lammpstrj can't be read"):
            read(path)
    with pytest.raises(ReadError, match="no bead 3"):
        Trajectory(np.array([0]), np.array([1, 2]), np.zeros((1, 2, 2))).bead(3)


@pytest.mark.parametrize("size", [0, 100, 400])
def test_a_dump_of_legs_that_is_not_whole_is_refused(tmp_path: Path, size: int) -> None:
    path = tmp_path / "legs.bin"
    path.write_bytes(b"DUMPCUSTOM"[: size % 11] * size)
    with pytest.raises(ReadError, match=r"legs\.bin can't be read"):
        read_rears(path, 3, 1)
