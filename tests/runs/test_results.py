"""Results as values: whole errors, notices, limits of the checks, files that have changed, and runs in memory."""

from __future__ import annotations

import gc
import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import beadband
from beadband.analysis.readers import read
from beadband.cli import main
from beadband.errors import RunError, UsageError
from beadband.lammps.engine import Session, run_script
from beadband.lammps.scripts import write_ring
from beadband.model.scene import scene_of
from beadband.planning.plan import plan_of
from beadband.runs import dispatch, rear_run
from beadband.runs import folder as files
from beadband.runs.checks import rounding_limit
from beadband.runs.measurement import measure
from beadband.runs.rear_run import estimate_of, hold
from beadband.runs.results import Estimate, NoEstimate, RearRun, Run


@pytest.fixture
def copied(default_run: tuple[Run, Path], tmp_path: Path) -> Path:
    return Path(shutil.copytree(default_run[1], tmp_path / "copy"))


def edit(path: Path, change: Callable[[dict[str, Any]], Any]) -> None:
    values = json.loads(path.read_text())
    change(values)
    path.write_text(json.dumps(values))


# Values and notices.


def test_the_first_speed_that_a_user_meets_has_the_whole_error(default_run: tuple[Run, Path]) -> None:
    run, values = default_run[0], json.loads((default_run[1] / files.RESULTS).read_text())
    assert run.speed == (values["rebound_speed_m_s"], values["rebound_speed_error_m_s"])
    assert run.speed.error > 4.0 * run.measurement.fitted_speed_m_s.error
    assert run.curvature is not None
    assert run.curvature.exponent.error == values["curvature"]["exponent_error"]
    assert run.alphas["bar"].value == values["alpha"]["bar"]
    assert f"{run.speed:.2f}" == "17.32 +/- 0.02"


def test_one_leg_gives_the_same_kind_of_result() -> None:
    with Session() as session:
        plan = plan_of(scene_of({"for": "speed"}), "leg")
        found = rear_run.rear_run(plan, session)
    assert plan.model == "leg"
    assert found.speed.error >= found.measurement.fitted_speed_m_s.error
    assert not found.failed_checks


def test_an_error_above_the_tolerance_is_always_said(default_run: tuple[Run, Path]) -> None:
    run = default_run[0]

    def asked(tolerance: float) -> Run:
        return replace(run, plan=replace(run.plan, scene=replace(run.scene, tolerance=tolerance)))

    tight = asked(0.95 * run.relative_error)
    (said,) = [one for one in tight.notices if one.code == "above-tolerance"]
    assert (said.values["value"], said.values["limit"]) == (tight.relative_error, tight.scene.tolerance)
    assert said.sentence == "the error of the rebound speed, 0.14 %, is above the tolerance of 0.13 %"
    assert "0.14 %, is above the tolerance of 0.010 %" in " ".join(one.sentence for one in asked(1e-4).notices)
    assert not tight.within_tolerance
    assert run.within_tolerance
    assert "above-tolerance" not in [one.code for one in run.notices]


def test_a_coarse_run_that_fails_keeps_its_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    plan = plan_of(scene_of({"for": "speed"}), "leg")
    measurement = rear_run.follow_rear(plan)

    def fail(*_: Any) -> None:
        raise RunError("the disk is full", "no-room")

    monkeypatch.setattr(rear_run, "follow_rear", fail)
    estimate = estimate_of(plan)
    assert estimate == NoEstimate("no-room", "the disk is full")
    (said,) = [one for one in RearRun(plan, measurement, estimate).notices if one.code == "no-second-run"]
    assert "the disk is full" in said.sentence


# Checks.


def test_an_asymmetric_release_fails_and_rounding_does_not(default_run: tuple[Run, Path], tmp_path: Path) -> None:
    run = default_run[0]
    limit = rounding_limit(run.plan.steps)
    assert run.rear.asymmetry_m / run.scene.wedge.leg_m < 0.01 * limit
    plan = plan_of(scene_of({"beads": 240}))
    ring = hold(plan)
    moved = ring.positions_m.copy()
    moved[20, 1] += 1e-4 * plan.scene.wedge.leg_m
    write_ring(tmp_path, plan, replace(ring, positions_m=moved))
    run_script(tmp_path, files.SCRIPT)
    off = RearRun(plan, measure(plan, read(tmp_path / files.REAR)), estimate_of(plan))
    (failed,) = off.failed_checks
    assert failed.code == "asymmetric"
    assert failed.values["value"] > 1e3 * failed.values["limit"]


def test_a_thin_band_that_rattles_on_its_finger_is_sound() -> None:
    """The disturbance of the contact is no asymmetry of the release: it has not come back to the tip."""
    done = beadband.run(band="I", law="linear", until="launch", beads=560)
    assert done.failed_checks == ()
    assert done.rear.asymmetry_m > 1e-8 * done.scene.wedge.leg_m
    assert 0.1 < done.quiet_s / done.plan.front_arrival_s < 0.4
    assert done.checks["asymmetry"].value < 0.01 * done.checks["asymmetry"].limit


def test_energy_and_momentum_that_are_wrong_fail(default_run: tuple[Run, Path]) -> None:
    run = default_run[0]
    assert run.checks["energy_balance"].limit < 0.03
    lost = replace(run.energy, kinetic_j=0.9 * run.energy.kinetic_j)
    assert [one.code for one in replace(run, energy=lost).failed_checks] == ["energy-unbalanced"]


# Folders whose files are not those of the results.


def refused(capsys: pytest.CaptureFixture[str], *words: str) -> str:
    assert main(list(words)) == 2
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.count("\n") == 1
    return said.err


@pytest.mark.parametrize("command", ["analyze", "plot", "report"])
def test_an_edited_scene_is_refused(command: str, copied: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = copied / files.SCENE
    path.write_text(path.read_text().replace("strain = 0.476", "strain = 0.9"))
    assert "scene.toml has changed since the run" in refused(capsys, command, str(copied))
    path.unlink()
    assert "without scene.toml" in refused(capsys, command, str(copied))


@pytest.mark.parametrize("command", ["analyze", "plot", "report"])
@pytest.mark.parametrize("finished", [True, False])
def test_a_cut_trajectory_is_refused(
    command: str, finished: bool, copied: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = copied / files.TRAJECTORY
    path.write_bytes(path.read_bytes()[:-5000])
    if not finished:
        (copied / files.RESULTS).unlink()
    said = refused(capsys, command, str(copied))
    if finished or command != "report":
        assert "trajectory.lammpstrj" in said
        assert "cut short" in said
    else:
        assert "without results.json" in said


def test_a_changed_data_file_is_refused(copied: Path) -> None:
    path = copied / files.DATA
    path.write_text(path.read_text() + "\n")
    with pytest.raises(UsageError, match=r"band\.data has changed") as caught:
        dispatch.analyze(copied)
    assert caught.value.code == "changed-file"


@pytest.mark.parametrize("command", ["report", "movie", "plot", "analyze"])
def test_a_missing_run_is_named(command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "nowhere' without" in refused(capsys, command, str(tmp_path / "nowhere"))


def test_results_of_other_versions_open_with_all_that_they_hold(copied: Path, default_run: tuple[Run, Path]) -> None:
    def older(values: dict[str, Any]) -> None:
        del values["schema_version"], values["fingerprints"], values["estimate"]["eq7_ratio"]
        values["estimate"]["of_another_version"] = 1.0

    edit(copied / files.RESULTS, older)
    again = dispatch.load(copied)
    assert isinstance(again.estimate, Estimate)
    assert again.estimate.eq7_ratio is None
    assert again.speed == default_run[0].speed


# In memory, and from a folder.


def test_a_run_without_a_folder_keeps_its_arrays() -> None:
    done = beadband.run(beads=120)
    place = done.folder
    assert done.ring.positions_m.shape == (*done.ring.times_s.shape, 120, 2)
    assert done.ring.stretch.shape == done.ring.curvature_1_m.shape == done.ring.positions_m.shape[:2]
    assert done.ring.stretch[0, 1] == pytest.approx(1.476, rel=1e-3)
    assert done.ring.curvature_1_m[0, 0] == pytest.approx(done.rear.tip_curvature_1_m[0], rel=1e-6)
    assert done.plot()[0].is_file()
    del done
    gc.collect()
    assert not place.exists()


def test_a_loaded_run_is_the_one_that_was_made(default_run: tuple[Run, Path]) -> None:
    made, folder = default_run
    again = beadband.load(folder)
    first, second = made.as_dict(), again.as_dict()
    for values in (first, second):
        values["wall_s"].pop("write")
    assert first == second
    assert np.array_equal(again.energy.kinetic_j, made.energy.kinetic_j)
    assert repr(again) == repr(made)
    assert max(map(len, repr(again).splitlines())) < 100
    assert len(repr(again).splitlines()) < 5
    assert again._repr_html_().startswith("<table><tr><td>rebound speed V</td><td>17.316 +/- 0.023 m/s</td>")
