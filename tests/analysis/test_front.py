"""The front of a strip and the impulse of its held end, on arrays made by hand."""

from __future__ import annotations

import numpy as np
import pytest

from beadband.analysis.curvature import bond_stretch
from beadband.analysis.readers import Pull
from beadband.analysis.strip import crossings, front, impulse

TIMES = np.linspace(0.0, 8e-3, 61)


def test_a_moving_ramp_is_followed_between_the_bonds() -> None:
    """A front of speed c and of a width of three bonds: the middle of the ramp lies at c t, wherever the bonds are."""
    spacing, bonds, speed = 1e-3, 200, 21.3
    middles = spacing * (np.arange(bonds) + 0.5)
    way = middles - speed * TIMES[:, None]
    stretch = np.clip(1.25 + 0.25 * way / (1.5 * spacing), 1.0, 1.5)
    path = crossings(stretch, 1.25, spacing)
    assert np.isnan(path[0])
    inside = (TIMES > 1e-3) & (speed * TIMES < 0.19)
    assert path[inside] == pytest.approx(speed * TIMES[inside], abs=1e-12)
    found = front(TIMES, path, bonds * spacing, 3e-3, 7e-3)
    assert found.speed_m_s.value == pytest.approx(speed, rel=1e-12)
    assert found.arrival_s.value == pytest.approx(bonds * spacing / speed, rel=1e-12)


def test_errors_of_the_front_are_those_of_a_scattered_path() -> None:
    """Over many draws of the noise speed and arrival scatter as much as their errors say."""
    draw = np.random.default_rng(1)
    found = [front(TIMES, 25.0 * TIMES + draw.normal(0.0, 1e-4, 61), 0.2, 3e-3, 7e-3) for _ in range(400)]
    for values in ([one.speed_m_s for one in found], [one.arrival_s for one in found]):
        scatter = np.std([one.value for one in values])
        assert np.mean([one.error for one in values]) == pytest.approx(scatter, rel=0.15)


def test_a_front_that_is_not_seen_has_no_speed() -> None:
    with pytest.raises(ValueError, match="a slope needs 4"):
        front(TIMES, np.full(61, np.nan), 0.2, 3e-3, 7e-3)
    assert np.isnan(crossings(np.full((2, 5), 1.5), 1.2, 1e-3)).all()
    assert np.isnan(crossings(np.full((2, 5), 1.0), 1.2, 1e-3)).all()


def test_impulse_is_that_of_velocity_verlet() -> None:
    """Means over intervals and the forces at their ends give the trapezoidal sum over all steps."""
    force = np.sin(0.03 * np.arange(41)) + 2.0
    step, every = 1e-3, 8
    lines = np.arange(0, 41, every)
    means = [force[0], *(force[i - every + 1 : i + 1].mean() for i in lines[1:])]
    pull = Pull(lines, np.array(means), force[lines], np.zeros(len(lines)))
    exact = [-step * (force[: i + 1].sum() - 0.5 * (force[0] + force[i])) for i in lines]
    assert impulse(pull, step) == pytest.approx(exact, rel=1e-13, abs=1e-16)


def test_stretch_of_an_open_chain() -> None:
    points = np.zeros((1, 4, 2))
    points[0, :, 0] = [0.0, 1.0, 3.0, 6.0]
    assert bond_stretch(points, 2.0, closed=False)[0].tolist() == [0.5, 1.0, 1.5]
