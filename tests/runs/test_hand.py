"""The hand that a launch moves: its limits, conservation, results, and refusals.

Its motion under the string's force and as a free oscillator are rung ``hand`` of beadband.studies.verification.
"""

from __future__ import annotations

import json
import math
import shutil
import subprocess
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from beadband.analysis.energy import launch_balance
from beadband.analysis.fits import hann_mean
from beadband.analysis.hand import peak_n
from beadband.analysis.readers import Watch
from beadband.cli import main
from beadband.errors import UsageError
from beadband.model.launch_string import finger_force_n, hand_under_string, hit_by_string, string_launch
from beadband.model.scene import scene_of
from beadband.observables import error_key
from beadband.planning.launch_plan import LaunchPlan, launch_plan_of
from beadband.runs import dispatch, launch
from beadband.runs import folder as files
from beadband.runs.hand import HandRun
from beadband.runs.launch_results import Launch

FAST: dict[str, Any] = {"until": "launch", "for": "speed", "beads": 160}
SPRUNG: dict[str, Any] = {"hand_mass_kg": 0.01, "hand_stiffness_n_m": 500.0, "hand_damping_n_s_m": 3.0}


@cache
def moved(**values: Any) -> tuple[LaunchPlan, HandRun, Watch]:
    """A launch with a hand: plan, hand, and the lines of finger.dat."""
    plan, _, watch, hand = launch.follow_hand(scene_of(FAST | values))
    return plan, hand, watch


@pytest.fixture(scope="module")
def sprung(tmp_path_factory: pytest.TempPathFactory) -> tuple[Launch, Path]:
    folder = tmp_path_factory.mktemp("hand") / "sprung"
    return launch.run(scene_of(FAST | SPRUNG), folder), folder


# Limits.


def test_a_heavy_hand_is_the_finger_that_stays() -> None:
    """Arrival, force and impulse come to those of today's launch as 1/mass."""
    plan, found, watch = launch.follow_launch(scene_of(FAST))
    apart = []
    for mass in (1e2, 1e4):
        _, hand, heavy = moved(hand_mass_kg=mass)
        assert found.rear_arrival_s is not None
        assert hand.found.hit_s is not None
        apart.append(abs(hand.found.hit_s / found.rear_arrival_s - 1.0))
        assert hand.found.displacement_m == pytest.approx(3.7e-6 / mass, rel=0.1)
        before = watch.times_s(plan.timestep_s) < plan.release.front_arrival_s
        assert np.abs(heavy.force_n[before] / watch.force_n[before] - 1.0).max() < 1e-3 / mass
    assert apart[1] < 1e-7
    assert apart[1] < 0.03 * apart[0]


def test_a_massless_hand_on_a_spring_bears_the_quasi_static_force() -> None:
    """F = F_pre - K X: what is left under a Hann window falls with the mass. A stiff spring bears a finger's force."""
    left = []
    for mass in (1e-4, 1e-5):
        plan, hand, watch = moved(hand_mass_kg=mass, hand_stiffness_n_m=1e4)
        times, arrival = watch.times_s(plan.timestep_s), plan.release.front_arrival_s
        spring = hand.motion.preload_n - hand.motion.stiffness_n_m * hand.path.mean_x_m
        centres = np.linspace(0.1, 1.4, 60) * arrival
        pair = [[hann_mean(times, one, at, 0.1 * arrival) for at in centres] for one in (watch.mean_force_n, spring)]
        assert min(pair[0]) < 0.55 * hand.motion.preload_n
        left.append(float(np.sqrt(np.mean(np.subtract(*pair) ** 2))) / hand.motion.preload_n)
    assert left[1] < 2e-3
    assert left[1] < 0.15 * left[0]

    plan, hand, _ = moved(hand_mass_kg=1e-3, hand_stiffness_n_m=1e6)
    fixed_plan, _, fixed = launch.follow_launch(scene_of(FAST))
    means = []
    for times, force in (
        (hand.path.steps * plan.timestep_s, hand.motion.preload_n - 1e6 * hand.path.mean_x_m),
        (fixed.times_s(fixed_plan.timestep_s), fixed.mean_force_n),
    ):
        means.append([hann_mean(times, force, share * plan.release.front_arrival_s, 5e-4) for share in (0.5, 1.1, 1.3)])
    assert means[0] == pytest.approx(means[1], abs=0.02 * hand.motion.preload_n)


def test_the_strings_hand_is_the_double_integral_of_its_force() -> None:
    scene = scene_of(FAST | {"hand_mass_kg": 0.02})
    times = np.linspace(0.0, 1.3 * string_launch(scene).finger_free_s, 4001)
    force = finger_force_n(scene, times)
    speed = np.concatenate([[0.0], np.cumsum(np.diff(times) * (force[0] - 0.5 * (force[1:] + force[:-1])))]) / 0.02
    way = np.concatenate([[0.0], np.cumsum(np.diff(times) * 0.5 * (speed[1:] + speed[:-1]))])
    assert hand_under_string(scene, times) == pytest.approx(way, abs=1e-5 * way[-1])
    assert hit_by_string(scene_of(FAST | {"hand_velocity_m_s": 2.0})).hit_speed_m_s == pytest.approx(
        scene.string.rear_speed_m_s - 2.0, rel=1e-9
    )
    assert hit_by_string(scene_of(FAST | {"hand_velocity_m_s": 20.0})).hit_s is None


# Conservation.


@pytest.mark.parametrize(
    "values",
    [
        {"hand_mass_kg": 0.02},
        {"hand_mass_kg": 0.02, "hand_preload_n": 8.0},
        {"hand_mass_kg": 1e-3, "hand_stiffness_n_m": 200.0, "hand_damping_n_s_m": 1.0},
        {"hand_mass_kg": 0.05, "hand_damping_n_s_m": 2.0, "band": "I", "half_angle_deg": 5.0},
    ],
    ids=lambda values: " ".join(map(str, values.values())),
)
def test_momentum_and_energy_of_band_and_hand(values: dict[str, Any]) -> None:
    plan, hand, watch = moved(**{"beads": 240, **values})
    assert launch_balance(watch, plan.timestep_s, hand.energy_j).error < 1.5e-3
    assert hand.checks(float(watch.momentum_n_s[-1]))["hand"].value < 1e-12
    assert hand.path.x_m[0] == hand.path.velocity_m_s[0] == 0.0


def test_the_energy_of_the_hand_is_the_bands_work_on_it() -> None:
    """Motion, spring and damper's loss less the work of the preload, against force times velocity."""
    plan, hand, watch = moved(hand_mass_kg=1e-3, hand_stiffness_n_m=2e3, hand_damping_n_s_m=2.0, hand_preload_n=4.0)
    intervals = np.diff(watch.steps, prepend=0) * plan.timestep_s
    work = -np.cumsum(watch.mean_force_n * hand.path.mean_velocity_m_s * intervals)
    assert np.ptp(work) > 0.01 * (watch.stretching_j[0] + watch.bending_j[0])
    assert np.abs(hand.energy_j - work).max() < 0.02 * np.ptp(work)


def test_a_prescribed_velocity_is_kept_and_its_work_counts() -> None:
    plan, hand, watch = moved(hand_velocity_m_s=0.5, beads=400)
    assert hand.path.x_m == pytest.approx(0.5 * watch.times_s(plan.timestep_s), rel=1e-12)
    assert hand.checks(1.0) == {}
    balance = launch_balance(watch, plan.timestep_s, hand.energy_j)
    assert np.ptp(balance.hand_j) > 0.04 * balance.stored_j
    assert balance.error < 4e-3  # its sudden start makes the band bounce on it, a few steps long


# Measuring.


def test_the_peak_is_that_of_whole_windows() -> None:
    times = np.linspace(0.0, 1.0, 1001)
    force = 2.0 + np.where(times > 0.9, 50.0, 0.0) + np.cos(2.0 * math.pi * (times - 0.5005) / 0.5)
    # A Hann window of half-width w multiplies a cosine of frequency f by sin(2 pi f w)/(2 pi f w (1 - (2 f w)^2)).
    turns = 2.0 * 0.05 / 0.5
    mean = math.sin(math.pi * turns) / (math.pi * turns * (1.0 - turns**2))
    assert peak_n(times, force, 0.9, 0.05) == pytest.approx(2.0 + mean, rel=1e-4)


# Runs and their folders.


def test_a_launch_reports_its_hand(sprung: tuple[Launch, Path]) -> None:
    done, folder = sprung
    values = json.loads((folder / files.RESULTS).read_text())
    felt = values["launch"]["hand"]
    assert felt["hit"] is True
    for name in ("hit_speed_m_s", "peak_force_n", "impulse_n_s", "displacement_m", "velocity_m_s"):
        assert 0.0 < felt[error_key(name)] < 0.5 * abs(felt[name])
    assert felt["impulse_n_s"] == pytest.approx(values["launch"]["finger_impulse_n_s"], rel=1e-9)
    assert 16.5 < felt["hit_speed_m_s"] < values["rebound_speed_m_s"]
    assert sum(values["launch"]["shares"].values()) == pytest.approx(1.0, abs=2e-3)
    assert values["launch"]["series"]["hand_x_m"][-1] == pytest.approx(felt["displacement_m"], rel=0.1)
    assert values["launch"]["series"]["clearance_m"][-1] < 1e-3
    assert "hand-hit" in values["warning_codes"]
    assert not values["checks"]["failed"]
    assert values["scene"]["hand_mass_kg"] == 0.01
    again = dispatch.analyze(folder).as_dict()
    assert json.dumps(again["launch"]) == json.dumps(done.as_dict()["launch"])


def test_plain_lammps_moves_the_hand(sprung: tuple[Launch, Path], tmp_path: Path, lmp: str) -> None:
    for name in (files.LAUNCH_SCRIPT, files.DATA, files.TABLE):
        shutil.copy(sprung[1] / name, tmp_path)
    subprocess.run([lmp, "-in", files.LAUNCH_SCRIPT, "-screen", "none"], cwd=tmp_path, check=True, timeout=100)
    assert (tmp_path / files.HAND).read_text() == (sprung[1] / files.HAND).read_text()


def test_a_hand_that_runs_ahead_is_not_hit(tmp_path: Path) -> None:
    done = launch.run(scene_of(FAST | {"hand_mass_kg": 3e-4, "beads": 60}), tmp_path / "run")
    values = json.loads((tmp_path / "run" / files.RESULTS).read_text())["launch"]["hand"]
    assert values["hit"] is False
    assert values["hit_speed_m_s"] is None
    assert done.hand is not None
    assert "hand-not-hit" in [one.code for one in done.notices]


# Choosing.


def test_a_light_hand_takes_shorter_steps() -> None:
    """Of beads pushed against it by k, and of its own spring: within the limit of stability of both."""
    heavy, light, stiff = (
        launch_plan_of(scene_of(FAST | {"hand_mass_kg": mass, "hand_stiffness_n_m": spring}))
        for mass, spring in ((1e3, 0.0), (1e-5, 0.0), (1e-3, 1e9))
    )
    bare = launch_plan_of(scene_of(FAST))
    assert heavy.timestep_s == pytest.approx(bare.timestep_s, rel=1e-5)
    assert heavy.contact_stiffness_n_m == pytest.approx(bare.contact_stiffness_n_m, rel=1e-3)
    assert light.timestep_s < 2.0 * math.sqrt(1e-5 / (20.0 * light.contact_stiffness_n_m))
    assert light.timestep_s < 0.5 * bare.timestep_s
    assert stiff.timestep_s < 2.0 * math.sqrt(1e-3 / 1e9)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"until": "release", "hand_mass_kg": 0.02}, "--hand-mass is not used with until release"),
        ({"finger": "clears", "hand_mass_kg": 0.02}, "--hand-mass is not used with finger clears"),
        ({"hand_mass_kg": 0.0}, "above 0 kg"),
        ({"hand_mass_kg": 0.02, "hand_stiffness_n_m": -1.0}, "0 N/m or more"),
        ({"hand_damping_n_s_m": 1.0}, "--hand-damping acts on a hand, and there is none"),
        ({"hand_preload_n": 1.0}, "add --hand-mass"),
        ({"hand_velocity_m_s": 1.0, "hand_mass_kg": 0.02}, "--hand-mass is not used"),
        ({"hand_velocity_m_s": 1.0, "hand_stiffness_n_m": 2.0}, "--hand-stiffness is not used"),
        ({"hand_mass_kg": "0.02 +/- 0.01"}, "takes no uncertainty"),
    ],
)
def test_nonsense_is_refused(values: dict[str, Any], said: str) -> None:
    with pytest.raises(UsageError) as refused:
        scene_of({"until": "launch", **values})
    assert said in str(refused.value)
    assert "\n" not in str(refused.value)


def test_other_commands_refuse_a_hand(capsys: pytest.CaptureFixture[str]) -> None:
    for command in (["ask"], ["sweep"], ["find", "strain", "--speed", "15"]):
        assert main([*command, "--hand-mass", "0.02"]) == 2
        assert "--hand-mass" in capsys.readouterr().err


def test_a_hit_that_the_beads_decide_has_no_error(sprung: tuple[Launch, Path]) -> None:
    from dataclasses import replace

    done = sprung[0]
    assert done.hand is not None
    other = replace(done.hand.found, hit=False, hit_s=None, hit_speed_m_s=None)
    unsure = replace(done, launch_estimate=replace(done.launch_estimate, hand=other))
    assert unsure.hand_figures == {**done.hand.figures(160, None, 0.0)}
    assert [one.code for one in unsure.hand.remarks((80, other))] == ["hand-hit", "hand-hit-unsure"]
