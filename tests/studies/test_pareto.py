"""The work-precision study: every method solves the same problem, and the study in its smallest form."""

from __future__ import annotations

import csv
import json
import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beadband import cli
from beadband.errors import UsageError
from beadband.lammps.divergence import DivergenceError
from beadband.lammps.engine import Session
from beadband.model.scene import scene_of
from beadband.runs.rear_run import follow_rear
from beadband.studies import pareto
from beadband.studies.pareto import page, report
from beadband.studies.pareto.methods import (
    LINEAR,
    LOSSY,
    MAIN,
    QUICK,
    STRING,
    Extent,
    Method,
    leg_plan,
    methods,
    with_step,
)
from beadband.studies.pareto.outcomes import OK
from beadband.studies.pareto.reference import references
from beadband.studies.pareto.runs import hold_by, run_once

SCENE = scene_of({})


@pytest.fixture(scope="module")
def session() -> Iterator[Session]:
    with Session() as opened:
        yield opened


def test_production_variant_is_the_production_script(session: Session) -> None:
    plan = leg_plan(SCENE, 160)
    answer, cost = run_once(Method("beads", "production", plan), session)
    # The same beads in other units, by another script: rounding and the reach of the bond table are left.
    assert answer.speed_m_s == pytest.approx(follow_rear(plan, session).fitted_speed_m_s.value, rel=3e-8)
    assert 0.0 < cost.integrate_s < 1.0


# Largest deviations of V and of the tip curvature around 0.1 of the arrival from the production run of as many beads;
# what other angles and integrators differ by is of the second order in spacing and step.
SAME = {
    ("bond", "spline, 51 points"): (1e-6, 1e-5),
    ("bond", "spline, 2001 points"): (1e-8, 1e-7),
    ("bond", "linear, 201 points"): (5e-5, 1e-4),
    ("bond", "linear, 2001 points"): (1e-6, 1e-5),
    ("bond", "lepton"): (1e-8, 1e-7),
    ("angle", "harmonic"): (2e-4, 2e-3),
    ("angle", "cosine"): (2e-4, 4e-3),
    ("angle", "rod table"): (2e-4, 2e-3),
    ("loss", "dpd/ext/tstat"): (1e-8, 1e-7),
    ("loss", "numerical 0.1"): (1e-3, 2e-3),
    ("output", "samples, not means"): (1e-5, 2e-3),
    ("output", "text dump"): (1e-9, 1e-9),
    ("output", "numpy, step by step"): (1e-5, 2e-3),
    ("integrator", "bonds inside, 2 a step"): (2e-4, 1e-2),
    ("integrator", "angles inside, 2 a step"): (2e-4, 5e-3),
    ("model", "ring, rear alone written"): (1e-4, 3e-3),
    ("model", "ring with contact"): (1e-4, 3e-3),
}
ELSE = {
    ("bond", "harmonic"): LINEAR,
    ("bond", "spline of linear law"): LINEAR,
    ("loss", "physical"): LOSSY,
    ("model", "leg without bending"): STRING,
}


@pytest.fixture(scope="module")
def moderate() -> dict[tuple[str, str], Method]:
    """Each variant of the quick diagram with 384 beads."""
    return {(m.family, m.variant): m for m in methods(SCENE, QUICK) if m.plan.beads == 384 and m.family != "step"}


def test_every_method_is_named_here(moderate: dict[tuple[str, str], Method]) -> None:
    others = {
        ("beads", "production"),
        ("angle", "rod"),  # the table's energy as an expression, forty times slower
        ("loss", "none"),
        ("loss", "numerical 0.8"),
        ("integrator", "bonds inside, 4 a step"),
        ("integrator", "angles inside, 4 a step"),
        ("model", "ring, all files"),
    }
    assert set(moderate) == set(SAME) | set(ELSE) | others
    assert {key: method.own for key, method in moderate.items() if method.own != MAIN} == ELSE


@pytest.mark.parametrize("key", list(SAME), ids=lambda key: ": ".join(key))
def test_method_solves_the_same_problem(
    key: tuple[str, str], moderate: dict[tuple[str, str], Method], session: Session
) -> None:
    ours, _ = run_once(moderate["beads", "production"], session)
    other, _ = run_once(moderate[key], session)
    for_speed, for_curvature = SAME[key]
    assert other.speed_m_s == pytest.approx(ours.speed_m_s, rel=for_speed)
    assert other.curvature_1_m[0] == pytest.approx(ours.curvature_1_m[0], rel=for_curvature)


def test_other_limits_are_reached(moderate: dict[tuple[str, str], Method], session: Session) -> None:
    """Harmonic bonds solve the linear law as its spline does; without bending the string's exact speed comes out."""
    harmonic, spline = (run_once(moderate["bond", name], session)[0] for name in ("harmonic", "spline of linear law"))
    assert harmonic.speed_m_s == pytest.approx(spline.speed_m_s, rel=1e-7)
    bare, _ = run_once(moderate["model", "leg without bending"], session)
    assert bare.speed_m_s == pytest.approx(SCENE.string.rear_speed_m_s, rel=2e-3)
    lossy, _ = run_once(moderate["loss", "physical"], session)
    ours, _ = run_once(moderate["beads", "production"], session)
    assert abs(lossy.speed_m_s / ours.speed_m_s - 1.0) > 2e-3


@pytest.mark.parametrize("angle", ["harmonic", "cosine", "rod"])
def test_leg_is_held_by_the_angles_that_it_is_released_with(angle: str) -> None:
    plan = leg_plan(SCENE, 384)
    own = hold_by(Method("angle", angle, plan, choices={"angle": angle}))
    quartic = hold_by(Method("angle", "quartic", plan))
    assert own.net_force < 1e-11
    assert np.abs(own.positions_m - quartic.positions_m).max() > 1e-3 * plan.scene.strand(384).spacing_m


def test_too_long_a_step_diverges(session: Session) -> None:
    plan = with_step(leg_plan(SCENE, 96), 1.3)
    with pytest.raises(DivergenceError):
        run_once(Method("step", "beyond", plan), session)


def test_step_keeps_the_end_of_the_run() -> None:
    plan = leg_plan(SCENE, 272)
    for share, inner in ((0.1, 1), (0.95, 1), (0.5, 4)):
        other = with_step(plan, share, inner)
        assert other.steps * other.timestep_s == pytest.approx(plan.steps * plan.timestep_s, rel=1e-12)
        assert other.timestep_s <= share * inner * plan.largest_timestep_s * (1.0 + 1e-12)
        assert other.steps % other.rear_steps == 0


def test_reference_of_the_string_is_exact_and_others_tell_their_spread(session: Session) -> None:
    found = references(SCENE, 768, session, [STRING])[STRING]
    assert found.values[0] == SCENE.string.rear_speed_m_s
    assert math.isnan(found.values[1])


def test_scene_too_stiff_for_a_leg_is_refused() -> None:
    with pytest.raises(UsageError, match="leg"):
        leg_plan(scene_of({"bending_scale": 400.0}), 96)


TINY = Extent(
    beads=(96, 192, 384),
    variants=(96, 192),
    steps=(96,),
    step_shares=(0.5, 1.3),
    respa=(96,),
    respa_inner=(2, 4),
    rings=(96,),
    spline_points=(51,),
    linear_points=(201,),
    losses=(0.1,),
    repeats=2,
    cores=(100,),
    core_rounds=1,
    core_runs=2,
)


@pytest.fixture(scope="module")
def tiny(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """The whole study in its smallest form."""
    folder = tmp_path_factory.mktemp("pareto")
    return folder, pareto.pareto(SCENE, folder, TINY)


def test_the_study_writes_its_tables_charts_and_page(tiny: tuple[Path, dict[str, Any]]) -> None:
    folder, result = tiny
    for name in ("pareto", "pareto-methods", "pareto-curvature", "pareto-cores"):
        assert (folder / f"{name}.png").stat().st_size > 10_000
        assert "</svg>" in (folder / f"{name}.svg").read_text()
    assert json.loads((folder / "frontier.json").read_text()) == result
    assert (folder / "pareto.md").read_text() == page.markdown(result)
    assert all(one in (folder / "pareto.md").read_text() for one in result["sentences"])
    assert "frontier, V" in report.table(result)


def test_the_results_of_the_study_agree_with_its_rows(tiny: tuple[Path, dict[str, Any]]) -> None:
    folder, result = tiny
    rows = list(csv.DictReader((folder / "pareto.csv").open()))
    counted = {code: sum(row["status"] == code for row in rows) for code in result["outcomes"]}
    assert counted == result["outcomes"]
    assert sum(counted.values()) == len(rows)
    (diverged,) = (row for row in rows if row["family"] == "step" and row["status"] != OK)
    assert diverged["status"] in ("diverged", "lost")
    for entry in result["frontier"]["speed"]:
        (row,) = (row for row in rows if all(row[key] == str(entry[key]) for key in ("family", "variant", "beads")))
        assert float(row["error_speed"]) == pytest.approx(entry["error"], rel=1e-5)
        assert row["status"] == OK
    plan = next(one for one in result["plan"] if one["quantity"] == "speed" and one["tolerance"] == 0.02)
    assert plan["error"] < 0.02
    assert plan["cost_over_frontier_at_tolerance"] is not None
    values = {finding["code"]: finding["values"] for finding in result["findings"]}
    for level in values["cost-of-speed"]["levels"]:
        if "seconds" in level:
            (row,) = (row for row in rows if all(row[k] == str(level[k]) for k in ("family", "variant", "beads")))
            assert float(row["sure_error_speed"]) <= level["error"]
            assert float(row["integrate_min_s"]) == pytest.approx(level["seconds"], rel=1e-5)
    ring, leg = (
        next(row for row in rows if row["beads"] == "96" and (row["family"], row["variant"]) == key)
        for key in (("model", "ring, all files"), ("beads", "production"))
    )
    assert int(ring["bead_steps"]) > 3 * int(leg["bead_steps"])
    cost = float(ring["integrate_min_s"]) / float(leg["integrate_min_s"])
    assert values["whole-ring"]["cost"] == pytest.approx([cost, cost], rel=1e-4)
    respa = [row for row in rows if row["family"] == "integrator"]
    assert values["respa-failures"]["runs"] == len(respa)
    assert sum(values["respa-failures"]["failed"].values()) == sum(not row["speed_m_s"] for row in respa)


@pytest.mark.parametrize(
    ("flag", "value"),
    [
        ("--beads", "100"),
        ("--timestep", "1e-6"),
        ("--loss-time", "1e-6"),
        ("--tolerance", "0.01"),
        ("--for", "speed"),
        ("--until", "launch"),
        ("--frames", "10"),
        ("--finger", "clears"),
        ("--flight", "0.01"),
    ],
)
def test_options_that_the_study_does_not_use_are_refused(
    flag: str, value: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        code = cli.main(["pareto", flag, value, "--out", str(tmp_path / "out")])
    except SystemExit as exit:
        code = exit.code  # type: ignore[assignment]
    assert code == 2
    assert flag in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_scene_that_sets_what_the_study_varies_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="--beads is not used"):
        pareto.pareto(replace(SCENE, beads=100), tmp_path, TINY)
