"""Releases: convergence, exact limits, conservation, and the same trajectory however LAMMPS is driven."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from beadband.analysis.curvature import curvatures
from beadband.analysis.fits import hann_mean
from beadband.analysis.readers import read, read_energies, read_mdanalysis
from beadband.errors import RunError
from beadband.lammps.engine import run_script
from beadband.lammps.scripts import write_ring
from beadband.model.bands import CATALOGUE
from beadband.model.scene import scene_of
from beadband.planning.plan import plan_of
from beadband.runs import dispatch, release
from beadband.runs import folder as files
from beadband.runs.rear_run import follow_rear, hold
from beadband.runs.results import Run
from conftest import rear_of

FINE = 1200


def mean_curvature(law: str, beads: int | None, share: float) -> float:
    plan, found = rear_of(law=law, **({"beads": beads} if beads else {}))
    later = found.rear.times_s > 0.0
    return hann_mean(
        found.rear.times_s[later],
        found.rear.tip_curvature_1_m[later],
        share * plan.front_arrival_s,
        0.03 * plan.front_arrival_s,
    )


@pytest.mark.parametrize("law", ["linear", "mooney-rivlin"])
def test_rebound_speed_converges(law: str) -> None:
    fine = rear_of(law=law, beads=FINE)[1].fitted_speed_m_s.value
    assert rear_of(law=law)[1].fitted_speed_m_s.value == pytest.approx(fine, rel=2e-3)
    assert rear_of(law=law, beads=120)[1].fitted_speed_m_s.value == pytest.approx(fine, rel=5e-3)


@pytest.mark.parametrize("law", ["linear", "mooney-rivlin"])
@pytest.mark.parametrize("share", [0.1, 0.3])
def test_tip_curvature_converges(law: str, share: float) -> None:
    assert mean_curvature(law, None, share) == pytest.approx(mean_curvature(law, FINE, share), rel=2e-2)


@pytest.mark.parametrize("law", ["linear", "mooney-rivlin"])
@pytest.mark.parametrize("band", list(CATALOGUE))
def test_without_bending_the_string_limit_is_exact(band: str, law: str) -> None:
    plan, found = rear_of(band=band, law=law, bending_scale=1e-4)
    assert found.fitted_speed_m_s.value == pytest.approx(plan.string.rear_speed_m_s, rel=3e-3)


def test_the_table_modulus_moves_bending_alone() -> None:
    """With Mooney-Rivlin E enters through EI only: 1e-4 of it is the string, as good as 1e-4 of EI."""
    plan, found = rear_of(modulus_pa=110.0, c10_pa=0.187e6, c01_pa=0.122e6)
    assert found.fitted_speed_m_s.value == pytest.approx(plan.string.rear_speed_m_s, rel=3e-3)


def test_error_bar_holds_the_converged_speed(default_run: tuple[Run, Path]) -> None:
    values = default_run[0].as_dict()
    fine = rear_of(law="mooney-rivlin", beads=FINE)[1].fitted_speed_m_s.value
    assert abs(values["rebound_speed_m_s"] - fine) < values["rebound_speed_error_m_s"]
    assert values["rebound_speed_error_m_s"] < 0.005 * values["rebound_speed_m_s"]


def test_tip_curvature_decays_self_similarly(default_run: tuple[Run, Path]) -> None:
    curvature = default_run[0].as_dict()["curvature"]
    assert curvature["exponent"] == pytest.approx(-0.5, abs=0.07)
    assert 0.55 < curvature["eq7_ratio"] < 0.70  # above the at-rest beam's half: the legs carry inertia along


def test_equal_groups_give_equal_speeds() -> None:
    """Scaling size, modulus and density leaves V/C alone: the same dynamics in other units."""
    base = scene_of({"beads": 200})
    scaled = scene_of(
        {
            "beads": 200,
            "circumference_m": 3.0 * 0.204,
            "width_m": 3.0 * 1.6e-3,
            "thickness_m": 3.0 * 2.0e-3,
            "density_kg_m3": 0.5 * 1300.0,
            "modulus_pa": 2.0 * 1.1e6,
            "c10_pa": 2.0 * 0.187e6,
            "c01_pa": 2.0 * 0.122e6,
        }
    )
    ratios = [follow_rear(plan_of(scene)).fitted_speed_m_s.value / scene.band.bar_speed_m_s for scene in (base, scaled)]
    assert ratios[1] == pytest.approx(ratios[0], rel=1e-9)


def test_energy_is_kept_without_loss(tmp_path: Path) -> None:
    run = release.run(scene_of({"law": "linear", "loss_time_s": 0.0}), tmp_path / "run")
    assert run.energy.error < 1e-4
    assert run.energy.dissipated_j[-1] == 0.0


def test_energy_is_balanced_with_loss(default_run: tuple[Run, Path]) -> None:
    run = default_run[0]
    assert run.energy.error < 2e-3
    stored = scene_of({}).band.area_m2 * 0.204 * float(scene_of({}).material.energy(1.476))
    assert run.energy.stored_j == pytest.approx(stored, rel=0.02)
    # The shock loses what the string's jump conditions say, over the part of the ring that the front has passed.
    string, law = run.plan.string, run.plan.scene.material
    behind = 1.0 + string.residual_strain
    jump = law.energy(1.476) - law.energy(behind) - 0.5 * (law.stress(1.476) + law.stress(behind)) * (1.476 - behind)
    lost = 2.0 * run.plan.scene.band.area_m2 * run.plan.scene.wedge.reference_leg_m * float(jump)
    assert run.energy.dissipated_j[-1] == pytest.approx(lost, rel=0.1)
    assert not run.failed_checks


def test_momenta_that_must_stay_zero(default_run: tuple[Run, Path]) -> None:
    run, folder = default_run
    rows = (folder / files.TRAJECTORY).read_text().splitlines()[-run.plan.beads :]
    x, y, vx, vy = np.array([row.split() for row in rows], dtype=float)[:, [2, 3, 5, 6]].T
    scale = np.abs(vy).sum()
    assert abs(vy.sum()) < 1e-6 * scale  # velocities are written to six digits
    assert abs((x * vy - y * vx).sum()) < 1e-6 * np.abs(x * vy).sum()
    assert np.abs(np.linalg.norm([vx, vy], axis=0)).max() > 10.0


def same_positions(folder: Path, other: Path) -> float:
    """Largest difference of two runs' beads over the reference leg."""
    pairs = [(read(folder / name), read(other / name)) for name in (files.TRAJECTORY, files.REAR)]
    return max(float(np.abs(a.positions_m - b.positions_m).max()) for a, b in pairs) / 0.0702


def copy_inputs(folder: Path, target: Path) -> Path:
    target.mkdir()
    for name in (files.SCRIPT, files.DATA, files.TABLE):
        shutil.copy(folder / name, target)
    return target


def test_plain_lammps_repeats_the_run(default_run: tuple[Run, Path], tmp_path: Path, lmp: str) -> None:
    target = copy_inputs(default_run[1], tmp_path / "plain")
    subprocess.run([lmp, "-in", files.SCRIPT, "-screen", "none"], cwd=target, check=True, timeout=100)
    assert same_positions(default_run[1], target) == 0.0
    assert (target / files.ENERGY).read_text() == (default_run[1] / files.ENERGY).read_text()


@pytest.mark.mpi
def test_two_ranks_repeat_the_run(default_run: tuple[Run, Path], tmp_path: Path, lmp: str, mpirun: str) -> None:
    target = copy_inputs(default_run[1], tmp_path / "two")
    command = [mpirun, "-np", "2", lmp, "-in", files.SCRIPT, "-screen", "none"]
    subprocess.run(command, cwd=target, check=True, timeout=100)
    assert same_positions(default_run[1], target) < 1e-9


def test_readers_agree_to_the_last_digit(default_run: tuple[Run, Path]) -> None:
    _, folder = default_run
    for name in (files.TRAJECTORY, files.REAR):
        ours, theirs = read(folder / name), read_mdanalysis(folder / name)
        assert np.array_equal(ours.steps, theirs.steps)
        assert np.array_equal(ours.ids, theirs.ids)
        assert np.array_equal(ours.positions_m, theirs.positions_m)
    again = dispatch.analyze(folder)
    assert again.measurement.fitted_speed_m_s == default_run[0].measurement.fitted_speed_m_s
    assert again.as_dict()["rebound_speed_error_m_s"] == default_run[0].as_dict()["rebound_speed_error_m_s"]


def test_whole_ring_and_rear_give_the_same_speed(default_run: tuple[Run, Path]) -> None:
    run, folder = default_run
    from beadband.runs.measurement import measure

    whole = measure(run.plan, read_mdanalysis(folder / files.TRAJECTORY)).fitted_speed_m_s.value
    assert whole == pytest.approx(run.measurement.fitted_speed_m_s.value, rel=1e-4)


def test_single_precision_would_spoil_the_curvature(default_run: tuple[Run, Path]) -> None:
    """What MDAnalysis' own positions do to the curvature, and that the readers keep clear of it."""
    import MDAnalysis

    run, folder = default_run
    universe = MDAnalysis.Universe(
        str(folder / files.REAR), topology_format="LAMMPSDUMP", format="LAMMPSDUMP", dt=run.plan.timestep_s
    )
    single = np.array([frame.positions[:, :2].astype(float) for frame in universe.trajectory])
    spacing = run.plan.scene.strand(run.plan.beads).spacing_m
    rough = curvatures(single[:, 2], single[:, 0], single[:, 1], spacing)
    noise = np.abs(rough - run.measurement.rear.tip_curvature_1_m).max()
    assert 1e-9 / spacing**2 < noise < 1e-7 / spacing**2  # of the order 1e-8 m / a^2


def test_scene_file_repeats_the_run_bit_by_bit(default_run: tuple[Run, Path], tmp_path: Path) -> None:
    from beadband.model.scenefile import read_scene

    run, folder = default_run
    again = release.run(scene_of(read_scene(folder / files.SCENE)), tmp_path / "again")
    assert again.plan.scene == run.plan.scene
    first, second = run.as_dict(), again.as_dict()
    for values in (first, second):
        for key in ("wall_s", "versions"):
            values.pop(key)
    assert json.dumps(first) == json.dumps(second)
    assert (folder / files.TRAJECTORY).read_bytes() == (tmp_path / "again" / files.TRAJECTORY).read_bytes()


def test_the_step_limit_is_the_edge(tmp_path: Path) -> None:
    """A little below the predicted limit a release gains no energy; above it, it blows up and says so."""
    base = plan_of(scene_of({"beads": 400}))

    def at(share: float, name: str) -> Path:
        folder = tmp_path / name
        folder.mkdir()
        plan = replace(base, timestep_s=share * base.largest_timestep_s)
        write_ring(folder, plan, hold(base))
        run_script(folder, files.SCRIPT)
        return folder

    energies = read_energies(at(0.9, "below") / files.ENERGY)
    total = energies.stretching_j + energies.bending_j + energies.kinetic_j
    assert total.max() <= 1.001 * total[0]
    with pytest.raises(RunError, match=r"likely cause: a time step beyond.*lower --timestep"):
        at(1.2, "above")


def test_result_file_keeps_the_contract(default_run: tuple[Run, Path]) -> None:
    values = json.loads((default_run[1] / files.RESULTS).read_text())
    keys = {
        *("scene", "leg_length_m", "finger_radius_m", "front_arrival_s", "bending_stiffness_n_m2"),
        *("mass_per_length_kg_m", "rebound_speed_m_s", "rebound_speed_error_m_s", "wave_speeds_m_s", "rebound_ratio"),
        *("alpha", "string_speed_m_s", "curvature", "series", "energy", "wall_s", "versions", "warnings"),
    }
    assert keys <= values.keys()
    for key in ("wave_speeds_m_s", "rebound_ratio", "alpha"):
        assert values[key].keys() == {"bar", "rest", "front_horizontal"}
    for key in ("band", "strain", "half_angle_deg", "law", "until", "tolerance", "beads", "timestep_s", "loss_time_s"):
        assert key in values["scene"]
    assert {"plan", "relax", "integrate", "measure", "write"} <= values["wall_s"].keys()
    assert {"stored_j", "kinetic_j", "bending_j", "dissipated_j", "balance_error"} <= values["energy"].keys()
    assert values["curvature"].keys() == {"window_s", "exponent", "exponent_error", "eq7_ratio", "eq7_ratio_error"}
    assert len({len(values["series"][key]) for key in ("t_s", "tip_x_m", "tip_speed_m_s", "tip_curvature_1_m")}) == 1
    assert values["front_arrival_s"] == pytest.approx(0.0702206 / 29.52086, rel=1e-5)
    speed = values["rebound_speed_m_s"]
    assert values["rebound_ratio"]["bar"] == pytest.approx(speed / math.sqrt(1.1e6 / 1300.0), rel=1e-12)
