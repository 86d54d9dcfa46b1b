"""Releases from a peg: the second method, bars, answers, errors of inputs, and a run's folder."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from beadband.analysis.fits import path_slope
from beadband.lammps.engine import Session
from beadband.model.scene import Scene, scene_of
from beadband.model.scenefile import read_scene
from beadband.planning.plan import plan_of
from beadband.runs import dispatch, release
from beadband.runs.ask import ask
from beadband.runs.ask_many import ask_many
from beadband.runs.input_errors import _derivatives, budget_of
from beadband.runs.rear_run import follow_rear, rear_run
from beadband.studies.find import find
from beadband.studies.pareto.peers.elements import Rod, graded_nodes
from beadband.studies.pareto.peers.elements import release as release_elements

LOSS_TIME_S = 2e-5


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    with Session() as opened:
        yield opened


def speed_of(scene: Scene, session: Session) -> float:
    return follow_rear(plan_of(scene, "leg"), session).fitted_speed_m_s.value


@pytest.mark.parametrize(
    ("band", "law", "radius"), [("II", "mooney-rivlin", 2e-3), ("II", "linear", 5e-3), ("III", "mooney-rivlin", 8e-3)]
)
def test_speed_is_that_of_the_second_method(band: str, law: str, radius: float, session: Session) -> None:
    """From its own held shape, with a loss that both resolve."""
    scene = scene_of({"band": band, "law": law, "tip_radius_m": radius, "beads": 600, "loss_time_s": LOSS_TIME_S})
    strand, arrival = scene.strand(600), scene.scales.front_arrival_s
    viscosity = scene.band.modulus_pa * LOSS_TIME_S
    rod = Rod(
        strand.law.stress,
        strand.law.tangent,
        strand.area_m2,
        strand.density_kg_m3,
        strand.bending_stiffness_n_m2,
        viscosity,
    )
    nodes = graded_nodes(scene.wedge.reference_leg_m, 60, 4.0)
    times, path, _ = release_elements(rod, 1.0 + scene.strain, scene.half_angle_rad, nodes, 0.9 * arrival, 300, radius)
    other = path_slope(times, path, 0.4 * arrival, 0.85 * arrival)
    assert speed_of(scene, session) == pytest.approx(other, rel=4e-4)


@pytest.mark.parametrize("radius", [1e-3, 3e-3, 8e-3])
def test_bars_hold_at_every_number_of_beads(radius: float, session: Session) -> None:
    levels = (120, 240, 480, 960)
    scene = scene_of({"tip_radius_m": radius, "for": "speed"})
    runs = [rear_run(plan_of(scene.with_beads(beads), "leg"), session).speed for beads in levels]
    best = runs[-1].value + (runs[-1].value - runs[-2].value)  # of the first order at least
    assert all(abs(one.value - best) < one.error for one in runs)
    assert runs[-1].error < 2e-3 * best


def test_an_answer_takes_runs_and_keeps_its_word(session: Session) -> None:
    values = {"tip_radius_m": 4e-3, "tolerance": 3e-3}
    found = ask(scene_of(values), session=session)
    assert found.model == "leg"
    assert found.runs > 0
    assert "large-peg" in {one.code for one in found.notices}
    fine = speed_of(scene_of({"tip_radius_m": 4e-3, "beads": 1600, "for": "speed"}), session)
    assert abs(found.value - fine) < found.error < 3e-3 * fine
    many = ask_many({"tip_radius_m": np.array([0.0, 4e-4, 4e-3]), "tolerance": 3e-3}, session=session)
    assert many.value[0] == many.value[1]
    assert many.value[2] == pytest.approx(found.value, rel=1e-12)
    assert many.model[2] == "leg"


def test_a_strain_is_found_for_a_peg(session: Session) -> None:
    found = find({"tip_radius_m": 4e-3, "band": "II"}, "strain", 12.0, session)
    again = speed_of(
        scene_of({"tip_radius_m": 4e-3, "band": "II", "strain": found.value, "beads": 800, "for": "speed"}), session
    )
    assert again == pytest.approx(12.0, abs=found.answer.error + 0.1 * found.answer.error)


def test_the_radius_is_one_more_length(session: Session) -> None:
    """d ln V/d ln of thickness, circumference and radius: those of ratios, and what legs give for each."""
    values = {"tip_radius_m": 4e-3, "for": "speed"}
    uncertain = {"tip_radius_m": "4e-3 +/- 2%", "circumference_m": "0.204 +/- 2%", "thickness_m": "2e-3 +/- 2%"}
    found = budget_of(scene_of({**values, **uncertain}), 17.5, session)
    assert found is not None
    slopes = dict(zip(found.inputs.names, found.sensitivities.tolist(), strict=True))
    assert sum(slopes.values()) == pytest.approx(0.0, abs=1e-12)
    base = plan_of(scene_of({**values, "tolerance": 0.002}), "leg")
    for name in uncertain:
        direct = _derivatives(base, {name: 0.05}, session)[name].speed
        assert slopes[name] == pytest.approx(direct, abs=0.012)
    assert abs(slopes["thickness_m"]) > 0.03


def test_a_run_keeps_its_peg(tmp_path: Path) -> None:
    done = release.run(
        scene_of({"tip_radius_m": 5e-3, "beads": 400, "for": "speed", "tolerance": 0.02}), tmp_path / "one"
    )
    assert not done.failed_checks
    values = done.as_dict()
    assert values["scene"]["tip_radius_m"] == 5e-3
    assert values["late_speed_m_s"] > 1.01 * values["rebound_speed_m_s"]
    assert values["warning_codes"] == ["large-peg"]
    again = dispatch.analyze(tmp_path / "one")
    assert again.speed.value == pytest.approx(done.speed.value, rel=1e-6)
    assert np.array_equal(again.held.positions_m, done.held.positions_m)
    other = release.run(scene_of(read_scene(tmp_path / "one" / "scene.toml")), tmp_path / "other")
    assert other.speed.value == done.speed.value
