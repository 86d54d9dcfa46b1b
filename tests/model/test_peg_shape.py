"""A tip on a peg: the exact held shape against quadrature, its limits, and the scenes that are refused."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.optimize import brentq

from beadband.cli import main
from beadband.errors import UsageError
from beadband.model import correction
from beadband.model.formula import formula
from beadband.model.peg import own_radius_m, peg_of
from beadband.model.scene import Scene, scene_of
from beadband.model.validity import validity_notices
from beadband.planning.plan import plan_of


def shape_of(scene: Scene, radius: float) -> tuple[float, float, float, float]:
    """Own radius, lift-off angle, stretch and wrapped length from the law's stress alone, by quadrature of its work."""
    law, area, stiffness = scene.material, scene.band.area_m2, scene.bending_stiffness_n_m2
    tension = area * float(law.stress(1.0 + scene.strain))

    def stretch(force: float) -> float:
        return float(brentq(lambda s: area * float(law.stress(s)) - force, 0.99, 1.001 + scene.strain, xtol=1e-15))

    def turning(alpha: float) -> float:
        work = quad(lambda x: stretch(tension * math.cos(x)) * math.sin(x), 0.0, alpha, epsabs=0.0, epsrel=1e-13)[0]
        return math.sqrt(2.0 * tension * work / stiffness)

    def excess(alpha: float) -> float:
        return turning(alpha) * radius - stretch(tension * math.cos(alpha))

    opening = math.pi / 2.0 - scene.half_angle_rad
    tip = stretch(tension * math.cos(opening))
    lift_off = brentq(excess, 1e-6, opening, xtol=1e-15)
    there = stretch(tension * math.cos(lift_off))
    return tip / turning(opening), lift_off, there, radius * (opening - lift_off) / there


@pytest.mark.parametrize("law", ["linear", "mooney-rivlin"])
@pytest.mark.parametrize(("band", "radius"), [("I", 4e-3), ("III", 1.5e-3)])
def test_held_shape_is_that_of_the_elastica(band: str, law: str, radius: float) -> None:
    scene = scene_of({"band": band, "law": law, "tip_radius_m": radius})
    peg = scene.peg
    assert peg is not None
    found = (own_radius_m(scene.strand(1), scene.strain, scene.half_angle_rad), peg.lift_off_rad, peg.stretch)
    assert (*found, peg.wrapped_m) == pytest.approx(shape_of(scene, radius), rel=1e-9)


def test_a_small_peg_touches_the_tip_alone() -> None:
    scene = scene_of({})
    strand, strain, phi = scene.strand(1), scene.strain, scene.half_angle_rad
    own = own_radius_m(strand, strain, phi)
    assert 0.3e-3 < own < 0.7e-3
    assert peg_of(strand, strain, phi, 0.999 * own) is None
    # Just above it hardly anything lies on the peg, and the curvature is that of the point-held tip.
    peg = peg_of(strand, strain, phi, own * (1.0 + 1e-6))
    assert peg is not None
    assert peg.wrapped_m < 1e-5 * own
    assert peg.lift_off_rad == pytest.approx(math.pi / 2.0 - phi, rel=1e-5)
    assert own_radius_m(scene_of({"bending_scale": 0.0}).strand(1), strain, phi) == 0.0


@pytest.mark.parametrize("scale", [1e-12, 1e-8, 1e-4])
def test_a_thin_band_lies_on_the_whole_of_its_peg(scale: float) -> None:
    """Of vanishing bending: lift-off at alpha = sqrt(EI stretch/T)/r, and r times the opening on the peg."""
    scene = scene_of({"bending_scale": scale, "tip_radius_m": 3e-3})
    peg, opening = scene.peg, math.pi / 2.0 - scene.half_angle_rad
    assert peg is not None
    lift_off = scene.scales.bending_layer_m * (1.0 + scene.strain) / 3e-3
    assert peg.lift_off_rad == pytest.approx(lift_off, rel=1e-3 if scale > 1e-6 else 1e-6)
    assert peg.wrapped_m == pytest.approx(3e-3 * (opening - lift_off) / 1.476, rel=1e-4)


def test_what_hangs_on_the_held_shape_follows_it() -> None:
    point, peg = scene_of({}), scene_of({"tip_radius_m": 5e-3})
    assert peg.peg is not None
    assert peg.scales.tip_sharpness == pytest.approx(peg.peg.stretch / 5e-3 * 1e-3)
    assert peg.scales.window.start_s > 10.0 * point.scales.window.start_s
    assert peg.scales.front_arrival_s == point.scales.front_arrival_s
    legs = [plan_of(scene.with_beads(400), "leg") for scene in (point, peg)]
    more = (legs[1].leg_bonds - legs[0].leg_bonds) * legs[0].strand.spacing_m
    assert more == pytest.approx(peg.peg.wrapped_m, abs=legs[0].strand.spacing_m)
    codes = [{one.code for one in validity_notices(scene)} for scene in (point, peg)]
    assert codes == [{"sharp-tip"}, {"large-peg"}]
    reasons = [
        {one.code for one in plan_of(scene_of({"tip_radius_m": radius})).reasons} & {"on-peg", "peg-at-tip"}
        for radius in (0.0, 5e-4, 5e-3)
    ]
    assert reasons == [set(), {"peg-at-tip"}, {"on-peg"}]


def test_the_map_knows_no_peg() -> None:
    for radius, known in ((0.0, True), (5e-4, True), (1e-3, False)):
        scene = scene_of({"tip_radius_m": radius})
        assert correction.applies(scene) is known
        assert bool(np.isfinite(formula(scene, "speed").error)) is known


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        ("run --tip-radius 5e-3 --until launch", "--until release"),
        ("run --tip-radius 5e-3 --bending-scale 0", "without bending"),
        ("ask --tip-radius 0.03", "too much of the leg"),
        ("ask --tip-radius -1e-3", "0 m or more"),
        ("pareto --tip-radius 1e-3", "not used by 'beadband pareto'"),
        ("run --tip-radius 0+/-1e-4", "no radius to be uncertain"),
    ],
)
def test_what_can_not_be_answered_is_refused_in_one_line(
    flags: str, said: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(flags.split()) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line


def test_the_radius_is_checked_where_it_is_given() -> None:
    with pytest.raises(UsageError, match="tip_radius_m"):
        scene_of({"tip_radius_m": math.nan})
    assert "tip_radius_m" not in scene_of({}).as_dict()
