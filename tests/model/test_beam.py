"""Closed forms of the paper's beam: each solves its equation, and each correction is the one that does."""

from __future__ import annotations

import math

import numpy as np
import pytest

from beadband.model import beam

PHI, SPREAD = math.radians(11.6), 0.0116
S, T = np.meshgrid(np.linspace(1e-3, 6e-3, 7), np.linspace(1e-3, 3e-3, 5))


def defect(constants: tuple[float, float, float, float]) -> float:
    return beam.equation_defect(lambda s, t: beam.general_angle(s, t, SPREAD, constants), S, T, SPREAD)


@pytest.mark.parametrize("constants", [(100.0, 0.0, 0.0, 0.0), (0.0, 1.0, 0.0, 0.0), (0.0, 0.0, 1.0, 0.0)])
def test_general_solution_solves_the_beam_equation(constants: tuple[float, float, float, float]) -> None:
    assert defect(constants) < 0.02  # the error of the differences; a wrong form leaves order one


def test_a_wrong_form_does_not_solve_it(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(beam, "_hypergeometric", lambda z: np.cos(np.sqrt(-z)))
    assert defect((100.0, 0.0, 0.0, 0.0)) > 0.1


def test_eq4_is_the_general_solution_with_its_constants() -> None:
    special = beam.general_angle(S, T, SPREAD, (0.0, 0.0, 2.0 * PHI - math.pi, math.pi / 2.0))
    assert np.allclose(beam.angle(S, T, PHI, SPREAD), special, rtol=1e-14)


def test_curvature_moment_and_shear_are_derivatives() -> None:
    step, stiffness = 1e-7, 3.5e-7

    def by_length(function: object, *more: float) -> np.ndarray:
        return (function(S + step, T, PHI, SPREAD, *more) - function(S - step, T, PHI, SPREAD, *more)) / (2.0 * step)  # type: ignore[operator]

    scale = float(beam.curvature(0.0, 1e-3, PHI, SPREAD))
    assert np.allclose(beam.curvature(S, T, PHI, SPREAD), -by_length(beam.angle), atol=1e-6 * scale)
    assert np.allclose(
        beam.moment(S, T, PHI, SPREAD, stiffness), -stiffness * by_length(beam.angle), atol=1e-6 * scale * stiffness
    )
    shear = beam.shear(S, T, PHI, SPREAD, stiffness)
    assert np.allclose(shear, -by_length(beam.moment, stiffness), atol=1e-6 * np.abs(shear).max())


def test_complement_peaks_where_the_paper_says_with_the_corrected_slope() -> None:
    peak = math.sqrt(2.0 * math.pi)
    assert beam.complement_slope(peak, PHI) == pytest.approx(0.0, abs=1e-12)
    xi, step = np.linspace(0.1, 6.0, 30), 1e-6
    numeric = (beam.complement(xi + step, PHI) - beam.complement(xi - step, PHI)) / (2.0 * step)
    assert np.allclose(beam.complement_slope(xi, PHI), numeric, atol=1e-8)


def test_a_kink_released_at_rest_has_half_the_curvature_of_eq7() -> None:
    assert beam.at_rest_share() == pytest.approx(
        beam.at_rest_curvature(1.0, PHI, SPREAD) / beam.eq7_curvature(1.0, PHI, SPREAD), abs=1e-3
    )


def test_the_series_says_where_it_ends() -> None:
    with pytest.raises(ValueError, match="series"):
        beam.general_angle(1.0, 1e-6, SPREAD, (1.0, 0.0, 0.0, 0.0))
