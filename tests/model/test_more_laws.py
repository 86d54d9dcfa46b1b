"""The rubber laws: their closed forms, their ranges, how they unload, and beads that do as the string limit says."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from beadband.errors import UsageError
from beadband.lammps.bond_table import LEG_TABLE_POINTS, TABLE_POINTS, bond_table, table_points
from beadband.model import laws
from beadband.model.laws import Gent, Law, MooneyRivlin, NeoHookean, Ogden, Yeoh, law_of
from beadband.model.scene import scene_of
from beadband.model.scenefile import flat_scene, scene_text
from beadband.model.wedge import string_limit
from beadband.parameters import TABLE, parsed
from beadband.planning.plan import plan_of
from beadband.runs.rear_run import follow_rear

LOCKING = Gent(4e5, 30.0)
SOFT_THEN_STIFF = Yeoh(2e5, -2e4, 2e3)
TWO_TERMS = Ogden((6.3e5, 1.2e3), (1.3, 5.0))
ALL: dict[str, Law] = {
    "neo-hookean": NeoHookean(4e5),
    "yeoh": SOFT_THEN_STIFF,
    "gent": LOCKING,
    "ogden": TWO_TERMS,
    "ogden-treloar": Ogden((6.3e5, 1.2e3, -1e4), (1.3, 5.0, -2.0)),
}
EVERY = pytest.mark.parametrize("law", ALL.values(), ids=ALL)


@EVERY
def test_stress_and_tangent_are_derivatives_of_the_energy(law: Law) -> None:
    stretch = np.linspace(0.4, 4.5, 83)
    ahead = stretch + 1e-30j
    for function, derivative in ((law.energy, law.stress), (law.stress, law.tangent)):
        assert np.allclose(np.imag(function(ahead)) / 1e-30, derivative(stretch), rtol=1e-12, atol=1e-6)
    assert law.energy(1.0) == law.stress(1.0) == 0.0


@EVERY
@pytest.mark.parametrize("strain", [1e-7, -1e-7])
def test_small_strains_keep_their_digits(law: Law, strain: float) -> None:
    exact = (1.0 + strain) - 1.0
    # The next terms of the series are of the order of the strain.
    assert law.energy(1.0 + strain) == pytest.approx(0.5 * law.rest_modulus_pa * exact**2, rel=1e-6, abs=0.0)
    assert law.stress(1.0 + strain) == pytest.approx(law.rest_modulus_pa * exact, rel=1e-6, abs=0.0)


@EVERY
def test_the_expression_for_lammps_is_the_energy(law: Law) -> None:
    formula = law.lammps_expression().replace("^", "**")
    for stretch in (0.6, 1.3, 4.2):
        assert eval(formula, {"s": stretch, "log": math.log}) == pytest.approx(law.energy(stretch), rel=1e-12)


def test_laws_agree_where_they_are_the_same() -> None:
    stretch = np.linspace(0.5, 3.0, 26)
    rubber = NeoHookean(4e5).stress(stretch)
    for same in (Yeoh(2e5, 0.0, 0.0), MooneyRivlin(2e5, 0.0), Ogden((4e5,), (2.0,)), Gent(4e5, 1e15)):
        assert np.allclose(same.stress(stretch), rubber, rtol=1e-12, atol=1e-6)
    both = Ogden((2 * 1.9e5, -2 * 1.2e5), (2.0, -2.0)).stress(stretch)
    assert np.allclose(both, MooneyRivlin(1.9e5, 1.2e5).stress(stretch), rtol=1e-12, atol=1e-6)


def test_constants_may_be_lists_in_flags_and_files() -> None:
    values = {"law": "ogden", "mu_pa": parsed("mu_pa", "6.3e5,1.2e3"), "alpha": parsed("alpha", "1.3,5")}
    scene = scene_of(values)
    assert scene.material == TWO_TERMS
    assert hash(scene.material) == hash(TWO_TERMS)
    assert scene_of({"law": "ogden", "mu_pa": 4e5, "alpha": 2.0}).material == Ogden((4e5,), (2.0,))
    file = {"law": {"name": "ogden", "mu_pa": [6.3e5, 1.2e3], "alpha": [1.3, 5.0]}}
    assert scene_of(flat_scene(file, "a file")).material == TWO_TERMS
    assert "mu_pa = [630000.0, 1200.0]" in scene_text(scene)
    assert scene.label == "III, ogden, mu 0.63,0.0012 MPa, alpha 1.3,5"


def test_laws_share_a_flag_and_keep_their_own_ranges() -> None:
    assert set(TABLE["mu_pa"].laws) == {"gent", "neo-hookean", "ogden"}
    assert TABLE["mu_pa"].help == "shear modulus at rest; of ogden, one modulus for each exponent"
    assert law_of("ogden", {"mu_pa": (4e5, -1e4), "alpha": (2.0, -2.0)}).rest_modulus_pa == pytest.approx(1.23e6)
    refused = {
        "mu_pa takes one number under the law gent": {"law": "gent", "mu_pa": [4e5, 1e4], "jm": 30.0},
        "mu_pa is out of range": {"law": "neo-hookean", "mu_pa": -4e5},
        "as many moduli as exponents": {"law": "ogden", "mu_pa": [4e5, 1e4], "alpha": [2.0]},
        "exponent of the law ogden is 0": {"law": "ogden", "mu_pa": 4e5, "alpha": 0.0},
        "takes one number or more": {"law": "ogden", "mu_pa": [], "alpha": []},
        "yeoh lacks a constant": {"law": "yeoh", "c1_pa": 2e5},
        "no stiffness at rest": {"law": "ogden", "mu_pa": [4e5, -5e5], "alpha": [2.0, 2.0]},
    }
    for words, values in refused.items():
        with pytest.raises(UsageError, match=words):
            scene_of(values)


def test_gent_locks_where_its_invariant_reaches_jm() -> None:
    for law in (LOCKING, Gent(4e5, 0.01), Gent(4e5, 1e5)):
        for stretch in (law.longest_stretch(), law.shortest_stretch()):
            assert stretch**2 + 2.0 / stretch - 3.0 == pytest.approx(law.jm, rel=1e-9)
        assert law.shortest_stretch() < 1.0 < law.longest_stretch()
        assert law.peak_stretch() is None
    scene = {"law": "gent", "mu_pa": 4e5, "jm": 30.0, "half_angle_deg": 5.0}
    assert scene_of({**scene, "strain": 4.714}).strain == 4.714
    with pytest.raises(UsageError, match=r"its law locks at a stretch of 5\.71402.*below 4\.71402"):
        scene_of({**scene, "strain": 4.7141})


@dataclass(frozen=True)
class Dip(Yeoh):
    """A tension that falls over less than a step of the scan."""

    name = "dip"

    def tangent(self, stretch: float) -> float:
        return (stretch - 1.505) ** 2 - 1e-6


def test_a_band_is_held_below_the_first_peak_only() -> None:
    law = Yeoh(2e5, -5e4, 6e3)
    peak = law.peak_stretch()
    assert peak == pytest.approx(1.5807, abs=1e-4)
    assert law.tangent(peak) == pytest.approx(0.0, abs=1e-6)
    # It rises again, beyond what it carried at the peak.
    assert law.stress(2.6) > 1.5 * law.stress(peak)
    assert law.tangent(2.6) > 0.0
    values = {"law": "yeoh", "c1_pa": 2e5, "c2_pa": -5e4, "c3_pa": 6e3}
    assert scene_of({**values, "strain": 0.55}).strain == 0.55
    with pytest.raises(UsageError, match=r"tension peaks at a stretch of 1\.581.*below 0\.5807"):
        scene_of({**values, "strain": 1.6})
    assert Dip(1.0, 0.0, 0.0).peak_stretch() == pytest.approx(1.504, abs=1e-9)
    assert SOFT_THEN_STIFF.peak_stretch() is None


@pytest.mark.parametrize("points", [LEG_TABLE_POINTS, TABLE_POINTS])
@pytest.mark.parametrize(("law", "strain"), [*((law, 0.8) for law in ALL.values()), (LOCKING, 4.6), (TWO_TERMS, 3.0)])
def test_the_bond_table_is_accurate_and_stops_short_of_locking(law: Law, strain: float, points: int) -> None:
    strand = scene_of({"strain": 0.1, "half_angle_deg": 5.0}).strand(100)
    strand = type(strand)(**{**vars(strand), "law": law})
    points = table_points(law, strain, points)
    text = bond_table(strand, strain, points)
    rows = np.array([line.split() for line in text.split("\n\n")[2].splitlines()], dtype=float)
    slopes = [float(word) for word in text.split("FP ")[1].split()[:2]]
    assert len(rows) == points
    assert np.isfinite(rows).all()
    if (longest := law.longest_stretch()) is not None:
        assert 1.0 + strain < rows[-1, 1] / strand.spacing_m < longest
    # LAMMPS draws the same cubic spline with these slopes at its ends.
    spline = CubicSpline(rows[:, 1], rows[:, 3], bc_type=((1, slopes[0]), (1, slopes[1])))
    top = min(1.0 + 1.2 * strain, rows[-1, 1] / strand.spacing_m)
    stretch = np.random.default_rng(1).uniform(0.6, top, 4000)
    force = -strand.area_m2 * law.stress(stretch)
    least = strand.area_m2 * law.rest_modulus_pa * 0.01
    error = np.abs(spline(stretch * strand.spacing_m) - force) / np.maximum(np.abs(force), least)
    assert error.max() < 1.05e-6


def test_tables_of_the_first_laws_keep_their_points() -> None:
    for strain in (0.1, 1.4, 5.0):
        assert table_points(MooneyRivlin(1.9e5, 1.2e5), strain, LEG_TABLE_POINTS) == LEG_TABLE_POINTS


def many_small_jumps(law: Law, ahead: float, behind: float, pieces: int = 3000) -> tuple[float, float]:
    """Particle speed, and power of the loss, of the jumps between points of the curve that are all admissible.

    From each point to the one that the least slope leads to: density 1. The law between the points is taken as linear.
    """
    x = np.linspace(behind, ahead, pieces + 1)
    y, w = law.stress(x), law.energy(x)
    at, speed, power = 0, 0.0, 0.0
    while at < pieces:
        slopes = (y[at + 1 :] - y[at]) / (x[at + 1 :] - x[at])
        to = at + 1 + int(np.argmin(slopes))
        jump, rate = x[to] - x[at], math.sqrt(slopes[to - at - 1])
        speed += rate * jump
        power += rate * (w[to] - w[at] - 0.5 * (y[to] + y[at]) * jump)
        at = to
    return speed, power


KINDS = [
    (Gent(4e5, 30.0), 1.476, "shock", 1),
    (Gent(4e5, 30.0), 3.0, "shock and fan", 2),
    (Gent(4e5, 30.0), 5.6, "shock and fan", 2),
    (Gent(4e5, 3.0), 2.0, "shock and fan", 2),
    (SOFT_THEN_STIFF, 2.0, "shock", 1),
    (SOFT_THEN_STIFF, 3.0, "shock and fan", 2),
    (TWO_TERMS, 1.8, "shock", 1),
    (TWO_TERMS, 4.0, "shock and fan", 2),
    (NeoHookean(4e5), 1.8, "shock", 1),
    (laws.Linear(1e6), 1.8, "sharp front", 1),
]


@pytest.mark.parametrize(("law", "held", "kind", "parts"), KINDS)
def test_the_wave_is_the_limit_of_many_admissible_jumps(law: Law, held: float, kind: str, parts: int) -> None:
    wave = law.unloading_wave(held, 1.02, 1.0)
    assert (wave.kind, len(wave.parts)) == (kind, parts)
    speed, power = many_small_jumps(law, held, 1.02)
    assert wave.particle_speed_m_s == pytest.approx(speed, rel=1e-6)
    found = sum(part.loss_j_m3 * part.front_speed_m_s for part in wave.parts)
    stored = law.energy(held) - law.energy(1.02)
    assert found == pytest.approx(power, rel=2e-4, abs=1e-5 * stored * wave.front_speed_m_s)
    ends = [held, *(part.behind for part in wave.parts)]
    assert ends == [*(part.ahead for part in wave.parts), 1.02]
    speeds = [speed for part in wave.parts for speed in (part.front_speed_m_s, part.tail_speed_m_s)]
    # The shock moves at the speed of the fan's tail, and takes nothing from it.
    assert speeds == pytest.approx(sorted(speeds, reverse=True), rel=1e-12)
    assert wave.front_speed_m_s == speeds[0]
    for part in wave.parts:
        assert part.loss_j_m3 > 0.0 if part.kind == "shock" else part.loss_j_m3 == 0.0


def test_a_fan_has_the_speed_of_sound_at_its_ends_and_touches_its_shock() -> None:
    density = 950.0
    wave = LOCKING.unloading_wave(4.0, 1.02, density)
    fan, shock = wave.parts
    assert fan.front_speed_m_s == pytest.approx(math.sqrt(LOCKING.tangent(4.0) / density), rel=1e-12)
    chord = (LOCKING.stress(shock.ahead) - LOCKING.stress(1.02)) / (shock.ahead - 1.02)
    assert LOCKING.tangent(shock.ahead) == pytest.approx(chord, rel=1e-9)
    assert shock.front_speed_m_s == pytest.approx(math.sqrt(chord / density), rel=1e-12)
    assert 0.0 < wave.mean_speed_ratio < 1.0
    assert wave.loss_j_m3 == shock.loss_j_m3


@settings(max_examples=40, deadline=None, derandomize=True)
@given(
    softening=st.floats(-0.3, 0.1),
    stiffening=st.floats(0.0, 0.05),
    held=st.floats(1.05, 4.0),
    behind=st.floats(0.0, 0.9),
)
def test_any_yeoh_law_unloads_admissibly(softening: float, stiffening: float, held: float, behind: float) -> None:
    law = Yeoh(1.0, softening, stiffening)
    peak = law.peak_stretch()
    held = min(held, 0.999 * peak) if peak is not None else held
    low = 1.0 + behind * (held - 1.0)
    wave = law.unloading_wave(held, low, 1.0)
    speed, power = many_small_jumps(law, held, low, 1000)
    assert wave.particle_speed_m_s == pytest.approx(speed, rel=1e-5)
    stored = law.energy(held) - law.energy(low)
    found = sum(part.loss_j_m3 * part.front_speed_m_s for part in wave.parts)
    assert found == pytest.approx(power, rel=1e-3, abs=1e-4 * stored * wave.front_speed_m_s)
    assert all(part.loss_j_m3 >= 0.0 for part in wave.parts)


@EVERY
def test_the_rebound_scales_as_the_moduli_over_the_density(law: Law) -> None:
    """All times scale with sqrt(density/modulus): exactly, for every law."""
    speed = string_limit(law, 1000.0, 1.5, 0.2).rear_speed_m_s
    assert string_limit(law, 1020.0, 1.5, 0.2).rear_speed_m_s == pytest.approx(speed * 1.02**-0.5, rel=1e-10)
    stiffer = {
        key: value
        if TABLE[key].unit != "Pa"
        else tuple(1.02 * each for each in value)
        if isinstance(value, tuple)
        else 1.02 * value
        for key, value in law.values().items()
    }
    found = string_limit(type(law)(**stiffer), 1000.0, 1.5, 0.2)
    assert found.rear_speed_m_s == pytest.approx(speed * 1.02**0.5, rel=1e-10)


RELEASES = [
    ({"law": "neo-hookean", "mu_pa": 4e5, "strain": 0.8}, "shock", 300),
    ({"law": "yeoh", "c1_pa": 2e5, "c2_pa": -1e3, "c3_pa": 50.0, "strain": 2.5}, "shock", 300),
    ({"law": "yeoh", "c1_pa": 2e5, "c2_pa": -2e4, "c3_pa": 2e3, "strain": 2.0}, "shock and fan", 300),
    ({"law": "gent", "mu_pa": 4e5, "jm": 30.0, "strain": 0.476}, "shock", 400),
    ({"law": "gent", "mu_pa": 4e5, "jm": 30.0, "strain": 2.0}, "shock and fan", 300),
    ({"law": "gent", "mu_pa": 4e5, "jm": 30.0, "strain": 4.0, "half_angle_deg": 8.0}, "shock and fan", 600),
    ({"law": "ogden", "mu_pa": [6.3e5, 1.2e3], "alpha": [1.3, 5.0], "strain": 0.8}, "shock", 300),
    ({"law": "ogden", "mu_pa": [6.3e5, 1.2e3], "alpha": [1.3, 5.0], "strain": 3.0}, "shock and fan", 300),
]


@pytest.mark.parametrize(("values", "kind", "beads"), RELEASES)
def test_beads_without_bending_rebound_as_the_string_limit(values: dict[str, object], kind: str, beads: int) -> None:
    rest = {"half_angle_deg": 10.0, "bending_scale": 1e-4, "for": "speed", "beads": beads}
    plan = plan_of(scene_of(rest | values), "leg")
    assert plan.string.wave.kind == kind
    found = follow_rear(plan).fitted_speed_m_s.value
    assert found == pytest.approx(plan.string.rear_speed_m_s, rel=3e-3)
    # The error is below the one that the plan predicts.
    assert abs(found / plan.string.rear_speed_m_s - 1.0) < plan.speed_error


def test_the_cut_leg_gives_the_speed_of_the_whole_one() -> None:
    """Behind a fan the way back takes longer than behind a shock: nothing of the cut arrives before the end."""
    values = {"law": "gent", "mu_pa": 4e5, "jm": 30.0, "strain": 4.0, "half_angle_deg": 8.0, "for": "speed"}
    plan = plan_of(scene_of({**values, "beads": 300}), "leg")
    longer = type(plan)(**{**vars(plan), "leg_bonds": 2 * plan.leg_bonds})
    found, whole = (follow_rear(one).fitted_speed_m_s.value for one in (plan, longer))
    assert found == pytest.approx(whole, rel=1e-4)


def test_the_waves_of_the_documents_are_those_of_the_laws() -> None:
    page = (Path(__file__).parents[2] / "docs" / "laws.md").read_text(encoding="utf-8")
    rows = [
        row.split(" | ") for row in page.splitlines() if " | shock" in row and row.startswith("| ") and " to " in row
    ]
    found = {(row[2], row[3].strip(), row[4].strip(), row[5].strip(" |")) for row in rows}
    expected = set()
    for values, _, _ in RELEASES:
        if values.get("c2_pa") == -1e3:
            continue  # not in the table
        scene = scene_of({**values, "half_angle_deg": 10.0})
        spans = {part.kind: f"{part.ahead:.3f} to {part.behind:.3f}" for part in scene.string.wave.parts}
        speed = f"{scene.string.rear_speed_m_s:.2f}"
        expected.add((scene.string.wave.kind, spans.get("fan", ""), spans["shock"], speed))
    assert expected <= found
