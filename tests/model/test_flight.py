"""The flight to the ground: limits in closed form, an independent integration, and the air across a band."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from beadband.analysis.drag import cross_flow_m3_s2
from beadband.model.bands import CATALOGUE
from beadband.model.flight import CIRCLE, GRAVITY_M_S2, ROUND, drag_areas_m2, fly, path_m
from beadband.model.scene import scene_of


@pytest.mark.parametrize("degrees", [5.0, 30.0, 45.0, 80.0])
def test_without_air(degrees: float) -> None:
    """V^2 sin(2 theta)/g from the ground; the parabola from a height."""
    theta, speed = math.radians(degrees), 7.0
    flight = fly(speed, theta)
    assert flight.range_m == pytest.approx(speed**2 * math.sin(2.0 * theta) / GRAVITY_M_S2, rel=1e-10)
    assert flight.landing_speed_m_s == pytest.approx(speed, rel=1e-10)
    assert flight.top_m == pytest.approx((speed * math.sin(theta)) ** 2 / (2.0 * GRAVITY_M_S2), rel=1e-10)
    up = speed * math.sin(theta)
    time = (up + math.sqrt(up**2 + 2.0 * GRAVITY_M_S2 * 1.5)) / GRAVITY_M_S2
    high = fly(speed, theta, 1.5)
    assert high.time_s == pytest.approx(time, rel=1e-10)
    assert high.range_m == pytest.approx(speed * math.cos(theta) * time, rel=1e-10)


def test_little_air_is_the_limit() -> None:
    """The range falls from that without air by a share in proportion to 1/L."""
    bare = fly(7.0, 0.7).range_m
    lost = [1.0 - fly(7.0, 0.7, drag_length_m=length).range_m / bare for length in (1e4, 1e5, 1e6)]
    for more, less in pairwise(lost):
        assert more / less == pytest.approx(10.0, rel=2e-3)


def test_limits_of_much_air() -> None:
    length = 4.0
    terminal = math.sqrt(GRAVITY_M_S2 * length)
    assert fly(12.0, 0.5, 100.0, length).landing_speed_m_s == pytest.approx(terminal, rel=1e-6)
    # Straight up: (L/2) ln(1 + V^2/(g L)).
    exact = 0.5 * length * math.log(1.0 + 12.0**2 / terminal**2)
    assert fly(12.0, math.radians(89.99), 0.0, length).top_m == pytest.approx(exact, rel=1e-6)
    # A fast level shot from a small height: x = L ln(1 + V t/L).
    shot = fly(300.0, 0.0, 1e-4, length)
    assert shot.range_m == pytest.approx(length * math.log(1.0 + 300.0 * shot.time_s / length), rel=1e-4)


@pytest.mark.parametrize(("degrees", "height", "length"), [(10.0, 0.0, 1.5), (45.0, 1.3, 4.0), (-20.0, 2.0, 6.0)])
def test_another_method(degrees: float, height: float, length: float) -> None:
    """The same path by integrating Newton's law in time."""
    theta, speed = math.radians(degrees), 12.0

    def rates(_: float, state: np.ndarray) -> list[float]:
        vx, vy = state[2:]
        drag = math.hypot(vx, vy) / length
        return [vx, vy, -drag * vx, -drag * vy - GRAVITY_M_S2]

    def ground(_: float, state: np.ndarray) -> float:
        return float(state[1] + height)

    ground.terminal, ground.direction = True, -1.0  # type: ignore[attr-defined]
    start = [0.0, 0.0 if height else 1e-300, speed * math.cos(theta), speed * math.sin(theta)]
    path = solve_ivp(rates, (0.0, 20.0), start, method="DOP853", rtol=1e-11, atol=1e-12, events=ground)
    flight = fly(speed, theta, height, length)
    end = path.y_events[0][-1]
    assert flight.time_s == pytest.approx(path.t_events[0][-1], rel=1e-8)
    assert flight.range_m == pytest.approx(end[0], rel=1e-8)
    assert flight.landing_speed_m_s == pytest.approx(math.hypot(end[2], end[3]), rel=1e-8)


def test_paths_end_where_flights_do() -> None:
    """And they obey Newton's law: dp/dx = -g/w^2, with w from the drag along the path."""
    path = path_m(12.0, 0.6, 1.0, 4.0, points=401)
    flight = fly(12.0, 0.6, 1.0, 4.0)
    assert path[-1] == pytest.approx([flight.range_m, 0.0], abs=1e-9)
    assert path[:, 1].max() == pytest.approx(flight.top_m, rel=1e-4)
    step = np.linalg.norm(np.diff(path, axis=0), axis=1)
    slope = np.diff(path[:, 1]) / np.diff(path[:, 0])
    middle = 0.5 * (path[1:, 0] + path[:-1, 0])
    w = 12.0 * math.cos(0.6) * np.exp(-(np.cumsum(step) - 0.5 * step) / 4.0)  # dw/ds = -w/L
    between = 0.5 * (w[1:] + w[:-1])
    assert np.diff(slope) / np.diff(middle) == pytest.approx(-GRAVITY_M_S2 / between**2, rel=2e-3)


def test_air_across_a_moving_chain() -> None:
    """A circle has 4/(3 pi) of its circumference across its flight; nothing drags what spins or moves along itself."""
    angle = np.linspace(0.0, 2.0 * math.pi, 2001)[:-1]
    ring = 0.03 * np.stack([np.cos(angle), np.sin(angle)], axis=1)
    times = np.array([0.0, 1e-5])
    flow = cross_flow_m3_s2(times, np.stack([ring, ring + np.array([12.0 * 1e-5, 0.0])]))[0]
    around = 2.0 * math.pi * 0.03
    assert flow[0] == pytest.approx(CIRCLE * around * 12.0**2, rel=1e-5)
    assert abs(flow[1]) < 1e-12 * flow[0]
    turn = np.array([[math.cos(1e-3), math.sin(1e-3)], [-math.sin(1e-3), math.cos(1e-3)]])
    assert np.abs(cross_flow_m3_s2(times, np.stack([ring, ring @ turn]))).max() < 1e-6 * (1e2 * 0.03) ** 2
    flat = np.concatenate([np.linspace(0.0, 1.0, 200), np.linspace(1.0, 0.0, 200)[1:-1]])
    strip = np.stack([flat, np.zeros_like(flat)], axis=1)
    assert np.abs(cross_flow_m3_s2(times, np.stack([strip, strip + np.array([1e-4, 0.0])]))).max() == 0.0
    across = cross_flow_m3_s2(times, np.stack([strip, strip + np.array([0.0, 1e-4])]))[0, 1]
    assert across == pytest.approx(2.0 * 10.0**2, rel=1e-9)


def test_the_mean_over_all_attitudes() -> None:
    """Flat sides: the mean cube of a cosine, 1/4; round ones: that of a sine, 3 pi/16."""
    cosine = (np.arange(20000) + 0.5) / 20000
    flat, rounded = drag_areas_m2(CATALOGUE["II"], 1.0), drag_areas_m2(CATALOGUE["circular"], 1.0)
    band, ring = CATALOGUE["II"], CATALOGUE["circular"]
    sides = (band.width_m or 0.0) + band.thickness_m
    assert flat.tumbling / band.circumference_m == pytest.approx(np.mean(cosine**3) * sides, rel=1e-6)
    mean = np.mean((1.0 - cosine**2) ** 1.5) * ring.thickness_m
    assert rounded.tumbling / ring.circumference_m == pytest.approx(mean, rel=1e-6)
    assert drag_areas_m2(ring).tumbling == pytest.approx(ROUND * rounded.tumbling)


def test_scenes_of_a_flight() -> None:
    scene = scene_of({"until": "launch", "elevation_deg": 30.0, "height_m": 1.2})
    assert scene_of(scene.as_dict()).height_m == 1.2
    for given, words in (
        ({"elevation_deg": 3.0}, "--elevation is not used with until release"),
        ({"until": "launch", "height_m": 1.0}, "--height is not used without --elevation"),
        ({"until": "launch", "elevation_deg": -5.0}, "thrown at the ground"),
        ({"until": "launch", "elevation_deg": "20 +/- 2"}, "--elevation takes no uncertainty"),
        ({"until": "launch", "elevation_deg": 90.0}, "elevation_deg is out of range"),
    ):
        with pytest.raises(ValueError, match=words):
            scene_of(given)
