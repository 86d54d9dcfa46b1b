"""Launches: a quiet start, impulse and momentum, the string's closed forms, convergence, and what the files hold."""

from __future__ import annotations

import json
import math
import shutil
import subprocess
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beadband.analysis.contact import (
    LaunchMeasurement,
    crossings,
    finger_free,
    last_load,
    rear_arrival_s,
    touches_of,
)
from beadband.analysis.readers import ReadError, Watch, read, read_watch
from beadband.cli import main
from beadband.errors import RunError, UsageError
from beadband.lammps.engine import run_script
from beadband.lammps.scripts import write_launch
from beadband.model.launch_string import finger_force_n, string_launch
from beadband.model.scene import scene_of
from beadband.model.scenefile import read_scene
from beadband.observables import error_key
from beadband.planning import launch_plan
from beadband.planning.launch_plan import DEPTH_BOUND, LaunchPlan, launch_plan_of
from beadband.planning.plan import plan_of
from beadband.reporting import summary
from beadband.runs import dispatch, launch
from beadband.runs import folder as files
from beadband.runs.launch_results import Launch
from beadband.statics.finger import finger_loads_n, settle_on
from beadband.statics.ring import WRAPPED, stretched_ring

LAUNCH: dict[str, Any] = {"until": "launch"}


@cache
def launched(**values: Any) -> tuple[LaunchPlan, LaunchMeasurement, Watch]:
    """A scene's launch, its finger alone followed."""
    return launch.follow_launch(scene_of({"until": "launch", **values}))


@pytest.fixture(scope="module")
def stays(tmp_path_factory: pytest.TempPathFactory) -> tuple[Launch, Path]:
    folder = tmp_path_factory.mktemp("launch") / "it's a launch"
    return launch.run(scene_of({"until": "launch", "beads": 160, "for": "speed"}), folder), folder


@pytest.fixture(scope="module")
def clears(tmp_path_factory: pytest.TempPathFactory) -> tuple[Launch, Path]:
    folder = tmp_path_factory.mktemp("launch") / "clears"
    values = {"until": "launch", "beads": 160, "for": "speed", "finger": "clears", "flight_s": 2e-3}
    return launch.run(scene_of(values), folder), folder


# The held ring on a finger that gives way.


@pytest.mark.parametrize("values", [{}, {"beads": 121}, {"band": "IV", "strain": 1.4, "beads": 400}, {"law": "linear"}])
def test_the_held_ring_rests_on_the_finger(values: dict[str, Any]) -> None:
    plan = launch_plan_of(scene_of({"until": "launch", "beads": 240, **values}))
    ring, support = plan.held()
    depths = support.depths_m(ring.positions_m)
    pushed = depths > 0.0
    loads = support.stiffness_n_m * depths[pushed]
    outward = ring.positions_m[pushed] - np.array([support.centre_m, 0.0])
    outward /= np.hypot(outward[:, 0], outward[:, 1])[:, None]
    total = loads @ outward
    assert ring.net_force < 1e-9
    assert total[0] == pytest.approx(2.0 * ring.tension_n * math.cos(plan.scene.half_angle_rad), rel=2e-3)
    assert abs(total[1]) < 1e-9 * ring.tension_n
    assert depths.max() < 0.1 * DEPTH_BOUND * plan.scene.band.thickness_m


def test_a_stiffer_finger_comes_to_the_rigid_one() -> None:
    """Depths, and the ring's departure from the rigid finger's, fall as 1/k."""
    scene = scene_of({})
    strand = scene.strand(240)
    rigid = stretched_ring(strand, 240, scene.strain, scene.half_angle_rad)
    assert finger_loads_n(rigid, strand).min() >= 0.0
    apart = []
    for stiffness in (1e5, 1e6, 1e7):
        ring, support = settle_on(rigid, strand, stiffness)
        apart.append((support.depths_m(ring.positions_m).max(), np.abs(ring.positions_m - rigid.positions_m).max()))
    for before, after in pairwise(apart):
        assert before[0] / after[0] == pytest.approx(10.0, rel=0.1)
        assert before[1] / after[1] == pytest.approx(10.0, rel=0.1)


def test_nothing_moves_before_the_front(tmp_path: Path) -> None:
    """A string with a linear law sends nothing ahead of its front: what lies on the finger rests until it comes."""
    plan = launch_plan_of(scene_of({"until": "launch", "law": "linear", "bending_scale": 0.0, "beads": 200}))
    write_launch(tmp_path, plan, *plan.held())
    run_script(tmp_path, files.LAUNCH_SCRIPT)
    ring = read(tmp_path / files.TRAJECTORY)
    times = ring.times_s(plan.timestep_s)
    wrapped = plan.held()[0].types == WRAPPED
    moved = np.abs(ring.positions_m - ring.positions_m[0])[:, wrapped].max(axis=(1, 2)) / plan.strand.spacing_m
    # The trajectory has ten digits of each position.
    assert moved[times < 0.5 * plan.release.front_arrival_s].max() < 1e-7
    assert moved[times > 1.2 * plan.release.front_arrival_s].min() > 1e-2


# Conservation.


@pytest.mark.parametrize(
    "values",
    [
        {"beads": 160, "for": "speed"},
        {"beads": 160, "law": "linear", "strain": 0.1},
        {"beads": 160, "strain": 1.2, "half_angle_deg": 20.0},
        {"band": "I", "half_angle_deg": 5.0, "beads": 160},
        {"band": "IV", "strain": 1.4, "beads": 400},
        {"beads": 200, "law": "linear", "strain": 1.4, "half_angle_deg": 5.0},
    ],
    ids=lambda values: " ".join(map(str, values.values())),
)
def test_momentum_energy_and_depth_in_very_different_launches(values: dict[str, Any]) -> None:
    from beadband.analysis.energy import launch_balance

    plan, found, watch = launched(**values)
    assert found.impulse_n_s == pytest.approx(found.momentum_n_s, rel=1e-12)
    assert launch_balance(watch, plan.timestep_s).error < 5e-3
    assert found.depth_m < DEPTH_BOUND * plan.scene.band.thickness_m
    assert found.rear_arrival_s is not None
    assert watch.steps[-1] < plan.steps


def test_energy_is_kept_without_loss(monkeypatch: pytest.MonkeyPatch) -> None:
    """To the second order in the step, also where the fronts meet and the band buckles; the contact counts."""
    from beadband.analysis.energy import launch_balance

    monkeypatch.setattr(launch_plan, "CONTACT_SHARE", 0.0)  # the same finger for both
    values = {"until": "launch", "law": "linear", "strain": 0.2, "loss_time_s": 0.0, "beads": 160}
    plan, _, watch = launch.follow_launch(scene_of(values))
    finer, _, finer_watch = launch.follow_launch(scene_of({**values, "timestep_s": 0.5 * plan.timestep_s}))
    assert finer.contact_stiffness_n_m == plan.contact_stiffness_n_m
    errors = [launch_balance(watch, plan.timestep_s).error, launch_balance(finer_watch, finer.timestep_s).error]
    assert errors[0] < 3e-3
    assert errors[1] < 0.4 * errors[0]
    assert launch_balance(watch, plan.timestep_s).dissipated_j[-1] == 0.0


def test_stored_energy_of_the_linear_law() -> None:
    """1/2 E A strain^2 for each unit of reference length."""
    plan, _, watch = launched(law="linear", bending_scale=0.0, beads=200)
    band = plan.scene.band
    exact = 0.5 * band.modulus_pa * band.area_m2 * 0.476**2 * band.circumference_m
    assert plan.string.stored_j == pytest.approx(exact, rel=1e-12)
    assert watch.stretching_j[0] + watch.contact_j[0] == pytest.approx(exact, rel=2e-3)


# The string.


def test_the_strings_force_gives_the_strings_momentum() -> None:
    for values in ({}, {"law": "linear", "strain": 0.9}, {"band": "II", "half_angle_deg": 28.0, "strain": 0.3}):
        scene = scene_of(values)
        string = string_launch(scene)
        times = np.linspace(0.0, string.finger_free_s, 20001)
        momentum = np.trapezoid(finger_force_n(scene, times), times)
        assert momentum == pytest.approx(string.momentum_n_s, rel=1e-8)
        assert string.exact
        assert 0.5 < string.efficiency < 1.0
    assert not string_launch(scene_of({"half_angle_deg": 35.0, "strain": 0.2})).exact


def test_the_strings_pause_has_a_sign_of_its_own() -> None:
    """(1 + strain)/(strain - strain1) (1 - sin)/(1 + sin) against 1 + tan (pi/2 + phi) decides, whatever the law."""
    for law in ("linear", "mooney-rivlin"):
        for strain in (0.1, 0.3, 0.476, 0.8, 1.3):
            for angle in (3.0, 8.0, 14.0, 24.0):
                scene = scene_of({"law": law, "strain": strain, "half_angle_deg": angle})
                phi, string = math.radians(angle), string_launch(scene)
                left = (1.0 + strain) / (strain - scene.string.residual_strain)
                left *= (1.0 - math.sin(phi)) / (1.0 + math.sin(phi))
                right = 1.0 + math.tan(phi) * (math.pi / 2.0 + phi)
                assert string.pause_s / string.finger_free_s == pytest.approx(left / right - 1.0, rel=1e-9)


@pytest.mark.parametrize("law", ["linear", "mooney-rivlin"])
def test_without_bending_the_string_is_met(law: str) -> None:
    """Force constant until the front arrives, then falling to nothing at (Cb/2)/(front speed); impulse and arrival."""
    plan, found, watch = launched(law=law, bending_scale=1e-4, beads=400, **{"for": "speed"})
    times, string = watch.times_s(plan.timestep_s), plan.string
    before = (times > 0.0) & (times < 0.9 * plan.release.front_arrival_s)
    assert np.abs(watch.mean_force_n[before] / finger_force_n(plan.scene, times[:1]) - 1.0).max() < 2e-3
    assert found.finger_free_s == pytest.approx(string.finger_free_s, rel=0.02)
    assert found.rear_arrival_s == pytest.approx(string.rear_arrival_s, rel=0.01)
    at_free = watch.momentum_n_s[times < 1.05 * string.finger_free_s][-1]
    assert at_free == pytest.approx(string.momentum_n_s, rel=0.02)


def test_the_string_is_approached_with_the_beads() -> None:
    errors = []
    for beads in (120, 480):
        plan, found, _ = launched(law="linear", bending_scale=1e-4, beads=beads, finger="clears", **{"for": "speed"})
        errors.append(abs(found.momentum_n_s / plan.string.momentum_n_s - 1.0))
    assert errors[1] < 0.6 * errors[0]


# Measuring.


def test_freedom_is_measured_through_a_rattle() -> None:
    """Right to the share of the load that counts as none, on the string's own force and through a rattle."""
    scene = scene_of({})
    string = string_launch(scene)
    times = np.linspace(0.0, 1.3 * string.finger_free_s, 600)
    exact = finger_force_n(scene, times)
    mean = exact.copy()
    mean[1:] = 0.5 * (exact[1:] + exact[:-1])
    rattle = mean * (1.0 + 0.5 * np.sin(np.arange(600) * 1.3))
    idle_s = 0.03 * string.finger_free_s
    for force in (mean, rattle):
        last = last_load(times, force, exact[0], idle_s)
        assert last is not None
        free = finger_free(times, force, last, 2.0 * string.tension_n, string.turning_1_s)
        assert free.value == pytest.approx(string.finger_free_s, rel=3e-3)
        assert abs(free.value - string.finger_free_s) < 2.0 * free.error < 0.01 * free.value
    rattle[480:490] = 0.05 * exact[0]  # a band that comes back before the finger has been idle for long enough
    later = last_load(times, rattle, exact[0], idle_s=0.06 * string.finger_free_s)
    assert later == 489
    again = finger_free(times, rattle, later, 2.0 * string.tension_n, string.turning_1_s)
    assert again.value == pytest.approx(string.finger_free_s, rel=0.01)
    assert last_load(times, np.full(600, exact[0]), exact[0], 1e-4) is None


def test_touches_and_arrivals() -> None:
    times = np.linspace(0.0, 10.0, 101)
    force = np.where(times < 4.0, 1.0, 0.0)
    force[60:63] = -0.5
    force[65] = 0.2
    force[90] = 0.3
    touches = touches_of(times, force, 1.0, 4.0, 0.5)
    assert [touch.impulse_n_s for touch in touches] == pytest.approx([-0.13, 0.03])
    assert touches[0].start_s == pytest.approx(5.9)
    gap = 5.03 - times
    assert rear_arrival_s(times[:51], gap[:51], 0.15) == pytest.approx(5.03)
    assert rear_arrival_s(times[:40], gap[:40], 0.15) is None


def test_crossings_are_counted() -> None:
    angle = np.linspace(0.0, 2.0 * math.pi, 201)[:-1]
    assert crossings(np.stack([np.cos(angle), np.sin(angle)], axis=1)) == 0
    assert crossings(np.stack([np.sin(2.0 * angle + 0.2), np.sin(angle + 0.05)], axis=1)) == 1
    assert crossings(np.stack([np.sin(3.0 * angle + 0.4), np.sin(2.0 * angle + 0.05)], axis=1)) == 7  # 2 p q - p - q


# Runs and their folders.


def test_a_launch_answers_the_question(stays: tuple[Launch, Path]) -> None:
    done, folder = stays
    values = json.loads((folder / files.RESULTS).read_text())
    found = values["launch"]
    assert found["pause_s"] == pytest.approx(found["rear_arrival_s"] - found["finger_free_s"], rel=1e-12)
    assert found["escape_speed_m_s"] == pytest.approx(found["finger"]["radius_m"] / found["pause_s"])
    assert found["finger_impulse_n_s"] == pytest.approx(found["momentum_n_s"], rel=1e-12)
    assert sum(found["shares"].values()) == pytest.approx(1.0, abs=5e-3)
    assert set(found["shares"]) == {"translation", "stretching", "bending", "vibration", "dissipated", "contact"}
    assert 0.0 < found["efficiency_error"] < 0.05
    for name in (
        "centre_of_mass_speed_m_s",
        "finger_free_s",
        "last_load_s",
        "rear_arrival_s",
        "pause_s",
        "escape_speed_m_s",
    ):
        assert found[error_key(name)] > 0.0
    series = found["series"]
    assert set(series) == {"t_s", "finger_force_n", "clearance_m", "centre_x_m", "centre_speed_m_s"}
    assert len({len(column) for column in series.values()}) == 1
    assert series["clearance_m"][-1] < 1e-3 < series["clearance_m"][0]
    # The centre of mass moves as its speed says, and the rebound is that of the release.
    way = np.trapezoid(series["centre_speed_m_s"], series["t_s"])
    assert series["centre_x_m"][-1] - series["centre_x_m"][0] == pytest.approx(way, rel=1e-4)
    assert values["rebound_speed_m_s"] == pytest.approx(17.3, rel=0.01)
    assert values["scene"]["until"] == "launch"
    assert not values["checks"]["failed"]
    # What the finger feels later takes from the band what the numbers say.
    assert done.found.touches
    assert any("touched" in sentence for sentence in values["warnings"])


def test_a_finger_that_clears_is_not_touched(clears: tuple[Launch, Path]) -> None:
    done, folder = clears
    assert done.found.touches == ()
    times = done.watch.times_s(done.launch_plan.timestep_s)
    assert done.found.rear_arrival_s is not None
    assert (
        times[-1] >= done.found.rear_arrival_s + 2e-3 - 3.0 * done.launch_plan.rear_steps * done.launch_plan.timestep_s
    )
    flying = times > 1.1 * done.launch_plan.string.finger_free_s
    assert np.ptp(done.watch.momentum_n_s[flying]) < 1e-12 * done.found.momentum_n_s
    steps = read(folder / files.TRAJECTORY).steps
    assert np.all(np.diff(steps) == done.launch_plan.frame_steps)


def test_analysis_and_scene_file_repeat_the_launch(clears: tuple[Launch, Path], tmp_path: Path) -> None:
    done, folder = clears
    again = launch.run(scene_of(read_scene(folder / files.SCENE)), tmp_path / "again")
    assert (folder / files.FINGER).read_bytes() == (tmp_path / "again" / files.FINGER).read_bytes()
    texts = []
    for one in (done, again, dispatch.analyze(folder)):
        values = one.as_dict()
        for key in ("wall_s", "versions"):
            values.pop(key)
        texts.append(json.dumps(values))
    assert texts[0] == texts[1] == texts[2]


def test_plain_lammps_repeats_the_launch(clears: tuple[Launch, Path], tmp_path: Path, lmp: str) -> None:
    for name in (files.LAUNCH_SCRIPT, files.DATA, files.TABLE):
        shutil.copy(clears[1] / name, tmp_path)
    command = [lmp, "-in", files.LAUNCH_SCRIPT, "-screen", "none"]
    subprocess.run(command, cwd=tmp_path, check=True, timeout=100)
    assert (tmp_path / files.FINGER).read_text() == (clears[1] / files.FINGER).read_text()
    assert (tmp_path / files.TRAJECTORY).read_bytes() == (clears[1] / files.TRAJECTORY).read_bytes()


def test_command_line(stays: tuple[Launch, Path], capsys: pytest.CaptureFixture[str]) -> None:
    folder = str(stays[1])
    assert main(["analyze", folder]) == 0
    said = capsys.readouterr().out
    for word in ("efficiency", "pause", "rebound speed V", "finger free"):
        assert word in said
    assert "hit" not in said.replace("energy before the hit", "")  # that is said of a hand, and there is none
    assert main(["plot", folder]) == 0
    pictures = capsys.readouterr().out.split("\n")[:-1]
    assert [Path(path).name for path in pictures] == [
        f"{name}.png" for name in ("shapes", "finger", "clearance", "energy", "overview")
    ]
    assert main(["plan", "--until", "launch", "--json"]) == 0
    assert any("finger" in reason for reason in json.loads(capsys.readouterr().out)["reasons"])


def test_a_rear_that_comes_first_hits() -> None:
    plan, found, _ = launched(strain=1.2, half_angle_deg=20.0, beads=160)
    assert found.finger_free_s is None
    assert found.pause_s is None
    assert plan.string.pause_s < 0.0
    assert any(one.code == "hand-is-hit" for one in plan.warnings)


def test_a_rear_that_never_comes_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(launch_plan, "CAP", 0.9)
    done = launch.run(scene_of({"until": "launch", "beads": 80, "for": "speed"}), tmp_path / "run")
    values = json.loads((tmp_path / "run" / files.RESULTS).read_text())
    assert values["launch"]["rear_arrival_s"] is None
    assert values["launch"]["pause_s"] is None
    assert any("did not reach" in sentence for sentence in values["warnings"])
    assert "not reached" in summary.run(done)


def test_a_broken_finger_is_said(tmp_path: Path) -> None:
    plan = launch_plan_of(scene_of({"until": "launch", "beads": 80, "for": "speed"}))
    ring, support = plan.held()
    write_launch(tmp_path, plan, ring, support)
    text = (tmp_path / files.LAUNCH_SCRIPT).read_text()
    core = float(support.radius_m) + 1e-5  # a core that reaches out of the surface holds the held beads inside
    lines = [
        f"variable core_radius index {core!r}" if "variable        core_radius" in x else x for x in text.split("\n")
    ]
    (tmp_path / files.LAUNCH_SCRIPT).write_text("\n".join(lines))
    with pytest.raises(RunError) as failed:
        run_script(tmp_path, files.LAUNCH_SCRIPT)
    assert failed.value.code == "broke-through-finger"


def test_damaged_files_are_refused(stays: tuple[Launch, Path], tmp_path: Path) -> None:
    (tmp_path / "finger.dat").write_text("# nothing\n0 1 2\n")
    with pytest.raises(ReadError, match=r"finger\.dat"):
        read_watch(tmp_path / "finger.dat")
    for name in (files.SCENE, files.REAR, files.TRAJECTORY, files.LAUNCH_SCRIPT):
        shutil.copy(stays[1] / name, tmp_path)
    (tmp_path / files.FINGER).unlink(missing_ok=True)
    with pytest.raises(UsageError, match=r"finger\.dat"):
        dispatch.analyze(tmp_path)


def test_steps_beyond_stability_are_refused() -> None:
    with pytest.raises(UsageError, match="stability"):
        launch_plan_of(scene_of({"until": "launch", "beads": 160, "timestep_s": 1e-4}))


def test_strands_that_would_compress_each_other_to_nothing_keep_their_loss() -> None:
    """The linear law from strains of about 0.9 on; a stiffening compression stops them, and less loss will do."""
    share = {}
    for law, strain in (("linear", 0.7), ("linear", 1.0), ("mooney-rivlin", 1.0)):
        plan = launch_plan_of(scene_of({"law": law, "strain": strain, "half_angle_deg": 10.0, "beads": 200} | LAUNCH))
        front_s = plan.strand.spacing_m * plan.scene.band.density_kg_m3 * plan.scene.string.wave.tail_speed_m_s
        share[law, strain] = plan.release.loss_time_s * plan.scene.band.modulus_pa / front_s
    assert share["linear", 0.7] < 0.9 * share["linear", 1.0]
    assert share["linear", 1.0] == pytest.approx(share["mooney-rivlin", 1.0])
    _, found, _ = launched(law="linear", strain=1.0, half_angle_deg=10.0, beads=200)
    assert found.shortest_stretch > 0.1


def test_a_launch_without_a_shock_has_beads_for_its_efficiency() -> None:
    """As many as keep the loss below the tolerance, of the second order in their number; a user's own are kept."""
    loose, tight = (
        launch_plan_of(scene_of({"law": "linear", "band": "I", "tolerance": t} | LAUNCH)) for t in (0.02, 5e-3)
    )
    assert tight.beads > plan_of(scene_of({"law": "linear", "band": "I"})).beads
    assert tight.beads == pytest.approx(2.0 * loose.beads, rel=0.1)
    assert [one.code for one in tight.reasons if one.code.startswith("beads")] == ["beads-for-launch"]
    assert launch_plan_of(scene_of({"law": "linear", "band": "I", "beads": 100} | LAUNCH)).beads == 100
